#![no_main]

use libfuzzer_sys::fuzz_target;
use openbench_bench::Suite;

fuzz_target!(|text: &str| {
    if let Ok(suite) = toml::from_str::<Suite>(text) {
        assert_eq!(
            toml::from_str::<Suite>(&suite.to_toml()).as_ref(),
            Ok(&suite)
        );
    }
});
