//! Runs engines by turns: A B A B (A A B B after turns of seconds), so that whatever else the machine does meets all of them alike.

use std::sync::Arc;
use std::thread::sleep;
use std::time::{Duration, Instant};

use anyhow::{Context, Result};
use bench_common::{Case, Engine, FrameTime};
use cpu_time::ProcessTime;
use rayon::ThreadPool;

/// One frame of one engine.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Frame {
    /// Wall times.
    pub time: FrameTime,
    /// Time that the processor worked for this process during the frame, by the number of threads: what the wall time would be if
    /// nobody else wanted the machine and all threads were busy. Steadier than wall time on a shared machine.
    pub cpu_ms: f64,
}

/// All that an engine did.
#[derive(Clone, Debug)]
pub struct Measured {
    /// As asked for.
    pub name: String,
    /// How it was set up.
    pub setup: String,
    /// Whether its mask must be that of exact arithmetic.
    pub exact: bool,
    /// One a round.
    pub frames: Vec<Frame>,
    /// The last answer.
    pub mask: Vec<u8>,
}

/// How long it may take.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Patience {
    /// Rounds that count, after one that does not.
    pub rounds: usize,
    /// After so much time there are no more rounds.
    pub budget: Duration,
    /// Rest before each frame, for the threads of other engines to fall asleep.
    pub rest: Duration,
    /// After a round in which an engine's turn took longer than this, each of them makes one more frame first, which does not count: virtual machines
    /// may take memory away that nobody has touched for seconds, and no frame of a renderer waits like that for the next.
    pub stale: Duration,
}

/// Runs the engines by turns.
///
/// # Errors
/// What an engine says.
pub fn measure(
    engines: &mut [Box<dyn Engine>],
    case: &Arc<Case>,
    pool: &ThreadPool,
    patience: Patience,
) -> Result<Vec<Measured>> {
    let mut all = Vec::new();
    for engine in engines.iter_mut() {
        engine.prepare(case).with_context(|| engine.name().to_owned())?;
        let mask = vec![0; case.samples.len()];
        let (name, exact) = (engine.name().to_owned(), engine.exact());
        all.push(Measured { name, setup: String::new(), exact, frames: Vec::new(), mask });
    }
    let start = Instant::now();
    let mut twice = false;
    for round in 0..=patience.rounds {
        if round > 1 && start.elapsed() > patience.budget {
            break;
        }
        let mut longest = Duration::ZERO;
        for (engine, measured) in engines.iter_mut().zip(&mut all) {
            let mut next = || {
                sleep(patience.rest);
                frame(engine.as_mut(), pool, &mut measured.mask).with_context(|| measured.name.clone())
            };
            if twice {
                next()?;
            }
            let turn = Instant::now();
            let frame = next()?;
            longest = longest.max(turn.elapsed());
            if round > 0 {
                measured.frames.push(frame);
            }
            measured.setup = engine.setup();
        }
        twice = longest > patience.stale;
    }
    Ok(all)
}

fn frame(engine: &mut dyn Engine, pool: &ThreadPool, mask: &mut [u8]) -> Result<Frame> {
    let cpu = ProcessTime::try_now()?;
    let time = pool.install(|| engine.frame(mask))?;
    let cpu_ms = cpu.try_elapsed()?.as_secs_f64() * 1e3 / pool.current_num_threads() as f64;
    Ok(Frame { time, cpu_ms })
}
