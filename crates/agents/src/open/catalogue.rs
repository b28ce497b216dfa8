//! The parts that OPEN can be made of, by name. A new part is one file and one line here; a part
//! from elsewhere is added to a [`Catalogue`] from outside.

use std::sync::Arc;

use openbench_core::{Registry, UnknownName};
use openbench_language::{ChatPlanner, GrammarPlanner, Planner};
use openbench_localization::fixes::Gnss;
use openbench_localization::{DeadReckoning, Fused, LidarInertial};
use openbench_motion::local::built_in::built_in;
use openbench_motion::local::{Entry, LocalPlanners};
use openbench_motion::teb;
use openbench_osm::OsmData;
use openbench_vision::{PlateReader, ReaderContext, ReaderRegistry};

use super::models::Models;
use super::parts::{LocalizerPart, MakeFixes, MakeLocalizer, PartError, Parts, ReadFixes};
use super::settings::{self, Settings, SettingsError};

/// The parts that OPEN can be made of.
#[derive(Clone)]
#[non_exhaustive]
pub struct Catalogue {
    /// Plate readers.
    pub readers: ReaderRegistry,
    /// Localizers.
    pub localizers: Registry<LocalizerPart>,
    /// Sources of fixes: where the robot is in `map`.
    pub fixes: Registry<Arc<ReadFixes>>,
    /// Local planners.
    pub local_planners: LocalPlanners,
}

impl Default for Catalogue {
    fn default() -> Self {
        Self {
            readers: ReaderRegistry::default(),
            localizers: localizers(),
            fixes: fixes(),
            local_planners: local_planners(),
        }
    }
}

fn localizers() -> Registry<LocalizerPart> {
    use LocalizerPart::{WithFixes, WithoutFixes};
    Registry::new("localizer")
        .with(
            "fused",
            "LiDAR-inertial odometry and fixes in a pose graph",
            WithFixes(Arc::new(|robot, fixes| {
                Box::new(Fused::new(robot.clone(), fixes))
            })),
        )
        .with(
            "lidar-inertial",
            "LiDAR-inertial odometry alone",
            WithoutFixes(Arc::new(|robot| {
                Box::new(LidarInertial::new(robot.clone()))
            })),
        )
        .with(
            "dead-reckoning",
            "wheel odometry and gyroscope",
            WithoutFixes(Arc::new(|robot| {
                Box::new(DeadReckoning::new(robot.clone()))
            })),
        )
}

fn fixes() -> Registry<Arc<ReadFixes>> {
    let sources: Registry<Arc<ReadFixes>> = Registry::new("source of fixes");
    sources
        .with("gnss", "a satellite receiver", Arc::new(gnss))
        .with("none", "no fixes", Arc::new(no_fixes))
}

/// The local planners of `openbench_motion`, with OPEN's settings.
fn local_planners() -> LocalPlanners {
    built_in().with(teb::entry_with(settings::teb()))
}

/// A robot without a receiver gets no fixes from it.
fn gnss(argument: &str) -> Result<MakeFixes, PartError> {
    refuse_argument(argument)?;
    Ok(Box::new(|robot| {
        let antenna = robot.gnss.unwrap_or_default();
        vec![Box::new(Gnss::new(antenna.translation.vector.xy()))]
    }))
}

fn no_fixes(argument: &str) -> Result<MakeFixes, PartError> {
    refuse_argument(argument)?;
    Ok(Box::new(|_| Vec::new()))
}

fn refuse_argument(argument: &str) -> Result<(), PartError> {
    if argument.is_empty() {
        Ok(())
    } else {
        Err("it takes no argument after a colon".into())
    }
}

impl Catalogue {
    /// The parts that settings name.
    ///
    /// # Errors
    /// [`SettingsError`] with the key whose value names no part, or a part that cannot be made.
    pub fn assemble(
        &self,
        settings: &Settings,
        models: &mut Models,
        memory: Option<OsmData>,
    ) -> Result<Parts, SettingsError> {
        Ok(Parts {
            planner: self.planner(&settings.planner, models)?,
            reader: self.reader(&settings.reader, models)?,
            localizer: self.localizer(settings)?,
            motion: self.local_planner(&settings.motion)?,
            ground: settings.ground,
            memory,
            meter: models.meter(),
            thinks_in_simulated_time: settings.thinks_in_simulated_time,
        })
    }

    /// The planner of instructions that a word names: `grammar`, or a chat model.
    ///
    /// # Errors
    /// [`SettingsError::Planner`] if the word names no model that can be opened.
    pub fn planner(
        &self,
        word: &str,
        models: &mut Models,
    ) -> Result<Box<dyn Planner>, SettingsError> {
        if word == "grammar" {
            return Ok(Box::new(GrammarPlanner::new()));
        }
        let model = models.open(word).map_err(|error| SettingsError::Planner {
            value: word.to_owned(),
            source: error.into(),
        })?;
        Ok(Box::new(ChatPlanner::new(model)))
    }

    /// The local planner of that name.
    ///
    /// # Errors
    /// [`SettingsError::Part`] with the names that there are.
    pub fn local_planner(&self, name: &str) -> Result<Entry, SettingsError> {
        let found = self.local_planners.get(name);
        found
            .cloned()
            .map_err(|error| part_error("motion", name, error))
    }

    /// The plate readers that the setting `reader` lists.
    fn reader(
        &self,
        list: &str,
        models: &mut Models,
    ) -> Result<Box<dyn PlateReader>, SettingsError> {
        let mut open = |word: &str| models.open(word).map_err(PartError::from);
        let mut context = ReaderContext::new(&mut open).with_settings(settings::reading());
        let made = self.readers.make(list, &mut context);
        made.map_err(|error| part_error("reader", list, error))
    }

    fn localizer(&self, settings: &Settings) -> Result<MakeLocalizer, SettingsError> {
        let name = &settings.localizer;
        let part = self.localizers.get(name);
        let part = part
            .map_err(|source| unknown_part("localizer", name, source))?
            .clone();
        match (part, &settings.fixes) {
            (LocalizerPart::WithoutFixes(make), None) => Ok(Box::new(move |robot| make(robot))),
            (LocalizerPart::WithoutFixes(_), Some(fixes)) => Err(SettingsError::TakesNoFixes {
                fixes: fixes.clone(),
                localizer: name.clone(),
            }),
            (LocalizerPart::WithFixes(make), fixes) => {
                let fixes = self.sources(fixes.as_deref().unwrap_or("none"))?;
                Ok(Box::new(move |robot| make(robot, fixes(robot))))
            }
        }
    }

    fn sources(&self, value: &str) -> Result<MakeFixes, SettingsError> {
        let (name, argument) = value.split_once(':').unwrap_or((value, ""));
        let read = self.fixes.get(name);
        let read = read.map_err(|source| unknown_part("fixes", value, source))?;
        read(argument).map_err(|error| part_error("fixes", value, error))
    }
}

fn part_error(key: &'static str, value: &str, source: impl Into<PartError>) -> SettingsError {
    SettingsError::Part {
        key,
        value: value.to_owned(),
        source: source.into(),
    }
}

fn unknown_part(key: &'static str, value: &str, source: UnknownName) -> SettingsError {
    SettingsError::UnknownPart {
        key,
        value: value.to_owned(),
        source,
    }
}

#[cfg(test)]
mod tests {
    use std::error::Error;

    use openbench_models::{Budget, Exchanges};

    use super::*;

    fn assemble(settings: Settings) -> Result<Parts, SettingsError> {
        let mut models = Models::new(Budget::default(), Exchanges::Unkept);
        Catalogue::default().assemble(&settings, &mut models, None)
    }

    /// Settings that need no model files.
    fn settings() -> Settings {
        Settings {
            reader: "replay:nowhere.jsonl".into(),
            ..Settings::default()
        }
    }

    #[test]
    fn a_name_that_is_not_registered_is_answered_with_those_that_are() {
        let catalogue = Catalogue::default();
        let error = catalogue.local_planner("pure-pursuit").err().unwrap();
        let source = error.source().unwrap().to_string();
        assert_eq!(error.to_string(), "motion=pure-pursuit");
        assert!(source.contains("teb, follower, mppi"), "{source}");
    }

    #[test]
    fn fixes_are_refused_where_nothing_takes_them() {
        let localizer = "dead-reckoning".to_owned();
        let settings = Settings {
            localizer,
            fixes: Some("gnss".into()),
            ..settings()
        };
        let Err(error) = Catalogue::default().localizer(&settings) else {
            panic!("accepted")
        };
        assert!(
            matches!(error, SettingsError::TakesNoFixes { .. }),
            "{error}"
        );
    }

    #[test]
    fn a_reader_that_is_no_name_and_no_model_is_refused() {
        let Err(error) = assemble(Settings {
            reader: "eyes".into(),
            ..settings()
        }) else {
            panic!("accepted")
        };
        assert!(
            matches!(error, SettingsError::Part { key: "reader", .. }),
            "{error}"
        );
    }
}
