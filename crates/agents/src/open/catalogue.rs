//! The parts that OPEN can be made of, by name. A new part is one file and one line here; a part
//! from elsewhere is added to a [`Catalogue`] from outside.

use std::sync::Arc;

use openbench_core::{Registry, RobotDescription, UnknownName};
use openbench_language::{ChatPlanner, GrammarPlanner, Planner};
use openbench_localization::fixes::Gnss;
use openbench_localization::registration::Registrar;
use openbench_localization::{DeadReckoning, Fused, LidarInertial};
use openbench_models::ModelSpec;
use openbench_motion::local::built_in::built_in;
use openbench_motion::local::{LocalPlanners, PlannerEntry};
use openbench_motion::teb;
use openbench_osm::OsmData;
use openbench_vision::readers::{self, Readers};
use openbench_vision::{PlateReader, ReaderContext};

use super::models::Models;
use super::parts::{
    Fixes, FixesPart, LocalizerPart, MakeFixes, MakeSituated, PartError, Parts, Situation,
};
use super::settings::{self, Settings, SettingsError};

/// The parts that OPEN can be made of.
#[derive(Clone)]
#[non_exhaustive]
pub struct Catalogue {
    /// Plate readers.
    pub readers: Readers,
    /// Localizers.
    pub localizers: Registry<LocalizerPart>,
    /// Sources of fixes: where the robot is in `map`.
    pub fixes: Registry<FixesPart>,
    /// Local planners.
    pub local_planners: LocalPlanners,
}

impl Default for Catalogue {
    fn default() -> Self {
        Self {
            readers: readers::built_in(),
            localizers: localizers(),
            fixes: fixes(),
            local_planners: local_planners(),
        }
    }
}

fn localizers() -> Registry<LocalizerPart> {
    Registry::new("localizer")
        .with(
            "fused",
            "LiDAR-inertial odometry and fixes in a pose graph",
            LocalizerPart::with_fixes(|robot, fixes| Box::new(Fused::new(robot.clone(), fixes))),
        )
        .with(
            "lidar-inertial",
            "LiDAR-inertial odometry alone",
            LocalizerPart::without_fixes(|robot| Box::new(LidarInertial::new(robot.clone()))),
        )
        .with(
            "dead-reckoning",
            "wheel odometry and gyroscope",
            LocalizerPart::without_fixes(|robot| Box::new(DeadReckoning::new(robot.clone()))),
        )
}

fn fixes() -> Registry<FixesPart> {
    Registry::new("source of fixes")
        .with("gnss", "a satellite receiver", FixesPart::new(gnss))
        .with(
            "osm",
            "the buildings of the public map",
            FixesPart::on_map(buildings),
        )
        .with("none", "no fixes", FixesPart::new(|_| Vec::new()))
}

/// The local planners of `openbench_motion`, with OPEN's settings.
fn local_planners() -> LocalPlanners {
    built_in()
        .with_entry(teb::entry_with(settings::teb()))
        .as_original()
}

/// A robot without a receiver gets no fixes from it.
fn gnss(robot: &RobotDescription) -> Fixes {
    let antenna = robot.gnss.unwrap_or_default();
    vec![Box::new(Gnss::new(antenna.translation.vector.xy()))]
}

/// Without a map there is nothing to register scans to.
fn buildings(situation: &Situation<'_>) -> Fixes {
    let registrar = situation.map.map(|map| {
        Registrar::new(
            Arc::new(map.clone()),
            situation.start,
            situation.robot.lidar,
        )
    });
    registrar
        .into_iter()
        .map(|one| Box::new(one) as _)
        .collect()
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
            localizer: self.localizer(&settings.localizer, settings.fixes.as_deref())?,
            motion: self.local_planner(&settings.motion)?,
            ground: settings.ground,
            memory,
            meter: models.meter(),
            thinks_in_simulated_time: settings.thinks_in_simulated_time,
        })
    }

    /// Whether all parts that settings name exist. Nothing is opened, loaded or downloaded.
    ///
    /// # Errors
    /// [`SettingsError`] with the key whose value names no part, or an argument that is refused.
    pub fn check(&self, settings: &Settings) -> Result<(), SettingsError> {
        if let Some(ChatWord { model, .. }) = ChatWord::read(&settings.planner) {
            let spec = ModelSpec::parse(model);
            spec.map_err(|error| planner_error(&settings.planner, error))?;
        }
        for name in self.readers.split(&settings.reader) {
            let found = self.readers.find(name);
            found.map_err(|source| unknown_part("reader", &settings.reader, source))?;
        }
        let _ = self.localizer(&settings.localizer, settings.fixes.as_deref())?;
        let _ = self.local_planner(&settings.motion)?;
        Ok(())
    }

    /// The planner of instructions that a word names: `grammar`, a chat model, or `MODEL,grammar`
    /// for a chat model with the grammar as fallback.
    ///
    /// # Errors
    /// [`SettingsError::Planner`] if the word names no model that can be opened.
    pub fn planner(
        &self,
        word: &str,
        models: &mut Models,
    ) -> Result<Box<dyn Planner>, SettingsError> {
        let Some(ChatWord { model, falls_back }) = ChatWord::read(word) else {
            return Ok(Box::new(GrammarPlanner::new()));
        };
        let model = models
            .open(model)
            .map_err(|error| planner_error(word, error))?;
        let planner = ChatPlanner::new(model);
        Ok(Box::new(if falls_back {
            planner.with_fallback()
        } else {
            planner
        }))
    }

    /// The local planner of that name.
    ///
    /// # Errors
    /// [`SettingsError::UnknownPart`] with the names that there are.
    pub fn local_planner(&self, name: &str) -> Result<PlannerEntry, SettingsError> {
        let found = self.local_planners.find(name);
        let found = found.map_err(|source| unknown_part("motion", name, source))?;
        Ok(found.entry.clone())
    }

    /// The plate readers that the setting `reader` lists.
    fn reader(
        &self,
        list: &str,
        models: &mut Models,
    ) -> Result<Box<dyn PlateReader>, SettingsError> {
        let mut open = |word: &str| models.open(word).map_err(PartError::from);
        let mut context = ReaderContext::new(&mut open).with_settings(settings::reading());
        let made = readers::make(&self.readers, list, &mut context);
        made.map_err(|error| part_error("reader", list, error))
    }

    /// What makes the localizer of that name, with a source of fixes if one is named.
    ///
    /// # Errors
    /// [`SettingsError`] if a name is not registered, the argument of the source is refused, or
    /// the localizer takes no fixes.
    pub fn localizer(
        &self,
        name: &str,
        fixes: Option<&str>,
    ) -> Result<Box<MakeSituated>, SettingsError> {
        let part = self.localizers.get(name);
        let part = part.map_err(|source| unknown_part("localizer", name, source))?;
        match (part.clone(), fixes) {
            (LocalizerPart::WithoutFixes(make), None | Some(settings::NO_FIXES)) => {
                Ok(Box::new(move |situation| make(situation.robot)))
            }
            (LocalizerPart::WithoutFixes(_), Some(fixes)) => Err(SettingsError::TakesNoFixes {
                fixes: fixes.to_owned(),
                localizer: name.to_owned(),
            }),
            (LocalizerPart::WithFixes(make), fixes) => {
                let fixes = self.sources(fixes.unwrap_or(settings::DEFAULT_FIXES))?;
                Ok(Box::new(move |situation| {
                    make(situation.robot, fixes(situation))
                }))
            }
        }
    }

    /// Whether the localizer of that name takes fixes; `false` for a name that is not registered.
    pub fn takes_fixes(&self, localizer: &str) -> bool {
        let part = self.localizers.get(localizer);
        matches!(part, Ok(LocalizerPart::WithFixes(_)))
    }

    fn sources(&self, value: &str) -> Result<Box<MakeFixes>, SettingsError> {
        let found = self.fixes.find(value);
        let found = found.map_err(|source| unknown_part("fixes", value, source))?;
        let read = found.entry.part.read(found.argument);
        read.map_err(|error| part_error("fixes", value, error))
    }
}

/// A value of `planner` that names a chat model.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct ChatWord<'a> {
    /// The name of the model.
    model: &'a str,
    /// Whether the grammar makes what the model cannot.
    falls_back: bool,
}

impl<'a> ChatWord<'a> {
    /// `None` for the grammar itself.
    fn read(word: &'a str) -> Option<Self> {
        if word == settings::GRAMMAR {
            return None;
        }
        // At the last comma: paths and addresses may contain commas.
        let listed = word.rsplit_once(',');
        let fallback = listed.filter(|(_, last)| *last == settings::GRAMMAR);
        Some(Self {
            model: fallback.map_or(word, |(model, _)| model),
            falls_back: fallback.is_some(),
        })
    }
}

fn planner_error(value: &str, source: impl Into<PartError>) -> SettingsError {
    SettingsError::Planner {
        value: value.to_owned(),
        source: source.into(),
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
        let catalogue = Catalogue::default();
        let Err(error) = catalogue.localizer("dead-reckoning", Some("gnss")) else {
            panic!("accepted")
        };
        for none in [None, Some("none")] {
            assert!(catalogue.localizer("dead-reckoning", none).is_ok());
        }
        assert!(catalogue.takes_fixes("fused") && !catalogue.takes_fixes("dead-reckoning"));
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
