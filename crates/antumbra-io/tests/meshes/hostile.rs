//! Seeded damage to small good files: any answer is fine but a panic, a long wait or a long text.

use std::time::{Duration, Instant};

use crate::{Folder, npy, ply, stl};

/// Knuth's multiplier; the high bits are good enough here.
struct Random(u64);

impl Random {
    fn below(&mut self, n: usize) -> usize {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        ((self.0 >> 33) as usize) % n.max(1)
    }
}

fn mutate(bytes: &mut Vec<u8>, random: &mut Random) {
    let at = random.below(bytes.len());
    match random.below(4) {
        0 => bytes.truncate(at),
        1 => bytes[at] ^= 1 << random.below(8),
        2 => bytes.iter_mut().skip(at).take(4).for_each(|b| *b = 0xff),
        // A number of the text, if there is one.
        _ => {
            let Some(start) = (at..bytes.len()).find(|&i| bytes[i].is_ascii_digit()) else { return };
            let len = bytes[start..].iter().take_while(|b| b.is_ascii_digit()).count();
            let words = ["4294967296", "nan", "-1", "1e999", "18446744073709551615"];
            bytes.splice(start..start + len, words[random.below(words.len())].bytes());
        }
    }
}

fn survive(name: &str, good: &[u8]) {
    let folder = Folder::new();
    let file = folder.file(name, good);
    antumbra_io::open(&file).unwrap_or_else(|e| panic!("{e}"));
    let mut faults = 0;
    for seed in 0..200 {
        let mut random = Random(seed);
        let mut bytes = good.to_vec();
        for _ in 0..=random.below(3) {
            if !bytes.is_empty() {
                mutate(&mut bytes, &mut random);
            }
        }
        folder.file(name, &bytes);
        let start = Instant::now();
        let result = antumbra_io::open(&file).and_then(|f| f.at(None));
        assert!(start.elapsed() < Duration::from_secs(2), "seed {seed} takes {:?}", start.elapsed());
        match result {
            Ok(scene) => scene.validate().unwrap_or_else(|e| panic!("seed {seed}: {e}")),
            Err(e) => {
                faults += 1;
                let text = e.to_string();
                assert!(text.contains(name) && text.lines().count() <= 2, "seed {seed}: {text}");
            }
        }
    }
    assert!(faults > 20, "only {faults} of 200 were noticed");
}

#[test]
fn obj() {
    survive(
        "damaged.obj",
        b"mtllib none.mtl\nv 0 0 0 1 0 0\nv 1 0 0 1 0 0\nv 1 1 0 1 0 0\nv 0 1 0 1 0 0\nvt 0 0\nvt 1 1\nvn 0 0 1\n\
          o thing\nusemtl red\nf 1/1/1 2/2/1 3/2/1 4/1/1\nf -1 -2 -3\nf 1//1 2//1 3//1\n",
    );
}

#[test]
fn ply_ascii() {
    survive("damaged.ply", ply::ASCII.as_bytes());
}

#[test]
fn ply_little_endian() {
    survive("damaged.ply", &ply::binary(false));
}

#[test]
fn ply_big_endian() {
    survive("damaged.ply", &ply::binary(true));
}

#[test]
fn stl_ascii() {
    survive("damaged.stl", stl::ASCII.as_bytes());
}

#[test]
fn stl_binary() {
    survive("damaged.stl", &stl::binary());
}

#[test]
fn npy_triangles() {
    let data: Vec<u8> = (0..18).flat_map(|i| (i as f32).to_le_bytes()).collect();
    survive("damaged.npy", &npy::file("<f4", "False", "(2, 3, 3)", &data));
}

#[test]
fn a_list_that_could_take_gigabytes_is_refused() {
    // Each byte of the list would become a triangle of 44 bytes: 64 MB of file, under 3 GB of scene.
    let n = 60_000_000u32;
    let mut bytes = "ply\nformat binary_little_endian 1.0\nelement vertex 3\nproperty char x\nproperty char y\nproperty char z\n\
         element face 1\nproperty list uint uchar vertex_index\nend_header\n".to_owned().into_bytes();
    bytes.extend([0; 9]);
    bytes.extend(n.to_le_bytes());
    bytes.resize(bytes.len() + n as usize, 0);
    assert!(crate::fault_of("big.ply", bytes).contains("needs more than the 1408 MiB"));
}
