//! OPEN's parts from `--set`.

use std::collections::BTreeMap;
use std::sync::{Mutex, PoisonError};

use openbench_agents::{Open, Parts};
use openbench_bench::{
    AgentFactory, AgentRequest, Disturbance, DisturbanceError, DisturbedTruth, TruthLocalizer,
};
use openbench_core::{Agent, RobotDescription};
use openbench_language::{ChatPlanner, GrammarPlanner, Planner};
use openbench_localization::fixes::Gnss;
use openbench_localization::{DeadReckoning, FixSource, Fused, LidarInertial, Localizer};
use openbench_models::{Budget, ModelSpec, ModelStore};
use openbench_motion::costmap::ground::Preferences;
use openbench_motion::local::built_in::built_in;
use openbench_motion::teb::settings::Margins;
use openbench_motion::{LocalPlanner, PlannerSettings, TebSettings, teb};
use openbench_vision::{InTurn, PlateReader, PpOcr, PpOcrSettings, VlmReader};

use crate::open_models::Models;

/// The set of model files that reads plates by default.
pub const DEFAULT_READER: &str = "ppocr-v4";

/// The camera is level and lower than any plate: below the horizon there is nothing to read.
const ABOVE_HORIZON: f32 = 0.6;

const KEYS: [&str; 8] = ["planner", "reader", "localizer", "fixes", "motion", "ground", "budget", "thinking"];

/// Distance from a place with which OPEN is there, metres: what it looks at is metres away.
const NEAR_ENOUGH: f64 = 0.15;
/// Distances that OPEN keeps: what stands is known to half a cell of its costmap, and cars bulge between the rings of the LiDAR.
const SEEN_BY_LIDAR: Margins = Margins { least: 0.06, moving: 0.3, comfort: 0.35 };
/// How much faster than foreseen people may come at the robot, m/s: they speed up and turn as they like.
const SURPRISE: f64 = 0.7;
/// People stop within half a second; what is foreseen of them is a little late.
const YIELDS: f64 = 0.6;
/// What a metre costs OPEN, in seconds: deliveries are measured by how much longer than need be the way was, too, so it rather turns on the spot than drives round.
const SHORT: f64 = 12.0;
/// Seed of the sampling controller's disturbances: runs repeat.
const MPPI_SEED: u64 = 1;

/// What makes OPEN for an episode. Networks are loaded with the first one and shared by all.
pub fn factory() -> AgentFactory {
    let networks = Mutex::new(None);
    Box::new(move |request| make(request, &networks))
}

fn make(request: &AgentRequest<'_>, networks: &Mutex<Option<PpOcr>>) -> Result<Box<dyn Agent>, String> {
    check(request.settings)?;
    let setting = |key: &str| request.settings.get(key).map(String::as_str);
    let mut models = Models::new(budget(setting("budget"))?, request.exchanges.clone());
    let parts = Parts {
        planner: planner(setting("planner").unwrap_or("grammar"), &mut models)?,
        reader: reader(setting("reader").unwrap_or(DEFAULT_READER), networks, &mut models)?,
        localizer: localizer(setting("localizer").unwrap_or("fused"), request)?,
        motion: motion(setting("motion").unwrap_or("teb"))?,
        ground: ground(setting("ground").unwrap_or("alike"))?,
        memory: request.memory.cloned(),
        meter: models.meter(),
        thinks_in_simulated_time: thinking(setting("thinking").unwrap_or("free"))?,
    };
    Ok(Box::new(Open::new(parts)))
}

/// Whether the settings are ones that OPEN has.
pub fn check(settings: &BTreeMap<String, String>) -> Result<(), String> {
    match settings.keys().find(|key| !KEYS.contains(&key.as_str())) {
        Some(key) => Err(format!("there is no setting `{key}`; there are {}", KEYS.join(", "))),
        None => Ok(()),
    }
}

/// The planner that a word names.
pub fn planner(word: &str, models: &mut Models) -> Result<Box<dyn Planner>, String> {
    if word == "grammar" {
        return Ok(Box::new(GrammarPlanner::new()));
    }
    let model = models.open(word).map_err(|e| format!("planner={word}: {e}; or write grammar"))?;
    Ok(Box::new(ChatPlanner::new(model)))
}

/// The chat model that a word names, its first answer taken as it is.
pub fn bare_planner(word: &str, models: &mut Models) -> Result<Box<dyn Planner>, String> {
    let model = models.open(word).map_err(|e| format!("planner={word}: {e}"))?;
    Ok(Box::new(ChatPlanner::bare(model)))
}

/// The most that a mission may ask of models.
fn budget(words: Option<&str>) -> Result<Budget, String> {
    words.map_or(Ok(Budget::default()), |words| words.parse().map_err(|e| format!("budget={words}: {e}")))
}

/// Whether the robot stands still in the world for as long as models take to answer.
fn thinking(word: &str) -> Result<bool, String> {
    match word {
        "free" => Ok(false),
        "charged" => Ok(true),
        _ => Err(format!("thinking={word}: write free, or charged for models that take simulated time")),
    }
}

/// The readers of which the setting `reader` is a list. A comma parts two only before the beginning of one: names and files may hold commas.
pub fn readers(words: &str) -> Vec<&str> {
    let begins = |text: &str| {
        let text = text.trim_start();
        text.starts_with(DEFAULT_READER) || ModelSpec::parse(text).is_ok()
    };
    let (mut list, mut start) = (Vec::new(), 0);
    for (at, _) in words.match_indices(',').filter(|(at, _)| begins(&words[at + 1..])) {
        list.push(words[start..at].trim());
        start = at + 1;
    }
    list.push(words[start..].trim());
    list
}

/// The plate readers that the words name, to be asked in turn. Their files must be here; `run` pulls them beforehand.
fn reader(
    words: &str,
    networks: &Mutex<Option<PpOcr>>,
    models: &mut Models,
) -> Result<Box<dyn PlateReader>, String> {
    let made: Result<Vec<_>, String> =
        readers(words).into_iter().map(|word| one_reader(word, networks, models)).collect();
    let mut made = made?.into_iter();
    let first = made.next().ok_or_else(|| "reader= names no reader".to_owned())?;
    let others: Vec<_> = made.collect();
    Ok(if others.is_empty() { first } else { Box::new(InTurn::new(first, others)) })
}

fn one_reader(
    word: &str,
    networks: &Mutex<Option<PpOcr>>,
    models: &mut Models,
) -> Result<Box<dyn PlateReader>, String> {
    if word == DEFAULT_READER {
        let mut loaded = networks.lock().unwrap_or_else(PoisonError::into_inner);
        let shared = match &*loaded {
            Some(shared) => shared.clone(),
            None => loaded.insert(ppocr()?).clone(),
        };
        return Ok(Box::new(shared));
    }
    let model = models.open(word).map_err(|e| format!("reader={word}: {e}; or write {DEFAULT_READER}"))?;
    Ok(Box::new(VlmReader::new(model)))
}

fn ppocr() -> Result<PpOcr, String> {
    let store = ModelStore::from_environment().map_err(|e| e.to_string())?;
    let settings = PpOcrSettings { upper_part: ABOVE_HORIZON, ..PpOcrSettings::default() };
    Ok(PpOcr::from_store(&store).map_err(|e| e.to_string())?.with_settings(settings))
}

fn localizer(word: &str, request: &AgentRequest<'_>) -> Result<Box<dyn Localizer>, String> {
    let fixes = request.settings.get("fixes").map(String::as_str);
    if let (Some(fixes), true) = (fixes, word != "fused") {
        return Err(format!("fixes={fixes}: only localizer=fused takes fixes, not localizer={word}"));
    }
    match word {
        "fused" => {
            Ok(Box::new(Fused::new(RobotDescription::sentry(), sources(fixes.unwrap_or("none"), request)?)))
        }
        "lidar-inertial" => Ok(Box::new(LidarInertial::new(RobotDescription::sentry()))),
        "dead-reckoning" => Ok(Box::new(DeadReckoning::new(RobotDescription::sentry()))),
        "truth" => Ok(Box::new(TruthLocalizer::new(request.truth.clone()))),
        _ => Err(format!(
            "localizer={word}: there is no such localizer; there are fused, lidar-inertial, dead-reckoning, truth"
        )),
    }
}

/// Which ground a word prefers.
fn ground(word: &str) -> Result<Preferences, String> {
    match word {
        "alike" => Ok(Preferences::NONE),
        "pavements" => Ok(Preferences::default()),
        _ => Err(format!("ground={word}: there is no such preference; there are alike, pavements")),
    }
}

/// The local planner that a word names.
pub fn motion(word: &str) -> Result<Box<dyn LocalPlanner>, String> {
    let settings = PlannerSettings::new(RobotDescription::sentry()).with_seed(MPPI_SEED);
    let planners = built_in().with(teb::entry_with(teb_settings()));
    planners.make(word, &settings).map_err(|e| format!("motion={word}: {:#}", anyhow::Error::new(e)))
}

fn teb_settings() -> TebSettings {
    let mut settings =
        TebSettings { tolerance: NEAR_ENOUGH, surprise: Some(SURPRISE), ..TebSettings::default() };
    settings.yields = Some(YIELDS);
    settings.band.margins = SEEN_BY_LIDAR;
    settings.band.weights.length = SHORT;
    settings
}

/// What says where the robot is in the map. A robot without a receiver hears nothing of satellites.
fn sources(word: &str, request: &AgentRequest<'_>) -> Result<Vec<Box<dyn FixSource>>, String> {
    let (kind, rest) = word.split_once(':').unwrap_or((word, ""));
    match (kind, rest) {
        ("none", "") => Ok(vec![]),
        ("gnss", "") => {
            let antenna = RobotDescription::sentry().with_gnss().gnss.unwrap_or_default();
            Ok(vec![Box::new(Gnss::new(antenna.translation.vector.xy()))])
        }
        ("disturbed-truth", rest) => {
            let disturbance = if rest.is_empty() { Ok(Disturbance::default()) } else { rest.parse() };
            let disturbance = disturbance.map_err(|e: DisturbanceError| format!("fixes={word}: {e}"))?;
            Ok(vec![Box::new(DisturbedTruth::new(request.truth.clone(), disturbance, request.seed))])
        }
        _ => Err(format!(
            "fixes={word}: there is no such source of fixes; there are gnss, none, disturbed-truth:NOISE,SHARE,FAR"
        )),
    }
}
