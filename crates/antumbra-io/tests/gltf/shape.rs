//! Where triangles end up: transforms, instancing, modes of primitives, accessors.

use crate::build::{Doc, Folder, TRIANGLE, close, one_mesh, plain_mesh};

fn corners(values: &[f32; 9]) -> [[f32; 3]; 3] {
    [0, 1, 2].map(|i| [0, 1, 2].map(|k| values[i * 3 + k]))
}

#[test]
fn positions_without_a_transform_are_kept_bit_for_bit() {
    let mut doc = Doc::default();
    let values = [0.1, 1e-30, -7.3, 1e10, 0.3, 2.5, f32::MIN_POSITIVE, 16777217.0, 9.9];
    doc.floats("VEC3", &values);
    let scene = doc.scene(&plain_mesh());
    assert_eq!(scene.soup.positions, [corners(&values)]);
    assert_eq!(scene.objects[0].name, "node 0");
    assert_eq!((scene.soup.object[0], scene.soup.material[0], scene.materials.len()), (0, 0, 1));
    assert!(scene.soup.uvs.is_empty() && scene.soup.normals.is_empty() && scene.soup.colors.is_empty());
}

#[test]
fn trs_of_parents_and_children_are_multiplied() {
    let rest = r#""nodes":[{"children":[1],"translation":[10,0,0],"scale":[2,2,2]},
        {"mesh":0,"name":"leaf","rotation":[0,0,0.70710678,0.70710678],"translation":[1,0,0]}],
        "meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}],"scenes":[{"nodes":[0]}]"#;
    let scene = Doc::triangle().scene(rest);
    let [a, b, c] = scene.soup.positions[0];
    assert!(
        close(a, [12.0, 0.0, 0.0]) && close(b, [12.0, 2.0, 0.0]) && close(c, [10.0, 0.0, 0.0]),
        "{a:?} {b:?} {c:?}"
    );
    assert_eq!(scene.objects[0].name, "leaf");
}

#[test]
fn matrices_are_read_by_columns_and_normals_go_by_the_inverse_transpose() {
    let mut doc = Doc::triangle();
    // The plane x + y = const, squeezed to half along x.
    let s = std::f32::consts::FRAC_1_SQRT_2;
    doc.floats("VEC3", &[s, s, 0.0, s, s, 0.0, s, s, 0.0]);
    let rest = r#""nodes":[{"mesh":0,"matrix":[0.5,0,0,0, 0,1,0,0, 0,0,1,0, 5,6,7,1]}],
        "meshes":[{"primitives":[{"attributes":{"POSITION":0,"NORMAL":1}}]}]"#;
    let scene = doc.scene(rest);
    assert_eq!(scene.soup.positions[0], [[5.0, 6.0, 7.0], [5.5, 6.0, 7.0], [5.0, 7.0, 7.0]]);
    let length = 5f32.sqrt();
    assert!(
        close(scene.soup.normals[0][0], [2.0 / length, 1.0 / length, 0.0]),
        "{:?}",
        scene.soup.normals[0]
    );
}

#[test]
fn a_mesh_under_many_nodes_is_there_many_times() {
    let rest = r#""nodes":[{"mesh":0},{"mesh":0,"translation":[0,0,1]},{"mesh":0,"name":"third"}],
        "meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}]"#;
    let scene = Doc::triangle().scene(rest);
    assert_eq!(scene.soup.object, [0, 1, 2]);
    assert_eq!(scene.soup.positions[1][0], [0.0, 0.0, 1.0]);
    assert_eq!(scene.objects[2].name, "third");
}

#[test]
fn gpu_instancing_copies_a_mesh_within_its_object() {
    let mut doc = Doc::triangle();
    doc.floats("VEC3", &[1.0, 0.0, 0.0, 2.0, 0.0, 0.0]);
    doc.floats("VEC3", &[1.0, 1.0, 1.0, 3.0, 3.0, 3.0]);
    let rest = r#""extensionsRequired":["EXT_mesh_gpu_instancing"],
        "nodes":[{"mesh":0,"translation":[0,5,0],
            "extensions":{"EXT_mesh_gpu_instancing":{"attributes":{"TRANSLATION":1,"SCALE":2}}}}],
        "meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}]"#;
    let scene = doc.scene(rest);
    assert_eq!(scene.soup.object, [0, 0]);
    assert_eq!(scene.soup.positions[1], [[2.0, 5.0, 0.0], [5.0, 5.0, 0.0], [2.0, 8.0, 0.0]]);
    assert!(doc.error(&rest.replace("\"SCALE\":2", "\"SCALE\":0")).contains("2 and 3 entries"));
    assert!(doc.error(&rest.replace("\"SCALE\":2", "\"SCALE\":-1")).contains("out of range"));
}

#[test]
fn only_the_default_scene_is_shown() {
    let rest = |scene: &str| {
        format!(
            r#"{scene}"nodes":[{{"mesh":0}},{{"children":[2]}},{{"mesh":0,"name":"b"}}],
            "meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}}}}]}}]"#
        )
    };
    let doc = Doc::triangle();
    let names = |scene: &str| doc.scene(&rest(scene)).objects.into_iter().map(|o| o.name).collect::<Vec<_>>();
    assert_eq!(names(r#""scene":1,"scenes":[{"nodes":[0]},{"nodes":[1]}],"#), ["b"]);
    assert_eq!(names(r#""scenes":[{"nodes":[0]},{"nodes":[1]}],"#), ["node 0"]);
    assert_eq!(names(""), ["node 0", "b"]);
}

#[test]
fn strips_and_fans_become_triangles_and_lines_nothing() {
    let mut doc = Doc::default();
    doc.floats("VEC3", &[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 1.0, 1.0, 0.0, 0.0, 2.0, 0.0]);
    doc.shorts("SCALAR", &[4, 3, 2, 1, 0]);
    let xs = |more: &str| {
        let scene = doc.scene(&one_mesh(&format!(r#""attributes":{{"POSITION":0}}{more}"#)));
        let id = |p: [f32; 3]| (p[0] + 2.0 * p[1]) as u32;
        scene.soup.positions.iter().map(|t| t.map(id)).collect::<Vec<_>>()
    };
    assert_eq!(xs(r#","mode":5"#), [[0, 1, 2], [1, 3, 2], [2, 3, 4]]);
    assert_eq!(xs(r#","mode":5,"indices":1"#), [[4, 3, 2], [3, 1, 2], [2, 1, 0]]);
    assert_eq!(xs(r#","mode":6"#), [[0, 1, 2], [0, 2, 3], [0, 3, 4]]);
    assert_eq!(xs(r#","mode":4"#), [[0, 1, 2]]);
    assert_eq!(xs(r#","mode":4,"indices":1"#), [[4, 3, 2]]);
    for mode in 0..4 {
        assert_eq!(xs(&format!(r#","mode":{mode}"#)).len(), 0);
    }
}

#[test]
fn few_corners_of_a_large_array_are_picked_out() {
    let mut doc = Doc::default();
    let positions: Vec<f32> = (0..300).map(|v| v as f32).collect();
    doc.floats("VEC3", &positions);
    doc.shorts("SCALAR", &[99, 0, 7]);
    let primitive = r#""attributes":{"POSITION":0,"NORMAL":0},"indices":1"#;
    let scene = doc.scene(&one_mesh(primitive));
    assert_eq!(scene.soup.positions, [[[297.0, 298.0, 299.0], [0.0, 1.0, 2.0], [21.0, 22.0, 23.0]]]);
    assert_eq!(scene.soup.normals.len(), 1);
}

#[test]
fn sparse_values_replace_others_and_need_no_base() {
    let mut doc = Doc::triangle();
    let at = doc.view(&[2, 0, 0, 0]);
    let value = doc.view(&[7.0f32, 8.0, 9.0].map(f32::to_le_bytes).concat());
    let sparse = format!(
        r#","sparse":{{"count":1,"indices":{{"bufferView":{at},"componentType":5121}},"values":{{"bufferView":{value}}}}}"#
    );
    doc.accessors.push(format!(r#"{{"bufferView":0,"count":3,"type":"VEC3","componentType":5126{sparse}}}"#));
    doc.accessors.push(format!(r#"{{"count":3,"type":"VEC3","componentType":5126{sparse}}}"#));
    let based = doc.scene(&one_mesh(r#""attributes":{"POSITION":1}"#));
    assert_eq!(based.soup.positions[0], [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [7.0, 8.0, 9.0]]);
    let bare = doc.scene(&one_mesh(r#""attributes":{"POSITION":2}"#));
    assert_eq!(bare.soup.positions[0], [[0.0; 3], [0.0; 3], [7.0, 8.0, 9.0]]);
    doc.bytes[36] = 3;
    let error = doc.error(&one_mesh(r#""attributes":{"POSITION":2}"#));
    assert!(error.contains("accessor 2: sparse index 3 out of range (there are 3 elements)"), "{error}");
}

#[test]
fn small_integers_are_normalised_and_strides_are_stepped_over() {
    let mut doc = Doc::default();
    // Three vertices of three signed bytes each, a stride of 4.
    doc.accessor(&[127, 0, 129, 9, 0, 127, 0, 9, 128, 0, 0], 3, "VEC3", 5120, r#","normalized":true"#);
    doc.views[0] = r#"{"buffer":0,"byteLength":11,"byteStride":4}"#.into();
    doc.accessors.push(r#"{"bufferView":0,"count":3,"type":"VEC3","componentType":5120}"#.into());
    let primitive = |a: u32| one_mesh(&format!(r#""attributes":{{"POSITION":{a}}}"#));
    let scene = doc.scene(&primitive(0));
    assert_eq!(scene.soup.positions[0], [[1.0, 0.0, -1.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0]]);
    let plain = doc.scene(&primitive(1));
    assert_eq!(plain.soup.positions[0], [[127.0, 0.0, -127.0], [0.0, 127.0, 0.0], [-128.0, 0.0, 0.0]]);
}

#[test]
fn missing_normals_uvs_and_colours_are_filled_where_others_have_them() {
    let mut doc = Doc::triangle();
    doc.floats("VEC2", &[0.0, 0.25, 0.5, 0.25, 0.0, f32::NAN]);
    doc.accessor(&[255, 0, 0, 9, 0, 255, 0, 9, 0, 0, 255, 9], 3, "VEC4", 5121, r#","normalized":true"#);
    let rest = r#""nodes":[{"mesh":0}],"meshes":[{"primitives":[
        {"attributes":{"POSITION":0}},{"attributes":{"POSITION":0,"NORMAL":0,"TEXCOORD_0":1,"COLOR_0":2}}]}]"#;
    let soup = doc.scene(rest).soup;
    assert_eq!(soup.uvs, [[[0.0; 2]; 3], [[0.0, 0.25], [0.5, 0.25], [0.0, 0.0]]]);
    assert_eq!(soup.colors, [[[1.0; 3]; 3], [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]]);
    assert_eq!(soup.normals, [[[0.0; 3]; 3], [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]]);
}

#[test]
fn degenerate_and_duplicate_triangles_are_kept() {
    let mut doc = Doc::triangle();
    doc.shorts("SCALAR", &[0, 0, 0, 0, 1, 2, 0, 1, 2]);
    assert_eq!(doc.scene(&one_mesh(r#""attributes":{"POSITION":0},"indices":1"#)).soup.len(), 3);
}

#[test]
fn buffers_come_from_data_uris_and_from_files_beside_the_scene() {
    let doc = Doc::triangle();
    let folder = Folder::new();
    let positions = |text: String| {
        let file = folder.open("scene.gltf", text.as_bytes()).unwrap_or_else(|e| panic!("{e}"));
        file.at(None).unwrap_or_else(|e| panic!("{e}")).soup.positions
    };
    assert_eq!(positions(doc.gltf(&plain_mesh())), [corners(&TRIANGLE)]);
    folder.write("my data.bin", &doc.bytes);
    assert_eq!(positions(doc.gltf_beside("my%20data.bin", &plain_mesh())), [corners(&TRIANGLE)]);
    assert_eq!(positions(format!("\u{feff}{}", doc.gltf(&plain_mesh()))).len(), 1);
    let error = folder.open("scene.gltf", doc.gltf_beside("gone.bin", &plain_mesh()).as_bytes()).unwrap_err();
    let error = error.to_string();
    assert!(error.contains("scene.gltf: buffer 0: ") && error.contains("gone.bin"), "{error}");
}
