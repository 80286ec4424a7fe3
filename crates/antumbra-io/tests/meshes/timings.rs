//! How long big files take; prints, asserts nothing. `cargo test --release -- --ignored --nocapture timings`.
#![allow(clippy::print_stderr)]

use std::time::Instant;

use antumbra_io::{read::npy, write};

use crate::Folder;

fn timed<T>(what: &str, work: impl FnOnce() -> T) -> T {
    let start = Instant::now();
    let result = work();
    eprintln!("{what}: {:.1} ms", start.elapsed().as_secs_f64() * 1e3);
    result
}

#[test]
#[ignore = "a measurement"]
fn timings() {
    let folder = Folder::new();
    let (width, height) = (1920, 1080);
    let mut seed = 1u32;
    // Smooth shading with some noise, as a picture has.
    let pixels: Vec<[f32; 3]> = (0..width * height)
        .map(|i| {
            seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            let noise = (seed >> 24) as f32 / 255.0 * 0.02;
            [(i % width) as f32 / 1920.0, (i / width) as f32 / 1080.0, 0.5].map(|v| v + noise)
        })
        .collect();
    let srgb: Vec<[u8; 3]> = pixels.iter().map(|p| p.map(write::png::srgb_byte)).collect();
    let mask: Vec<u8> = (0..width * height).map(|i| u8::from((i / 97 + i / width) % 5 == 0)).collect();

    timed("png colour", || write::png::color(&folder.path("c.png"), width, height, &srgb).unwrap());
    timed("png linear", || write::png::linear(&folder.path("l.png"), width, height, &pixels).unwrap());
    timed("png mask", || write::png::mask(&folder.path("m.png"), width, height, &mask).unwrap());
    timed("png by image, fast", || {
        use image::{ExtendedColorType, ImageEncoder, codecs::png};
        let mut bytes = Vec::new();
        let (speed, filter) = (png::CompressionType::Fast, png::FilterType::Adaptive);
        png::PngEncoder::new_with_quality(&mut bytes, speed, filter)
            .write_image(srgb.as_flattened(), width as u32, height as u32, ExtendedColorType::Rgb8)
            .unwrap();
    });
    let extra = vec![1.0; width * height];
    timed("exr, 4 channels", || {
        write::exr::color(&folder.path("a.exr"), width, height, &pixels, &[("mask", &extra)]).unwrap();
    });
    timed("npy samples write", || {
        write::npy::samples(&folder.path("s.npy"), &pixels, &[height, width]).unwrap();
    });
    timed("npy samples read, 25 MB", || npy::read_samples(&folder.path("s.npy")).unwrap());
    let triangles = vec![[[1.0f32; 3]; 3]; 2_800_000];
    timed("npy triangles write", || write::npy::triangles(&folder.path("t.npy"), &triangles).unwrap());
    timed("npy triangles read, 101 MB", || npy::read_triangles(&folder.path("t.npy")).unwrap());
    let mut obj = String::new();
    for i in 0..300_000 {
        obj += &format!("v {}.25 {}.5 0.125\nvt 0.5 0.25\nvn 0 0 1\n", i % 1000, i / 1000);
    }
    for i in 1..290_000 {
        obj += &format!("f {i}/{i}/{i} {0}/{0}/{0} {1}/{1}/{1} {2}/{2}/{2}\n", i + 1, i + 1001, i + 1000);
    }
    let file = folder.file("big.obj", &obj);
    timed(&format!("obj, {} MB", obj.len() >> 20), || antumbra_io::open(&file).unwrap());
    for name in ["c.png", "m.png", "a.exr"] {
        eprintln!("{name}: {} KB", folder.path(name).metadata().unwrap().len() >> 10);
    }
}
