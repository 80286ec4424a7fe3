use crate::{fault_of, scene_of};

/// A square with normals, colours and texture coordinates, one quad, one strip; ASCII.
pub(crate) const ASCII: &str = "ply\nformat ascii 1.0\ncomment by hand\nelement vertex 4\nproperty float x\nproperty double y\nproperty int z\n\
    property float nx\nproperty float ny\nproperty float nz\nproperty uchar red\nproperty uchar green\nproperty uchar blue\n\
    property float s\nproperty float t\nelement edge 1\nproperty int a\nproperty list uchar short b\n\
    element face 2\nproperty uchar flags\nproperty list uchar int vertex_indices\nend_header\n\
    0 0 0  0 0 1  255 0 0  0 0\n1 0 0  0 0 1  255 0 0  1 0\n1 1 0  0 0 1  255 0 0  1 1\n0 1 0  0 0 1  255 0 0  0 1\n\
    7 2 8 9\n0 4 0 1 2 3\n1 3 0 2 1\n";

/// The same shape as bytes of either order.
pub(crate) fn binary(big: bool) -> Vec<u8> {
    let order = if big { "big" } else { "little" };
    let mut bytes = format!(
        "ply\nformat binary_{order}_endian 1.0\nelement vertex 4\nproperty float x\nproperty double y\nproperty short z\n\
         property uchar red\nproperty uchar green\nproperty uchar blue\nelement face 2\nproperty list ushort uint vertex_index\nend_header\n"
    )
    .into_bytes();
    let mut put = |raw: &[u8]| {
        let mut raw = raw.to_vec();
        if big {
            raw.reverse();
        }
        bytes.extend(raw);
    };
    for (x, y) in [(0.0f32, 0.0f64), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)] {
        put(&x.to_le_bytes());
        put(&y.to_le_bytes());
        put(&(-3i16).to_le_bytes());
        [255u8, 128, 0].iter().for_each(|c| put(&[*c]));
    }
    for face in [&[0u32, 1, 2, 3][..], &[0, 2, 1]] {
        put(&(face.len() as u16).to_le_bytes());
        face.iter().for_each(|i| put(&i.to_le_bytes()));
    }
    bytes
}

#[test]
fn ascii_with_all_that_is_understood() {
    let s = scene_of("a.ply", ASCII).soup;
    assert_eq!(
        s.positions,
        [
            [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0]],
            [[0.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]],
            [[0.0, 0.0, 0.0], [1.0, 1.0, 0.0], [1.0, 0.0, 0.0]],
        ]
    );
    assert_eq!(s.normals[2], [[0.0, 0.0, 1.0]; 3]);
    assert_eq!(s.colors[0], [[1.0, 0.0, 0.0]; 3]);
    assert_eq!(s.uvs[0], [[0.0, 1.0], [1.0, 1.0], [1.0, 0.0]], "v counts downwards");
    assert_eq!(scene_of("a.ply", ASCII.replace('\n', "\r\n")).soup.positions, s.positions);
}

#[test]
fn binary_of_both_orders() {
    let little = scene_of("a.ply", binary(false)).soup;
    assert_eq!(little.positions[1], [[0.0, 0.0, -3.0], [1.0, 1.0, -3.0], [0.0, 1.0, -3.0]]);
    assert!((little.colors[0][0][1] - 0.2158).abs() < 1e-3, "128 is sRGB");
    assert!(little.normals.is_empty() && little.uvs.is_empty());
    let big = scene_of("a.ply", binary(true)).soup;
    assert_eq!((big.positions, big.colors), (little.positions, little.colors));
}

#[test]
fn faces_before_vertices_and_float_colours() {
    let text = "ply\nformat ascii 1.0\nelement face 1\nproperty list uchar int vertex_index\nelement vertex 3\n\
        property float x\nproperty float y\nproperty float z\nproperty float red\nproperty float green\nproperty float blue\n\
        end_header\n3 0 1 2\n0 0 0 .5 .5 .5\n1 0 0 .5 .5 .5\n0 1 0 .5 .5 .5";
    let s = scene_of("a.ply", text).soup;
    assert_eq!(s.positions, [[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]]);
    assert_eq!(s.colors[0], [[0.5; 3]; 3], "floats are linear");
}

#[test]
fn triangle_strips() {
    let text = "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n\
        element tristrips 1\nproperty list int int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n1 1 0\n8 0 1 2 3 -1 1 2 3\n";
    assert_eq!(scene_of("a.ply", text).soup.len(), 3);
}

#[test]
fn a_point_cloud_is_named_as_such() {
    let text = ASCII.replace("element face 2", "element face 0");
    assert_eq!(fault_of("a.ply", text), "a point cloud: 4 vertices and no faces; make a surface of it first");
}

#[test]
fn faults_name_the_place() {
    let of = |from: &str, to: &str| fault_of("a.ply", ASCII.replace(from, to));
    assert_eq!(of("4 0 1 2 3", "4 0 1 2 4"), "face 0, line 28: vertex index 4 out of range (there are 4)");
    assert_eq!(of("4 0 1 2 3", "4 0 -1 2 3"), "face 0, line 28: vertex index -1 out of range (there are 4)");
    assert_eq!(of("\n1 1 0", "\n1 nan 0"), "vertex 2, line 25: [1.0, NaN, 0.0] is not finite");
    assert_eq!(of("\n1 1 0", "\n1 1e60 0"), "vertex 2, line 25: [1.0, inf, 0.0] is not finite");
    assert_eq!(of("\n1 1 0", "\n1 one 0"), "vertex 2, line 25: \"one\" is not a number");
    assert_eq!(of("1 3 0 2 1\n", ""), "face 1, line 28: the file ends early: truncated?");
    assert!(of("vertex 4", "vertex 4294967296").contains("4294967296 rows of \"vertex\""));
    assert!(of("7 2 8 9", "7 4294967296 8 9").contains("a list of 4294967296 entries"));
    assert_eq!(of("property double y\n", ""), "the vertices have no property 'y'");
    assert_eq!(of("int z", "real z"), "line 7: unknown type \"real\"");
    assert_eq!(of("ply\n", "stl\n"), "not a PLY file: it does not begin with 'ply'");
    let mut cut = binary(false);
    cut.truncate(cut.len() - 1);
    assert_eq!(
        fault_of("a.ply", cut),
        "face 1: a list of 3 entries, but the file has room for 2 at most: truncated?"
    );
}

#[test]
fn rows_without_columns_cost_nothing() {
    let text = ASCII.replace(
        "element edge 1\nproperty int a\nproperty list uchar short b\n",
        "element x 18446744073709551615\n",
    );
    assert_eq!(scene_of("a.ply", text.replace("7 2 8 9\n", "")).soup.len(), 3);
}
