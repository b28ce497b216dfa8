//! Policies in child processes.

use std::path::PathBuf;
use std::process::Command;
use std::sync::Arc;
use std::time::{Duration, Instant};

use openbench_agents::remote::{ChildLink, LinkError, Patience, Policy, Pool};
use openbench_core::{
    Action, Agent, Briefing, Camera, FailureCause, Georeference, Goal, Image, LidarPoint,
    LidarScan, LonLat, Observation, Pose2, RobotDescription, SimTime, Start, Velocity,
};

const SOON: Duration = Duration::from_secs(20);

fn shell(script: &str, within: Duration) -> Result<ChildLink, LinkError> {
    ChildLink::start(Command::new("sh").args(["-c", script]), within)
}

fn error_of(script: &str) -> LinkError {
    shell(script, SOON).err().unwrap()
}

#[test]
fn a_program_that_is_not_there_is_named() {
    let error = ChildLink::start(&mut Command::new("/nowhere/policy"), SOON);
    let error = error.err().unwrap().to_string();
    assert!(error.contains("/nowhere/policy"), "{error}");
}

#[test]
fn a_program_that_ends_says_how() {
    let error = error_of("exit 3");
    assert!(matches!(error, LinkError::Ended { .. }), "{error}");
    assert!(error.to_string().contains("exit status: 3"), "{error}");
}

#[test]
fn a_program_that_prints_something_else_is_refused() {
    // The first four bytes are taken for a length, here some 1.8 GB.
    let error = error_of("echo hello everybody; sleep 60");
    assert!(matches!(error, LinkError::TooLong { .. }), "{error}");
    let error = error_of(r"printf '\003\000\000\000abc'; sleep 60");
    assert!(matches!(error, LinkError::Unreadable { .. }), "{error}");
}

#[test]
fn a_silent_program_is_stopped() {
    let began = Instant::now();
    let error = shell("exec sleep 600", Duration::from_millis(100))
        .err()
        .unwrap();
    assert!(matches!(error, LinkError::Silent { .. }), "{error}");
    // Far below the time that it would sleep.
    assert!(began.elapsed() < Duration::from_secs(60));
}

struct NoCamera;

impl Camera for NoCamera {
    fn image(&self) -> Option<Arc<Image>> {
        None
    }
}

/// The example `policy_program`, which is built with these tests.
fn example() -> PathBuf {
    let test = std::env::current_exe().unwrap();
    test.parent()
        .unwrap()
        .with_file_name("examples")
        .join("policy_program")
}

fn policy() -> Policy {
    let pool = Pool::new(|within| {
        Ok(Box::new(ChildLink::start(
            &mut Command::new(example()),
            within,
        )?))
    });
    Policy::new(&pool, 1, Patience::default()).unwrap()
}

fn begin(policy: &mut Policy) {
    let briefing = Briefing {
        map_osm: b"<osm/>".to_vec(),
        georeference: Georeference::tangent_plane(LonLat::default()),
        goal: Goal::Instruction("box to unit 1".into()),
        start: Start::exact(Pose2::default()),
        robot: RobotDescription::sentry(),
        time_limit: Duration::from_secs(60),
    };
    policy.begin(&briefing, &mut Vec::new()).unwrap();
}

fn act(policy: &mut Policy, millis: u64, ahead: f32) -> Action {
    let scan = LidarScan {
        points: vec![LidarPoint {
            xyz: [ahead, 0.0, 0.0],
            offset_ns: 0,
            reflectivity: 0,
            line: 0,
        }],
        ..LidarScan::default()
    };
    let observation = Observation {
        time: SimTime::from_millis(millis),
        imu: &[],
        wheels: &[],
        scan: Some(&scan),
        gnss: None,
        camera: &NoCamera,
    };
    policy.act(&observation, &mut Vec::new())
}

#[test]
fn a_program_drives_by_what_it_sees_and_ends_episodes() {
    let mut policy = policy();
    begin(&mut policy);
    let drive = |speed| Action::Drive(Velocity::new(speed, 0.0));
    assert_eq!(act(&mut policy, 50, 3.0), drive(0.3));
    assert_eq!(act(&mut policy, 100, 0.4), drive(0.0));
    let Action::GiveUp(give_up) = act(&mut policy, 10_000, 3.0) else {
        panic!("ten seconds are over");
    };
    assert_eq!(give_up.cause, FailureCause::DoorNotFound);
    assert_eq!(policy.finish(&mut Vec::new()), None);
}
