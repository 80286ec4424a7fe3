//! Files that are wrong, by accident or by intent.

use std::time::{Duration, Instant};

use super::*;

#[test]
fn errors_name_file_line_and_statement() {
    for (text, expected) in [
        ("\n\np 3 0 0 nan 0 0 0 0 0 0", "main.aff line 3: p: corner: 'nan' is not a finite number"),
        ("s 0 0\n1e308 1", "main.aff line 2: s: centre: '1e308' is too large a number"),
        ("s 0 0 inf 1", "main.aff line 1: s: centre: 'inf' is too large a number"),
        ("p 4294967296 0 0 0", "main.aff line 1: p: corners: 4294967296 are announced, the file holds fewer"),
        ("p -1 0 0 0", "main.aff line 1: p: corners: -1 is negative"),
        ("p 2 0 0 0 1 1 1", "main.aff line 1: p: 2 corners, at least 3 are needed"),
        ("wobble 1", "main.aff line 1: unknown statement 'wobble'"),
        (
            "m vertices 1 0 0 0\ntriangles 1\n0 0 1",
            "main.aff line 3: m: vertex index 1 is out of range (there are 1)",
        ),
        ("m vertices 0 lines", "main.aff line 1: m: expected 'triangles', found 'lines'"),
        ("xs 1 1 1 0 0 1 0 0 0 0 {", "main.aff line 1: the file ends, but the '{' of line 1 is still open"),
        ("}", "main.aff line 1: }: no '{' of this file is open"),
        ("k a {\n transl 3 ", "main.aff line 2: k: transl: 3 are announced, the file holds fewer"),
        ("k a { visibility 0 }", "main.aff line 1: k: visibility: 0 keys, at least 1 are needed"),
        (
            "k a { hop 4",
            "main.aff line 1: k: unknown kind of keys 'hop'; known are transl, rot, scale and visibility",
        ),
        ("a 1 0 5", "main.aff line 1: a: the start 1 is after the end 0"),
        ("v from 0 0 0", "main.aff line 1: v: 'from' and 'at' are needed"),
        ("v from 0 0 0 at 1 0 0 angle 180", "main.aff line 1: v: angle 180 is not between 0 and 180"),
        ("c 0 0 0 1 0 0 0 1", "main.aff line 1: c: base and apex are the same point"),
        ("fm 0 0", "main.aff line 1: fm: the file ends where ambient colour should follow"),
        ("i 0 gone.aff", "main.aff line 1: i: cannot read 'gone.aff': there is no such file"),
    ] {
        assert_eq!(error(text), expected);
    }
}

#[test]
fn a_missing_main_file_is_an_io_error() {
    let folder = Folder::new();
    assert!(matches!(folder.open(), Err(crate::Error::Io { .. })));
}

#[test]
fn includes_stay_in_the_folder() {
    let outer = Folder::with("", &[("secret.aff", TRIANGLE), ("in/main.aff", "i 0 ../secret.aff")]);
    let message = open(&outer.0.join("in/main.aff")).unwrap_err().to_string();
    assert!(
        message.ends_with("cannot read '../secret.aff': it lies outside the main file's folder"),
        "{message}"
    );
    let absolute = format!("i 0 {}", outer.0.join("secret.aff").display());
    assert!(error(&absolute).contains("outside the main file's folder"));
    // Back and forth within the folder is fine.
    let folder = Folder::with("i 0 sub/a.aff", &[("sub/a.aff", "i 0 ../b.aff"), ("b.aff", TRIANGLE)]);
    assert_eq!(folder.open().unwrap().at(None).unwrap().soup.len(), 1);
}

#[cfg(unix)]
#[test]
fn links_and_folders_are_no_way_out() {
    let outer = Folder::with("", &[("secret.aff", TRIANGLE), ("in/main.aff", "i 0 link.aff")]);
    std::os::unix::fs::symlink(outer.0.join("secret.aff"), outer.0.join("in/link.aff")).unwrap();
    let message = open(&outer.0.join("in/main.aff")).unwrap_err().to_string();
    assert!(message.ends_with("outside the main file's folder"), "{message}");
    let folder = Folder::with("i 0 sub", &[("sub/a.aff", "")]);
    assert!(error_in(&folder).ends_with("there is no such file"));
}

#[test]
fn include_cycles_are_errors() {
    let folder = Folder::with("i 0 a.aff", &[("a.aff", "\ni 0 b.aff"), ("b.aff", "i 0 a.aff")]);
    assert_eq!(error_in(&folder), "b.aff line 1: i: 'a.aff' includes itself");
}

#[test]
fn exponential_includes_are_stopped() {
    let names: Vec<String> = (0..40).map(|i| format!("f{i}.aff")).collect();
    let folder = Folder::with("i 0 f0.aff", &[]);
    for (i, name) in names.iter().enumerate() {
        let next = format!("i 0 f{}.aff\n", i + 1);
        folder.write(name, next.repeat(2).as_bytes());
    }
    assert!(error_in(&folder).ends_with("more than 32 files within each other"));
    folder.write("f20.aff", TRIANGLE.as_bytes());
    assert!(error_in(&folder).ends_with("more than 100000 includes"));
    // Many triangles in each instead of many files.
    folder.write("f14.aff", "s 0 0 0 1\n".repeat(1000).as_bytes());
    let start = Instant::now();
    assert!(error_in(&folder).ends_with("more than 4194304 triangles with all includes"));
    assert!(start.elapsed() < Duration::from_secs(20));
}

#[test]
fn nested_braces_are_limited() {
    let text = "xs 2 2 2 0 0 1 0 0 0 0 {".repeat(5000);
    assert!(error(&text).ends_with("more than 1024 nested braces and files"));
    // Below the limit the numbers leave the range.
    let text = format!("{}{TRIANGLE}{}", "xs 2 2 2 0 0 1 0 0 0 0 {".repeat(500), "}".repeat(500));
    let message = file(&text).at(None).unwrap_err().to_string();
    assert!(message.ends_with("object 'main', triangle 0 of the scene: a coordinate is too large at time 0"));
}

#[test]
fn polygons_that_cross_themselves_are_triangles_too() {
    assert_eq!(scene("p 4  0 0 0  1 1 0  1 0 0  0 1 0").soup.len(), 2);
    assert_eq!(scene("p 5  0 0 0  0 0 0  0 0 0  0 0 0  0 0 0").soup.len(), 3);
    assert_eq!(scene("p 5  0 0 0  3e38 0 0  0 -3e38 0  3e38 3e38 0  0 3e38 0").soup.len(), 3);
}

/// Every statement once.
const EVERYTHING: &str = "# all
v from 0 0 9 at 0 0 0 up 0 1 0 angle 40 hither 1 resolution 8 6
b 0 0 0 am 1 1 1 a 0 2 50 d 1
l 1 2 3 .5 .5 .5
la lamp 4 5 6
f 1 .5 .2 1 0 1 .5 1
s 0 0 0 1
c 0 0 0 1 0 2 0 .5
fm .1 .1 .1 .2 .2 .2 .3 .3 .3 1 0 1
i 1 part.aff
xs 1 2 3  0 1 0 45  1 0 0
{
 x arm { p 5  4 0 0  4 4 0  0 4 0  3 3 0  0 0 0 }
 pp 3  0 0 0 0 0 1  1 0 0 0 0 1  0 1 0 0 0 1
}
tt a.ppm  0 0 0 0 0  1 0 0 1 0  0 1 0 0 1
ttp a.ppm  0 0 0 0 0 1 0 0  1 0 0 0 0 1 1 0  0 1 0 0 0 1 0 1
tpa 2 0 0 0 0 0 0 1 1 0 0 0 0 1 0 1 0 0 0 1  2 4 0 0 0 1 0 5 0 0 0 1 0 4 1 0 0 1 0
m vertices 3 0 0 0 1 0 0 0 1 0 normals 1 0 0 1 texturecoords 1 a.ppm 0 0 triangles 1 0 1 2 0 0 0 0 0 0
k arm { transl 4 0 1 2 3 0 0 0 1 1 2 3 0 0 0 2 1 2 3 0 0 1 3 1 2 3 0 0 0
 rot 4 0 0 1 0 90 0 0 0 1 0 1 0 180 0 0 0 2 1 1 0 90 0 1 0 3 0 1 0 90 0 0 0
 scale 4 0 1 1 1 0 0 0 1 1 1 1 0 0 0 2 1 1 1 1 0 0 3 1 1 1 0 0 0
 visibility 1 0 1 }
k camera { rot 4 0 0 1 0 90 0 0 0 1 0 1 0 90 0 0 0 2 0 1 0 90 0 0 0 3 0 1 0 90 0 0 0 }
";

#[test]
fn mutated_files_give_a_scene_or_an_error() {
    let folder = Folder::with(EVERYTHING, &[("part.aff", TRIANGLE), ("a.ppm", "P3 1 1 255 1 2 3")]);
    assert_eq!(folder.open().unwrap().at(Some(1.0)).unwrap().soup.len(), 528 + 48 + 1 + 3 + 1 + 4);
    let mut state = 0x9e37_79b9_7f4a_7c15_u64;
    let mut random = |below: usize| {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 33) as usize % below
    };
    let words: Vec<&str> = EVERYTHING.split_inclusive(char::is_whitespace).collect();
    let (mut scenes, mut errors) = (0, 0);
    for round in 0..300 {
        let mut bytes = EVERYTHING.as_bytes().to_vec();
        match round % 3 {
            0 => bytes.truncate(random(bytes.len())),
            1 => {
                for _ in 0..=random(4) {
                    let at = random(bytes.len());
                    bytes[at] ^= 1 << random(8);
                }
            }
            _ => {
                let number = ["nan ", "4294967296 ", "1e308 ", "-1 ", "3e38 ", "{ "][random(6)];
                let mut words = words.clone();
                let at = random(words.len());
                words[at] = number;
                bytes = words.concat().into_bytes();
            }
        }
        folder.write("main.aff", &bytes);
        let start = Instant::now();
        let result = folder.open().and_then(|file| {
            file.at(None)?;
            file.at(Some(1.3))
        });
        assert!(start.elapsed() < Duration::from_secs(2), "round {round}");
        match result {
            Ok(scene) => {
                scene.validate().unwrap();
                scenes += 1;
            }
            Err(error) => {
                let text = error.to_string();
                assert!(text.lines().count() <= 2 && text.contains("main.aff"), "{text}");
                errors += 1;
            }
        }
    }
    assert!(scenes > 20 && errors > 100, "{scenes} scenes, {errors} errors");
}
