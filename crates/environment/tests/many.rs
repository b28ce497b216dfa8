//! Several environments give what each gives alone.

use openbench_bench::worlds::suite_named;
use openbench_environment::{
    AfterEnd, Beginning, Environment, EnvironmentError, Environments, Options, World,
};

fn options() -> Options {
    Options {
        // Short, so that episodes end.
        time_limit_s: Some(1.0),
        ..Options::default()
    }
}

fn world() -> World {
    World::new(suite_named("small").unwrap(), &options()).unwrap()
}

fn seeded(count: usize) -> Vec<Option<Beginning>> {
    let beginning = |i: usize| Beginning {
        seed: Some(i as u64),
        episode: None,
    };
    (0..count).map(|i| Some(beginning(i))).collect()
}

#[test]
fn each_does_what_it_does_alone_on_any_number_of_threads() {
    let world = world();
    let action = |i: usize, step: usize| [0.1 * (i + 1) as f64, 0.1 * step as f64, 0.0];
    // For each environment, its steps.
    let mut alone: Vec<Vec<_>> = Vec::new();
    for i in 0..3 {
        let mut environment = Environment::new(world.clone(), options()).unwrap();
        environment.reset(Some(i as u64), None).unwrap();
        let mut steps = Vec::new();
        for step in 0..30 {
            let stepped = environment.step(action(i, step)).unwrap();
            let ended = stepped.outcome.is_some();
            let begun = ended.then(|| environment.reset(None, None).unwrap());
            steps.push((stepped, begun));
        }
        alone.push(steps);
    }
    assert!(alone[0][19].1.is_some(), "an episode ends after a second");
    for threads in [1, 2, 7] {
        let mut many = Environments::new(&world, &options(), 3, threads, AfterEnd::Reset).unwrap();
        many.reset(&seeded(3)).unwrap();
        let mut together: Vec<Vec<_>> = vec![Vec::new(); 3];
        for step in 0..30 {
            let actions: Vec<[f64; 3]> = (0..3).map(|i| action(i, step)).collect();
            let steps = many.step(&actions).unwrap();
            for (steps, stepped) in together.iter_mut().zip(steps) {
                steps.push((stepped.step, stepped.begun));
            }
        }
        assert_eq!(together, alone, "{threads} threads");
    }
}

#[test]
fn steps_can_be_received_one_by_one() {
    let mut many = Environments::new(&world(), &options(), 2, 2, AfterEnd::Reset).unwrap();
    many.reset(&seeded(2)).unwrap();
    many.send(1, [0.1, 0.0, 0.0]).unwrap();
    assert!(matches!(
        many.send(1, [0.0; 3]),
        Err(EnvironmentError::AtWork(1))
    ));
    assert!(matches!(
        many.receive(2),
        Err(EnvironmentError::Idle { .. })
    ));
    let received = many.receive(1).unwrap();
    assert_eq!(received[0].0, 1);
    assert!(many.send(2, [0.0; 3]).is_err());
}

#[test]
fn an_error_of_one_leaves_the_others_usable() {
    let mut many = Environments::new(&world(), &options(), 2, 1, AfterEnd::Wait).unwrap();
    many.reset(&seeded(2)).unwrap();
    let bad = many.step(&[[0.1, 0.0, 0.0], [f64::NAN, 0.0, 0.0]]);
    assert!(matches!(bad, Err(EnvironmentError::Action(_))));
    many.step(&[[0.1, 0.0, 0.0]; 2]).unwrap();
}
