//! Materials, textures, lights and cameras.

use antumbra::scene::{AlphaMode, Material, Wrap};

use crate::build::{Doc, Folder, base64, close, png};

/// A triangle with uvs in sets 0 and 1 and this material, and more members.
fn with_material(doc: &mut Doc, material: &str, more: &str) -> String {
    doc.floats("VEC2", &[0.0, 0.0, 1.0, 0.0, 0.0, 1.0]);
    doc.floats("VEC2", &[5.0, 5.0, 6.0, 5.0, 5.0, 6.0]);
    format!(
        r#""nodes":[{{"mesh":0}}],"materials":[{{{material}}}],"meshes":[{{"primitives":[
        {{"attributes":{{"POSITION":0,"TEXCOORD_0":1,"TEXCOORD_1":2}},"material":0}}]}}]{more}"#
    )
}

/// Members for one image in a `data:` URI and one texture of it.
fn one_texture() -> String {
    let uri = base64(&png(3, 2));
    format!(
        r#","textures":[{{"source":0,"sampler":0}}],"samplers":[{{"wrapS":33071,"wrapT":33648}}],
        "images":[{{"name":"leaf","uri":"data:image/png;base64,{uri}"}}]"#
    )
}

#[test]
fn factors_alpha_emission_and_unlit_are_read() {
    let mut doc = Doc::triangle();
    let material = r#""name":"glass","alphaMode":"MASK","alphaCutoff":0.25,"emissiveFactor":[1,0.5,0],
        "pbrMetallicRoughness":{"baseColorFactor":[0.1,0.2,0.3,0.4]},
        "extensions":{"KHR_materials_unlit":{},"KHR_materials_emissive_strength":{"emissiveStrength":4}}"#;
    let rest = with_material(&mut doc, material, "");
    let expected = Material {
        name: "glass".into(),
        base_color: [0.1, 0.2, 0.3, 0.4],
        base_color_texture: None,
        alpha_mode: AlphaMode::Mask { cutoff: 0.25 },
        emissive: [4.0, 2.0, 0.0],
        unlit: true,
    };
    assert_eq!(doc.scene(&rest).materials, [expected]);
    let mode = |text: &str| {
        let mut doc = Doc::triangle();
        let rest = with_material(&mut doc, text, "");
        doc.scene(&rest).materials[0].alpha_mode
    };
    assert_eq!(mode(r#""alphaMode":"BLEND""#), AlphaMode::Blend);
    assert_eq!(mode(r#""alphaMode":"MASK""#), AlphaMode::Mask { cutoff: 0.5 });
    assert_eq!(mode(""), AlphaMode::Opaque);
}

#[test]
fn specular_glossiness_gives_its_diffuse_colour() {
    let mut doc = Doc::triangle();
    let material = r#""extensions":{"KHR_materials_pbrSpecularGlossiness":
        {"diffuseFactor":[0.5,0.5,0.5,1],"diffuseTexture":{"index":0}}}"#;
    let rest = with_material(&mut doc, material, &one_texture());
    let scene = doc.scene(&rest);
    assert_eq!(scene.materials[0].base_color, [0.5, 0.5, 0.5, 1.0]);
    assert_eq!(scene.materials[0].base_color_texture, Some(0));
}

#[test]
fn textures_are_decoded_once_with_their_wrapping() {
    let mut doc = Doc::triangle();
    let material = r#""pbrMetallicRoughness":{"baseColorTexture":{"index":0,"texCoord":1}}"#;
    let rest = with_material(&mut doc, material, &one_texture());
    let scene = doc.scene(&rest);
    let texture = &scene.textures[0];
    assert_eq!((texture.name.as_str(), texture.width, texture.height), ("leaf", 3, 2));
    assert_eq!(texture.pixels, [[255, 0, 0, 128]; 6]);
    assert_eq!(texture.wrap, [Wrap::Clamp, Wrap::Mirror]);
    assert_eq!(scene.soup.uvs[0][1], [6.0, 5.0]);
}

#[test]
fn images_come_from_buffer_views_and_from_files() {
    let material = r#""pbrMetallicRoughness":{"baseColorTexture":{"index":0}}"#;
    let mut doc = Doc::triangle();
    let view = doc.view(&png(1, 1));
    let images =
        format!(r#","textures":[{{"source":0}}],"images":[{{"bufferView":{view},"mimeType":"image/png"}}]"#);
    let rest = with_material(&mut doc, material, &images);
    let scene = doc.scene(&rest);
    assert_eq!((scene.textures[0].pixels.len(), scene.textures[0].wrap), (1, [Wrap::Repeat; 2]));

    let folder = Folder::new();
    folder.write("a b.png", &png(2, 2));
    let mut doc = Doc::triangle();
    let rest =
        with_material(&mut doc, material, r#","textures":[{"source":0}],"images":[{"uri":"a%20b.png"}]"#);
    let scene = folder.open("scene.gltf", doc.gltf(&rest).as_bytes()).and_then(|f| f.at(None));
    assert_eq!(scene.unwrap_or_else(|e| panic!("{e}")).textures[0].pixels.len(), 4);
}

#[test]
fn images_that_no_base_colour_uses_are_not_looked_at() {
    let mut doc = Doc::triangle();
    let material = r#""normalTexture":{"index":0}"#;
    let rest =
        with_material(&mut doc, material, r#","textures":[{"source":0}],"images":[{"uri":"gone.png"}]"#);
    assert!(doc.scene(&rest).textures.is_empty());
}

#[test]
fn texture_transforms_are_baked_into_uvs() {
    let uvs = |transform: &str| {
        let mut doc = Doc::triangle();
        let material = format!(
            r#""pbrMetallicRoughness":{{"baseColorTexture":{{"index":0,
            "extensions":{{"KHR_texture_transform":{{{transform}}}}}}}}}"#
        );
        let rest = with_material(&mut doc, &material, &one_texture());
        doc.scene(&rest).soup.uvs[0]
    };
    // The example of the extension: the lower left quadrant, that is u in 0 to 0.5 and v in 0.5 to 1.
    let [a, b, c] = uvs(r#""offset":[0,1],"rotation":1.57079632679,"scale":[0.5,0.5]"#);
    assert!(close(a, [0.0, 1.0]) && close(b, [0.0, 0.5]) && close(c, [0.5, 1.0]), "{a:?} {b:?} {c:?}");
    assert_eq!(uvs(r#""offset":[0,1],"scale":[1,-1]"#), [[0.0, 1.0], [1.0, 1.0], [0.0, 0.0]]);
    assert_eq!(uvs(r#""texCoord":1,"scale":[2,2]"#)[0], [10.0, 10.0]);
}

#[test]
fn primitives_without_a_material_get_the_default_one() {
    let rest = r#""materials":[{"name":"red"}],"nodes":[{"mesh":0}],"meshes":[{"primitives":[
        {"attributes":{"POSITION":0}},{"attributes":{"POSITION":0},"material":0},{"attributes":{"POSITION":0}}]}]"#;
    let scene = Doc::triangle().scene(rest);
    assert_eq!(scene.soup.material, [1, 0, 1]);
    assert_eq!(scene.materials[1], Material::default());
    assert_eq!(scene.materials[0].base_color, [1.0; 4]);
}

#[test]
fn lights_stand_at_their_nodes() {
    let rest = r#""extensions":{"KHR_lights_punctual":{"lights":[{"type":"point","color":[1,0,0],"intensity":7},
        {"type":"directional"},{"type":"spot","name":"lamp","spot":{}}]}},
        "nodes":[{"translation":[1,0,0],"children":[1,2,3]},
        {"name":"bulb","translation":[0,2,0],"extensions":{"KHR_lights_punctual":{"light":0}}},
        {"extensions":{"KHR_lights_punctual":{"light":1}}},{"extensions":{"KHR_lights_punctual":{"light":2}}}]"#;
    let scene = Doc::triangle().scene(rest);
    let [point, spot] = &scene.lights[..] else { panic!("{:?}", scene.lights) };
    assert_eq!(
        (point.name.as_str(), point.position, point.color),
        ("bulb", [1.0, 2.0, 0.0], [1.0, 0.0, 0.0])
    );
    assert_eq!((point.intensity, spot.name.as_str(), spot.intensity), (7.0, "lamp", 1.0));
    let error = Doc::triangle().error(&rest.replace("\"light\":2", "\"light\":3"));
    assert!(error.contains("node 3: light 3 out of range (there are 3)"), "{error}");
}

#[test]
fn cameras_look_along_minus_z_and_move() {
    let mut doc = Doc::triangle();
    let input = doc.floats("SCALAR", &[0.0, 1.0]);
    let output = doc.floats("VEC3", &[0.0, 0.0, 0.0, 0.0, 0.0, 10.0]);
    let rest = format!(
        r#""cameras":[{{"type":"perspective","perspective":{{"yfov":1.57079632679,"znear":0.1}}}},
        {{"type":"orthographic","orthographic":{{"xmag":1,"ymag":1,"zfar":1,"znear":0.1}}}}],
        "nodes":[{{"name":"eye","camera":0,"scale":[3,3,3],"rotation":[0,0.70710678,0,0.70710678]}},{{"camera":1}}],
        "animations":[{{"channels":[{{"sampler":0,"target":{{"node":0,"path":"translation"}}}}],
        "samplers":[{{"input":{input},"output":{output}}}]}}]"#
    );
    let file = doc.open(&rest).unwrap_or_else(|e| panic!("{e}"));
    let cameras = file.at(Some(1.0)).unwrap_or_else(|e| panic!("{e}")).cameras;
    let [camera] = &cameras[..] else { panic!("{cameras:?}") };
    assert_eq!((camera.name.as_str(), camera.eye, camera.up), ("eye", [0.0, 0.0, 10.0], [0.0, 1.0, 0.0]));
    assert!(close(camera.target, [-10.0, 0.0, 10.0]) && (camera.fov - 90.0).abs() < 1e-4, "{camera:?}");
    let wide = doc.error(&rest.replace("1.57079632679", "4"));
    assert!(wide.contains("camera 0: its field of view"), "{wide}");
}
