use crate::{fault_of, scene_of};

pub(crate) const ASCII: &str = "solid left wing\n facet normal 0 0 nan\n  outer loop\n   vertex 0 0 0\n   vertex 1 0 0\n   vertex 0 1e0 0\n  endloop\n endfacet\nendsolid left wing\n\
    SOLID right\nFACET NORMAL 0 0 1\nOUTER LOOP\nVERTEX 0 0 5\nVERTEX 1 0 5\nVERTEX 0 1 5\nENDLOOP\nENDFACET\nENDSOLID\n";

/// Two facets, under a head that could be that of an ASCII file.
pub(crate) fn binary() -> Vec<u8> {
    let mut bytes = b"solid but binary".to_vec();
    bytes.resize(80, b' ');
    bytes.extend(2u32.to_le_bytes());
    for z in [0.0f32, 5.0] {
        for v in [[9.0, 9.0, 9.0], [0.0, 0.0, z], [1.0, 0.0, z], [0.0, 1.0, z]].as_flattened() {
            bytes.extend(v.to_le_bytes());
        }
        bytes.extend([1, 2]);
    }
    bytes
}

#[test]
fn ascii_solids_become_objects() {
    let s = scene_of("a.stl", ASCII);
    assert_eq!(s.soup.positions[1], [[0.0, 0.0, 5.0], [1.0, 0.0, 5.0], [0.0, 1.0, 5.0]]);
    assert_eq!(s.soup.object, [0, 1]);
    let names: Vec<_> = s.objects.iter().map(|o| o.name.as_str()).collect();
    assert_eq!(names, ["left wing", "right"]);
}

#[test]
fn binary_that_begins_with_solid() {
    let s = scene_of("part.stl", binary());
    assert_eq!(s.soup.positions, scene_of("a.stl", ASCII).soup.positions);
    assert_eq!(s.objects[0].name, "part");
}

#[test]
fn faults_name_the_triangle() {
    let of = |from: &str, to: &str| fault_of("a.stl", ASCII.replace(from, to));
    assert_eq!(
        of("vertex 1 0 0", "vertex 1 inf 0"),
        "line 7: triangle 0, vertex 1: [1.0, inf, 0.0] is not finite"
    );
    assert_eq!(of("vertex 1 0 0", "vertex 1 a 0"), "line 5: triangle 0: \"a\" is not a number");
    assert_eq!(of("   vertex 1 0 0\n", ""), "line 6: triangle 0 has 2 vertices instead of three");
    assert_eq!(of("ENDSOLID\n", ""), "no 'endsolid' after triangle 2: truncated?");
    assert_eq!(of(" facet", " face"), "line 2: \"face\" is no STL keyword");
    assert_eq!(fault_of("a.stl", "solid x\nendsolid x\n"), "no triangles");

    let mut bytes = binary();
    bytes[84 + 50 + 12 + 24..][..4].copy_from_slice(&f32::NAN.to_le_bytes());
    assert_eq!(fault_of("a.stl", &bytes), "triangle 1, vertex 2: [NaN, 1.0, 5.0] is not finite");
    bytes.pop();
    assert_eq!(
        fault_of("a.stl", &bytes),
        "binary STL of 2 facets should have 184 bytes, but has 183: truncated?"
    );
    assert!(fault_of("a.stl", "hello").starts_with("neither a binary STL"));
}
