//! A policy on another thread of this process.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{self, Receiver, RecvTimeoutError, Sender};
use std::time::{Duration, Instant};

use super::link::{Link, LinkError};
use super::message::{Reply, Request};

/// How often it is asked whether to stop.
const STOP_EVERY: Duration = Duration::from_millis(50);

/// The benchmark's end.
pub struct ChannelLink {
    requests: Sender<Request>,
    replies: Receiver<Reply>,
    stop: Arc<AtomicBool>,
}

/// The policy's end.
pub struct ChannelPolicy {
    requests: Receiver<Request>,
    replies: Sender<Reply>,
}

/// Both ends of a connection. When `stop` is set, the link ends, whatever the policy does.
pub fn channel(stop: Arc<AtomicBool>) -> (ChannelLink, ChannelPolicy) {
    let (to_policy, requests) = mpsc::channel();
    let (to_benchmark, replies) = mpsc::channel();
    let link = ChannelLink {
        requests: to_policy,
        replies,
        stop,
    };
    let policy = ChannelPolicy {
        requests,
        replies: to_benchmark,
    };
    (link, policy)
}

impl ChannelPolicy {
    /// Waits for the next message; `None` when there will be no more.
    pub fn receive(&self) -> Option<Request> {
        self.requests.recv().ok()
    }

    /// Answers. An answer that nobody waits for any more is dropped.
    pub fn send(&self, reply: Reply) {
        // The run has ended.
        let _ = self.replies.send(reply);
    }
}

impl Link for ChannelLink {
    fn send(&mut self, request: &Request) -> Result<(), LinkError> {
        let sent = self.requests.send(request.clone());
        sent.map_err(|_| LinkError::ended("its thread"))
    }

    fn receive(&mut self, within: Duration) -> Result<Reply, LinkError> {
        let until = Instant::now() + within;
        loop {
            let left = until.saturating_duration_since(Instant::now());
            match self.replies.recv_timeout(left.min(STOP_EVERY)) {
                Ok(reply) => return Ok(reply),
                Err(RecvTimeoutError::Disconnected) => return Err(LinkError::ended("its thread")),
                // Relaxed suffices: no other memory depends on the flag.
                Err(RecvTimeoutError::Timeout) if self.stop.load(Ordering::Relaxed) => {
                    return Err(LinkError::ended("because the run was stopped"));
                }
                Err(RecvTimeoutError::Timeout) if left.is_zero() => {
                    return Err(LinkError::Silent { within });
                }
                Err(RecvTimeoutError::Timeout) => {}
            }
        }
    }
}
