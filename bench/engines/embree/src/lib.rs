//! Embree 4: what a user on a CPU would otherwise do. A hierarchy over the triangles every frame, and one any-hit ray a sample.
//!
//! The default is the combination that was fastest in total on the machines tried (`bench/README.md`): quality LOW, rebuilt on
//! the same scene object so that its memory is warm, packets of 8 (16 where they are one vector), the coherent flag, rays from
//! the light, not robust. Other combinations are options, for whoever doubts it.
//!
//! A ray's end at the sample is cut by a relative epsilon, the usual guard against self-shadowing, so masks differ from exact ones.

mod ffi;
mod options;
mod trace;

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Instant;

use anyhow::{Context, Result, bail};
use bench_common::{Case, Engine, FrameTime, ms_since};

use ffi::{Device, Scene};
use options::Options;

/// The environment variable that says where the shared library is.
pub const LIBRARY: &str = "ANTUMBRA_EMBREE_LIB";

/// Embree as an engine.
pub struct Embree {
    name: String,
    options: Options,
    device: Arc<Device>,
    /// With what is left out of each ray.
    scene: Option<(Arc<Case>, Scene, f32)>,
}

impl Embree {
    /// Loads the library that [`LIBRARY`] names. `options` are joined by colons, e.g. `sample:robust`; empty for the default.
    ///
    /// # Errors
    /// An unknown option, no library, or what Embree says.
    pub fn new(options: &str, threads: usize) -> Result<Embree> {
        let Some(path) = std::env::var_os(LIBRARY).map(PathBuf::from) else {
            bail!("{LIBRARY} is not set: bench/engines/embree/fetch.sh gets the library and prints its path");
        };
        Embree::load(&path, options, threads)
    }

    fn load(path: &Path, text: &str, threads: usize) -> Result<Embree> {
        let mut options = Options::parse(text)?;
        let device = Device::new(path, &format!("threads={threads}"))?;
        if !device.has_native_16() && !options.packet_told {
            options.packet = 8;
        }
        let name = if text.is_empty() { "embree".to_owned() } else { format!("embree:{text}") };
        Ok(Embree { name, options, device, scene: None })
    }
}

impl Engine for Embree {
    fn name(&self) -> &str {
        &self.name
    }

    fn setup(&self) -> String {
        format!("Embree {}, {}", self.device.version(), self.options)
    }

    fn prepare(&mut self, case: &Arc<Case>) -> Result<()> {
        self.scene = None;
        let scene = Scene::new(&self.device, case, self.options.quality, self.options.flags)?;
        self.scene = Some((case.clone(), scene, case.cut(self.options.epsilon)));
        Ok(())
    }

    fn frame(&mut self, mask: &mut [u8]) -> Result<FrameTime> {
        let (case, scene, cut) = self.scene.as_mut().context("frame before prepare")?;
        let start = Instant::now();
        if self.options.join {
            scene.rebuild_joined()?;
        } else {
            scene.rebuild()?;
        }
        let build_ms = ms_since(start);
        trace::trace(case, scene, &self.options, *cut, mask);
        let total_ms = ms_since(start);
        Ok(FrameTime { build_ms, trace_ms: total_ms - build_ms, total_ms })
    }
}
