//! Tests of the whole of shading on a floor that fills the picture.

use super::*;
use crate::mask::{NONE, SHADOWED};
use crate::samples::ViewSamples;
use crate::scene::{Material, Object, Soup};

const SIDE: usize = 32;

/// A floor of 2 x 2 seen from straight above; the last row of pixels is background.
fn floor(material: Material) -> (Scene, Camera, GBuffer) {
    let soup = Soup {
        positions: vec![[[-1.0, 0.0, -1.0], [3.0, 0.0, -1.0], [-1.0, 0.0, 3.0]]],
        object: vec![0],
        material: vec![0],
        ..Soup::default()
    };
    let scene = Scene {
        soup,
        objects: vec![Object { name: "floor".to_owned() }],
        materials: vec![material],
        ..Scene::default()
    };
    let n = SIDE * SIDE;
    let mut samples = ViewSamples { width: SIDE, height: SIDE, ..ViewSamples::default() };
    let mut bary = Vec::new();
    for i in 0..n {
        let (x, z) = ((i % SIDE) as f32 / SIDE as f32, (i / SIDE) as f32 / SIDE as f32);
        let seen = i / SIDE + 1 < SIDE;
        samples.positions.push(if seen { [2.0 * x - 1.0, 0.0, 2.0 * z - 1.0] } else { [f32::NAN; 3] });
        samples.normals.push([0.0, 1.0, 0.0]);
        samples.triangle.push(if seen { 0 } else { u32::MAX });
        bary.push([x / 2.0, z / 2.0]);
    }
    let camera = Camera {
        name: String::new(),
        eye: [0.0, 4.0, 0.0],
        target: [0.0; 3],
        up: [0.0, 0.0, -1.0],
        fov: 30.0,
    };
    (scene, camera, GBuffer { samples, bary })
}

fn half_lit() -> Vec<u8> {
    (0..SIDE * SIDE)
        .map(|i| match (i / SIDE + 1 == SIDE, i % SIDE < SIDE / 2) {
            (true, _) => NONE,
            (_, true) => SHADOWED,
            _ => LIT,
        })
        .collect()
}

fn picture(material: Material, lights: &[(PointLight, &[u8])], options: &Options) -> Vec<V3> {
    let (scene, camera, gbuffer) = floor(material);
    shade(&scene, &camera, &gbuffer, lights, options).unwrap()
}

#[test]
fn lit_is_brighter_than_shadow_and_shadow_is_not_black() {
    let mask = half_lit();
    let light = PointLight::at([0.0, 2.0, 0.0]);
    let p = picture(Material::default(), &[(light, &mask)], &Options::default());
    let (shadow, lit, background) = (p[5 * SIDE + 2][1], p[5 * SIDE + 30][1], p[SIDE * SIDE - 1]);
    assert!(lit > 2.0 * shadow && shadow > 0.02, "{lit} {shadow}");
    assert!(background.iter().all(|v| *v > 0.0));
    assert!(p.iter().flatten().all(|v| v.is_finite() && *v < 6.0));
}

#[test]
fn the_unit_of_intensity_does_not_matter_and_lights_add_up() {
    let mask = half_lit();
    let light = |intensity| PointLight { intensity, ..PointLight::at([0.3, 2.0, 0.1]) };
    let options = Options { ambient: 0.0, ..Options::default() };
    let one = picture(Material::default(), &[(light(1.0), &mask)], &options);
    let bright = picture(Material::default(), &[(light(5e6), &mask)], &options);
    let two = picture(Material::default(), &[(light(1.0), &mask), (light(1.0), &mask)], &options);
    let four = (0..SIDE * SIDE).map(|i| (one[i], bright[i], two[i]));
    for (a, b, c) in four {
        // Twice the light at half the exposure.
        assert!((a[0] - b[0]).abs() < 1e-4 && (a[0] - c[0]).abs() < 1e-4, "{a:?} {b:?} {c:?}");
    }
    assert_eq!(one[2], [0.0; 3], "shadowed, and no ambient");
}

#[test]
fn nothing_reflects_more_than_arrives() {
    let mask = vec![LIT; SIDE * SIDE];
    let gray = |v: f32| Material { base_color: [v, v, v, 1.0], ..Material::default() };
    let options = Options { ambient: 0.0, ..Options::default() };
    let light = PointLight::at([0.0, 1.0, 0.0]);
    let full = picture(gray(0.5), &[(light.clone(), &mask)], &options);
    let peak = full.iter().map(|c| c[0]).fold(0.0, f32::max);
    let middle = {
        let mut v: Vec<f32> = full[..SIDE * (SIDE - 1)].iter().map(|c| c[0]).collect();
        v.sort_by(f32::total_cmp);
        v[v.len() / 2]
    };
    assert!((middle - 0.36).abs() < 0.02, "the median lit pixel: {middle}");
    assert!(peak < 7.0 * middle, "{peak} {middle}");
    let below = picture(gray(0.5), &[(PointLight::at([0.0, -1.0, 0.0]), &mask)], &options);
    assert!(below[..SIDE].iter().all(|c| *c == [0.0; 3]), "a light behind the surface gives nothing");
}

#[test]
fn unlit_and_emissive_need_no_light() {
    let unlit = Material { base_color: [0.1, 0.2, 0.3, 1.0], unlit: true, ..Material::default() };
    assert_eq!(picture(unlit, &[], &Options::default())[0], [0.1, 0.2, 0.3]);
    let lamp = Material { emissive: [2.0, 0.0, 0.0], ..Material::default() };
    assert!(picture(lamp, &[], &Options::default())[0][0] > 2.0);
}

#[test]
fn lengths_are_checked_and_hard_numbers_do_not_panic() {
    let (scene, camera, mut gbuffer) = floor(Material::default());
    gbuffer.bary.pop();
    assert!(shade(&scene, &camera, &gbuffer, &[], &Options::default()).is_err());
    let mask = vec![LIT; SIDE * SIDE];
    for position in [[0.0; 3], [1e38, 1e38, 1e38], [0.0, 1e-40, 0.0]] {
        let light = PointLight { intensity: f32::MAX, ..PointLight::at(position) };
        let p = picture(Material::default(), &[(light, &mask)], &Options::default());
        assert_eq!(encode::picture(&p).len(), SIDE * SIDE);
    }
}
