//! A ball of thin hairs: the hardest case for hierarchies over triangles, as every box is full of gaps.

use rayon::prelude::*;

use super::Arguments;
use super::build::{Builder, round};
use super::math::{Rng, V3, add, cross, scale, turn, unit};
use super::shapes::frames;

/// Points along a hair; the first and the last are tips.
const POINTS: usize = 42;
/// A closed three-sided tube: 40 rings make 39 rows of 6, and 3 triangles at each tip.
const TRIANGLES: usize = 6 * (POINTS - 2);
const CENTRE: V3 = [0.0, 1.3, 0.0];

pub(super) fn hairball(arguments: &Arguments, b: &mut Builder) {
    let hairs = (arguments.size.saturating_sub(6) / TRIANGLES).max(1);
    // Fewer hairs are thicker ones, so that a small ball looks like one.
    let radius = (0.0034 * (12_000.0 / hairs as f64).sqrt()).clamp(0.0016, 0.015);
    let mut triangles = Vec::with_capacity(hairs * TRIANGLES + 16);
    triangles.resize(hairs * TRIANGLES, [[0.0; 3]; 3]);
    // Each hair has its own stream of random numbers and its own place in the array: the order of work is free.
    triangles.par_chunks_mut(TRIANGLES).enumerate().for_each(|(k, out)| {
        hair(&mut Rng::new(arguments.seed, k as u64), radius, out);
    });
    b.object("hair").paint("hair", 0xb06a3b).world_triangles(triangles);
    b.object("floor").paint("floor", 0xcfc6b4);
    b.quad([[-4.0, 0.0, -2.6], [-4.0, 0.0, 5.0], [4.0, 0.0, 5.0], [4.0, 0.0, -2.6]]);
    b.object("walls").paint("wall", 0x9fb4b8);
    b.quad([[-4.0, 0.0, -2.6], [4.0, 0.0, -2.6], [4.0, 5.0, -2.6], [-4.0, 5.0, -2.6]]);
    b.quad([[4.0, 0.0, -2.6], [4.0, 0.0, 5.0], [4.0, 5.0, 5.0], [4.0, 5.0, -2.6]]);
    b.light([-2.7, 3.4, 2.6], 0xfff3e0, 4.4).camera([-0.9, 2.0, 5.4], [0.45, 1.22, -0.3], 36.0);
}

/// A strand that leaves the middle, sweeps around a random axis and curls.
fn hair(rng: &mut Rng, radius: f64, out: &mut [[[f32; 3]; 3]]) {
    let from = rng.direction();
    let axis = unit(cross(from, rng.direction()));
    let side = cross(axis, from);
    let (reach, sweep) = (0.78 + 0.4 * rng.unit() * rng.unit(), rng.range(0.1, 0.5));
    let (curls, curl, phase) = (rng.range(1.0, 3.5), rng.range(0.01, 0.09), rng.unit());
    let path: [V3; POINTS] = std::array::from_fn(|k| {
        let t = k as f64 / (POINTS - 1) as f64;
        let (cos, sin) = turn(sweep * t);
        let outward = add(scale(from, cos), scale(side, sin));
        let along = add(scale(side, cos), scale(from, -sin));
        let (c, s) = turn(curls * t + phase);
        // Quick to the outside, then along it.
        let r = reach * (0.25 + 0.75 * t * (2.0 - t)) + curl * t * c;
        add(CENTRE, add(scale(outward, r), add(scale(axis, curl * t * s), scale(along, curl * t * c))))
    });
    let frames = frames(&path);
    let ring = |k: usize| {
        // Thin at the root, thickest early, pointed at the end.
        let t = k as f64 / (POINTS - 1) as f64;
        let r = radius * (0.35 + 0.65 * (1.0 - t) * (0.4 + t).min(1.0));
        [0.0, 1.0 / 3.0, 2.0 / 3.0].map(|u| {
            let (cos, sin) = turn(u);
            round(add(path[k], add(scale(frames[k][0], r * cos), scale(frames[k][1], r * sin))))
        })
    };
    let (root, tip) = (round(path[0]), round(path[POINTS - 1]));
    let mut out = out.iter_mut();
    let mut push = |triangle| *out.next().expect("as many triangles as TRIANGLES says") = triangle;
    let mut lower = ring(1);
    (0..3).for_each(|i| push([root, lower[(i + 1) % 3], lower[i]]));
    for k in 2..POINTS - 1 {
        let upper = ring(k);
        for i in 0..3 {
            let j = (i + 1) % 3;
            push([lower[i], lower[j], upper[j]]);
            push([lower[i], upper[j], upper[i]]);
        }
        lower = upper;
    }
    (0..3).for_each(|i| push([lower[i], lower[(i + 1) % 3], tip]));
}
