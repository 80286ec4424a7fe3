use antumbra_io::read::npy;
use antumbra_io::write;

use crate::{Folder, fault, scene};

const TRIANGLES: [[[f32; 3]; 3]; 2] = [
    [[0.0, 1.0, 2.0], [3.0, 4.0, 5.0], [6.0, 7.0, 8.0]],
    [[-0.0, 1e-40, 3e38], [1.0, 1.0, 1.0], [1.0, 1.0, 1.0]],
];

/// An NPY file, by hand.
pub(crate) fn file(descr: &str, fortran: &str, shape: &str, data: &[u8]) -> Vec<u8> {
    let text = format!("{{'descr': '{descr}', 'fortran_order': {fortran}, 'shape': {shape}, }}\n");
    let mut bytes = b"\x93NUMPY\x02\x00".to_vec();
    bytes.extend((text.len() as u32).to_le_bytes());
    bytes.extend(text.as_bytes());
    bytes.extend(data);
    bytes
}

#[test]
fn round_trips() {
    let folder = Folder::new();
    let path = folder.path("t.npy");
    write::npy::triangles(&path, &TRIANGLES).unwrap();
    let bits =
        |t: &[[[f32; 3]; 3]]| t.as_flattened().as_flattened().iter().map(|v| v.to_bits()).collect::<Vec<_>>();
    assert_eq!(bits(&npy::read_triangles(&path).unwrap()), bits(&TRIANGLES));
    assert_eq!(bits(&scene(&path).soup.positions), bits(&TRIANGLES));
    write::npy::triangles(&path, &[]).unwrap();
    assert!(npy::read_triangles(&path).unwrap().is_empty());
    assert_eq!(fault(&path), "no triangles");

    let samples: Vec<[f32; 3]> = (0..6).map(|i| [i as f32, f32::NAN, 0.5]).collect();
    for shape in [vec![2, 3], vec![6]] {
        write::npy::samples(&path, &samples, &shape).unwrap();
        let (read, leading) = npy::read_samples(&path).unwrap();
        assert_eq!(leading, shape);
        assert!(read.iter().zip(&samples).all(|(a, b)| a.map(f32::to_bits) == b.map(f32::to_bits)));
        write::npy::mask(&path, &[0, 1, 255, 0, 1, 255], &shape).unwrap();
        assert_eq!(npy::read_mask(&path).unwrap(), (vec![0, 1, 255, 0, 1, 255], shape));
    }
}

#[test]
fn byte_orders_doubles_and_fortran_order() {
    let folder = Folder::new();
    // [2, 3]: rows (0 1 2) and (10 11 12).
    let rows = [[0.0f32, 1.0, 2.0], [10.0, 11.0, 12.0]];
    let columns = [0.0f32, 10.0, 1.0, 11.0, 2.0, 12.0];
    let c = rows.as_flattened();
    let wide = |v: &f32| f64::from(*v);
    for (descr, fortran, data) in [
        ("<f4", "False", c.iter().flat_map(|v| v.to_le_bytes()).collect::<Vec<u8>>()),
        (">f4", "False", c.iter().flat_map(|v| v.to_be_bytes()).collect()),
        ("<f8", "False", c.iter().flat_map(|v| wide(v).to_le_bytes()).collect()),
        (">f8", "True", columns.iter().flat_map(|v| wide(v).to_be_bytes()).collect()),
        ("<f4", "True", columns.iter().flat_map(|v| v.to_le_bytes()).collect()),
    ] {
        let path = folder.file("s.npy", file(descr, fortran, "(2, 3)", &data));
        assert_eq!(npy::read_samples(&path).unwrap(), (rows.to_vec(), vec![2]), "{descr} {fortran}");
    }
    let path = folder.file("m.npy", file("|b1", "True", "(2, 3)", &[0, 1, 0, 1, 1, 0]));
    assert_eq!(npy::read_mask(&path).unwrap(), (vec![0, 0, 1, 1, 1, 0], vec![2, 3]));
}

#[test]
fn faults_name_shape_type_and_index() {
    let folder = Folder::new();
    let of = |descr: &str, shape: &str, data: &[u8]| {
        let path = folder.file("x.npy", file(descr, "False", shape, data));
        let cut = |e: antumbra_io::Error| e.to_string().replace(&format!("{}: ", path.display()), "");
        [
            npy::read_triangles(&path).map_or_else(cut, |_| String::new()),
            npy::read_samples(&path).map_or_else(cut, |_| String::new()),
            npy::read_mask(&path).map_or_else(cut, |_| String::new()),
        ]
    };
    let [triangles, samples, mask] = of("<i4", "(1, 3)", &[0; 12]);
    assert_eq!(triangles, "the array is [1, 3] of type \"<i4\", but triangles [T,3,3] are wanted");
    assert_eq!(
        samples,
        "the array is [1, 3] of type \"<i4\", but numbers of type <f4, >f4, <f8 or >f8 are wanted"
    );
    assert_eq!(mask, "the array is [1, 3] of type \"<i4\", but a mask of type |u1 are wanted");
    let [triangles, ..] = of("<f4", "(4294967296, 3, 3)", &[0; 12]);
    assert_eq!(
        triangles,
        "the shape [4294967296, 3, 3] of <f4 takes 154618822656 bytes, but 12 follow the header: truncated?"
    );
    let [triangles, ..] = of("<f4", "(9223372036854775807, 3, 3)", &[0; 12]);
    assert_eq!(triangles, "the shape [9223372036854775807, 3, 3] is impossible");
    let [_, samples, _] = of("<f8", "(1, 3)", [0.0, 1e39, 0.0f64].map(f64::to_le_bytes).as_flattened());
    assert_eq!(samples, "sample 0: [0.0, inf, 0.0] is infinite");
    let nan = [f32::NAN.to_le_bytes(); 9];
    let [triangles, ..] = of("<f4", "(1, 3, 3)", nan.as_flattened());
    assert!(triangles.starts_with("triangle 0, vertex 0"), "{triangles}");
    let [.., mask] = of("|u1", "(3,)", &[0, 255, 7]);
    assert_eq!(mask, "mask entry 2 is 7, not 0, 1 or 255");
    assert_eq!(fault(&folder.file("y.npy", b"\x93NUMPY\x01\x00\xff\xff")), "the file ends early: truncated?");
    assert_eq!(fault(&folder.file("y.npy", b"PK\x03\x04\x00\x00\x00\x00\x00")), "not an NPY file");
}
