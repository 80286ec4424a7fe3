use antumbra::scene::{AlphaMode, Wrap};
use antumbra_io::write::png;

use crate::{Folder, fault_of, scene, scene_of};

const SQUARE: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";

#[test]
fn polygons_and_all_forms_of_corners() {
    let text = format!(
        "{SQUARE}vt 0.25 0.25\nvn 0 0 1\nf 1 2 3 4\nf 1/1 2/1 3/1\nf 1//1 2//1 3//1\nf 1/1/1 2/1/1 3/1/1\n"
    );
    let s = scene_of("a.obj", text).soup;
    assert_eq!(s.len(), 5);
    assert_eq!(s.positions[1], [[0.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]]);
    assert_eq!(s.uvs[2], [[0.25, 0.75]; 3], "v counts downwards");
    assert_eq!((s.uvs[0], s.normals[0]), ([[0.0; 2]; 3], [[0.0; 3]; 3]));
    assert_eq!(s.normals[4], [[0.0, 0.0, 1.0]; 3]);
    assert!(s.colors.is_empty());
}

#[test]
fn concave_polygons_keep_their_shape() {
    let s = scene_of("a.obj", "v 0 0 0\nv 4 -2 0\nv 1 0 0\nv 4 2 0\nf 1 2 3 4\n").soup;
    let area = |t: &[[f32; 3]; 3]| {
        ((t[1][0] - t[0][0]) * (t[2][1] - t[0][1]) - (t[1][1] - t[0][1]) * (t[2][0] - t[0][0])) / 2.0
    };
    assert!(s.positions.iter().all(|t| area(t) > 0.0));
}

#[test]
fn negative_and_forward_indices() {
    let s = scene_of("a.obj", format!("{SQUARE}f -4 -3 -2\nf 1 2 5\nv 7 7 7\n")).soup;
    assert_eq!(
        s.positions,
        [
            [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0]],
            [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [7.0, 7.0, 7.0]],
        ]
    );
}

#[test]
fn groups_and_objects_become_objects() {
    let text =
        format!("{SQUARE}f 1 2 3\no my house\nf 1 2 3\ng roof\nf 1 2 3\no my house\nf 1 2 4\ng nothing\n");
    let s = scene_of("block.obj", text);
    let names: Vec<_> = s.objects.iter().map(|o| o.name.as_str()).collect();
    assert_eq!(names, ["block", "my house", "roof"]);
    assert_eq!(s.soup.object, [0, 1, 2, 1]);
}

#[test]
fn dirty_triangles_are_kept() {
    let s = scene_of("a.obj", format!("{SQUARE}f 1 1 1\nf 1 2 3\nf 1 2 3\nf 1 2\nl 1 2\np 1\n"));
    assert_eq!(s.soup.len(), 3);
}

#[test]
fn line_ends_comments_and_joined_lines() {
    let s = scene_of("a.obj", "# x\r\nv 0 0 0 # o\r\nv 1 0 \\\r\n 0\r\nv 1 1 0\r\n  f 1 2 \\\r\n  3 # f");
    assert_eq!(s.soup.positions, [[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0]]]);
}

#[test]
fn vertex_colours_are_srgb() {
    let s = scene_of("a.obj", "v 0 0 0 1 0.5 0\nv 1 0 0 0 0 0\nv 0 1 0\nf 1 2 3\n").soup;
    let [first, second, third] = s.colors[0];
    assert!((first[1] - 0.214).abs() < 1e-3 && first[0] == 1.0 && first[2] == 0.0);
    assert_eq!((second, third), ([0.0; 3], [1.0; 3]));
}

#[test]
fn materials() {
    let folder = Folder::new();
    folder.file("a b.mtl", "newmtl glass\nKd 0.1 0.2 0.3\nTr 0.75\nKe 2\nnewmtl opaque\nd 1\nTr 1\n");
    let text = format!("mtllib a b.mtl\n{SQUARE}usemtl opaque\nf 1 2 3\nusemtl glass\nf 1 2 3\n");
    let s = scene(&folder.file("a.obj", text));
    assert_eq!(s.soup.material, [0, 1]);
    assert_eq!((s.materials[0].name.as_str(), s.materials[0].alpha_mode), ("opaque", AlphaMode::Opaque));
    assert_eq!(
        (s.materials[1].base_color, s.materials[1].alpha_mode),
        ([0.1, 0.2, 0.3, 0.25], AlphaMode::Blend)
    );
    assert_eq!(s.materials[1].emissive, [2.0; 3]);
}

#[test]
fn textures_and_alpha_maps_of_other_sizes() {
    let folder = Folder::new();
    png::color(&folder.path("red leaf.png"), 1, 1, &[[255, 0, 0]]).unwrap();
    png::color(&folder.path("holes.png"), 2, 1, &[[0; 3], [255; 3]]).unwrap();
    folder.file(
        "m.mtl",
        "newmtl leaf\nKd 0 0 0\nmap_Kd -s 2 3 1 -clamp on textures\\red leaf.png\nmap_d holes.png\nnewmtl net\nmap_d holes.png\nnewmtl plain\nmap_Kd red leaf.png\n",
    );
    let text = format!(
        "mtllib m.mtl\n{SQUARE}vt 1 1\nusemtl leaf\nf 1/1 2/1 3/1\nusemtl net\nf 1 2 3\nusemtl plain\nf 1/1 2/1 3/1\n"
    );
    let s = scene(&folder.file("a.obj", text));
    let mask = AlphaMode::Mask { cutoff: 0.5 };
    let modes: Vec<_> = s.materials.iter().map(|m| m.alpha_mode).collect();
    assert_eq!(modes, [mask, mask, AlphaMode::Opaque]);
    assert_eq!(s.materials[0].base_color, [1.0; 4], "black under a texture means white");
    assert_eq!(s.textures[0].pixels, [[255, 0, 0, 0], [255, 0, 0, 255]]);
    assert_eq!((s.textures[0].width, s.textures[0].wrap), (2, [Wrap::Clamp; 2]));
    assert_eq!(s.textures[1].pixels, [[255, 255, 255, 0], [255; 4]]);
    assert_eq!((s.soup.uvs[0][0], s.soup.uvs[2][0]), ([2.0, -2.0], [1.0, 0.0]));
}

#[test]
fn what_is_missing_is_named_and_the_shapes_load() {
    let folder = Folder::new();
    folder.file("m.mtl", "newmtl wall\nmap_Kd wood.png\nnewmtl roof\nmap_Kd m.mtl\n");
    let text =
        format!("mtllib m.mtl\n{SQUARE}usemtl wall\nf 1 2 3\nusemtl roof\nf 1 2 3\nusemtl door\nf 1 2 3\n");
    let names =
        |path: &std::path::Path| scene(path).materials.into_iter().map(|m| m.name).collect::<Vec<_>>();
    assert_eq!(
        names(&folder.file("a.obj", text)),
        ["wall (missing texture wood.png)", "roof (unreadable texture m.mtl)", "door (missing material)",]
    );
    let lost = folder.file("b.obj", format!("mtllib lost.mtl\n{SQUARE}usemtl wall\nf 1 2 3\n"));
    assert_eq!(names(&lost), ["wall (missing file lost.mtl)"]);
}

#[test]
fn faults_name_line_and_index() {
    let of = |tail: &str| fault_of("a.obj", format!("{SQUARE}{tail}"));
    assert_eq!(of("f 1 2 9\n"), "line 5: vertex index 9 out of range (there are 4)");
    assert_eq!(of("f 1 2 0\n"), "line 5: vertex index 0 out of range (there are 4)");
    assert_eq!(of("f -5 2 1\n"), "line 5: vertex index -5 out of range (there are 4)");
    assert_eq!(of("f 1/2 2/2 3/2\n"), "line 5: texture coordinate index 2 out of range (there are 0)");
    assert_eq!(of("f 1 2 4294967296\n"), "line 5: vertex index 4294967296 out of range (there are 4)");
    assert_eq!(of("f 1 2 x\n"), "line 5: \"x\" is no corner of a face");
    assert_eq!(of("v 1 nan 2\n"), "line 5: vertex 5: \"nan\" is not a finite number");
    assert_eq!(of("v 1 1e99 2\n"), "line 5: vertex 5: \"1e99\" is not a finite number");
    assert_eq!(of("v 1 2\n"), "line 5: vertex 5: 2 coordinates instead of three");
    assert_eq!(of(""), "no triangles: no face has three corners");
    assert_eq!(fault_of("a.obj", ""), "the file is empty");
}

#[test]
fn a_bad_number_in_a_material_names_its_file() {
    let folder = Folder::new();
    let mtl = folder.file("m.mtl", "newmtl a\nKd 1 x 1\n");
    let obj = folder.file("a.obj", format!("mtllib m.mtl\n{SQUARE}usemtl a\nf 1 2 3\n"));
    let text = antumbra_io::open(&obj).unwrap_err().to_string();
    assert_eq!(text, format!("{}: line 2: \"x\" is not a number", mtl.display()));
}
