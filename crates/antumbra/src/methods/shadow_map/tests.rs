//! Nearly right where a shadow is large, worse at its edges, and the same in every run.

use super::*;
use crate::methods::{CubeMap, DualParaboloid, Oracle};

/// A grid of quads in the plane `y = height`, with gaps.
fn plates(height: f32) -> Vec<Triangle> {
    (0..36)
        .flat_map(|i| {
            let (x, z) = ((i % 6) as f32 * 2.0 - 6.0, (i / 6) as f32 * 2.0 - 6.0);
            let at = |dx: f32, dz: f32| [x + dx, height, z + dz];
            [[at(0.0, 0.0), at(1.2, 0.0), at(1.2, 1.2)], [at(0.0, 0.0), at(1.2, 1.2), at(0.0, 1.2)]]
        })
        .collect()
}

/// A floor and a ceiling of samples around a light between plates above and below it.
fn scene() -> (Vec<Triangle>, Vec<[f32; 3]>) {
    let mut triangles = plates(-2.0);
    triangles.extend(plates(2.0));
    let positions = (0..40_000)
        .map(|i| {
            let (x, z) = ((i % 200) as f32 * 0.11 - 11.0, (i / 200) as f32 * 0.11 - 11.0);
            [x, if i % 2 == 0 { 4.0 } else { -4.0 }, z]
        })
        .chain([[f32::NAN; 3], [0.1, 0.2, 0.3]])
        .collect();
    (triangles, positions)
}

const LIGHT: [f32; 3] = [0.1, 0.2, 0.3];

fn wrong(method: &mut dyn Method) -> f64 {
    let (triangles, positions) = scene();
    let samples = Samples::list(&positions);
    let (mut mask, mut expected) = (vec![7; positions.len()], vec![7; positions.len()]);
    method.shadow(&triangles, samples, LIGHT, &mut mask).unwrap();
    Oracle.shadow(&triangles, samples, LIGHT, &mut expected).unwrap();
    assert_eq!(mask[40_000..], [NONE, LIT]);
    let differ = mask.iter().zip(&expected).filter(|(a, b)| a != b).count();
    differ as f64 / mask.len() as f64
}

#[test]
fn finer_maps_are_less_wrong() {
    for base in [ShadowMapOptions::CUBE, ShadowMapOptions::PARABOLOID] {
        let at = |resolution| {
            let options = ShadowMapOptions { resolution, ..base };
            match base.arc_error {
                None => wrong(&mut CubeMap::with(options)),
                Some(_) => wrong(&mut DualParaboloid::with(options)),
            }
        };
        let (coarse, fine) = (at(64), at(1024));
        assert!(coarse < 0.25 && fine < 0.02 && fine < coarse, "{base:?}: {coarse} {fine}");
    }
}

#[test]
fn filtering_keeps_the_shadow_and_planes_clip() {
    let pcf = ShadowMapOptions { pcf: 3, ..ShadowMapOptions::CUBE };
    assert!(wrong(&mut CubeMap::with(pcf)) < 0.03);
    let pcf = ShadowMapOptions { pcf: 4, ..ShadowMapOptions::PARABOLOID };
    assert!(wrong(&mut DualParaboloid::with(pcf)) < 0.03);
    // Straight edges instead of arcs: worse.
    let arcs = wrong(&mut DualParaboloid::with(ShadowMapOptions::PARABOLOID));
    let straight = ShadowMapOptions { arc_error: None, ..ShadowMapOptions::PARABOLOID };
    assert!(wrong(&mut DualParaboloid::with(straight)) > arcs);
    // A near plane beyond all casters leaves nothing to shadow.
    let (triangles, positions) = scene();
    let mut mask = vec![7; positions.len()];
    let near = Some(1e3);
    for method in [
        &mut CubeMap::with(ShadowMapOptions { near, ..ShadowMapOptions::CUBE }) as &mut dyn Method,
        &mut DualParaboloid::with(ShadowMapOptions { near, ..ShadowMapOptions::PARABOLOID }),
    ] {
        method.shadow(&triangles, Samples::list(&positions), LIGHT, &mut mask).unwrap();
        assert!(mask.iter().all(|&m| m != SHADOWED));
    }
}

#[test]
fn threads_and_rubbish_do_not_matter() {
    let (mut triangles, positions) = scene();
    let huge = f32::MAX;
    triangles.push([[huge, -huge, huge], [-huge, huge, 1.0], [0.0, huge, -huge]]);
    triangles.push([LIGHT; 3]);
    triangles.push([LIGHT, [1e-40, 2e-40, 0.0], [5.0, 0.2, 0.3]]);
    let run = |threads: usize, method: &mut dyn Method| {
        let mut mask = vec![7; positions.len()];
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| method.shadow(&triangles, Samples::list(&positions), LIGHT, &mut mask)).unwrap();
        mask
    };
    let options = Options::default();
    assert!(run(1, &mut CubeMap::new(&options)) == run(3, &mut CubeMap::new(&options)));
    assert!(run(1, &mut DualParaboloid::new(&options)) == run(3, &mut DualParaboloid::new(&options)));
}
