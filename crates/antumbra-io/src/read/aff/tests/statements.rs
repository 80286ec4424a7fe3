//! Statements without motion.

use antumbra::scene::AlphaMode;

use super::*;

#[test]
fn a_polygon_is_a_fan_with_a_plain_material() {
    let scene = scene("# a comment\np 4  0 0 0  1 0 0  1 1 0  0 1 0 % another");
    let [a, b, c, d] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
    assert_eq!(scene.soup.positions, [[a, b, c], [a, c, d]]);
    assert_eq!(scene.name, "main");
    assert_eq!(scene.objects[0].name, "main");
    assert_eq!(scene.materials[0].name, "default");
    assert!(scene.soup.normals.is_empty() && scene.soup.uvs.is_empty());
}

#[test]
fn a_dented_polygon_keeps_its_area() {
    // An arrow head whose dent is seen badly from the first corner.
    let scene = scene("p 5  4 0 0  4 4 0  0 4 0  3 3 0  0 0 0");
    let area: f32 = scene
        .soup
        .positions
        .iter()
        .map(|[a, b, c]| 0.5 * ((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])).abs())
        .sum();
    assert_eq!(scene.soup.len(), 3);
    // The square of 16 less the triangle of corners (0 4), (3 3), (0 0).
    assert!((area - 10.0).abs() < 1e-5, "{area}");
}

#[test]
fn a_patch_has_normals() {
    let scene = scene("pp 3  0 0 0  0 0 2   1 0 0  0 0 1   0 1 0  0 0 1");
    assert_eq!(scene.soup.normals, [[[0.0, 0.0, 1.0]; 3]]);
}

#[test]
fn a_mesh_takes_indices_for_each_of_its_arrays() {
    let scene = scene(
        "fm .1 .1 .1 .5 .6 .7 .9 .9 .9 10 0 1
         m vertices 3  0 0 0  1 0 0  0 1 0
         normals 1  0 0 1
         texturecoords 2 wood.ppm  0 0  .5 1
         triangles 1  0 1 2  0 0 0  0 1 1",
    );
    assert_eq!(scene.soup.uvs, [[[0.0, 0.0], [0.5, 1.0], [0.5, 1.0]]]);
    assert_eq!(scene.soup.normals[0][2], [0.0, 0.0, 1.0]);
    assert_eq!(scene.materials[0].name, "main line 1 (missing texture wood.ppm)");
    assert_eq!(scene.materials[0].base_color, [0.5, 0.6, 0.7, 1.0]);
    assert_eq!(scene.materials[0].base_color_texture, None);
}

#[test]
fn degenerate_triangles_are_kept() {
    assert_eq!(scene("m vertices 1  1 1 1  triangles 2  0 0 0  0 0 0").soup.len(), 2);
}

#[test]
fn fills_become_materials() {
    let text =
        format!("f .5 1 .2 .5 0 1 .25 1.5 {TRIANGLE} fm 0 0 0 .1 .2 .3 0 0 0 1 0 1 {TRIANGLE}{TRIANGLE}");
    let scene = scene(&text);
    assert_eq!(scene.soup.material, [0, 1, 1]);
    assert_eq!(scene.materials[0].base_color, [0.25, 0.5, 0.1, 0.75]);
    assert_eq!(scene.materials[0].alpha_mode, AlphaMode::Blend);
    assert_eq!(scene.materials[1].alpha_mode, AlphaMode::Opaque);
}

#[test]
fn textured_triangles_read_their_image() {
    let text = "tt A.PPM  0 0 0 0 1  1 0 0 1 1  0 1 0 0 0
                ttp b.ppm  0 0 0  0 0 1  0 0   1 0 0  0 0 1  1 0   0 1 0  0 0 1  0 1";
    let folder = Folder::with(text, &[("a.ppm", "P3 1 2 255  255 0 0  0 0 255"), ("b.ppm", "junk")]);
    let scene = folder.open().unwrap().at(None).unwrap();
    assert_eq!(scene.textures[0].pixels, [[255, 0, 0, 255], [0, 0, 255, 255]]);
    assert_eq!(scene.materials[0].base_color_texture, Some(0));
    assert_eq!(scene.materials[0].base_color, [1.0; 4]);
    assert_eq!(scene.materials[1].name, "default (unreadable texture b.ppm)");
    assert_eq!(scene.soup.uvs[0][1], [1.0, 1.0]);
    assert_eq!(scene.soup.normals, [[[0.0; 3]; 3], [[0.0, 0.0, 1.0]; 3]]);
}

#[test]
fn spheres_and_cones_become_triangles() {
    let sphere = scene("s 1 2 3  2");
    assert_eq!(sphere.soup.len(), 528);
    let (lo, hi) = sphere.soup.bounds().unwrap();
    assert_near(lo, [-1.0, 0.0, 1.0]);
    assert_near(hi, [3.0, 4.0, 5.0]);
    for (corners, normals) in sphere.soup.positions.iter().zip(&sphere.soup.normals) {
        for k in 0..3 {
            assert_near([0, 1, 2].map(|i| [1.0, 2.0, 3.0][i] + 2.0 * normals[k][i]), corners[k]);
        }
    }
    let cylinder = scene("c 0 0 0 1  0 2 0 1");
    assert_eq!(cylinder.soup.len(), 48);
    let tip = scene("c 0 0 0 1  0 2 0 0");
    assert_eq!(tip.soup.len(), 24);
    assert!(tip.soup.normals[0][0][1] > 0.4);
    let inside = scene("c 0 0 0 -1  0 2 0 -1").soup;
    let [p, n] = [inside.positions[0][0], inside.normals[0][0]];
    assert!(p[0] * n[0] + p[2] * n[2] < -0.99);
}

#[test]
fn transforms_scale_turn_and_move_in_this_order() {
    let scene =
        scene(&format!("xs 2 1 1  0 0 1 90  10 0 0 {{ xs 1 1 1  0 0 0 30  0 0 5 {{ {TRIANGLE} }} }}"));
    assert_near(scene.soup.positions[0][0], [10.0, 0.0, 5.0]);
    assert_near(scene.soup.positions[0][1], [10.0, 2.0, 5.0]);
    assert_near(scene.soup.positions[0][2], [9.0, 0.0, 5.0]);
}

#[test]
fn normals_follow_a_squeeze_and_a_mirror() {
    let patch = "pp 3  0 0 0  1 1 0   1 0 0  1 1 0   0 1 0  0 0 0";
    let squeezed = scene(&format!("xs 2 1 1  1 0 0 0  0 0 0 {{ {patch} }}"));
    assert_near(squeezed.soup.normals[0][0], [0.2_f32.sqrt(), 0.8_f32.sqrt(), 0.0]);
    assert_eq!(squeezed.soup.normals[0][2], [0.0; 3]);
    let mirrored = scene(&format!("xs -1 1 1  1 0 0 0  0 0 0 {{ {patch} }}"));
    assert_near(mirrored.soup.normals[0][0], [-0.5_f32.sqrt(), 0.5_f32.sqrt(), 0.0]);
}

#[test]
fn viewpoint_and_lights() {
    let scene = scene(
        "v from 1 2 3 at 4 5 6 up 0 0 1 angle 30 hither .1 resolution 640 480
         b .1 .2 .3  am 1 1 1
         l 1 2 3
         l 4 5 6  .5 .25 0
         xs 1 1 1 0 0 1 0  10 0 0 { la lamp 1 1 1  1 0 0 }",
    );
    let camera = &scene.cameras[0];
    assert_eq!((camera.eye, camera.target), ([1.0, 2.0, 3.0], [4.0, 5.0, 6.0]));
    assert_eq!((camera.up, camera.fov), ([0.0, 0.0, 1.0], 30.0));
    let lights: Vec<_> = scene.lights.iter().map(|l| (l.name.as_str(), l.position, l.color)).collect();
    assert_eq!(
        lights,
        [
            ("", [1.0, 2.0, 3.0], [1.0; 3]),
            ("", [4.0, 5.0, 6.0], [0.5, 0.25, 0.0]),
            ("lamp", [11.0, 1.0, 1.0], [1.0, 0.0, 0.0]),
        ]
    );
    assert!(scene.soup.is_empty());
}

#[test]
fn includes_share_fills_and_make_objects() {
    let main = format!("i 0 red.aff {TRIANGLE} x arm {{ i 0 sub/Part.aff }} i 0 sub/part.aff {TRIANGLE}");
    let part = format!("i 0 deep.aff {TRIANGLE}");
    let folder = Folder::with(
        &main,
        &[("red.aff", "fm 0 0 0 1 0 0 0 0 0 1 0 1"), ("sub/part.aff", &part), ("sub/deep.aff", TRIANGLE)],
    );
    let scene = folder.open().unwrap().at(None).unwrap();
    let names: Vec<_> = scene.objects.iter().map(|o| o.name.as_str()).collect();
    assert_eq!(names, ["main", "arm/part/deep", "arm/part", "part/deep", "part"]);
    assert_eq!(scene.soup.object, [0, 1, 2, 3, 4, 0]);
    assert!(scene.soup.material.iter().all(|&m| m == 0));
    assert_eq!(scene.materials[0].name, "red line 1");
}

#[test]
fn the_same_include_twice_makes_two_objects() {
    let folder = Folder::with("i 0 a.aff i 0 a.aff", &[("a.aff", TRIANGLE)]);
    let scene = folder.open().unwrap().at(None).unwrap();
    assert_eq!(scene.objects[1].name, "a 2");
}

#[test]
fn finer_details_than_asked_for_are_left_out() {
    let folder = Folder::with("i 1 not_there.aff d 2 i 2 a.aff i 3 not_there.aff", &[("a.aff", TRIANGLE)]);
    assert_eq!(folder.open().unwrap().at(None).unwrap().soup.len(), 1);
}
