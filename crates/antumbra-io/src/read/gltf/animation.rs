//! Keyframes, and the pose that they make at a time.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use gltf::json::animation::{Interpolation, Property};

use super::math::{Trs, slerp};
use super::nodes::{Local, Tree};
use super::source::{Source, label};
use crate::Error;

/// What moves one property of one node.
#[derive(Debug)]
struct Channel {
    node: usize,
    property: Property,
    interpolation: Interpolation,
    /// Seconds, increasing; at least one.
    times: Arc<[f32]>,
    /// `width` numbers a key; three times as many for cubic splines (in-tangent, value, out-tangent).
    values: Vec<f32>,
    width: usize,
}

/// All animations of a file, as if played together.
#[derive(Debug, Default)]
pub(super) struct Animation {
    channels: Vec<Channel>,
}

/// How the nodes stand at a time.
pub(super) struct Pose {
    /// One a node.
    pub(super) locals: Vec<Local>,
    /// Weights of morph targets of the nodes whose weights are animated.
    pub(super) weights: BTreeMap<usize, Vec<f32>>,
}

impl Animation {
    /// Reads all channels that can be played. Where several aim at the same property of a node, the first wins;
    /// those without a target node or with an unknown property are left out, as glTF asks for.
    ///
    /// `targets` is the number of morph targets of a mesh.
    pub(super) fn read(
        source: &Source<'_>,
        tree: &Tree,
        targets: impl Fn(usize) -> usize,
    ) -> Result<Animation, Error> {
        let mut taken = BTreeSet::new();
        let mut inputs: BTreeMap<usize, Arc<[f32]>> = BTreeMap::new();
        let mut channels = Vec::new();
        for (a, animation) in source.root.animations.iter().enumerate() {
            let name = label("animation", a, animation.name.as_deref());
            for (c, channel) in animation.channels.iter().enumerate() {
                let user = format!("{name}, channel {c}");
                let Ok(property) = source.known(&channel.target.path, "path", &user) else { continue };
                let node = channel.target.node.value();
                let target = source.item(&tree.nodes, node, "node", &user)?;
                if !taken.insert((node, property as u8)) {
                    continue;
                }
                let width = match property {
                    Property::Translation | Property::Scale => 3,
                    Property::Rotation => 4,
                    Property::MorphTargetWeights => target.mesh.map_or(0, &targets),
                };
                if width == 0 {
                    continue;
                }
                if property != Property::MorphTargetWeights && matches!(target.local, Local::Matrix(_)) {
                    let what = format!(
                        "{user}: moves {}, which has a matrix; only nodes without can be animated",
                        target.label
                    );
                    return Err(source.error(what));
                }
                let sampler = source.item(&animation.samplers, channel.sampler.value(), "sampler", &user)?;
                let interpolation = source.known(&sampler.interpolation, "interpolation", &user)?;
                let input = sampler.input.value();
                let times = match inputs.get(&input) {
                    Some(times) => times.clone(),
                    None => read_times(source, input, &user)?,
                };
                inputs.insert(input, times.clone());
                let values = read_values(source, sampler.output.value(), property, &user)?;
                let keys = if interpolation == Interpolation::CubicSpline { 3 } else { 1 };
                let expected = times.len().saturating_mul(keys * width);
                super::accessor::same_length(source, &user, "the output", values.len(), expected)?;
                channels.push(Channel { node, property, interpolation, times, values, width });
            }
        }
        Ok(Animation { channels })
    }

    /// First and last key of all channels.
    pub(super) fn time_span(&self) -> Option<[f32; 2]> {
        let ends = self.channels.iter().filter_map(|c| Some([*c.times.first()?, *c.times.last()?]));
        ends.reduce(|a, b| [a[0].min(b[0]), a[1].max(b[1])])
    }

    /// The pose at `time`; each channel holds its first and last value outside of its own keys. `None`: the rest pose.
    pub(super) fn pose(&self, tree: &Tree, time: Option<f32>) -> Pose {
        let mut pose =
            Pose { locals: tree.nodes.iter().map(|n| n.local).collect(), weights: BTreeMap::new() };
        let Some(time) = time else { return pose };
        for channel in &self.channels {
            let value = channel.sample(time);
            if channel.property == Property::MorphTargetWeights {
                pose.weights.insert(channel.node, value.iter().map(|&v| v as f32).collect());
            } else if let Local::Trs(trs) = &mut pose.locals[channel.node] {
                channel.put(trs, &value);
            }
        }
        pose
    }
}

impl Channel {
    fn put(&self, trs: &mut Trs, value: &[f64]) {
        match (self.property, value) {
            (Property::Translation, &[x, y, z]) => trs.translation = [x, y, z],
            (Property::Scale, &[x, y, z]) => trs.scale = [x, y, z],
            (Property::Rotation, &[x, y, z, w]) => trs.rotation = [x, y, z, w],
            // `read` gave each property its width.
            _ => {}
        }
    }

    /// The value at `time` (glTF 2.0, appendix C).
    fn sample(&self, time: f32) -> Vec<f64> {
        let after = self.times.partition_point(|&t| t <= time);
        let before = after.saturating_sub(1);
        if after == 0 || after == self.times.len() || self.interpolation == Interpolation::Step {
            return self.value(before);
        }
        let (t0, t1) = (f64::from(self.times[before]), f64::from(self.times[after]));
        // Not 0: `partition_point` put `time` between the two.
        let span = t1 - t0;
        let s = (f64::from(time) - t0) / span;
        let (a, b) = (self.value(before), self.value(after));
        match (self.interpolation, self.property) {
            (Interpolation::CubicSpline, _) => {
                let (out, into) = (self.part(before, 2), self.part(after, 0));
                let (s2, s3) = (s * s, s * s * s);
                let [h0, h1] = [2.0 * s3 - 3.0 * s2 + 1.0, -2.0 * s3 + 3.0 * s2];
                let [g0, g1] = [(s3 - 2.0 * s2 + s) * span, (s3 - s2) * span];
                (0..self.width).map(|k| h0 * a[k] + g0 * out[k] + h1 * b[k] + g1 * into[k]).collect()
            }
            (_, Property::Rotation) => slerp([a[0], a[1], a[2], a[3]], [b[0], b[1], b[2], b[3]], s).to_vec(),
            _ => a.iter().zip(&b).map(|(a, b)| a + (b - a) * s).collect(),
        }
    }

    /// The value of a key.
    fn value(&self, key: usize) -> Vec<f64> {
        self.part(key, 1)
    }

    /// In-tangent (0), value (1) or out-tangent (2) of a key.
    fn part(&self, key: usize, part: usize) -> Vec<f64> {
        let at = if self.interpolation == Interpolation::CubicSpline { key * 3 + part } else { key };
        self.values[at * self.width..][..self.width].iter().copied().map(f64::from).collect()
    }
}

fn read_times(source: &Source<'_>, accessor: usize, user: &str) -> Result<Arc<[f32]>, Error> {
    let times = source.scalars(accessor, &[1], user)?.values;
    if times.is_empty() {
        return Err(source.error(format!("{user}: there are no keys")));
    }
    if let Some(key) = times.iter().position(|t| !t.is_finite()) {
        return Err(source.error(format!("{user}: the time of key {key} is {}", times[key])));
    }
    if let Some(key) = times.windows(2).position(|w| w[1] < w[0]) {
        let (a, b) = (times[key], times[key + 1]);
        return Err(source
            .error(format!("{user}: the time of key {} ({b}) is before that of key {key} ({a})", key + 1)));
    }
    Ok(times.into())
}

/// The output numbers, flat.
fn read_values(
    source: &Source<'_>,
    accessor: usize,
    property: Property,
    user: &str,
) -> Result<Vec<f32>, Error> {
    let width = match property {
        Property::Translation | Property::Scale => 3,
        Property::Rotation => 4,
        Property::MorphTargetWeights => 1,
    };
    let values = source.scalars(accessor, &[width], user)?.values;
    if let Some(at) = values.iter().position(|v| !v.is_finite()) {
        return Err(source.error(format!("{user}: value {} is not a finite number", at / width)));
    }
    Ok(values)
}
