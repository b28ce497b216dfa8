//! Exit codes. 0: done (a failed delivery is a result, not an error). 1: an episode could not be
//! completed, `verify` differs, or `plan` reports a problem. 2: bad usage or bad input. 130, 143: a
//! run was stopped by SIGINT or SIGTERM.

use std::io::{self, Write};

use openbench_bench::BenchError;
use openbench_core::with_causes;

/// How a command ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Outcome {
    /// Done.
    Done,
    /// Done, and what was found is a problem.
    Problem,
    /// Stopped in order by the signal of this number.
    Stopped(u8),
}

/// What clap says about a command line; `--help` and `--version` are no errors.
pub fn usage(error: &clap::Error) -> u8 {
    // If the terminal is closed, there is nobody to tell.
    if error.use_stderr() {
        let text = error.render().to_string();
        if text == presentable(&text) {
            let _ = error.print();
        } else {
            // Without colours, but also without what was too long or secret.
            let _ = writeln!(io::stderr(), "{}", presentable(&text).trim_end());
        }
        2
    } else {
        let _ = error.print();
        0
    }
}

/// The exit code of a command; an error is said on stderr, with its causes.
pub fn exit(result: anyhow::Result<Outcome>) -> u8 {
    match result {
        Ok(Outcome::Done) => 0,
        Ok(Outcome::Problem) => 1,
        // As shells report processes that a signal has ended.
        Ok(Outcome::Stopped(signal)) => 128 + signal,
        Err(error) if is_closed_pipe(&error) => 0,
        Err(error) => {
            // Not `eprintln!`, which panics if stderr cannot be written.
            let text = presentable(&with_causes(error.as_ref()));
            let _ = writeln!(io::stderr(), "openbench: {text}");
            if is_failed_run(&error) { 1 } else { 2 }
        }
    }
}

/// An error's text as it may be shown: without passwords in addresses, and no longer than anybody
/// reads, since errors quote what they are about.
fn presentable(text: &str) -> String {
    const LONGEST_WORD: usize = 200;
    const LONGEST: usize = 4000;
    let words = text.split_inclusive(char::is_whitespace);
    let text: String = words
        .map(|word| shortened(&without_secrets(word), LONGEST_WORD))
        .collect();
    shortened(&text, LONGEST)
}

/// An address without the user name and password in it, and without its query, which may have a
/// key.
fn without_secrets(word: &str) -> String {
    let Some((scheme, rest)) = word.split_once("://") else {
        return word.to_owned();
    };
    if let Some((address, query)) = rest.split_once('?') {
        let address = without_secrets(&format!("{scheme}://{address}"));
        // The blank behind the word stays.
        let blank = &query[query.trim_end().len()..];
        return format!("{address}?…{blank}");
    }
    let end = rest.find(['/', '?', '#']).unwrap_or(rest.len());
    match rest[..end].rfind('@') {
        Some(at) => format!("{scheme}://…{}", without_secrets(&rest[at..])),
        None => format!("{scheme}://{}", without_secrets(rest)),
    }
}

/// The beginning and the end of a text that is too long.
fn shortened(text: &str, most: usize) -> String {
    let count = text.chars().count();
    if count <= most {
        return text.to_owned();
    }
    // The end says what to do.
    let (head, tail) = (most / 2, most / 4);
    let begin: String = text.chars().take(head).collect();
    let end: String = text.chars().skip(count - tail).collect();
    let left_out = count - head - tail;
    format!("{begin}… ({left_out} characters left out) …{end}")
}

fn is_failed_run(error: &anyhow::Error) -> bool {
    // A replay that differs, a model that never answered, a log that cannot be written. Other
    // errors are of usage or input.
    matches!(
        error.downcast_ref(),
        Some(
            BenchError::Differs { .. }
                | BenchError::Altered { .. }
                | BenchError::Log(_)
                | BenchError::Unreachable { .. }
        )
    )
}

/// Whoever read our output has had enough, as `head` does.
fn is_closed_pipe(error: &anyhow::Error) -> bool {
    error
        .downcast_ref::<io::Error>()
        .is_some_and(|e| e.kind() == io::ErrorKind::BrokenPipe)
}

/// Writes text to stdout.
pub fn say(text: &str) -> anyhow::Result<()> {
    let mut out = io::stdout().lock();
    out.write_all(text.as_bytes())?;
    out.flush()?;
    Ok(())
}

/// Writes a value to stdout as JSON.
pub fn say_json(value: &impl serde::Serialize) -> anyhow::Result<()> {
    say(&(serde_json::to_string_pretty(value)? + "\n"))
}

/// Writes a message for people to stderr.
pub fn tell(message: &str) {
    // Not `eprintln!`, which panics if stderr cannot be written.
    let _ = writeln!(io::stderr(), "{message}");
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn secrets_in_addresses_are_not_shown() {
        for (text, shown) in [
            (
                "planner=openai:m@http://user:secret@host/v1: no",
                "planner=openai:m@http://…@host/v1: no",
            ),
            ("see https://host/a@b now", "see https://host/a@b now"),
            ("r=a@http://h/v1?key=secret: no", "r=a@http://h/v1?… no"),
            ("a://b@c://d:secret@e", "a://…@c://…@e"),
            ("no address: a@b", "no address: a@b"),
        ] {
            assert_eq!(presentable(text), shown);
        }
    }

    #[test]
    fn megabytes_are_not_echoed() {
        let long = format!("`{}` is no number; write one", "9".repeat(5_000_000));
        let shown = presentable(&long);
        assert!(shown.len() < 400 && shown.ends_with("is no number; write one"));
        let words = presentable(&"many words ".repeat(100_000));
        assert!(words.chars().count() < 4100);
        assert_eq!(presentable("short\ntext"), "short\ntext");
    }
}
