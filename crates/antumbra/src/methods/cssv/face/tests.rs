//! The theorem behind the method on small scenes full of ties, and the bounds of the culling.

use antumbra_predicates::exact;
use fearless_simd::{Level, dispatch};

use super::super::adjacency::Adjacency;
use super::super::leaf::{Leaf, Offsets};
use super::super::reference::choose;
use super::super::silhouette::Casters;
use super::super::tiles::{Packet, Tree};
use super::super::traverse::Counts;
use super::super::tuning::PACKET;
use super::*;
use crate::methods::Samples;

struct Lattice(u64);

impl Lattice {
    fn below(&mut self, n: u64) -> u64 {
        self.0 = self.0.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (self.0 >> 33) % n
    }

    fn point(&mut self, n: u64) -> [f32; 3] {
        [0; 3].map(|_: i32| self.below(n) as f32 - (n / 2) as f32)
    }
}

struct Scene {
    triangles: Vec<Triangle>,
    samples: Vec<[f32; 3]>,
    casters: Casters,
    reference: Reference,
}

fn scene(seed: u64, triangles: usize, samples: usize) -> Scene {
    let mut lattice = Lattice(seed);
    let light = lattice.point(5);
    let triangles: Vec<Triangle> =
        (0..triangles).map(|_| [lattice.point(5), lattice.point(5), lattice.point(5)]).collect();
    let samples: Vec<_> = (0..samples).map(|_| lattice.point(7)).collect();
    scene_of(triangles, samples, light)
}

fn scene_of(triangles: Vec<Triangle>, samples: Vec<[f32; 3]>, light: [f32; 3]) -> Scene {
    let mut adjacency = Adjacency::default();
    adjacency.build(&triangles);
    let mut casters = Casters::default();
    casters.face(&triangles, light);
    casters.extract(&adjacency);
    let reference = choose(None, &samples, &triangles, &casters).expect("a generic point");
    Scene { triangles, samples, casters, reference }
}

impl Scene {
    fn faces(&self, pass: bool) -> (Faces<'_>, Vec<Face>) {
        let Casters { light, facing, edges } = &self.casters;
        let reference = self.reference;
        let make = Faces { pass, reference, light: *light, triangles: &self.triangles, facing, edges };
        let volumes = || (0..facing.len()).filter(|&t| facing[t] != 0).map(|t| t as u32);
        let mut all: Vec<Face> = (0..edges.len()).map(|e| make.side(e as u32)).collect();
        all.extend(volumes().map(|t| make.cap(t)));
        if !pass {
            all.extend(volumes().map(|t| make.far_cap(t)));
        }
        (make, all)
    }

    fn volumes(&self, p: [f32; 3]) -> i32 {
        let contain = |t: &&Triangle| exact::blocks(t, self.casters.light, p);
        self.triangles.iter().filter(contain).count() as i32
    }
}

#[test]
fn crossings_add_up_to_the_number_of_blocking_triangles() {
    for seed in 0..40 {
        let scene = scene(seed, 30, 60);
        for pass in [true, false] {
            let (make, faces) = scene.faces(pass);
            let start = if pass { scene.volumes(scene.reference.point) } else { 0 };
            for &p in &scene.samples {
                let crossed = faces.iter().filter(|f| make.decide(f.source, p)).map(|f| f.weight);
                assert_eq!(
                    start + crossed.sum::<i32>(),
                    scene.volumes(p),
                    "seed {seed}, z-pass {pass}, {p:?}"
                );
            }
        }
    }
}

#[test]
fn a_sample_at_the_reference_point_or_the_light_or_a_corner_is_counted_right() {
    for seed in 0..40 {
        let scene = scene(seed, 20, 10);
        for pass in [true, false] {
            let (make, faces) = scene.faces(pass);
            let at_eye = scene.volumes(scene.reference.point);
            for p in [scene.reference.point, scene.casters.light, scene.triangles[0][0]] {
                let crossed = faces.iter().filter(|f| make.decide(f.source, p)).map(|f| f.weight);
                let start = if pass { at_eye } else { 0 };
                assert_eq!(
                    start + crossed.sum::<i32>(),
                    scene.volumes(p),
                    "seed {seed}, z-pass {pass}, {p:?}"
                );
            }
        }
    }
}

#[test]
fn a_verdict_holds_for_every_sample_of_the_region() {
    let (mut accepted, mut rejected) = (0, 0);
    for seed in 0..30 {
        let scene = scene(seed, 30, 500);
        let mut tree = Tree::default();
        tree.build(Samples::list(&scene.samples), &scene.reference);
        let mut packet_of = vec![0; scene.samples.len()];
        tree.scatter(&mut packet_of, |out, packet, _| *out = packet);
        for pass in [true, false] {
            let (make, faces) = scene.faces(pass);
            for packet in 0..tree.packets() {
                let region = tree.bounds(0, packet).region().expect("in front of the reference point");
                for face in &faces {
                    let verdict = dispatch!(Level::new(), s => face.against(s, pass, &region));
                    let expected = match verdict {
                        Verdict::Refine => continue,
                        Verdict::Accept => true,
                        Verdict::Reject => false,
                    };
                    accepted += u32::from(expected);
                    rejected += u32::from(!expected);
                    for (p, _) in scene.samples.iter().zip(&packet_of).filter(|(_, at)| **at == packet) {
                        assert_eq!(make.decide(face.source, *p), expected);
                    }
                }
            }
        }
    }
    assert!(accepted > 50 && rejected > 500, "{accepted} accepted, {rejected} rejected");
}

/// Ties on the lattice, and the same far off the origin, where differences of coordinates are rounded.
#[test]
fn a_packet_is_counted_as_its_samples_are_decided() {
    let (mut crossings, mut counts) = (0, Counts::default());
    for seed in 0..24 {
        let mut scene = scene(seed, 24, 300);
        if seed % 2 == 1 {
            let far = |p: [f32; 3]| [p[0] * 0.37 + 1000.1, p[1] * 0.21 - 77.7, p[2] * 1.3];
            let triangles = scene.triangles.iter().map(|t| t.map(far)).collect();
            let samples = scene.samples.iter().map(|p| far(*p)).collect();
            scene = scene_of(triangles, samples, far(scene.casters.light));
        }
        let mut tree = Tree::default();
        tree.build(Samples::list(&scene.samples), &scene.reference);
        for pass in [true, false] {
            let (make, faces) = scene.faces(pass);
            for index in 0..tree.packets() {
                let mut packet = Packet::EMPTY;
                tree.load(&scene.samples, &scene.reference, index, &mut packet);
                let region = tree.bounds(0, index).region().expect("in front of the reference point");
                let offsets = Offsets::new(&packet, &region);
                for offsets in [Some((&offsets, &region)), None] {
                    for face in &faces {
                        let mut leaf = Leaf {
                            decide: &make,
                            positions: &scene.samples,
                            packet: &packet,
                            offsets,
                            count: [0; PACKET],
                        };
                        dispatch!(Level::new(), s => leaf.add(s, face, &mut counts));
                        for at in 0..packet.count {
                            let crossed = make.decide(face.source, scene.samples[packet.id[at] as usize]);
                            assert_eq!(leaf.count[at], if crossed { face.weight } else { 0 });
                            crossings += u64::from(crossed);
                        }
                    }
                }
            }
        }
    }
    assert_eq!(counts.leaf_hits, crossings);
    // Half of the packets were given to f32, which left some tests to f64, which left the ties.
    assert!(counts.filter_f64 - counts.leaf_tests / 2 > 1000, "{counts:?}");
    assert!(counts.filter_f64 < counts.leaf_tests * 3 / 4, "{counts:?}");
    assert!(counts.filter_exact > 1000, "{counts:?}");
}
