//! `openbench srtp`

use std::fmt::Write as _;
use std::path::Path;

use openbench_agents::open::Catalogue;
use openbench_bench::score::metrics::PAPER_SRTP;
use openbench_language::{ChatPlanner, Planner};
use openbench_trials::instructions::score::{Scores, Share, score};
use openbench_trials::instructions::{Difficulty, Split, built_in, read};

use crate::args::{DifficultyArg, SplitArg, SrtpArgs};
use crate::commands::{read_map, unbounded_models};
use crate::outcome::{Outcome, say, say_json};
use crate::progress::{progress_bar, tell_tenths};

/// Most misunderstandings that the table lists.
const SHOWN: usize = 10;

/// Prints how many instructions a planner understands.
pub fn run(args: &SrtpArgs, parts: &Catalogue) -> anyhow::Result<Outcome> {
    let inputs: Vec<&Path> = [&args.data, &args.map]
        .into_iter()
        .filter_map(Option::as_deref)
        .collect();
    let mut models = unbounded_models(&args.planner, &inputs, args.exchanges.as_deref())?;
    let planner: Box<dyn Planner> = if args.bare {
        Box::new(ChatPlanner::unverified(models.open(&args.planner)?))
    } else {
        parts.planner(&args.planner, &mut models)?
    };
    let (what, mut cases) = match &args.data {
        Some(path) => (path.display().to_string(), read(path)?),
        None => {
            let (name, split) = match args.split {
                SplitArg::Development => ("development", Split::Development),
                SplitArg::Test => ("test", Split::Test),
                SplitArg::Unseen => ("unseen", Split::Unseen),
            };
            (format!("the {name} split"), built_in(split))
        }
    };
    if let Some(wanted) = args.difficulty.map(difficulty) {
        cases.retain(|case| case.difficulty == Some(wanted));
        // Without an instruction there is no share to report.
        anyhow::ensure!(
            !cases.is_empty(),
            "no instruction of {what} is said to be {}",
            named(wanted)
        );
    }
    let map = args.map.as_deref().map(read_map).transpose()?;
    let bar = progress_bar(cases.len(), "instructions");
    let mut scores = score(planner.as_ref(), &cases, map.as_ref(), || {
        bar.inc(1);
        // A hidden bar: nobody watches a terminal. Without a model it is done at once.
        if bar.is_hidden() && models.meter().spent().calls > 0 {
            // A hidden bar counts all the same.
            tell_tenths(bar.position() as usize, cases.len(), "instructions");
        }
    });
    // A planner that asks no model leaves the use of models out.
    scores.models = Some(models.meter().spent()).filter(|used| used.calls > 0);
    bar.finish_and_clear();
    if args.json {
        say_json(&scores)?
    } else {
        say(&table(&scores, &what))?
    }
    Ok(Outcome::Done)
}

fn table(scores: &Scores, what: &str) -> String {
    let mut text = format!(
        "{} on {what}\n\n            instructions  right   SRTP  95 % interval\n",
        scores.planner
    );
    let mut line = |name: &str, share: &Share| {
        let percent = |value: f64| format!("{:.1}", 100.0 * value);
        let interval = share
            .interval
            .map(|[low, high]| format!("{} to {}", percent(low), percent(high)));
        let _ = writeln!(
            text,
            "{name:11} {:12}  {:5}  {:>5}  {:>13}",
            share.instructions,
            share.right,
            share.srtp.map(percent).unwrap_or_default(),
            interval.unwrap_or_default()
        );
    };
    line("all", &scores.all);
    if scores.fallbacks > 0 {
        line("w. fallback", &scores.with_fallback);
    }
    scores
        .difficulties
        .iter()
        .for_each(|(difficulty, share)| line(named(*difficulty), share));
    scores
        .languages
        .iter()
        .for_each(|(language, share)| line(language, share));
    let _ = writeln!(
        text,
        "\n{:.3} ms per instruction, {:.3} ms at most",
        scores.mean_ms, scores.max_ms
    );
    if let Some(used) = &scores.models {
        let each = |sum: u64| sum as f64 / scores.all.instructions.max(1) as f64;
        let _ = writeln!(
            text,
            "per instruction: {:.1} calls, {:.0} tokens read, {:.0} written; {} failed calls; \
             {} plans with parts by the grammar",
            each(used.calls.into()),
            each(used.prompt_tokens),
            each(used.completion_tokens),
            used.failed,
            scores.fallbacks,
        );
    }
    misunderstood(&mut text, scores);
    let _ = write!(
        text,
        "\n\nThe paper's table, of other instructions, 60 runs each (not run here):"
    );
    for (model, srtp) in PAPER_SRTP {
        let _ = write!(text, " {model} {:.0},", 100.0 * srtp);
    }
    text.trim_end_matches(',').to_owned() + "\n"
}

/// Writes the first instructions with a wrong plan, and how many more there are.
fn misunderstood(text: &mut String, scores: &Scores) {
    for wrong in scores.wrong.iter().take(SHOWN) {
        let planned: Vec<String> = wrong
            .planned
            .iter()
            .map(|door| format!("({door})"))
            .collect();
        let said = wrong
            .said
            .as_ref()
            .map(|said| format!("; {said}"))
            .unwrap_or_default();
        let _ = write!(
            text,
            "\n{}: {}\n    planned: {}{said}",
            wrong.id,
            wrong.instruction,
            planned.join(" ")
        );
    }
    if scores.wrong.len() > SHOWN {
        let _ = write!(
            text,
            "\nand {} more (--json has them all)",
            scores.wrong.len() - SHOWN
        );
    }
}

fn difficulty(word: DifficultyArg) -> Difficulty {
    match word {
        DifficultyArg::Easy => Difficulty::Easy,
        DifficultyArg::Medium => Difficulty::Medium,
        DifficultyArg::Hard => Difficulty::Hard,
    }
}

fn named(difficulty: Difficulty) -> &'static str {
    match difficulty {
        Difficulty::Easy => "easy",
        Difficulty::Medium => "medium",
        Difficulty::Hard => "hard",
    }
}
