//! What goes to stdout and stderr.

use std::io::{ErrorKind, IsTerminal, Write};
use std::sync::mpsc::{RecvTimeoutError, Sender, channel};
use std::time::{Duration, Instant};

use anyhow::{Context, Result};
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

use crate::report::StageReport;

/// Prints data. A reader that went away (`| head`) has what it wanted: no error.
pub(crate) fn print(text: &str) -> Result<()> {
    print_bytes(text.as_bytes())
}

/// [`print`] for what is made as bytes.
pub(crate) fn print_bytes(bytes: &[u8]) -> Result<()> {
    let mut out = std::io::stdout().lock();
    match out.write_all(bytes).and_then(|()| out.flush()) {
        Err(e) if e.kind() != ErrorKind::BrokenPipe => Err(e).context("cannot write to stdout"),
        _ => Ok(()),
    }
}

/// Prints a value as indented JSON.
pub(crate) fn print_json(value: &impl serde::Serialize) -> Result<()> {
    print(&format!("{}\n", serde_json::to_string_pretty(value)?))
}

/// A line on stderr; if even that fails there is nobody to tell.
pub(crate) fn tell(line: &str) {
    let _ = writeln!(std::io::stderr().lock(), "{line}");
}

/// How long a run must take before a bar appears: short ones do not flicker.
const PATIENCE: Duration = Duration::from_millis(500);

/// Times the stages of a run, and shows the present one where a person watches.
pub(crate) struct Progress {
    quiet: bool,
    bar: ProgressBar,
    /// Dropping it tells the waiting thread that the run is over.
    _done: Option<Sender<()>>,
    began: Instant,
    last: Instant,
    stages: Vec<StageReport>,
}

impl Progress {
    pub(crate) fn new(quiet: bool) -> Progress {
        let bar = ProgressBar::with_draw_target(None, ProgressDrawTarget::hidden());
        let watched = !quiet && std::io::stderr().is_terminal();
        let done = watched.then(|| {
            let (sender, receiver) = channel::<()>();
            let bar = bar.clone();
            std::thread::spawn(move || {
                if receiver.recv_timeout(PATIENCE) == Err(RecvTimeoutError::Timeout) {
                    if let Ok(style) = ProgressStyle::with_template("{spinner} {msg} {elapsed}") {
                        bar.set_style(style);
                    }
                    bar.set_draw_target(ProgressDrawTarget::stderr());
                    bar.enable_steady_tick(Duration::from_millis(100));
                }
            });
            sender
        });
        let now = Instant::now();
        Progress { quiet, bar, _done: done, began: now, last: now, stages: Vec::new() }
    }

    /// What is done now.
    pub(crate) fn doing(&self, what: impl Into<String>) {
        self.bar.set_message(what.into());
    }

    /// Ends a stage that began at the last call.
    pub(crate) fn stage(&mut self, name: &'static str) {
        let now = Instant::now();
        self.stages.push(StageReport { name, ms: (now - self.last).as_secs_f64() * 1e3 });
        self.last = now;
    }

    /// A line for the user, unless told to be quiet.
    pub(crate) fn note(&self, line: &str) {
        if !self.quiet {
            self.bar.suspend(|| tell(line));
        }
    }

    /// Takes the bar away. The stages, and the time of the whole run in milliseconds.
    pub(crate) fn finish(&mut self) -> (Vec<StageReport>, f64) {
        self.bar.finish_and_clear();
        (std::mem::take(&mut self.stages), self.began.elapsed().as_secs_f64() * 1e3)
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        self.bar.finish_and_clear();
    }
}

/// Lines up columns: the first and those named in `left` to the left, numbers to the right.
pub(crate) fn table(rows: &[Vec<String>], left: &[usize]) -> String {
    let columns = rows.iter().map(Vec::len).max().unwrap_or(0);
    let wide = |k: usize| rows.iter().filter_map(|r| r.get(k)).map(|c| c.chars().count()).max().unwrap_or(0);
    let widths: Vec<usize> = (0..columns).map(wide).collect();
    let mut text = String::new();
    for row in rows {
        let cells = row.iter().enumerate().map(|(k, cell)| {
            let pad = " ".repeat(widths[k] - cell.chars().count());
            if left.contains(&k) { format!("{cell}{pad}") } else { format!("{pad}{cell}") }
        });
        text.push_str(cells.collect::<Vec<_>>().join("  ").trim_end());
        text.push('\n');
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_line_up() {
        let rows = [vec!["name".to_owned(), "ms".to_owned()], vec!["a".to_owned(), "12.5".to_owned()]];
        assert_eq!(table(&rows, &[0]), "name    ms\na     12.5\n");
        assert_eq!(table(&[], &[]), "");
    }
}
