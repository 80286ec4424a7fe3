//! Primary visibility: what the eye sees in each pixel, as a view sample.
//!
//! Packets of 8 x 8 pixel rays are walked through the same hierarchy as shadow rays, nearest children first. f32 lanes
//! find candidates (closed triangles: no cracks), f64 decides the nearest, so pictures are the same for every
//! instruction set and thread count. The eye looks through the holes of alpha masks and through surfaces that
//! are more than half transparent.

use antumbra_predicates::{Coefficients, Resolver};
use fearless_simd::{Simd, SimdBase, SimdMask, dispatch, f32x8};
use rayon::prelude::*;

use super::view::{cross, dot, normalize};
use super::{NO_SAMPLE, View, ViewSamples, offset};
use crate::Isa;
use crate::bvh::packet::{Cone, PACKET, Packet, Stack, Visitor, WalkCounts, walk};
use crate::bvh::{Bvh, Leaf, WIDTH};
use crate::scene::{Camera, Scene};

/// Pixels of a tile's side.
const TILE: usize = 8;

/// The view samples of a picture, and where on their triangles they lie.
#[derive(Clone, Debug, Default)]
pub struct GBuffer {
    /// The samples.
    pub samples: ViewSamples,
    /// Weights of the triangle's second and third corner.
    pub bary: Vec<[f32; 2]>,
}

/// Options of [`render`].
#[derive(Clone, Copy, Debug, Default)]
pub struct GBufferOptions {
    /// Instruction set of the kernels.
    pub isa: Isa,
}

/// Finds the sample of every pixel.
pub fn render(
    scene: &Scene,
    camera: &Camera,
    width: usize,
    height: usize,
    options: &GBufferOptions,
) -> GBuffer {
    let mut bvh = Bvh::default();
    bvh.build(&scene.soup.positions);
    let frame = View::new(camera, width, height);
    // Rays end well beyond everything: the farther, the finer the directions that f32 end points can name.
    let reach = (0..8)
        .map(|corner| {
            let d = [0, 1, 2].map(|k| {
                let v = if corner >> k & 1 == 0 { bvh.bounds.lo[k] } else { bvh.bounds.hi[k] };
                f64::from(v) - frame.eye[k]
            });
            dot(d, d).sqrt()
        })
        .fold(0.0, f64::max);
    let reach = if reach.is_finite() { reach * 4.0 } else { 1.0 };
    let count = width * height;
    let mut out = GBuffer {
        samples: ViewSamples {
            width,
            height,
            positions: vec![NO_SAMPLE; count],
            normals: vec![[0.0; 3]; count],
            triangle: vec![u32::MAX; count],
            depth: vec![f32::INFINITY; count],
            view: Some(frame),
        },
        bary: vec![[0.0; 2]; count],
    };
    let level = options.isa.level().unwrap_or_else(fearless_simd::Level::new);
    let job = Job { scene, bvh: &bvh, frame, reach, width, height };
    let band = (width * TILE).max(1);
    let samples = &mut out.samples;
    samples
        .positions
        .par_chunks_mut(band)
        .zip(samples.normals.par_chunks_mut(band))
        .zip(samples.triangle.par_chunks_mut(band))
        .zip(samples.depth.par_chunks_mut(band))
        .zip(out.bary.par_chunks_mut(band))
        .enumerate()
        .for_each(|(index, ((((positions, normals), triangle), depth), bary))| {
            let band = Band { first_row: index * TILE, positions, normals, triangle, depth, bary };
            dispatch!(level, s => render_band(s, &job, band));
        });
    out
}

struct Job<'a> {
    scene: &'a Scene,
    bvh: &'a Bvh,
    frame: View,
    reach: f64,
    width: usize,
    height: usize,
}

/// The output of a row of tiles.
struct Band<'a> {
    first_row: usize,
    positions: &'a mut [[f32; 3]],
    normals: &'a mut [[f32; 3]],
    triangle: &'a mut [u32],
    depth: &'a mut [f32],
    bary: &'a mut [[f32; 2]],
}

#[inline(always)]
fn render_band<S: Simd>(s: S, job: &Job<'_>, band: Band<'_>) {
    let eye = job.frame.eye.map(|v| v as f32);
    let rows = band.positions.len() / job.width;
    let mut stack = Stack::default();
    let mut packet = Packet::EMPTY;
    for tile in 0..job.width.div_ceil(TILE) {
        packet.count = 0;
        for row in 0..rows {
            for x in tile * TILE..job.width.min((tile + 1) * TILE) {
                let d = job.frame.direction(x, band.first_row + row, job.width, job.height);
                let p = [0, 1, 2].map(|k| (job.frame.eye[k] + d[k] * job.reach) as f32);
                packet.push(p, (row * job.width + x) as u32);
            }
        }
        packet.pad();
        let cone = Cone::new(eye, packet.bounds(), &job.bvh.bounds);
        let mut nearest = Nearest::new(&packet, cone, eye, job.scene);
        let mut counts = WalkCounts::default();
        s.vectorize(
            #[inline(always)]
            || walk::<S, _, true>(s, job.bvh, &cone, &mut stack, &mut counts, &mut nearest),
        );
        for i in 0..packet.count {
            let Some(hit) = nearest.hit(i) else { continue };
            let at = packet.id[i] as usize;
            let Some((position, normal)) = surface_point(job, eye, &hit) else { continue };
            band.positions[at] = position;
            band.normals[at] = normal;
            band.triangle[at] = hit.triangle;
            band.bary[at] = hit.bary.map(|v| v as f32);
            let d = [0, 1, 2].map(|k| f64::from(position[k]) - job.frame.eye[k]);
            band.depth[at] = dot(d, job.frame.forward) as f32;
        }
    }
}

/// The sample of a hit: on the triangle, moved to the eye's side, and the geometric normal.
fn surface_point(job: &Job<'_>, eye: [f32; 3], hit: &Hit) -> Option<([f32; 3], [f32; 3])> {
    let t = &job.scene.soup.positions[hit.triangle as usize];
    let v = t.map(|v| v.map(f64::from));
    let edge = |i: usize| [0, 1, 2].map(|k| v[i][k] - v[0][k]);
    let (ab, ac) = (edge(1), edge(2));
    let position = [0, 1, 2].map(|k| v[0][k] + hit.bary[0] * ab[k] + hit.bary[1] * ac[k]);
    let facing = antumbra_predicates::exact::facing(t, eye);
    // The normal of the corner order points away from the eye where the determinant is positive.
    let normal = normalize(cross(ab, ac))?.map(|n| n * -f64::from(facing));
    let position = offset::to_side(position, normal, t, -facing)?;
    Some((position, normal.map(|n| n as f32)))
}

/// Where a ray first meets the scene.
#[derive(Clone, Copy, Debug)]
struct Hit {
    triangle: u32,
    bary: [f64; 2],
}

/// Finds the nearest triangle of each ray of a packet.
struct Nearest<'a> {
    packet: &'a Packet,
    cone: Cone,
    eye: [f32; 3],
    scene: &'a Scene,
    coefficients: Coefficients,
    /// Ray parameters of the nearest hits so far, rounded up.
    near: [f32; PACKET],
    /// The same in f64, and what was hit.
    best: [(f64, Hit); PACKET],
    limit: f32,
}

impl<'a> Nearest<'a> {
    fn new(packet: &'a Packet, cone: Cone, eye: [f32; 3], scene: &'a Scene) -> Self {
        let nothing = (f64::INFINITY, Hit { triangle: u32::MAX, bary: [0.0; 2] });
        Nearest {
            packet,
            cone,
            eye,
            scene,
            coefficients: Coefficients::ZERO,
            near: [1.0; PACKET],
            best: [nothing; PACKET],
            limit: 1.0,
        }
    }

    fn hit(&self, i: usize) -> Option<Hit> {
        let (t, hit) = self.best[i];
        t.is_finite().then_some(hit)
    }

    /// Takes the triangle for ray `i` if it is nearer than what is there (ties: the lower index).
    fn offer(&mut self, i: usize, triangle: u32, resolver: &Resolver) {
        let Some((t, bary)) = resolver.intersect(self.packet.point(i)) else { return };
        let (best, hit) = self.best[i];
        if t > best || (t == best && triangle > hit.triangle) || !self.scene.is_there(triangle, bary) {
            return;
        }
        self.best[i] = (t, Hit { triangle, bary });
        self.near[i] = (t as f32).next_up();
    }
}

impl Visitor for Nearest<'_> {
    #[inline(always)]
    fn limit(&self) -> f32 {
        self.limit
    }

    #[inline(always)]
    fn leaf<S: Simd>(&mut self, s: S, leaf: &Leaf) -> bool {
        let live = leaf.live();
        let verdict = leaf.block.against(s, live, self.eye, &self.cone.group, &mut self.coefficients);
        let mut maybe = verdict.maybe;
        let mut changed = false;
        while maybe != 0 {
            let lane = maybe.trailing_zeros() as usize;
            maybe &= maybe - 1;
            let triangle = leaf.id[lane];
            let mut resolver = None;
            let edge_on = verdict.edge_on >> lane & 1 == 1;
            for vector in 0..self.packet.vectors() {
                let base = vector * WIDTH;
                let p = self.packet.load(s, vector);
                let lanes = self.coefficients.test(s, lane, p);
                let mut candidates = lanes.blocked | lanes.unsure;
                if edge_on {
                    candidates = 0xff;
                } else if candidates != 0 {
                    let depth = self.coefficients.depth(s, lane, p);
                    // f32 depths are good to a few units of the last place; f64 compares again.
                    let near = f32x8::from_slice(s, &self.near[base..base + WIDTH]) * (1.0 + 1e-4);
                    candidates &= !(depth.simd_gt(near).to_bitmask() as u8) | lanes.unsure;
                }
                let used = (self.packet.all() >> base) as u8;
                candidates &= used;
                if candidates == 0 {
                    continue;
                }
                let resolver = resolver.get_or_insert_with(|| {
                    Resolver::new(&self.scene.soup.positions[triangle as usize], self.eye)
                });
                let Some(resolver) = *resolver else { break };
                changed = true;
                while candidates != 0 {
                    let i = base + candidates.trailing_zeros() as usize;
                    candidates &= candidates - 1;
                    self.offer(i, triangle, &resolver);
                }
            }
        }
        if changed {
            self.limit = self.near[..self.packet.count].iter().fold(0.0, |m: f32, v| m.max(*v));
        }
        false
    }
}
