//! The `openbench` binary.

use std::process::ExitCode;

fn main() -> ExitCode {
    openbench::main_with(openbench::Extensions::new())
}
