//! A policy as a program of its own: it reads requests on its standard input, and answers on its
//! standard output. `openbench run --agent program:target/release/examples/policy_program` runs it.
//!
//! It drives straight ahead, stops before what is nearer than half a metre, and gives up after ten
//! seconds.

use std::io::{Write, stdin, stdout};

use openbench_agents::remote::LinkError;
use openbench_agents::remote::frame::{frame, read_frame};
use openbench_agents::remote::message::{Act, Hello, PROTOCOL, Reply, Request, Scan};
use openbench_core::{Action, FailureCause, GiveUp, SimTime, Velocity};

fn main() -> Result<(), LinkError> {
    say(&Reply::Hello(Hello {
        protocol: PROTOCOL,
        program: "policy_program".to_owned(),
    }))?;
    let mut policy = Ahead::default();
    while let Some(request) = read_frame(&mut stdin().lock())? {
        say(&policy.answer(request))?;
    }
    Ok(())
}

fn say(reply: &Reply) -> Result<(), LinkError> {
    let mut out = stdout().lock();
    out.write_all(&frame(reply)?)?;
    Ok(out.flush()?)
}

/// Drives ahead.
#[derive(Default)]
struct Ahead {
    time: SimTime,
    blocked: bool,
}

impl Ahead {
    fn answer(&mut self, request: Request) -> Reply {
        match request {
            Request::Begin(_) => {
                *self = Self::default();
                Reply::Ready { reports: vec![] }
            }
            Request::Act(Act { time, has_scan, .. }) => {
                self.time = time;
                // The scan comes as the next request; without one, the last one counts.
                if has_scan {
                    return Reply::WantScan;
                }
                self.action()
            }
            Request::Scan(scan) => {
                self.blocked = scan.is_some_and(|scan| is_blocked(&scan));
                self.action()
            }
            Request::Image(_) => self.action(),
            Request::Finish => Reply::Finished { map: None },
        }
    }

    fn action(&self) -> Reply {
        let action = if self.time >= SimTime::from_millis(10_000) {
            Action::GiveUp(GiveUp {
                address: None,
                cause: FailureCause::DoorNotFound,
                detail: "ten seconds are over".to_owned(),
            })
        } else {
            let speed = if self.blocked { 0.0 } else { 0.3 };
            Action::Drive(Velocity::new(speed, 0.0))
        };
        Reply::Action {
            action,
            reports: vec![],
        }
    }
}

/// Whether anything above the ground is less than half a metre ahead.
fn is_blocked(scan: &Scan) -> bool {
    let number = |bytes: &[u8; 4]| f32::from_le_bytes(*bytes);
    let (numbers, _) = scan.xyz.as_chunks::<4>();
    let (points, _) = numbers.as_chunks::<3>();
    points.iter().any(|point| {
        let [x, y, z] = point.each_ref().map(number);
        (0.0..0.5).contains(&x) && y.abs() < 0.2 && z > -0.15
    })
}
