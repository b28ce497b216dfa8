//! Agents behind policy servers: `--agent openpi:ws://HOST:PORT`, `vla-eval:ws://HOST:PORT` and
//! `navdp:http://HOST:PORT`.

use std::collections::BTreeMap;
use std::sync::Arc;

use openbench_agents::served::{
    NAVDP, NavDp, OPENPI, OpenPi, Protocol, Recorded, Served, Server, ServerError, Settings, Turns,
    VLA_EVAL, VlaEval,
};
use openbench_bench::run::registry::{AgentError, AgentSettings};
use openbench_bench::{AgentFactory, AgentRequest, Setting};
use openbench_core::Agent;

/// Makes a server with settings, which is not connected to yet.
type MakeServer = dyn Fn(Settings) -> Result<Box<dyn Server>, ServerError> + Send + Sync;

/// Agents with one server.
struct ServedFactory {
    protocol: Protocol,
    make: Box<MakeServer>,
}

/// The agents with an openpi server.
///
/// # Errors
/// What is no address.
pub fn openpi(address: &str) -> Result<Arc<dyn AgentFactory>, AgentError> {
    let address = address.to_owned();
    factory(OPENPI, move |settings| {
        Ok(Box::new(OpenPi::new(&address, settings)?))
    })
}

/// The agents with a model server of vla-eval.
///
/// # Errors
/// What is no address.
pub fn vla_eval(address: &str) -> Result<Arc<dyn AgentFactory>, AgentError> {
    let address = address.to_owned();
    factory(VLA_EVAL, move |settings| {
        Ok(Box::new(VlaEval::new(&address, settings)?))
    })
}

/// The agents with a NavDP server.
///
/// # Errors
/// What is no address.
pub fn navdp(address: &str) -> Result<Arc<dyn AgentFactory>, AgentError> {
    let (address, turns) = (address.to_owned(), Turns::default());
    factory(NAVDP, move |settings| {
        Ok(Box::new(NavDp::new(&address, settings, turns.clone())?))
    })
}

fn factory(
    protocol: Protocol,
    make: impl Fn(Settings) -> Result<Box<dyn Server>, ServerError> + Send + Sync + 'static,
) -> Result<Arc<dyn AgentFactory>, AgentError> {
    // So that an address that is none is found at once.
    make(Settings::of(&protocol, &BTreeMap::new())?)?;
    let make = Box::new(make);
    Ok(Arc::new(ServedFactory { protocol, make }))
}

impl AgentFactory for ServedFactory {
    fn make(&self, request: &AgentRequest<'_>) -> Result<Box<dyn Agent>, AgentError> {
        let settings = Settings::of(&self.protocol, request.settings)?;
        let server = (self.make)(settings.clone())?;
        let answers = Recorded::new(&request.exchanges, server)?;
        Ok(Box::new(Served::new(answers, settings, request.seed)))
    }

    fn check(&self, settings: &AgentSettings) -> Result<(), AgentError> {
        Settings::of(&self.protocol, settings)?;
        Ok(())
    }

    fn reach(&self, settings: &AgentSettings) -> Result<(), AgentError> {
        (self.make)(Settings::of(&self.protocol, settings)?)?.reach()?;
        Ok(())
    }

    fn in_force(&self, settings: &AgentSettings) -> BTreeMap<String, Setting> {
        let in_force = self.protocol.settings().map(|setting| {
            let value = setting.value(settings).to_owned();
            (setting.key.to_owned(), Setting::new(value, setting.default))
        });
        in_force.collect()
    }
}
