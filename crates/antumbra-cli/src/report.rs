//! The JSON that programs read. Keys are added, never renamed, without a new [`SCHEMA_VERSION`].

use antumbra::methods::{Stage, Stats};
use antumbra::scene::Camera;
use serde::{Serialize, Serializer};

/// Version of the shape of all JSON that the program writes.
pub(crate) const SCHEMA_VERSION: u32 = 1;

/// A stage and its wall time.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct StageReport {
    pub(crate) name: &'static str,
    pub(crate) ms: f64,
}

impl From<&Stage> for StageReport {
    fn from(stage: &Stage) -> StageReport {
        StageReport { name: stage.name, ms: stage.ms }
    }
}

/// Named numbers, in their own order.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Named(pub(crate) Vec<(&'static str, u64)>);

impl Serialize for Named {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_map(self.0.iter().map(|(name, value)| (name, value)))
    }
}

/// What `--stats` holds: one call of a method, or several of one method summed up.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct StatsReport {
    pub(crate) schema_version: u32,
    pub(crate) method: &'static str,
    pub(crate) backend: &'static str,
    pub(crate) isa: &'static str,
    pub(crate) threads: usize,
    pub(crate) samples: usize,
    pub(crate) triangles: usize,
    pub(crate) shadowed: usize,
    pub(crate) stages: Vec<StageReport>,
    pub(crate) total_ms: f64,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub(crate) runs_ms: Vec<f64>,
    pub(crate) bytes: Named,
    pub(crate) counters: Named,
}

impl StatsReport {
    /// One call.
    pub(crate) fn new(stats: &Stats) -> StatsReport {
        StatsReport {
            schema_version: SCHEMA_VERSION,
            method: stats.method,
            backend: stats.backend,
            isa: stats.isa,
            threads: stats.threads,
            samples: stats.samples,
            triangles: stats.triangles,
            shadowed: stats.shadowed,
            stages: stats.stages.iter().map(StageReport::from).collect(),
            total_ms: stats.total_ms,
            runs_ms: Vec::new(),
            bytes: Named(stats.bytes.to_vec()),
            counters: Named(stats.counters.to_vec()),
        }
    }

    /// Several runs on the same input: all times and their median, with the stages of the run nearest to it.
    pub(crate) fn of_runs(runs: &[Stats]) -> Option<StatsReport> {
        let times: Vec<f64> = runs.iter().map(|s| s.total_ms).collect();
        let median = median(&times)?;
        let nearest =
            runs.iter().min_by(|a, b| (a.total_ms - median).abs().total_cmp(&(b.total_ms - median).abs()))?;
        Some(StatsReport { total_ms: median, runs_ms: times, ..StatsReport::new(nearest) })
    }

    /// Several lights of one picture: times, shadows and counters summed, buffers at their largest.
    pub(crate) fn of_lights(lights: &[Stats]) -> Option<StatsReport> {
        let (first, others) = lights.split_first()?;
        let mut sum = StatsReport::new(first);
        for other in others {
            sum.samples += other.samples;
            sum.triangles = sum.triangles.max(other.triangles);
            sum.shadowed += other.shadowed;
            sum.total_ms += other.total_ms;
            for stage in &other.stages {
                match sum.stages.iter_mut().find(|s| s.name == stage.name) {
                    Some(s) => s.ms += stage.ms,
                    None => sum.stages.push(stage.into()),
                }
            }
            gather(&mut sum.bytes.0, &other.bytes, |a, b| a.max(b));
            gather(&mut sum.counters.0, &other.counters, |a, b| a + b);
        }
        Some(sum)
    }
}

fn gather(into: &mut Vec<(&'static str, u64)>, from: &[(&'static str, u64)], join: fn(u64, u64) -> u64) {
    for &(name, value) in from {
        match into.iter_mut().find(|(n, _)| *n == name) {
            Some((_, v)) => *v = join(*v, value),
            None => into.push((name, value)),
        }
    }
}

/// The middle value; the mean of the two in the middle of an even number.
pub(crate) fn median(values: &[f64]) -> Option<f64> {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let upper = *sorted.get(sorted.len() / 2)?;
    let lower = sorted[(sorted.len() - 1) / 2];
    Some(lower + (upper - lower) / 2.0)
}

/// A camera, and why that one.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct CameraReport {
    pub(crate) name: String,
    pub(crate) eye: [f32; 3],
    pub(crate) target: [f32; 3],
    pub(crate) up: [f32; 3],
    pub(crate) fov: f32,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) rule: Option<&'static str>,
}

impl CameraReport {
    pub(crate) fn new(camera: &Camera, rule: Option<&'static str>) -> CameraReport {
        let Camera { name, eye, target, up, fov } = camera.clone();
        CameraReport { name, eye, target, up, fov, rule }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn stats(total_ms: f64) -> Stats {
        Stats {
            method: "oracle",
            total_ms,
            shadowed: 2,
            stages: vec![Stage { name: "test_all", ms: total_ms }].into(),
            bytes: vec![("tree", 10)].into(),
            counters: vec![("leaf_tests", 3)].into(),
            ..Stats::default()
        }
    }

    #[test]
    fn medians() {
        assert_eq!(median(&[3.0, 1.0, 2.0]), Some(2.0));
        assert_eq!(median(&[4.0, 1.0, 2.0, 3.0]), Some(2.5));
        assert_eq!(median(&[]), None);
        let report = StatsReport::of_runs(&[stats(9.0), stats(1.0), stats(5.0)]).unwrap();
        assert_eq!((report.total_ms, report.stages[0].ms), (5.0, 5.0));
        assert_eq!(report.runs_ms, [9.0, 1.0, 5.0]);
    }

    #[test]
    fn lights_add_up_and_keys_keep_their_order() {
        let report = StatsReport::of_lights(&[stats(1.0), stats(2.0)]).unwrap();
        assert_eq!((report.total_ms, report.shadowed, report.stages[0].ms), (3.0, 4, 3.0));
        assert_eq!((report.bytes.0[0].1, report.counters.0[0].1), (10, 6));
        let json = serde_json::to_string(&report).unwrap();
        let places: Vec<usize> = ["schema_version", "method", "stages", "total_ms", "bytes", "counters"]
            .map(|k| json.find(k).unwrap())
            .into();
        assert!(places.is_sorted(), "{json}");
        assert!(!json.contains("runs_ms"));
    }
}
