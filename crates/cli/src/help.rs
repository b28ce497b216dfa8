//! Help texts that list the registered agents and parts.

use std::fmt::Write as _;

use clap::{Command, CommandFactory as _};
use openbench_agents::open::choices::MODEL;
use openbench_agents::open::{Catalogue, Choices};
use openbench_agents::served::SETTINGS;
use openbench_core::registry::Entry;
use openbench_models::spec::FORMS;
use openbench_vision::ReaderPart;

use crate::Extensions;
use crate::args::Args;

/// Width of help texts, columns.
const WIDTH: usize = 100;
/// Yardsticks for what OPEN estimates and reads.
const TRUTH: &str = "
Yardsticks that use the truth, named in the results:
  reader=truth[:PIXELS]
      reads the plates in view whose capitals are so high in the image (default 10 pixels)
  localizer=truth
  fixes=disturbed-truth:NOISE,SHARE,FAR
      standard deviation in metres, share of false fixes, largest error of these in metres
";

/// The command line, with the agents and parts that there are in its help texts.
pub fn command(extensions: &Extensions) -> Command {
    let choices = extensions.parts().choices();
    let run = format!(
        "{}\n{}{}{TRUTH}{}",
        agents(extensions),
        settings_of_open(&choices),
        parts_of_open(extensions.parts()),
        settings_of_servers()
    );
    let motion = list("Local planners", value_names(&choices, "motion"));
    let people = list("Local planners", marked_values(&choices, "motion"));
    let health = list("Localizers", marked_values(&choices, "localizer"));
    Args::command()
        .mut_subcommand("run", |command| prepend(command, &run))
        .mut_subcommand("bench", |bench| {
            bench
                .mut_subcommand("motion", |command| prepend(command, &motion))
                .mut_subcommand("people", |command| prepend(command, &people))
                .mut_subcommand("health", |command| prepend(command, &health))
        })
}

/// Puts a text before what follows the options in the help of a command.
fn prepend(command: Command, text: &str) -> Command {
    let rest = command
        .get_after_help()
        .map(ToString::to_string)
        .unwrap_or_default();
    command.after_help(format!("{text}\n{rest}"))
}

fn agents(extensions: &Extensions) -> String {
    let mut text = "Agents (--agent NAME, by default open):\n".to_owned();
    for (name, about) in extensions.agents().names() {
        text += &line(name, about);
    }
    text
}

/// What the parts are that the settings name.
fn parts_of_open(parts: &Catalogue) -> String {
    let mut text = "  The parts are:\n".to_owned();
    let is_reader = |entry: &&Entry<ReaderPart>| FORMS.iter().all(|form| form.name != entry.name);
    for entry in parts.readers.entries().filter(is_reader) {
        text += &described(entry);
    }
    for entry in parts.localizers.entries() {
        text += &described(entry);
    }
    for entry in parts.fixes.entries() {
        text += &described(entry);
    }
    for entry in parts.local_planners.entries() {
        text += &described(entry);
    }
    text
}

/// A line with the name of a part, and what it is.
fn described<P>(entry: &Entry<P>) -> String {
    line(&entry.name, &entry.about)
}

fn line(name: &str, about: &str) -> String {
    format!("      {name:<24} {about}\n")
}

fn settings_of_open(choices: &[Choices]) -> String {
    let mut text = "Settings of the agent `open` (--set KEY=VALUE):\n".to_owned();
    for choices in choices {
        text += &list(&format!("  {}", choices.key), values(choices));
        let _ = writeln!(text, "      {}", choices.about);
    }
    let _ = writeln!(text, "  {MODEL} is one of:");
    for form in FORMS {
        let _ = writeln!(text, "      {:<24} {}", form.name, form.about);
    }
    text
}

fn settings_of_servers() -> String {
    let mut text = "\nSettings of agents behind policy servers (--set KEY=VALUE):\n".to_owned();
    for setting in SETTINGS {
        let (key, values, default) = (setting.key, setting.values, setting.default);
        let _ = writeln!(text, "  {key}: {values} (default {default})");
        let _ = writeln!(text, "      {}", setting.about);
    }
    text
}

/// The values of a setting, the default marked.
fn values(choices: &Choices) -> Vec<String> {
    let Choices {
        values, default, ..
    } = choices;
    // A setting may list the form of its values only, among which the default is not.
    if values.contains(default) {
        values.iter().map(|value| marked(value, default)).collect()
    } else {
        vec![format!("{} (default {default})", values.join(", "))]
    }
}

fn marked(value: &str, default: &str) -> String {
    if value == default {
        format!("{value} (default)")
    } else {
        value.to_owned()
    }
}

fn of_key<'c>(choices: &'c [Choices], key: &str) -> impl Iterator<Item = &'c Choices> {
    choices.iter().filter(move |choices| choices.key == key)
}

fn value_names(choices: &[Choices], key: &str) -> Vec<String> {
    of_key(choices, key)
        .flat_map(|choices| choices.values.clone())
        .collect()
}

fn marked_values(choices: &[Choices], key: &str) -> Vec<String> {
    of_key(choices, key).flat_map(values).collect()
}

/// `HEAD: A, B, C`, in lines of at most [`WIDTH`] columns.
fn list(head: &str, words: impl IntoIterator<Item = String>) -> String {
    let mut text = format!("{head}:");
    let mut column = text.len();
    let mut words = words.into_iter().peekable();
    while let Some(mut word) = words.next() {
        if words.peek().is_some() {
            word.push(',');
        }
        if column + 1 + word.len() > WIDTH {
            text.push_str("\n     ");
            column = 5;
        }
        text.push(' ');
        text.push_str(&word);
        column += 1 + word.len();
    }
    text.push('\n');
    text
}

#[cfg(test)]
mod tests {
    use openbench_core::RobotDescription;
    use openbench_localization::{DeadReckoning, Localizer};

    use super::*;

    fn wheels(robot: &RobotDescription) -> Box<dyn Localizer> {
        Box::new(DeadReckoning::new(robot.clone()))
    }

    fn help(extensions: &Extensions, words: &[&str]) -> String {
        let words = ["openbench"].iter().chain(words).chain(&["--help"]);
        let asked = command(extensions).try_get_matches_from(words);
        asked.unwrap_err().to_string()
    }

    #[test]
    fn the_command_line_is_consistent() {
        command(&Extensions::new()).debug_assert();
    }

    #[test]
    fn registered_parts_are_listed_with_their_defaults() {
        let text = help(&Extensions::new(), &["run"]);
        for line in [
            "Agents (--agent NAME, by default open):\n",
            "      fused                    LiDAR-inertial odometry and fixes in a pose graph\n",
            "      openpi:ws://HOST:PORT    a policy server of openpi\n",
            "  actions: velocity, waypoints or trajectory (default velocity)\n",
            "planner: grammar (default), MODEL\n",
            "reader: ppocr-v4 (default), MODEL\n",
            "localizer: fused (default), lidar-inertial, dead-reckoning\n",
            "fixes: gnss, osm (default), none\n",
            "motion: teb (default), follower, mppi\n",
            "budget: CALLS,TOKENS,SECONDS (default 1000,2000000,1800)\n",
            "Examples:",
        ] {
            assert!(text.contains(line), "{line} is not in {text}");
        }
    }

    #[test]
    fn parts_from_outside_are_listed_where_they_can_be_named() {
        let extensions = Extensions::new().with_localizer("wheels", "wheels alone", wheels);
        for words in [&["run"][..], &["bench", "health"]] {
            let text = help(&extensions, words);
            assert!(text.contains("dead-reckoning, wheels\n"), "{text}");
        }
    }

    #[test]
    fn long_lists_continue_on_the_next_line() {
        let words = (0..40).map(|i| format!("part-{i}"));
        let text = list("  motion", words);
        assert!(text.lines().all(|line| line.len() <= WIDTH), "{text}");
        assert!(text.lines().count() > 1 && text.ends_with(", part-39\n"));
    }
}
