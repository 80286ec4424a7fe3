//! What moves: keyframes, skins, morph targets.

use antumbra_io::SceneFile;

use crate::build::{Doc, close};

/// Opens a file with one animation of node 0; its outputs are accessor `output`.
fn animated(doc: &Doc, path: &str, interpolation: &str, input: usize, output: usize) -> SceneFile {
    let rest = format!(
        r#""nodes":[{{"mesh":0}}],"meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}}}}]}}],
        "animations":[{{"channels":[{{"sampler":0,"target":{{"node":0,"path":"{path}"}}}}],
        "samplers":[{{"input":{input},"output":{output},"interpolation":"{interpolation}"}}]}}]"#
    );
    doc.open(&rest).unwrap_or_else(|e| panic!("{e}"))
}

/// The second corner, which is (1, 0, 0) at rest.
fn corner(file: &SceneFile, time: f32) -> [f32; 3] {
    file.at(Some(time)).unwrap_or_else(|e| panic!("{e}")).soup.positions[0][1]
}

#[test]
fn steps_hold_lines_go_and_both_are_clamped() {
    let mut doc = Doc::triangle();
    let input = doc.floats("SCALAR", &[1.0, 2.0, 4.0]);
    let output = doc.floats("VEC3", &[0.0, 0.0, 0.0, 10.0, 0.0, 0.0, 10.0, 8.0, 0.0]);
    let step = animated(&doc, "translation", "STEP", input, output);
    let line = animated(&doc, "translation", "LINEAR", input, output);
    assert_eq!(line.time_span(), Some([1.0, 4.0]));
    assert_eq!(line.at(None).unwrap_or_else(|e| panic!("{e}")).soup.positions[0][1], [1.0, 0.0, 0.0]);
    for (time, stepped, linear) in [
        (-5.0, [1.0, 0.0, 0.0], [1.0, 0.0, 0.0]),
        (1.5, [1.0, 0.0, 0.0], [6.0, 0.0, 0.0]),
        (2.0, [11.0, 0.0, 0.0], [11.0, 0.0, 0.0]),
        (3.0, [11.0, 0.0, 0.0], [11.0, 4.0, 0.0]),
        (99.0, [11.0, 8.0, 0.0], [11.0, 8.0, 0.0]),
    ] {
        assert_eq!(corner(&step, time), stepped, "{time}");
        assert_eq!(corner(&line, time), linear, "{time}");
    }
    assert!(line.at(Some(f32::NAN)).is_err());
}

#[test]
fn rotations_turn_at_constant_speed_also_from_small_integers() {
    let mut doc = Doc::triangle();
    let input = doc.floats("SCALAR", &[0.0, 3.0]);
    let quarter = std::f32::consts::FRAC_1_SQRT_2;
    let output = doc.floats("VEC4", &[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, quarter, quarter]);
    let file = animated(&doc, "rotation", "LINEAR", input, output);
    let third = std::f32::consts::FRAC_PI_6;
    assert!(close(corner(&file, 1.0), [third.cos(), third.sin(), 0.0]));
    let short = (quarter * 32767.0).round() as i16;
    let bytes: Vec<u8> =
        [0, 0, 0, 32767, 0, 0, short, short].iter().flat_map(|v: &i16| v.to_le_bytes()).collect();
    let output = doc.accessor(&bytes, 2, "VEC4", 5122, r#","normalized":true"#);
    let file = animated(&doc, "rotation", "LINEAR", input, output);
    assert!(close(corner(&file, 3.0), [0.0, 1.0, 0.0]));
}

#[test]
fn cubic_splines_use_tangents() {
    let mut doc = Doc::triangle();
    let input = doc.floats("SCALAR", &[0.0, 2.0]);
    // In-tangent, value, out-tangent of each key: x is Hermite from 0 with slope 3 to 10 with slope -1.
    let x = [0.0, 0.0, 3.0, -1.0, 10.0, 0.0];
    let output = doc.floats("VEC3", &x.map(|x| [x, 0.0, 0.0]).concat());
    let file = animated(&doc, "translation", "CUBICSPLINE", input, output);
    // At the middle: 0.5 * 0 + 0.125 * 2 * 3 + 0.5 * 10 - 0.125 * 2 * -1.
    assert_eq!(corner(&file, 1.0)[0], 1.0 + 6.0);
    assert_eq!((corner(&file, 0.0)[0], corner(&file, 2.0)[0]), (1.0, 11.0));
}

#[test]
fn scales_are_animated_and_the_first_of_two_animations_wins() {
    let mut doc = Doc::triangle();
    let input = doc.floats("SCALAR", &[0.0, 1.0]);
    let late = doc.floats("SCALAR", &[0.0, 9.0]);
    let two = doc.floats("VEC3", &[1.0, 1.0, 1.0, 2.0, 2.0, 2.0]);
    let five = doc.floats("VEC3", &[5.0, 5.0, 5.0, 5.0, 5.0, 5.0]);
    let clip = |input: usize, output: usize, path: &str| {
        format!(
            r#"{{"channels":[{{"sampler":0,"target":{{"node":0,"path":"{path}"}}}}],
            "samplers":[{{"input":{input},"output":{output}}}]}}"#
        )
    };
    let rest = format!(
        r#""nodes":[{{"mesh":0}}],"meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}}}}]}}],
        "animations":[{},{},{}]"#,
        clip(input, two, "scale"),
        clip(late, five, "scale"),
        clip(input, five, "translation")
    );
    let file = doc.open(&rest).unwrap_or_else(|e| panic!("{e}"));
    assert_eq!(file.time_span(), Some([0.0, 1.0]));
    assert_eq!(corner(&file, 1.0), [7.0, 5.0, 5.0]);
}

#[test]
fn morph_targets_add_up_by_weights_of_mesh_node_and_animation() {
    let mut doc = Doc::triangle();
    let up = doc.floats("VEC3", &[0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0]);
    let aside = doc.floats("VEC3", &[4.0, 0.0, 0.0, 4.0, 0.0, 0.0, 4.0, 0.0, 0.0]);
    let input = doc.floats("SCALAR", &[0.0, 1.0]);
    let output = doc.floats("SCALAR", &[0.0, 0.0, 1.0, 0.5]);
    let rest = |node: &str, animations: &str| {
        format!(
            r#""nodes":[{{"mesh":0{node}}}],"meshes":[{{"weights":[1,0],"primitives":[{{"attributes":{{"POSITION":0}},
            "targets":[{{"POSITION":{up}}},{{"POSITION":{aside}}}]}}]}}]{animations}"#
        )
    };
    assert_eq!(doc.scene(&rest("", "")).soup.positions[0][1], [1.0, 0.0, 1.0]);
    assert_eq!(doc.scene(&rest(r#","weights":[2,0.25]"#, "")).soup.positions[0][1], [2.0, 0.0, 2.0]);
    let animations = format!(
        r#","animations":[{{"channels":[{{"sampler":0,"target":{{"node":0,"path":"weights"}}}}],
        "samplers":[{{"input":{input},"output":{output}}}]}}]"#
    );
    let file = doc.open(&rest("", &animations)).unwrap_or_else(|e| panic!("{e}"));
    assert_eq!(corner(&file, 0.5), [2.0, 0.0, 0.5]);
}

#[test]
fn morph_targets_bend_normals() {
    let mut doc = Doc::triangle();
    let up = doc.floats("VEC3", &[0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0]);
    let bend = doc.floats("VEC3", &[1.0, 0.0, -1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
    let rest = format!(
        r#""nodes":[{{"mesh":0}}],"meshes":[{{"weights":[1],"primitives":[
        {{"attributes":{{"POSITION":0,"NORMAL":{up}}},"targets":[{{"NORMAL":{bend}}}]}}]}}]"#
    );
    assert_eq!(doc.scene(&rest).soup.normals[0], [[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, 0.0, 1.0]]);
}

/// A triangle whose corners hang on joint 0, on joint 1, and half on each; both joints are bound at x = 1.
fn skinned(doc: &mut Doc, joints: &[u16; 12]) -> String {
    let joints = doc.shorts("VEC4", joints);
    let weights = doc.floats("VEC4", &[1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.5, 0.5, 0.0, 0.0]);
    let bind = [1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, -1.0, 0.0, 0.0, 1.0];
    let bind = doc.floats("MAT4", &[bind, bind].concat());
    format!(
        r#""nodes":[{{"mesh":0,"skin":0,"translation":[100,0,0]}},{{"children":[2],"translation":[1,0,0]}},
        {{"translation":[0,0,8]}}],"skins":[{{"joints":[1,2],"inverseBindMatrices":{bind}}}],
        "meshes":[{{"primitives":[{{"attributes":{{"POSITION":0,"JOINTS_0":{joints},"WEIGHTS_0":{weights}}}}}]}}]"#
    )
}

#[test]
fn skins_blend_joints_and_ignore_their_own_node() {
    let mut doc = Doc::triangle();
    let rest = skinned(&mut doc, &[0, 7, 7, 7, 1, 7, 7, 7, 0, 1, 7, 7]);
    let scene = doc.scene(&rest);
    assert_eq!(scene.soup.positions[0], [[0.0, 0.0, 0.0], [1.0, 0.0, 8.0], [0.0, 1.0, 4.0]]);
}

#[test]
fn a_joint_out_of_range_is_named() {
    let mut doc = Doc::triangle();
    let rest = skinned(&mut doc, &[0, 7, 7, 7, 5, 7, 7, 7, 0, 1, 7, 7]);
    let error = doc.error(&rest);
    assert!(
        error.contains("node 0, mesh 0, primitive 0, vertex 1: joint 5 out of range (there are 2)"),
        "{error}"
    );
}

#[test]
fn a_second_set_of_joints_counts_too() {
    let mut doc = Doc::triangle();
    let joints = doc.shorts("VEC4", &[0; 12]);
    let others = doc.shorts("VEC4", &[1; 12]);
    let weights = doc.floats("VEC4", &[0.25; 12]);
    let rest = format!(
        r#""nodes":[{{"mesh":0,"skin":0}},{{}},{{"translation":[0,0,8]}}],"skins":[{{"joints":[1,2]}}],
        "meshes":[{{"primitives":[{{"attributes":{{"POSITION":0,"JOINTS_0":{joints},"WEIGHTS_0":{weights},
        "JOINTS_1":{others},"WEIGHTS_1":{weights}}}}}]}}]"#
    );
    assert_eq!(doc.scene(&rest).soup.positions[0][1], [1.0, 0.0, 4.0]);
}
