//! Agents in other programs: `--agent python:FILE.py:CLASS` and `--agent program:COMMAND`.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::Arc;
use std::time::Duration;

use openbench_agents::remote::{ChildLink, Patience, Policy, Pool};
use openbench_bench::run::registry::{AgentError, AgentSettings};
use openbench_bench::{AgentFactory, AgentRequest, ModelDigest, Setting};
use openbench_core::Agent;
use openbench_models::{PullEvent, sha256_of};

/// The variable that names the Python interpreter of `python:` agents.
pub const INTERPRETER: &str = "OPENBENCH_PYTHON";
/// The setting for how long an action may take.
const TIMEOUT: &str = "timeout";
/// The setting for how long a program may take to begin.
const BEGIN_TIMEOUT: &str = "begin-timeout";
/// The setting for whether answers take simulated time.
const THINKING: &str = "thinking";
/// Its values.
const FREE: &str = "free";
const CHARGED: &str = "charged";
/// The longest time that can be set, seconds.
const LONGEST_S: f64 = 86_400.0;

/// Agents that are one program.
struct ProgramFactory {
    /// The processes that run it.
    pool: Pool,
    /// The file that the agent is, if there is one.
    file: Option<PathBuf>,
}

/// The agents that are classes in Python files.
///
/// # Errors
/// An argument that is none of `FILE.py:CLASS`, or a file that is not there.
pub fn python(argument: &str) -> Result<Arc<dyn AgentFactory>, AgentError> {
    let parts = argument.rsplit_once(':');
    let Some((file, class)) = parts.filter(|(file, class)| !file.is_empty() && is_name(class))
    else {
        return Err(format!(
            "python:{argument}: write python:FILE.py:CLASS, such as python:my_agent.py:MyAgent"
        )
        .into());
    };
    if !Path::new(file).is_file() {
        return Err(format!("python:{argument}: there is no file {file}").into());
    }
    let interpreter = std::env::var(INTERPRETER).unwrap_or_else(|_| "python3".to_owned());
    // `-u`, so that what an agent prints is seen when it prints it.
    let words = [&interpreter, "-u", "-m", "openbench._child", file, class];
    Ok(Arc::new(ProgramFactory {
        pool: pool(words.map(str::to_owned).to_vec()),
        file: Some(file.into()),
    }))
}

/// The agents that are programs which speak the policy protocol.
///
/// # Errors
/// An empty command.
pub fn program(argument: &str) -> Result<Arc<dyn AgentFactory>, AgentError> {
    let words: Vec<String> = argument.split_whitespace().map(str::to_owned).collect();
    let Some(first) = words.first() else {
        return Err("write program:COMMAND, such as program:./my-policy".into());
    };
    // A program that is found in PATH has no hash in the results.
    let file = Some(PathBuf::from(first)).filter(|path| path.is_file());
    let pool = pool(words);
    Ok(Arc::new(ProgramFactory { pool, file }))
}

/// Processes of a command.
fn pool(words: Vec<String>) -> Pool {
    Pool::new(move |within| {
        let mut command = Command::new(&words[0]);
        command.args(&words[1..]);
        Ok(Box::new(ChildLink::start(&mut command, within)?))
    })
}

/// Whether a word can be the name of a class.
fn is_name(word: &str) -> bool {
    !word.is_empty()
        && word
            .chars()
            .all(|c| c.is_alphanumeric() || "_.".contains(c))
}

impl AgentFactory for ProgramFactory {
    fn make(&self, request: &AgentRequest<'_>) -> Result<Box<dyn Agent>, AgentError> {
        let Settings { patience, by_clock } = parse(request.settings)?;
        let policy = Policy::new(&self.pool, request.seed, patience)?;
        Ok(Box::new(if by_clock { policy.timed() } else { policy }))
    }

    fn check(&self, settings: &AgentSettings) -> Result<(), AgentError> {
        parse(settings).map(|_| ())
    }

    fn is_charged_by_clock(&self, settings: &AgentSettings) -> bool {
        parse(settings).is_ok_and(|settings| settings.by_clock)
    }

    fn cannot_repeat(&self, settings: &AgentSettings) -> Option<String> {
        self.is_charged_by_clock(settings).then(|| {
            "its computing was charged by the clock (--realtime), which no run repeats".to_owned()
        })
    }

    fn prepare(
        &self,
        settings: &AgentSettings,
        _: &mut dyn FnMut(PullEvent),
    ) -> Result<(), AgentError> {
        // A program that cannot begin is an error of the user, not a result.
        let link = self.pool.take(parse(settings)?.patience.begin)?;
        self.pool.give_back(link);
        Ok(())
    }

    fn in_force(&self, settings: &AgentSettings) -> BTreeMap<String, Setting> {
        let defaults = Patience::default();
        let times = [(TIMEOUT, defaults.act), (BEGIN_TIMEOUT, defaults.begin)];
        let setting = |(key, default): (&str, Duration)| {
            let default = default.as_secs_f64().to_string();
            let value = settings.get(key).unwrap_or(&default);
            (key.to_owned(), Setting::new(value.clone(), &default))
        };
        let thinking = settings
            .get(THINKING)
            .map(|value| (THINKING.to_owned(), Setting::new(value.clone(), FREE)));
        times.into_iter().map(setting).chain(thinking).collect()
    }

    fn models(&self, _: &AgentSettings) -> Result<Vec<ModelDigest>, AgentError> {
        let Some(file) = &self.file else {
            return Ok(Vec::new());
        };
        let open = std::fs::File::open(file);
        let sha256 = open.and_then(sha256_of);
        let sha256 = sha256.map_err(|error| format!("{}: {error}", file.display()))?;
        let name = file.file_name().unwrap_or_default().to_string_lossy();
        Ok(vec![ModelDigest {
            name: name.into_owned(),
            sha256,
        }])
    }

    fn inputs(&self, _: &AgentSettings) -> Vec<PathBuf> {
        self.file.iter().cloned().collect()
    }
}

/// The settings of these agents.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
struct Settings {
    /// How long answers may take.
    patience: Patience,
    /// Whether answers take as much simulated time as they took wall time.
    by_clock: bool,
}

/// Settings as they are written.
fn parse(words: &AgentSettings) -> Result<Settings, AgentError> {
    let mut settings = Settings::default();
    for (key, value) in words {
        match key.as_str() {
            TIMEOUT => settings.patience.act = seconds(key, value)?,
            BEGIN_TIMEOUT => settings.patience.begin = seconds(key, value)?,
            THINKING => settings.by_clock = by_clock(value)?,
            _ => {
                return Err(format!(
                    "{key}: there is no such setting; known: {TIMEOUT}, {BEGIN_TIMEOUT}, {THINKING}"
                )
                .into());
            }
        }
    }
    Ok(settings)
}

fn seconds(key: &str, value: &str) -> Result<Duration, AgentError> {
    let seconds: Option<f64> = value.parse().ok();
    let seconds = seconds.filter(|seconds| *seconds > 0.0 && *seconds <= LONGEST_S);
    let time = seconds.map(Duration::from_secs_f64);
    time.ok_or_else(|| format!("{key}={value}: write seconds, up to a day").into())
}

fn by_clock(value: &str) -> Result<bool, AgentError> {
    match value {
        FREE => Ok(false),
        CHARGED => Ok(true),
        _ => Err(format!("{THINKING}={value}: write {FREE} or {CHARGED}").into()),
    }
}
