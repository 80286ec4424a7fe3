//! Damaged files: any answer will do, but there must be one, and an error names the file on at most two lines.

use crate::build::{Doc, Folder, base64, png};

/// A file with everything in it: texture, skin, morph target, sparse accessor, animations, light, camera, instances.
fn everything() -> (Doc, String) {
    let mut doc = Doc::triangle();
    let joints = doc.shorts("VEC4", &[0, 1, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0]);
    let weights = doc.floats("VEC4", &[0.5, 0.5, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0]);
    let target = doc.floats("VEC3", &[0.0, 0.0, 1.0, 0.0, 0.0, 2.0, 0.0, 0.0, 3.0]);
    let uvs = doc.floats("VEC2", &[0.0, 0.0, 1.0, 0.0, 0.0, 1.0]);
    let indices = doc.shorts("SCALAR", &[0, 1, 2, 2, 1, 0]);
    let times = doc.floats("SCALAR", &[0.0, 0.5, 2.0]);
    let moves = doc.floats("VEC3", &[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 1.0, 0.0]);
    let turns = doc.floats("VEC4", &[0.0, 0.0, 0.0, 1.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0]);
    let weigh = doc.floats("SCALAR", &[0.0, 1.0, 0.5]);
    let image = doc.view(&png(5, 4));
    let at = doc.view(&[1, 0, 0, 0]);
    let value = doc.view(&[0u8; 12]);
    doc.accessors.push(format!(
        r#"{{"bufferView":0,"count":3,"type":"VEC3","componentType":5126,"sparse":{{"count":1,
        "indices":{{"bufferView":{at},"componentType":5121}},"values":{{"bufferView":{value}}}}}}}"#
    ));
    let sparse = doc.accessors.len() - 1;
    let rest = format!(
        r#""scene":0,"scenes":[{{"nodes":[0,1,3,4]}}],
        "nodes":[{{"mesh":0,"skin":0,"name":"body"}},{{"children":[2],"translation":[1,0,0]}},
        {{"rotation":[0,0,0,1],"camera":0}},{{"mesh":1,"matrix":[1,0,0,0,0,1,0,0,0,0,1,0,0,0,5,1],
        "extensions":{{"EXT_mesh_gpu_instancing":{{"attributes":{{"TRANSLATION":{moves}}}}}}}}},
        {{"extensions":{{"KHR_lights_punctual":{{"light":0}}}}}}],
        "cameras":[{{"type":"perspective","perspective":{{"yfov":1,"znear":0.1}}}}],
        "extensions":{{"KHR_lights_punctual":{{"lights":[{{"type":"point"}}]}}}},
        "skins":[{{"joints":[1,2]}}],"textures":[{{"source":0}}],"images":[{{"bufferView":{image},"mimeType":"image/png"}}],
        "materials":[{{"alphaMode":"MASK","pbrMetallicRoughness":{{"baseColorTexture":{{"index":0}}}}}}],
        "meshes":[{{"weights":[1],"primitives":[{{"attributes":{{"POSITION":0,"JOINTS_0":{joints},"WEIGHTS_0":{weights},
        "TEXCOORD_0":{uvs}}},"indices":{indices},"material":0,"targets":[{{"POSITION":{target}}}]}}]}},
        {{"primitives":[{{"attributes":{{"POSITION":{sparse}}},"mode":5}}]}}],
        "animations":[{{"channels":[{{"sampler":0,"target":{{"node":1,"path":"translation"}}}},
        {{"sampler":1,"target":{{"node":2,"path":"rotation"}}}},{{"sampler":2,"target":{{"node":0,"path":"weights"}}}}],
        "samplers":[{{"input":{times},"output":{moves}}},{{"input":{times},"output":{turns}}},
        {{"input":{times},"output":{weigh},"interpolation":"STEP"}}]}}]"#
    );
    (doc, rest)
}

/// A small generator of the 64-bit xorshift family (Marsaglia 2003, "Xorshift RNGs").
struct Random(u64);

impl Random {
    fn below(&mut self, n: usize) -> usize {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 % n as u64) as usize
    }
}

fn damage(bytes: &mut Vec<u8>, random: &mut Random) {
    for _ in 0..=random.below(3) {
        let at = random.below(bytes.len().max(5) - 4);
        match random.below(6) {
            0 => bytes.truncate(at.max(1)),
            1 | 2 => bytes[at] ^= 1 << random.below(8),
            3 => bytes[at..at + 4].fill(0xFF),
            4 => bytes[at..at + 4].copy_from_slice(&f32::NAN.to_le_bytes()),
            // Digits make the worst numbers of a JSON text.
            _ => bytes[at] = b'0' + random.below(10) as u8,
        }
        if bytes.len() < 5 {
            break;
        }
    }
}

fn survive(name: &str, original: &[u8], seed: u64, rounds: usize) {
    let folder = Folder::new();
    let mut random = Random(seed);
    let mut good = 0;
    for round in 0..rounds {
        let mut bytes = original.to_vec();
        damage(&mut bytes, &mut random);
        let result = folder.open(name, &bytes).and_then(|file| {
            let rest = file.at(None)?;
            rest.validate().unwrap_or_else(|e| panic!("round {round}: {e}"));
            file.time_span();
            file.at(Some(0.75))
        });
        match result {
            Ok(scene) => {
                scene.validate().unwrap_or_else(|e| panic!("round {round}: {e}"));
                good += 1;
            }
            Err(e) => {
                let text = e.to_string();
                assert!(text.contains(name) && text.lines().count() <= 2, "round {round}: {text}");
            }
        }
    }
    // Otherwise the damage was so great that nothing but the first check was tried.
    assert!(good > 0 && good < rounds, "{good} of {rounds} were read");
}

#[test]
fn the_undamaged_file_is_read() {
    let (doc, rest) = everything();
    let scene = doc.scene(&rest);
    assert_eq!(
        (scene.soup.len(), scene.lights.len(), scene.cameras.len(), scene.textures.len()),
        (5, 1, 1, 1)
    );
}

#[test]
fn damaged_glbs_never_panic() {
    let (doc, rest) = everything();
    survive("damaged.glb", &doc.glb(&rest), 0x9E37_79B9_7F4A_7C15, 200);
}

#[test]
fn damaged_json_never_panics() {
    let (doc, rest) = everything();
    survive("damaged.gltf", doc.gltf(&rest).as_bytes(), 0xD1B5_4A32_D192_ED03, 200);
}

#[test]
fn damaged_binary_parts_never_panic() {
    let (doc, rest) = everything();
    let folder = Folder::new();
    let mut random = Random(7);
    for _ in 0..200 {
        let mut doc =
            Doc { bytes: doc.bytes.clone(), views: doc.views.clone(), accessors: doc.accessors.clone() };
        let length = doc.bytes.len();
        damage(&mut doc.bytes, &mut random);
        doc.bytes.resize(length, 0);
        let _ = base64(&doc.bytes);
        if let Ok(file) = folder.open("damaged.glb", &doc.glb(&rest)) {
            let _ = file.at(Some(0.3));
        }
    }
}
