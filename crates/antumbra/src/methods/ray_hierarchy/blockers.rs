//! Which triangles go first (section 3.4 of the paper, which leaves the choice open).
//!
//! A good blocker covers whole nodes. Its score is about the solid angle that it fills, `area · cos / r² = |det| / (2 r³)`; it
//! must not be small against a node of 64 rays, and there must not be many of them, as all others wait.

use antumbra_predicates::Triangle;
use rayon::prelude::*;

use super::options::RayHierarchyOptions;
use super::vector::{cross, dot};

/// The triangles of both passes; the order within each is that of the soup.
#[derive(Debug, Default)]
pub(super) struct Passes {
    /// Pass 1.
    pub(super) blockers: Vec<u32>,
    /// Pass 2.
    pub(super) rest: Vec<u32>,
    scores: Vec<f32>,
}

/// About the solid angle that a triangle fills as seen from the light.
fn score(t: &Triangle, light: [f32; 3]) -> f32 {
    let p = t.map(|v| [0, 1, 2].map(|k| f64::from(v[k]) - f64::from(light[k])));
    let edge = |k: usize| [0, 1, 2].map(|i| p[k][i] - p[0][i]);
    let det = dot(cross(edge(1), edge(2)), p[0]);
    let centre = [0, 1, 2].map(|k| (p[0][k] + p[1][k] + p[2][k]) / 3.0);
    let r = dot(centre, centre).sqrt();
    (det.abs() / (2.0 * r * r * r)) as f32
}

impl Passes {
    /// Chooses the blockers; `mean` is the mean solid angle of the nodes that they are compared with.
    pub(super) fn choose(
        &mut self,
        triangles: &[Triangle],
        light: [f32; 3],
        mean: f64,
        options: &RayHierarchyOptions,
    ) {
        triangles.par_iter().with_min_len(1024).map(|t| score(t, light)).collect_into_vec(&mut self.scores);
        let least = (mean * options.blocker_solid_angle) as f32;
        let good = |score: f32| score > least;
        let limit = (triangles.len() as f64 * options.blocker_share).ceil() as usize;
        let scores = &self.scores;
        self.blockers.clear();
        self.blockers.extend((0..triangles.len() as u32).filter(|i| good(scores[*i as usize])));
        if limit < self.blockers.len() {
            self.blockers.select_nth_unstable_by(limit, |a, b| {
                scores[*b as usize].total_cmp(&scores[*a as usize]).then(a.cmp(b))
            });
            self.blockers.truncate(limit);
            self.blockers.sort_unstable();
        }
        self.rest.clear();
        let mut next = self.blockers.iter().copied().peekable();
        self.rest.extend((0..triangles.len() as u32).filter(|i| next.next_if_eq(i).is_none()));
    }

    pub(super) fn bytes(&self) -> usize {
        (self.blockers.len() + self.rest.len() + self.scores.len()) * 4
    }
}
