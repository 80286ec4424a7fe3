use antumbra_io::{read::npy, write};
use exr::prelude::{FlatSamples, ReadChannels, ReadLayers};

use crate::Folder;

#[test]
fn png_colours_and_masks() {
    let folder = Folder::new();
    let path = folder.path("a.png");
    write::png::color(&path, 2, 1, &[[1, 2, 3], [250, 251, 252]]).unwrap();
    let read = || image::open(&path).unwrap();
    assert_eq!(read().into_rgb8().into_raw(), [1, 2, 3, 250, 251, 252]);
    write::png::indexed(&path, 3, 1, &[[9, 8, 7], [1, 2, 3]], &[1, 0, 200]).unwrap();
    assert_eq!(read().into_rgb8().into_raw(), [1, 2, 3, 9, 8, 7, 1, 2, 3]);
    for palette in [&[][..], &[[0; 3]; 257]] {
        assert!(write::png::indexed(&path, 1, 1, palette, &[0]).is_err());
    }
    write::png::linear(&path, 1, 2, &[[0.0, 0.215_860_5, 9.0], [f32::NAN, -1.0, 1.0]]).unwrap();
    assert_eq!(read().into_rgb8().into_raw(), [0, 128, 255, 0, 0, 255]);
    write::png::mask(&path, 3, 1, &[0, 1, 255]).unwrap();
    assert_eq!(read().into_luma8().into_raw(), [255, 0, 128], "lit white, shadowed black, none grey");
}

#[test]
fn exr_with_extra_channels() {
    let folder = Folder::new();
    let path = folder.path("a.exr");
    let pixels = [[0.0, 1.0, 2.0], [3.0, -4.0, 1e30]];
    write::exr::color(&path, 2, 1, &pixels, &[("mask", &[0.0, 255.0]), ("Z", &[7.0, 8.0])]).unwrap();
    let read = || {
        exr::prelude::read()
            .no_deep_data()
            .largest_resolution_level()
            .all_channels()
            .first_valid_layer()
            .all_attributes()
            .from_file(&path)
    };
    let image = read().unwrap();
    let channels: Vec<_> = image.layer_data.channel_data.list.iter().collect();
    let values = |name: &str| match &channels.iter().find(|c| c.name.to_string() == name).unwrap().sample_data
    {
        FlatSamples::F32(values) => values.clone(),
        other => panic!("{other:?}"),
    };
    assert_eq!([values("R"), values("G"), values("B")], [[0.0, 3.0], [1.0, -4.0], [2.0, 1e30]]);
    assert_eq!([values("mask"), values("Z")], [[0.0, 255.0], [7.0, 8.0]]);

    write::exr::numbers(&path, 1, 2, &[0.5, f32::NAN]).unwrap();
    let image = read().unwrap();
    let [y] = &image.layer_data.channel_data.list[..] else { panic!("one channel") };
    let FlatSamples::F32(values) = &y.sample_data else { panic!("not f32") };
    assert_eq!((y.name.to_string().as_str(), values[0], values[1].is_nan()), ("Y", 0.5, true));
    assert!(write::exr::numbers(&path, 2, 2, &[0.5]).is_err());
    for (name, len) in [("R", 2), ("", 2), ("a\u{3b1}", 2), ("ok", 1)] {
        assert!(write::exr::color(&path, 2, 1, &pixels, &[(name, &vec![0.0; len])]).is_err(), "{name}");
    }
}

#[test]
fn sizes_that_do_not_fit_are_refused() {
    let folder = Folder::new();
    let text = |r: Result<(), antumbra_io::Error>| r.unwrap_err().to_string();
    let path = folder.path("x");
    assert!(
        text(write::png::mask(&path, 2, 2, &[0])).ends_with("mask: 1 entries do not fill the shape [2, 2]")
    );
    assert!(text(write::png::color(&path, 0, 5, &[])).ends_with("a picture of 0 x 5 pixels is not possible"));
    assert!(text(write::npy::samples(&path, &[[0.0; 3]], &[2])).contains("do not fill the shape [2, 3]"));
    assert!(text(write::npy::f32_array(&path, &[], &[usize::MAX, 9])).contains("do not fill"));
    assert!(folder.names().is_empty());
}

#[test]
fn files_are_replaced_whole_and_leave_nothing_behind() {
    let folder = Folder::new();
    let path = folder.file("m.npy", "old");
    write::npy::mask(&path, &[1, 0], &[2]).unwrap();
    assert_eq!(npy::read_mask(&path).unwrap().0, [1, 0]);
    write::bytes(&folder.path("a.json"), b"{}").unwrap();
    assert_eq!(folder.names(), ["a.json", "m.npy"]);
}

#[test]
fn a_missing_folder_and_a_folder_are_named() {
    let folder = Folder::new();
    let path = folder.path("no/where/a.npy");
    let text = write::bytes(&path, b"").unwrap_err().to_string();
    let parent = folder.path("no/where");
    assert_eq!(text, format!("{}: the folder {} does not exist", path.display(), parent.display()));
    let text = write::bytes(&folder.path("."), b"").unwrap_err().to_string();
    assert!(text.ends_with("is a folder, not a file"), "{text}");
    let path = folder.file("file", "").join("a.npy");
    assert!(write::bytes(&path, b"").unwrap_err().to_string().ends_with("is not a folder"));
}

#[cfg(unix)]
#[test]
fn links_are_followed_and_devices_stay_devices() {
    let folder = Folder::new();
    let file = folder.file("real", "old");
    std::os::unix::fs::symlink(&file, folder.path("link")).unwrap();
    write::bytes(&folder.path("link"), b"new").unwrap();
    assert_eq!(std::fs::read(&file).unwrap(), b"new");
    assert!(folder.path("link").is_symlink());
    write::bytes(std::path::Path::new("/dev/null"), b"gone").unwrap();
    assert!(!std::path::Path::new("/dev/null").is_file());
}
