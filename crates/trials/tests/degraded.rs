//! Sensors that are worse than believed: the localizer may be off, but it says so.

use std::time::Duration;

use openbench_bench::{Prepared, builtin_suite};
use openbench_core::RobotDescription;
use openbench_localization::Fused;
use openbench_trials::degraded::{Degradation, trial};

/// Drives of a minute and a half in a world that the thresholds were not chosen in.
#[test]
fn nobody_is_far_off_with_good_health() {
    let prepared = Prepared::world_of(builtin_suite("small").unwrap()).unwrap();
    let drive = |degradation| {
        let mut localizer = Fused::new(RobotDescription::sentry(), Vec::new());
        trial(
            &prepared,
            5,
            Duration::from_secs(90),
            degradation,
            &mut localizer,
        )
        .unwrap()
    };
    let sound = drive(Degradation::None);
    assert!(
        sound.good > 0.95 && sound.largest_good_m < 0.05,
        "{sound:?}"
    );
    for degradation in [
        Degradation::Noisy(10.0),
        Degradation::Quantised(0.25),
        Degradation::Blinded(0.0),
        Degradation::Jerked,
        Degradation::TurnedLidar(5.0),
    ] {
        let trial = drive(degradation);
        let errors = trial.errors.unwrap();
        assert_eq!(errors.silent_divergences, 0, "{trial:?}");
        // Wheels and gyroscope alone would not be that far off: nothing runs away.
        assert!(errors.max_m < 0.2 * trial.metres, "{trial:?}");
    }
}
