//! The built program from outside: exit codes, messages, files.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// A folder of its own for a test, gone at its end.
struct Folder(PathBuf);

impl Folder {
    fn new(test: &str) -> Folder {
        let path = std::env::temp_dir().join(format!("antumbra-{test}-{}", std::process::id()));
        std::fs::create_dir_all(&path).unwrap();
        Folder(path)
    }

    fn file(&self, name: &str) -> String {
        self.0.join(name).display().to_string()
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

fn antumbra(words: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_antumbra")).args(words).output().unwrap()
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

fn fine(words: &[&str]) -> String {
    let output = antumbra(words);
    assert_eq!(output.status.code(), Some(0), "{words:?}: {}", text(&output.stderr));
    text(&output.stdout)
}

#[test]
fn mistakes_are_named_on_one_or_two_lines_with_exit_code_2() {
    let folder = Folder::new("mistakes");
    let empty = folder.file("empty.ply");
    std::fs::write(
        &empty,
        "ply\nformat ascii 1.0\nelement vertex 0\nproperty float x\nproperty float y\nproperty float z\nelement face 0\nproperty list uchar int vertex_indices\nend_header\n",
    )
    .unwrap();
    let [png, missing, mask] = ["a.png", "missing.glb", "m.npy"].map(|name| folder.file(name));
    for (words, parts) in [
        (vec!["render", "builtin:single", "--size", "0x0", "-o", &png], vec!["--size 0x0"]),
        (vec!["render", "builtin:single", "--size", "99999x99999", "-o", &png], vec!["--size", "million"]),
        (
            vec!["render", "builtin:single", "--light", "nan,0,0", "-o", &png],
            vec!["--light nan,0,0", "finite"],
        ),
        (vec!["render", "builtin:single", "--method", "foo", "-o", &png], vec!["foo", "oracle"]),
        (vec!["render", "builtin:nope", "-o", &png], vec!["nope", "single"]),
        (vec!["render", "single", "-o", &png], vec!["builtin:single"]),
        (vec!["render", &missing, "-o", &png], vec!["missing.glb"]),
        (vec!["render", "scene.xyz", "-o", &png], vec!["xyz", ".glb"]),
        (vec!["render", &empty, "-o", &png], vec!["empty.ply"]),
        (vec!["render", "builtin:single", "--camera-index", "99", "-o", &png], vec!["--camera-index 99"]),
        (vec!["render", "builtin:single", "--light-index", "99", "-o", &png], vec!["--light-index 99"]),
        (
            vec!["render", "builtin:single", "--backend", "gpu", "-o", &png],
            vec!["not built into this version; use"],
        ),
        (vec!["render", "builtin:single", "--exclude-object", "zzz", "-o", &png], vec!["zzz", "there are"]),
        (
            vec!["render", "builtin:single", "--method", "ptsv", "--debug", "depth", "-o", &png],
            vec!["--debug depth", "ptsv", "visits (tests of", "level (height"],
        ),
        (
            vec!["render", "builtin:single", "--debug", "triangles", "--mask", &mask],
            vec!["--debug triangles", "-o"],
        ),
        (vec!["render", "builtin:single"], vec!["nothing to write"]),
        (vec!["render", "builtin:single", "--bogus"], vec!["--bogus", "antumbra render --help"]),
        (vec!["compare"], vec!["SCENE", "--help"]),
        (
            vec!["mask", "--triangles", &missing, "--samples", &missing, "--light", "0,0,0", "--json"],
            vec!["missing"],
        ),
        (vec!["frobnicate"], vec!["frobnicate", "antumbra --help"]),
    ] {
        let output = antumbra(&words);
        let told = text(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{words:?}: {told}");
        assert!(told.starts_with("error: ") && told.lines().count() <= 2, "{words:?}: {told}");
        assert!(parts.iter().all(|part| told.contains(part)), "{words:?}: {told}");
        assert!(output.stdout.is_empty(), "{words:?}");
    }
    assert!(!Path::new(&png).exists());
}

#[test]
fn what_render_saw_gives_the_same_mask_again() {
    let folder = Folder::new("again");
    let [m, s, t, again, stats, png, exr] =
        ["m.npy", "s.npy", "t.npy", "again.npy", "s.json", "p.png", "p.exr"].map(|name| folder.file(name));
    let common = ["render", "builtin:single", "--size", "65x37", "--light", "-0.3,2.5,0.1"];
    let files = ["-o", &png, "--mask", &m, "--samples", &s, "--triangles", &t, "--stats", &stats];
    let silent = antumbra(&[&common[..], &files[..], &["--quiet"]].concat());
    assert_eq!((silent.status.code(), silent.stdout.len(), silent.stderr.len()), (Some(0), 0, 0));

    let words = ["mask", "--triangles", &t, "--samples", &s, "--light", "-0.3,2.5,0.1", "--method", "oracle"];
    let json = fine(&[&words[..], &["-o", &again, "--repeat", "3", "--json", "--threads", "1"]].concat());
    assert_eq!(std::fs::read(&m).unwrap(), std::fs::read(&again).unwrap());
    let json: serde_json::Value = serde_json::from_str(&json).unwrap();
    assert_eq!((json["method"].as_str(), json["threads"].as_u64()), (Some("oracle"), Some(1)));
    assert_eq!(json["runs_ms"].as_array().map(Vec::len), Some(3));

    let stats: serde_json::Value = serde_json::from_str(&std::fs::read_to_string(&stats).unwrap()).unwrap();
    for key in [
        "method",
        "backend",
        "isa",
        "threads",
        "samples",
        "triangles",
        "shadowed",
        "stages",
        "total_ms",
        "bytes",
        "counters",
    ] {
        assert!(!stats[key].is_null(), "{key}");
    }
    assert_eq!(stats["shadowed"], json["shadowed"]);
    let names: Vec<&str> =
        stats["program_stages"].as_array().unwrap().iter().filter_map(|s| s["name"].as_str()).collect();
    assert_eq!(names, ["read", "place", "gbuffer", "shadow", "shade", "write"]);

    fine(&[&common[..], &["-o", &exr]].concat());
    assert!(std::fs::read(&exr).unwrap().starts_with(&[0x76, 0x2f, 0x31, 0x01]));
    assert!(std::fs::read(&png).unwrap().starts_with(b"\x89PNG"));
}

#[test]
fn several_lights_have_a_mask_each() {
    let folder = Folder::new("several");
    let [m, t] = ["m.npy", "t.npy"].map(|name| folder.file(name));
    let words =
        ["render", "builtin:single", "--size", "32x18", "--light", "0,3,0", "--light=-1,3,0", "--mask", &m];
    let json = fine(&[&words[..], &["--triangles", &t, "--json"]].concat());
    let json: serde_json::Value = serde_json::from_str(&json).unwrap();
    assert_eq!(json["lights"].as_array().map(Vec::len), Some(2));
    assert!(["m.0.npy", "m.1.npy", "t.npy"].iter().all(|name| Path::new(&folder.file(name)).exists()));
    assert!(!Path::new(&m).exists());
}

#[test]
fn debug_views_are_listed_drawn_and_explained() {
    let folder = Folder::new("debug");
    let [png, again, exr, plain] = ["d.png", "e.png", "d.exr", "p.png"].map(|name| folder.file(name));
    for method in ["ray-cast", "ptsv", "cssv"] {
        let list = fine(&["render", "builtin:single", "--method", method, "--debug", "list"]);
        assert!(
            list.starts_with(&format!("debug views of {method}:\n")) && list.lines().count() > 2,
            "{list}"
        );
        let list = fine(&["render", "builtin:single", "--method", method, "--debug", "list", "--json"]);
        let list: serde_json::Value = serde_json::from_str(&list).unwrap();
        let views = list["views"].as_array().unwrap();
        assert!(views.iter().all(|v| !v["shows"].as_str().unwrap().is_empty()), "{list}");
        for view in views {
            let name = view["name"].as_str().unwrap();
            let words = ["render", "builtin:single", "--size", "48x27", "--method", method, "--debug", name];
            let output = antumbra(&[&words[..], &["-o", &png, "--json"]].concat());
            let told = text(&output.stderr);
            assert_eq!(output.status.code(), Some(0), "{words:?}: {told}");
            assert!(told.contains(&format!("debug view {name}: ")) && told.contains("yellow"), "{told}");
            let json: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
            let debug = &json["debug"];
            assert_eq!(debug["view"].as_str(), Some(name));
            let legend = &debug["lights"][0];
            assert_eq!(legend["range"][0], 0.0);
            let (end, max) = (legend["range"][1].as_f64().unwrap(), legend["max"].as_f64().unwrap());
            assert!(end <= max && (end < max) == (legend["above"].as_u64() > Some(0)), "{legend}");
            assert!(std::fs::read(&png).unwrap().starts_with(b"\x89PNG"));
        }
    }
    // The colours are those of the view, not of the picture; the numbers come without colours.
    let words = ["render", "builtin:single", "--size", "48x27", "--method", "ptsv"];
    fine(&[&words[..], &["-o", &plain]].concat());
    fine(&[&words[..], &["-o", &png, "--debug", "tile"]].concat());
    fine(&[&words[..], &["-o", &again, "--debug", "level"]].concat());
    fine(&[&words[..], &["-o", &exr, "--debug", "level"]].concat());
    let [plain, tile, level] = [&plain, &png, &again].map(|path| std::fs::read(path).unwrap());
    assert!(plain != tile && tile != level && plain != level);
    assert!(std::fs::read(&exr).unwrap().starts_with(&[0x76, 0x2f, 0x31, 0x01]));
    // A range of one's own, so that pictures can be compared.
    let words = [&words[..], &["--debug", "level", "--debug-max", "2.5", "-o", &png, "--json"]].concat();
    let json: serde_json::Value = serde_json::from_str(&fine(&words)).unwrap();
    assert_eq!(
        (json["debug"]["range_to"].as_str(), &json["debug"]["lights"][0]["range"][1]),
        (Some("as told"), &2.5.into())
    );
    // Without --debug nothing is said of it.
    let words = ["render", "builtin:single", "--size", "48x27", "--method", "ptsv"];
    assert!(!fine(&[&words[..], &["--json"]].concat()).contains("\"debug\""));
    // A picture for each light.
    let lights = ["--light", "0,3,0", "--light=-1,3,0", "--debug", "level", "-o", &png];
    fine(&[&words[..], &lights].concat());
    assert!(["d.0.png", "d.1.png"].iter().all(|name| Path::new(&folder.file(name)).exists()));
}

#[test]
fn compare_finds_the_exact_methods_equal() {
    let folder = Folder::new("compare");
    let dir = folder.file("differences");
    let words = ["compare", "builtin:lattice", "--size", "48x27", "--diff-dir", &dir];
    let table = fine(&words);
    assert!(table.contains("all exact methods agree") && table.contains("reference: oracle"), "{table}");
    assert!(Path::new(&dir).join("oracle.png").exists());
    let json: serde_json::Value = serde_json::from_str(&fine(&[&words[..], &["--json"]].concat())).unwrap();
    assert_eq!(json["agree"], true);
    let rows = json["lights"][0]["methods"].as_array().unwrap();
    assert!(rows.iter().filter(|r| r["exact"] == true).all(|r| r["mismatches"] == 0), "{rows:?}");
}

#[test]
fn lists_help_and_pages() {
    assert!(fine(&["methods"]).contains("oracle"));
    assert!(fine(&["scenes"]).contains("builtin:single"));
    for words in [["methods", "--json"], ["scenes", "--json"]] {
        assert!(serde_json::from_str::<serde_json::Value>(&fine(&words)).is_ok());
    }
    let info = fine(&["info", "builtin:degenerate"]);
    assert!(info.contains("degenerate") && info.contains("bounds"), "{info}");
    let json: serde_json::Value =
        serde_json::from_str(&fine(&["info", "builtin:degenerate", "--json"])).unwrap();
    assert!(json["degenerate"].as_u64() > Some(0));
    assert!(fine(&["render", "--help"]).contains("Examples:"));
    assert!(fine(&["--version"]).starts_with("antumbra "));
    assert!(fine(&["completions", "bash"]).contains("antumbra"));
    assert!(fine(&["man"]).contains(".TH") && fine(&["man", "render"]).contains("antumbra-render"));
    assert_eq!(antumbra(&[]).status.code(), Some(2));
}

#[test]
#[cfg(unix)]
fn a_reader_that_goes_away_is_no_error() {
    let shell =
        format!("{} completions bash | head -c 1; echo ${{PIPESTATUS[0]}}", env!("CARGO_BIN_EXE_antumbra"));
    let Ok(output) = Command::new("bash").args(["-c", &shell]).output() else { return };
    assert!(text(&output.stdout).ends_with("0\n"), "{} {}", text(&output.stdout), text(&output.stderr));
}

#[test]
fn reproduce_writes_a_page_and_names_what_is_not_there() {
    let folder = Folder::new("reproduce");
    let (page, scenes) = (folder.file("page.md"), folder.file("."));
    let words = ["reproduce", "--scenes", &scenes, "--only", "lists", "--divide", "64", "-q", "-o", &page];
    fine(&words);
    let written = std::fs::read_to_string(&page).unwrap();
    for part in [
        "# Reproducing the papers",
        "`crytek_sponza/sponza.glb` is not there; `builtin:atrium` stands in",
        "`bart_museum/bart_museum.glb` is not there; left out",
        "| builtin:one-cell, 30 x 16 |",
        "divided by 64",
        "- Holds: yes",
    ] {
        assert!(written.contains(part), "{part}: {written}");
    }
    let output = antumbra(&["reproduce", "--only", "nope"]);
    assert_eq!(output.status.code(), Some(2));
    assert!(text(&output.stderr).contains("no such section; there are frames, sorting"));
}
