use super::*;
use crate::methods::Oracle;
use crate::scene::procedural;

/// Triangles, samples (a picture of `width`) and light of a built-in scene, and the oracle's mask.
fn case(spec: &str, size: [usize; 2]) -> (Vec<Triangle>, Vec<[f32; 3]>, [f32; 3], Vec<u8>) {
    let scene = procedural::builtin(spec, None).unwrap();
    let out = crate::samples::gbuffer::render(
        &scene,
        &scene.cameras[0],
        size[0],
        size[1],
        &crate::samples::gbuffer::GBufferOptions::default(),
    );
    let (triangles, positions, light) =
        (scene.soup.positions.clone(), out.samples.positions, scene.lights[0].position);
    let mask = oracle(&triangles, &positions, light);
    (triangles, positions, light, mask)
}

fn oracle(triangles: &[Triangle], positions: &[[f32; 3]], light: [f32; 3]) -> Vec<u8> {
    let mut mask = vec![7; positions.len()];
    Oracle.shadow(triangles, Samples::list(positions), light, &mut mask).unwrap();
    mask
}

fn counter(stats: &Stats, name: &str) -> u64 {
    stats.counters.iter().find(|c| c.0 == name).unwrap().1
}

#[test]
fn least_capacity_takes_rounds_and_gives_the_same_mask() {
    let (triangles, positions, light, expected) = case("atrium?size=2000", [96, 64]);
    let mut method = LightTiles::with_capacity(&Options::default(), 1);
    let mut mask = vec![7; expected.len()];
    let stats = method.shadow(&triangles, Samples::image(&positions, 96), light, &mut mask).unwrap();
    assert!(mask == expected);
    assert!(counter(&stats, "rounds") > 10, "{:?}", stats.counters);
    // 32 triangles may go over the mark, into every tile: three chunks of single ones and one of eights, of 128 bytes. A tile has two lists, each
    // with its end and eight numbers of chunks.
    let tiles = counter(&stats, "tiles");
    let lists = stats.bytes.iter().find(|b| b.0 == "triangle_lists").unwrap().1;
    assert!(
        lists <= ((4 * tiles + 1) * 128 + 80 * tiles) * rayon::current_num_threads() as u64,
        "{lists} bytes, {tiles} tiles"
    );
}

#[test]
fn many_triangles_for_few_samples_in_one_round_and_in_several() {
    let (triangles, positions, light, expected) = case("room", [144, 96]);
    for (capacity, least_rounds) in [(CAPACITY, 1), (5000, 3)] {
        let mut method = LightTiles::with_capacity(&Options::default(), capacity);
        let mut mask = vec![7; expected.len()];
        let stats = method.shadow(&triangles, Samples::image(&positions, 144), light, &mut mask).unwrap();
        assert!(mask == expected, "room for {capacity} entries");
        assert!(counter(&stats, "rounds") >= least_rounds, "{:?}", stats.counters);
        // Tiles are dense: blocks are halved, and most samples are found to be beside a triangle before they are tested.
        let loose = counter(&stats, "loose_samples").div_ceil(16) + counter(&stats, "tiles");
        assert!(counter(&stats, "leaves") > counter(&stats, "block_leaves") + loose, "{:?}", stats.counters);
        assert!(counter(&stats, "leaf_tests") < 4 * counter(&stats, "pairs"), "{:?}", stats.counters);
    }
}

#[test]
fn pictures_of_any_width_and_height() {
    for [width, height] in [[1, 5], [3, 3], [5, 7], [7, 1], [8, 4], [9, 40], [13, 9], [36, 6], [100, 3]] {
        let (triangles, positions, light, expected) = case("room", [width, height]);
        let mut method = LightTiles::new(&Options::default());
        let mut mask = vec![7; expected.len()];
        method.shadow(&triangles, Samples::image(&positions, width), light, &mut mask).unwrap();
        assert!(mask == expected, "{width} x {height}");
        // The last row may be short.
        let short = positions.len() - width / 2;
        let mut mask = vec![7; short];
        method.shadow(&triangles, Samples::image(&positions[..short], width), light, &mut mask).unwrap();
        assert!(mask == expected[..short], "{width} x {height}, the last row short");
    }
}

#[test]
fn lists_of_any_length_one_after_the_other() {
    let (triangles, positions, light, expected) = case("room", [72, 60]);
    for capacity in [1, 1 << 20] {
        let mut method = LightTiles::with_capacity(&Options::default(), capacity);
        for len in [4097, 1, 33, 4095, 8, 32, 4096, 31, 63, 4320] {
            let mut mask = vec![7; len];
            let samples = Samples::list(&positions[..len]);
            method.shadow(&triangles, samples, light, &mut mask).unwrap();
            assert!(mask == expected[..len], "{len} samples, room for {capacity} entries");
        }
        // A picture after lists, and in fewer rounds or more than the frame before.
        let mut mask = vec![7; expected.len()];
        method.shadow(&triangles[..16], Samples::image(&positions, 72), light, &mut mask).unwrap();
        assert!(mask == oracle(&triangles[..16], &positions, light));
        method.shadow(&triangles, Samples::image(&positions, 72), light, &mut mask).unwrap();
        assert!(mask == expected);
    }
}

#[test]
fn leaves_may_stick_out_of_their_tiles() {
    // Few triangles: leaves stick out by two cells. Slivers across the borders of tiles, and small ones on them.
    let light = [0.3, 4.0, 0.2];
    let positions: Vec<_> =
        (0..192 * 144).map(|i| [(i % 192) as f32 * 0.05 - 4.8, 0.0, (i / 192) as f32 * 0.05 - 3.6]).collect();
    let mut triangles = Vec::new();
    for k in 0..40 {
        let x = k as f32 * 0.19 - 3.7;
        triangles.push([[x, 0.5, -3.0], [x + 0.02, 0.5, -3.0], [0.5 * x, 0.7, 3.0]]);
        triangles.push([[x, 1.0, 0.4 * x], [x + 0.03, 1.0, 0.4 * x], [x, 1.0, 0.4 * x + 0.03]]);
    }
    assert!(triangles.len() <= positions.len() / WIDE);
    let expected = oracle(&triangles, &positions, light);
    let shadowed = expected.iter().filter(|m| **m == SHADOWED).count();
    assert!(shadowed > 1000 && shadowed < 20_000, "{shadowed}");
    let mut method = LightTiles::new(&Options::default());
    let mut mask = vec![7; positions.len()];
    method.shadow(&triangles, Samples::image(&positions, 192), light, &mut mask).unwrap();
    assert!(mask == expected);
    // Of tiles of the face's own grid that have samples.
    let out = |tile: usize| {
        let (grid, region) =
            (&method.tiles.grids[usize::from(method.tiles.face[tile])], &method.tiles.region[tile]);
        let [x0, x1, y0, _] = method.tiles.cells[tile].map(u32::from);
        let (left, right) = (grid.fit.cell(0, region.lo[0]), grid.fit.cell(0, region.hi[0]));
        let has_samples = region.lo[0] <= region.hi[0];
        let is_own = has_samples && x0.max(y0) < 1 << grid.levels && grid.at(x0, y0) == tile as u32;
        if is_own { x0.saturating_sub(left).max(right.saturating_sub(x1)) } else { 0 }
    };
    assert_eq!((0..method.tiles.len()).map(out).max(), Some(2), "cells that leaves stick out");
}

#[test]
fn neighbours_share_an_entry() {
    // A fine net over a floor, in the order of a mesh: some triangles missing, some without extent, and no whole number of eights.
    let light = [0.2, 5.0, -0.3];
    let positions: Vec<_> =
        (0..96 * 64).map(|i| [(i % 96) as f32 * 0.1 - 4.8, 0.0, (i / 96) as f32 * 0.1 - 3.2]).collect();
    let corner = |x: usize, z: usize| {
        [x as f32 * 0.031 - 1.0, 2.0 + 0.1 * ((x * z % 7) as f32), z as f32 * 0.05 - 1.0]
    };
    let mut triangles = Vec::new();
    for (z, x) in (0..40).flat_map(|z| (0..65).map(move |x| (z, x))) {
        let [a, b, c, d] = [corner(x, z), corner(x + 1, z), corner(x, z + 1), corner(x + 1, z + 1)];
        if (x + z) % 5 != 0 {
            triangles.push([a, b, c]);
        }
        triangles.push(if x % 11 == 3 { [b, b, c] } else { [b, d, c] });
    }
    triangles.truncate(triangles.len() - (triangles.len() + 5) % 8);
    assert_eq!(triangles.len() % 8, 3);
    let expected = oracle(&triangles, &positions, light);
    for capacity in [1, CAPACITY] {
        let mut method = LightTiles::with_capacity(&Options::default(), capacity);
        let mut mask = vec![7; positions.len()];
        let stats = method.shadow(&triangles, Samples::image(&positions, 96), light, &mut mask).unwrap();
        assert!(mask == expected);
        let [entries, prepared] = ["list_entries", "prepared"].map(|name| counter(&stats, name));
        assert!(entries > 0 && 2 * entries < prepared, "{entries} entries, {prepared} triangles");
    }
}

#[test]
fn large_triangles_among_small_neighbours_descend() {
    let light = [0.0, 0.0, 4.0];
    let at = |i: usize, n: usize| 3.8 * (i as f32 / n as f32 - 0.5);
    let positions: Vec<[f32; 3]> =
        (0..768 * 96).map(|i| [at(i % 768, 768), at(i / 768, 96), i as f32 * 1e-6]).collect();
    let large = |i: usize| {
        let z = 1.0 + 0.01 * i as f32;
        [[-1.0, -0.8, z], [0.9, -0.7, z + 0.1], [0.1, 0.9, z - 0.1]]
    };
    let small = |i: usize| {
        let (x, y) = (0.02 * (i % 6) as f32, 0.02 * (i / 6) as f32);
        [[x, y, 1.0], [x + 0.02, y, 1.0], [x, y + 0.02, 1.1]]
    };
    let cases: [(Vec<Triangle>, u64); 4] = [
        (vec![large(0)], 1),
        ((0..32).map(large).collect(), 32),
        ((0..32).map(|i| if i == 20 { large(0) } else { small(i) }).collect(), 1),
        ((0..30).map(small).collect(), 0),
    ];
    for (triangles, descents) in cases {
        let mut mask = vec![7; positions.len()];
        let mut method = LightTiles::new(&Options::default());
        let stats = method.shadow(&triangles, Samples::image(&positions, 768), light, &mut mask).unwrap();
        assert!(mask == oracle(&triangles, &positions, light), "{descents} large triangles");
        assert_eq!(counter(&stats, "descents"), descents, "{:?}", stats.counters);
    }
}

/// Corners of two clumps at different depths.
const APART: [[f32; 3]; 2] = [[-4.0, 0.0, 1.0], [5.0, 1.0, -2.0]];

/// Two clumps of 40,000 samples, 1e-4 rad wide as the light sees them, that alternate from pixel to pixel, and a fence of `slivers` across each.
fn clumps(slivers: usize, corners: [[f32; 3]; 2], side: usize) -> (Vec<Triangle>, Vec<[f32; 3]>, [f32; 3]) {
    let light = [0.0, 10.0, 0.0];
    let mut positions = Vec::new();
    let step = 1e-3 / side as f32;
    for i in 0..2 * side * side {
        let (corner, x, z) = (corners[i % 2], i / 2 % side, i / (2 * side));
        positions.push([corner[0] + x as f32 * step, corner[1], corner[2] + z as f32 * step]);
    }
    let mut triangles = Vec::new();
    let width = 1e-3 / slivers as f32;
    for k in 0..slivers {
        for clump in corners {
            // Halfway to the light.
            let at = |x: f32, z: f32| [(clump[0] + x) / 2.0, (clump[1] + 10.0) / 2.0, (clump[2] + z) / 2.0];
            let x = k as f32 * width;
            triangles.push([at(x, -1e-3), at(x + 0.5 * width, -1e-3), at(x + 0.25 * width, 2e-3)]);
        }
    }
    (triangles, positions, light)
}

#[test]
fn clumps_near_few_triangles_stay_together() {
    let (triangles, positions, light) = clumps(3, APART, 200);
    let expected = oracle(&triangles, &positions, light);
    let shadowed = expected.iter().filter(|m| **m == SHADOWED).count();
    assert!(shadowed > 10_000 && shadowed < 70_000, "{shadowed}");
    // One clump is a whole face.
    let one: Vec<_> = positions.iter().copied().step_by(2).collect();
    let of_one: Vec<_> = expected.iter().copied().step_by(2).collect();
    // In no order: 12,347 has no divisor with 40,000.
    let shuffle = |i: usize| i * 12_347 % one.len();
    let shuffled: Vec<_> = (0..one.len()).map(|i| one[shuffle(i)]).collect();
    let of_shuffled: Vec<_> = (0..one.len()).map(|i| of_one[shuffle(i)]).collect();
    for (positions, expected) in [(&positions, &expected), (&shuffled, &of_shuffled)] {
        for (capacity, samples) in [
            (CAPACITY, Samples::image(positions, 400)),
            (CAPACITY, Samples::list(positions)),
            (1, Samples::list(positions)),
        ] {
            let mut method = LightTiles::with_capacity(&Options::default(), capacity);
            let mut mask = vec![7; positions.len()];
            let stats = method.shadow(&triangles, samples, light, &mut mask).unwrap();
            assert!(mask == *expected);
            assert!(method.tiles.any_sparse);
            assert_eq!(counter(&stats, "loose_samples"), 0);
            // A leaf for each block and clump.
            assert!(counter(&stats, "block_leaves") <= 2 * positions.len().div_ceil(BLOCK) as u64);
            // All sixteen that share a tile have some of its samples, and share its triangles.
            let with_samples = method.tiles.region.iter().filter(|r| r.lo[0] <= r.hi[0]).count();
            assert!(with_samples >= 16, "{with_samples}");
        }
    }
}

#[test]
fn clumps_of_several_crowded_cells_stay_together() {
    // A hundred widths apart: 256 cells in all, some two or three for each clump.
    let (triangles, positions, light) = clumps(2, [[-4.0, 0.0, 1.0], [-3.9, 0.0, 1.1]], 800);
    let expected = oracle(&triangles, &positions, light);
    let shadowed = expected.iter().filter(|m| **m == SHADOWED).count();
    assert!(shadowed > 100_000 && shadowed < 1_200_000, "{shadowed}");
    let mut method = LightTiles::new(&Options::default());
    let mut mask = vec![7; positions.len()];
    let stats = method.shadow(&triangles, Samples::image(&positions, 1600), light, &mut mask).unwrap();
    assert!(mask == expected);
    let widest = method.tiles.grids[..FACES].iter().map(|grid| grid.sparse_shift).max().unwrap();
    assert!(method.tiles.any_sparse && widest > 0, "{widest}");
    assert_eq!(counter(&stats, "loose_samples"), 0);
    let blocks = positions.len().div_ceil(BLOCK) as u64;
    assert!(counter(&stats, "block_leaves") <= 2 * blocks, "{widest} {blocks} blocks, {:?}", stats.counters);
}

#[test]
fn clumps_near_many_triangles_get_grids_of_their_own() {
    let (triangles, positions, light) = clumps(40, APART, 200);
    let expected = oracle(&triangles, &positions, light);
    let shadowed = expected.iter().filter(|m| **m == SHADOWED).count();
    assert!(shadowed > 10_000 && shadowed < 70_000, "{shadowed}");
    for samples in [Samples::image(&positions, 400), Samples::list(&positions)] {
        let mut method = LightTiles::new(&Options::default());
        let mut mask = vec![7; positions.len()];
        let stats = method.shadow(&triangles, samples, light, &mut mask).unwrap();
        assert!(mask == expected);
        // Without grids in crowded cells there would be two tiles with samples, and every triangle met every leaf.
        assert!(counter(&stats, "tiles") >= 20, "{:?}", stats.counters);
        // Both clumps are parted, though they alternate from pixel to pixel.
        let held = |tile: usize| {
            let mut samples = 0;
            for worker in &method.gathered {
                worker.loose.each(tile, |loose| samples += loose.len());
                worker.leaves.each(tile, |leaves| {
                    samples += leaves.iter().map(|leaf| leaf.mask().count_ones() as usize).sum::<usize>();
                });
            }
            samples
        };
        let most = (0..method.tiles.len()).map(held).max().unwrap();
        assert!(most < positions.len() / 8, "{most} samples in a tile");
        let all = (triangles.len() * positions.len()) as u64;
        assert!(counter(&stats, "leaf_tests") < all / 6, "{:?}", stats.counters);
    }
}

#[test]
fn a_tile_that_cannot_be_parted_takes_turns() {
    // All samples in one direction from the light, and triangles across and beside it at many depths.
    let light = [0.0; 3];
    let positions: Vec<[f32; 3]> = (0..90_000).map(|i| [0.0, 0.0, -1.0 - i as f32 / 60_000.0]).collect();
    let mut triangles = Vec::new();
    for k in 0..60 {
        let (z, side) = (-0.9 - k as f32 * 0.04, if k % 3 == 0 { 0.0 } else { 0.2 });
        triangles.push([[side - 0.1, -0.1, z], [side + 0.1, -0.1, z - 0.01], [side, 0.1, z]]);
    }
    // Some samples stay lit.
    let triangles = &triangles[5..];
    let expected = oracle(triangles, &positions, light);
    let lit = expected.iter().filter(|m| **m == LIT).count();
    assert!(lit > 1000 && lit < 80_000, "{lit}");
    for capacity in [1, CAPACITY] {
        let mut method = LightTiles::with_capacity(&Options::default(), capacity);
        let mut mask = vec![7; positions.len()];
        let stats = method.shadow(triangles, Samples::list(&positions), light, &mut mask).unwrap();
        assert!(mask == expected);
        assert!(counter(&stats, "leaves") > tuning::MOST_LEAVES as u64, "{:?}", stats.counters);
    }
    // More than eight triangles a block: halves are leaves. All samples are within the bounds of the new ones, and beside them.
    let positions: Vec<_> = positions.iter().copied().step_by(2).collect();
    let blocks = positions.len() / BLOCK;
    let beside = (0..9 * blocks).map(|k| {
        let z = -0.5 - k as f32 / (10 * blocks) as f32;
        [[-0.1, -0.02, z], [0.1, 0.18, z], [-0.1, 0.18, z]]
    });
    let dense: Vec<_> = beside.chain(triangles.iter().copied()).collect();
    let expected: Vec<_> = expected.iter().copied().step_by(2).collect();
    let mut mask = vec![7; positions.len()];
    let mut method = LightTiles::new(&Options::default());
    let stats = method.shadow(&dense, Samples::list(&positions), light, &mut mask).unwrap();
    assert!(mask == expected);
    assert!(counter(&stats, "leaves") > 2 * blocks as u64 - 10, "{:?}", stats.counters);
    assert!(2 * blocks > tuning::MOST_LEAVES);
}

/// What differences of directions would lose in f32: as the light goes away, work must not grow, and nothing be missed, whatever face, edge or corner of
/// the cube the scene is seen through.
#[test]
fn a_far_light_sees_as_finely_as_a_near_one() {
    let (mut triangles, positions, _, _) = case("forest?size=3000", [96, 64]);
    let ball =
        triangles.as_flattened().iter().fold(Region::EMPTY, |b, p| b.union(&Region { lo: *p, hi: *p }));
    let middle = [0, 1, 2].map(|k| 0.5 * (ball.lo[k] + ball.hi[k]));
    let size = (0..3).map(|k| ball.hi[k] - ball.lo[k]).fold(0.0, f32::max);
    // Neighbours in the list are no neighbours in space: eights see through several faces.
    let stride = 1009;
    triangles = (0..triangles.len()).map(|i| triangles[i * stride % triangles.len()]).collect();
    let count = triangles.len();
    for direction in
        [[0.1, 0.9, 0.2], [-0.7, 0.7, 0.05], [0.58, 0.57, -0.58], [-0.3, 0.8, 0.5], [0.5, 0.4, -0.75]]
    {
        let mut work = Vec::new();
        for sizes in [16.0, 100.0, 1e4, 1e6] {
            let light = [0, 1, 2].map(|k| middle[k] + direction[k] * sizes * size);
            // Some near the light, large as seen from it or not.
            triangles.truncate(count);
            for k in 0..24 {
                let at = |t: f32, by: f32| {
                    [0, 1, 2].map(|i| light[i] + t * (middle[i] - light[i]) + by * size * [0.3, -0.2, 0.4][i])
                };
                let t = [0.999, 0.9, 0.3, 1e-3][k % 4];
                let by = (k as f32 - 12.0) * 0.03;
                triangles.push([at(t, by), at(t, by + 0.01 * t), at(t * 1.001, by + 0.02)]);
            }
            let expected = oracle(&triangles, &positions, light);
            for isa in Isa::available() {
                let mut method = LightTiles::new(&Options { isa, ..Options::default() });
                let mut mask = vec![7; positions.len()];
                let stats =
                    method.shadow(&triangles, Samples::image(&positions, 96), light, &mut mask).unwrap();
                let wrong = (0..mask.len()).filter(|&i| mask[i] != expected[i]).count();
                assert_eq!(wrong, 0, "{direction:?}, {sizes} sizes, {isa:?}");
                if isa == Isa::Auto.resolved() {
                    work.push(counter(&stats, "leaf_tests") + counter(&stats, "pairs"));
                }
            }
        }
        assert!(work[1] < work[0] * 5 / 4 && work[2] < work[0] * 3 / 2, "{direction:?}: {work:?}");
    }
}

#[test]
fn samples_at_the_light_and_far_beyond_are_answered() {
    let triangles = [[[-1.0, 1.0, -1.0], [1.0, 1.0, -1.0], [0.0, 1.0, 1.0]]];
    let light = [0.0, 2.0, 0.0];
    let mut positions =
        vec![[0.0, 2.0, 0.0], [0.0, -1e30, 0.0], [f32::NAN; 3], [0.0, 0.0, 0.0], [1e-30, 2.0, 1e-30]];
    positions.extend([[f32::MAX, -f32::MAX, 0.0], [0.0, -f32::MAX, 1.0]]);
    let expected = oracle(&triangles, &positions, light);
    let mut method = LightTiles::new(&Options::default());
    let mut mask = vec![7; positions.len()];
    let stats = method.shadow(&triangles, Samples::list(&positions), light, &mut mask).unwrap();
    assert_eq!(mask, expected);
    assert_eq!(counter(&stats, "wild_samples"), 5);
}
