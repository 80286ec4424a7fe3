//! Any method of antumbra, by name.

use std::sync::Arc;
use std::time::Instant;

use antumbra::methods::{Method, Options, create, info};
use anyhow::{Context, Result};
use bench_common::{Case, Engine, FrameTime, ms_since};

/// The method that `auto` stands for where the catalogue does not know that word.
const FALLBACK: &str = "ray-cast";

/// A method of the catalogue.
pub struct Antumbra {
    name: String,
    method: Box<dyn Method>,
    exact: bool,
    case: Option<Arc<Case>>,
    isa: &'static str,
}

impl Antumbra {
    /// Finds the method; `auto` is the one that the library would pick.
    ///
    /// # Errors
    /// A name that nobody knows; the message lists those there are.
    pub fn new(method: &str) -> Result<Antumbra> {
        let found = match info(method) {
            Err(_) if method == "auto" => info(FALLBACK)?,
            found => found?,
        };
        Ok(Antumbra {
            name: format!("antumbra:{method}"),
            method: create(found.name, &Options::default())?,
            exact: found.exact,
            case: None,
            isa: "",
        })
    }
}

impl Engine for Antumbra {
    fn name(&self) -> &str {
        &self.name
    }

    fn setup(&self) -> String {
        format!("{}, {}", self.method.name(), self.isa)
    }

    fn exact(&self) -> bool {
        self.exact
    }

    fn prepare(&mut self, case: &Arc<Case>) -> Result<()> {
        self.case = Some(case.clone());
        Ok(())
    }

    fn frame(&mut self, mask: &mut [u8]) -> Result<FrameTime> {
        let case = self.case.as_ref().context("frame before prepare")?;
        let start = Instant::now();
        let stats = self.method.shadow(case.triangles(), case.asked(), case.light, mask)?;
        // The caller's clock, not the method's own: it holds the making of the statistics, too.
        let total_ms = ms_since(start);
        self.isa = stats.isa;
        let build_ms = stats.stages.iter().filter(|s| s.name.starts_with("build")).map(|s| s.ms).sum();
        Ok(FrameTime { build_ms, trace_ms: total_ms - build_ms, total_ms })
    }
}
