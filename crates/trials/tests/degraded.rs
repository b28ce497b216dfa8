//! Degraded sensors: the localizer may have large errors, but must report them.

use std::time::Duration;

use openbench_bench::{Prepared, builtin_suite};
use openbench_core::RobotDescription;
use openbench_localization::Fused;
use openbench_trials::degraded::{Degradation, trial};

/// Drives of 90 s in a world that was not used to choose the thresholds.
#[test]
fn large_errors_are_not_reported_with_good_health() {
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
    let intact = drive(Degradation::None);
    assert!(
        intact.good > 0.95 && intact.largest_good_m < 0.05,
        "{intact:?}"
    );
    for degradation in [
        Degradation::Noisy(10.0),
        Degradation::Quantised(0.25),
        Degradation::Blinded(0.0),
        Degradation::ImuShocks,
        Degradation::TurnedLidar(5.0),
    ] {
        let trial = drive(degradation);
        let errors = trial.errors.unwrap();
        assert_eq!(errors.silent_divergences, 0, "{trial:?}");
        // Dead reckoning with wheels and gyroscope has smaller errors: the estimate must not
        // diverge.
        assert!(errors.max_m < 0.2 * trial.metres, "{trial:?}");
    }
}
