//! Every error names the file, the object and the index.

use crate::build::{Doc, Folder, one_mesh, plain_mesh};

#[track_caller]
fn expect(error: &str, part: &str) {
    assert!(error.contains(part), "'{error}' lacks '{part}'");
    assert!(error.contains("scene.gl") && error.lines().count() <= 2, "{error}");
}

fn open_error(name: &str, bytes: &[u8]) -> String {
    match Folder::new().open(name, bytes) {
        Ok(_) => panic!("no error"),
        Err(e) => e.to_string(),
    }
}

#[test]
fn broken_containers() {
    let glb = Doc::triangle().glb(&plain_mesh());
    expect(&open_error("scene.glb", &glb[..glb.len() - 10]), "cut off?");
    expect(&open_error("scene.glb", &glb[..6]), "inside the GLB header");
    expect(&open_error("scene.glb", b""), "the JSON part cannot be read");
    expect(&open_error("scene.gltf", b"{\"asset\":"), "the JSON part cannot be read");
    let mut old = glb.clone();
    old[4] = 1;
    expect(&open_error("scene.glb", &old), "GLB version 1; only version 2");
    let mut long = glb.clone();
    long[12..16].fill(0xFF);
    expect(&open_error("scene.glb", &long), "the GLB chunk at byte 12 (4294967295 bytes) ends past the file");
    let mut none = glb;
    none[16..20].copy_from_slice(b"WHAT");
    expect(&open_error("scene.glb", &none), "no JSON chunk");
    expect(&open_error("scene.gltf", br#"{"asset":{"version":"1.0"}}"#), "glTF version 1.0");
}

#[test]
fn many_json_items_are_refused_before_they_are_parsed() {
    let text = format!(r#"{{"asset":{{"version":"2.0"}},"nodes":[{}{{}}]}}"#, "{},".repeat(1 << 20));
    expect(&open_error("scene.gltf", text.as_bytes()), "too many items");
}

#[test]
fn required_extensions_that_are_not_read() {
    let rest = |name: &str| format!(r#""extensionsRequired":["{name}"],{}"#, plain_mesh());
    let error = Doc::triangle().error(&rest("KHR_draco_mesh_compression"));
    expect(&error, "KHR_draco_mesh_compression");
    expect(&error, "without mesh compression");
    expect(&Doc::triangle().error(&rest("EXT_meshopt_compression")), "without mesh compression");
    expect(&Doc::triangle().error(&rest("ABC_new")), "the extension ABC_new, which cannot be read");
    assert_eq!(Doc::triangle().scene(&rest("KHR_mesh_quantization")).soup.len(), 1);
}

#[test]
fn accessors_that_reach_too_far() {
    let with = |accessor: &str| {
        let mut doc = Doc::triangle();
        doc.accessors[0] = accessor.into();
        doc.error(&plain_mesh())
    };
    let vec3 = r#""type":"VEC3","componentType":5126"#;
    expect(&with(&format!(r#"{{"bufferView":0,"count":4,{vec3}}}"#)), "accessor 0: 4 elements of 12 bytes");
    expect(
        &with(&format!(r#"{{"bufferView":0,"byteOffset":4,"count":3,{vec3}}}"#)),
        "do not fit in buffer view 0 of 36",
    );
    for count in ["4294967296", "18446744073709551615", "1000000000"] {
        expect(&with(&format!(r#"{{"count":{count},{vec3}}}"#)), "limit of");
        expect(&with(&format!(r#"{{"bufferView":0,"count":{count},{vec3}}}"#)), "accessor 0");
    }
    let huge = u64::MAX;
    expect(&with(&format!(r#"{{"bufferView":0,"byteOffset":{huge},"count":3,{vec3}}}"#)), "do not fit");
    expect(
        &with(&format!(r#"{{"bufferView":7,"count":3,{vec3}}}"#)),
        "accessor 0: buffer view 7 out of range (there are 1)",
    );
    expect(
        &with(r#"{"bufferView":0,"count":3,"type":"VEC2","componentType":5126}"#),
        "has the type Vec2 of F32",
    );
    expect(&with(r#"{"bufferView":0,"count":3,"type":"VEC9","componentType":5126}"#), "the value of 'type'");
    expect(
        &with(r#"{"bufferView":0,"count":3,"type":"VEC3","componentType":1}"#),
        "the value of 'componentType'",
    );
}

#[test]
fn buffer_views_and_buffers_that_reach_too_far() {
    let with = |view: &str| {
        let mut doc = Doc::triangle();
        doc.views[0] = view.into();
        doc.error(&plain_mesh())
    };
    expect(
        &with(r#"{"buffer":0,"byteOffset":4,"byteLength":36}"#),
        "buffer view 0: 36 bytes at 4 do not fit in buffer 0",
    );
    let huge = u64::MAX;
    expect(
        &with(&format!(r#"{{"buffer":0,"byteOffset":{huge},"byteLength":{huge}}}"#)),
        "do not fit in buffer 0",
    );
    expect(&with(r#"{"buffer":3,"byteLength":36}"#), "buffer view 0: buffer 3 out of range (there are 1)");
    expect(&with(r#"{"buffer":0,"byteLength":36,"byteStride":8}"#), "a stride of 8 bytes for elements of 12");
    let doc = Doc { bytes: vec![0; 36], ..Doc::triangle() };
    let text = doc.gltf(&plain_mesh()).replace(r#""byteLength":36,"uri""#, r#""byteLength":37,"uri""#);
    expect(&open_error("scene.gltf", text.as_bytes()), "buffer 0 has 36 bytes where 37 were promised");
    let text = doc.gltf_beside("http://example.org/x.bin", &plain_mesh());
    expect(&open_error("scene.gltf", text.as_bytes()), "is not a relative path");
}

#[test]
fn indices_out_of_range_are_named() {
    let mut doc = Doc::triangle();
    doc.shorts("SCALAR", &[0, 1, 700]);
    let error = doc.error(&one_mesh(r#""attributes":{"POSITION":0},"indices":1"#));
    expect(&error, "mesh 0 'wall', primitive 0: index 700 out of range (there are 3 vertices)");
    let error = doc.error(&one_mesh(r#""attributes":{"POSITION":9}"#));
    expect(&error, "mesh 0 'wall', primitive 0: accessor 9 out of range (there are 2)");
    let error = doc.error(&one_mesh(r#""attributes":{"POSITION":0},"material":2"#));
    expect(&error, "mesh 0 'wall', primitive 0: material 2 out of range (there are 0)");
    let error = doc.error(&one_mesh(r#""attributes":{"POSITION":0},"indices":0"#));
    expect(&error, "has the type Vec3 of F32");
    doc.floats("VEC3", &[0.0; 6]);
    let error = doc.error(&one_mesh(r#""attributes":{"POSITION":0,"NORMAL":2}"#));
    expect(&error, "NORMAL has 2 entries where 3 were expected");
}

#[test]
fn positions_that_are_not_finite_are_named() {
    let mut doc = Doc::default();
    doc.floats("VEC3", &[0.0, 0.0, 0.0, 1.0, f32::NAN, 0.0, 0.0, 1.0, 0.0, 5.0, 5.0, 5.0]);
    doc.shorts("SCALAR", &[0, 2, 3]);
    let error = doc.error(&plain_mesh());
    expect(
        &error,
        "node 0, mesh 0 'wall', primitive 0, vertex 1: its position [NaN, NaN, NaN] is not finite",
    );
    // The bad vertex is part of no triangle.
    assert_eq!(doc.scene(&one_mesh(r#""attributes":{"POSITION":0},"indices":1"#)).soup.len(), 1);
    let rest = plain_mesh().replace(r#""mesh":0"#, r#""mesh":0,"name":"far","scale":[3e38,1,1]"#);
    let mut doc = Doc::default();
    doc.floats("VEC3", &[0.0, 0.0, 0.0, 9.0, 0.0, 0.0, 0.0, 1.0, 0.0]);
    expect(&doc.error(&rest), "node 0 'far', mesh 0 'wall', primitive 0, vertex 1: its position [inf, ");
}

#[test]
fn nodes_that_are_no_trees() {
    let nodes = |nodes: &str| Doc::triangle().error(&format!(r#""nodes":[{nodes}]"#));
    expect(&nodes(r#"{"name":"a","children":[1]},{"children":[0]}"#), "node 0 'a' is below itself");
    expect(&nodes(r#"{"children":[0]}"#), "node 0 is below itself");
    expect(&nodes(r#"{"children":[2]},{"children":[2]},{}"#), "node 2 is a child of node 0 and of node 1");
    expect(&nodes(r#"{"children":[4]}"#), "node 0: child 4 out of range (there are 1)");
    expect(&nodes(r#"{"mesh":4}"#), "node 0: mesh 4 out of range (there are 0)");
    expect(&nodes(r#"{"skin":4}"#), "node 0: skin 4 out of range");
    expect(&nodes(r#"{"camera":4}"#), "node 0: camera 4 out of range");
    let rest = r#""nodes":[],"scenes":[{"nodes":[3]}]"#;
    expect(&Doc::triangle().error(rest), "scene: node 3 out of range (there are 0)");
    expect(&Doc::triangle().error(r#""scene":5"#), "default scene: scene 5 out of range");
    let skin = r#""nodes":[{}],"skins":[{"name":"s","joints":[0,8]}]"#;
    expect(&Doc::triangle().error(skin), "skin 0 's': joint node 8 out of range (there are 1)");
}

#[test]
fn deep_hierarchies_do_not_overflow_the_stack() {
    let count = 100_000;
    let chain = (1..count).map(|i| format!(r#"{{"children":[{i}]}},"#)).collect::<String>();
    let rest = format!(
        r#""nodes":[{chain}{{"mesh":0}}],"meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}}}}]}}]"#
    );
    assert_eq!(Doc::triangle().scene(&rest).soup.len(), 1);
}

#[test]
fn copies_are_counted_before_they_are_made() {
    let mut doc = Doc::triangle();
    doc.accessors.push(r#"{"count":1000000,"type":"VEC3","componentType":5126}"#.into());
    doc.shorts("SCALAR", &[0; 3000]);
    let rest = one_mesh(r#""attributes":{"POSITION":0},"indices":2"#).replace(
        r#""mesh":0"#,
        r#""mesh":0,"extensions":{"EXT_mesh_gpu_instancing":{"attributes":{"SCALE":1}}}"#,
    );
    expect(&doc.error(&rest), "1000000000 triangles (all copies counted)");
}

#[test]
fn animations_that_do_not_fit() {
    let mut doc = Doc::triangle();
    let input = doc.floats("SCALAR", &[0.0, 1.0]);
    let output = doc.floats("VEC3", &[0.0; 9]);
    let backwards = doc.floats("SCALAR", &[1.0, 0.0, 2.0]);
    let broken = doc.floats("SCALAR", &[1.0, f32::INFINITY, 2.0]);
    let empty = doc.floats("SCALAR", &[]);
    let error = |node: &str, channel: &str, input: usize| {
        doc.error(&format!(
            r#""nodes":[{{{node}}}],"animations":[{{"name":"run","channels":[{{{channel}}}],
            "samplers":[{{"input":{input},"output":{output}}}]}}]"#
        ))
    };
    let good = r#""sampler":0,"target":{"node":0,"path":"scale"}"#;
    expect(
        &error("", good, input),
        "animation 0 'run', channel 0: the output has 9 entries where 6 were expected",
    );
    expect(&error("", good, backwards), "the time of key 1 (0) is before that of key 0 (1)");
    expect(&error("", good, broken), "the time of key 1 is inf");
    expect(&error("", good, empty), "there are no keys");
    let matrix = r#""matrix":[1,0,0,0,0,1,0,0,0,0,1,0,0,0,0,1]"#;
    expect(&error(matrix, good, input), "which has a matrix");
    expect(
        &error("", r#""sampler":3,"target":{"node":0,"path":"scale"}"#, input),
        "sampler 3 out of range (there are 1)",
    );
    expect(
        &error("", r#""sampler":0,"target":{"node":6,"path":"scale"}"#, input),
        "node 6 out of range (there are 1)",
    );
}

#[test]
fn images_that_cannot_be_decoded() {
    let with = |image: &str, bytes: &[u8]| {
        let mut doc = Doc::triangle();
        doc.view(bytes);
        let base = r#""materials":[{"pbrMetallicRoughness":{"baseColorTexture":{"index":0}}}]"#;
        doc.error(&format!(r#"{base},"textures":[{{"source":0}}],"images":[{{"name":"bark",{image}}}]"#))
    };
    expect(&with(r#""bufferView":1"#, b"RIFFxxxxWEBP"), "image 0 'bark'");
    expect(&with(r#""bufferView":1"#, b"nothing"), "image 0 'bark': neither PNG nor JPEG");
    let mut cut = crate::build::png(64, 64);
    cut.truncate(cut.len() - 30);
    expect(&with(r#""bufferView":1"#, &cut), "image 0 'bark'");
    expect(&with(r#""uri":"gone.png""#, b""), "gone.png");
    expect(&with(r#""mimeType":"image/png""#, b""), "neither a buffer view nor a URI");
    // A header that promises 2^31 - 1 pixels a side.
    let mut bomb = crate::build::png(1, 1);
    bomb[16..24].copy_from_slice(&[0x7F, 0xFF, 0xFF, 0xFF, 0x7F, 0xFF, 0xFF, 0xFF]);
    expect(&with(r#""bufferView":1"#, &bomb), "image 0 'bark'");
    let rest = r#""materials":[{"name":"m","pbrMetallicRoughness":{"baseColorTexture":{"index":4}}}]"#;
    expect(&Doc::triangle().error(rest), "material 0 'm': texture 4 out of range (there are 0)");
    let rest = r#""materials":[{"pbrMetallicRoughness":{"baseColorTexture":{"index":0}}}],
        "textures":[{"extensions":{"EXT_texture_webp":{"source":0}}}]"#;
    expect(&Doc::triangle().error(rest), "texture 0 needs EXT_texture_webp");
}
