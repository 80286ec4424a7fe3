//! Makes small glTF files.

use std::path::PathBuf;
use std::sync::atomic::{AtomicU32, Ordering};

use antumbra::scene::Scene;
use antumbra_io::{Error, SceneFile};

/// A triangle in the plane z = 0.
pub(crate) const TRIANGLE: [f32; 9] = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0];

/// Binary data and the accessors to it.
#[derive(Default)]
pub(crate) struct Doc {
    pub(crate) bytes: Vec<u8>,
    pub(crate) views: Vec<String>,
    pub(crate) accessors: Vec<String>,
}

impl Doc {
    /// A document with the accessor 0: positions of [`TRIANGLE`].
    pub(crate) fn triangle() -> Doc {
        let mut doc = Doc::default();
        doc.floats("VEC3", &TRIANGLE);
        doc
    }

    /// A buffer view of some bytes; its index.
    pub(crate) fn view(&mut self, bytes: &[u8]) -> usize {
        let offset = self.bytes.len();
        self.bytes.extend(bytes);
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        self.views.push(format!(r#"{{"buffer":0,"byteOffset":{offset},"byteLength":{}}}"#, bytes.len()));
        self.views.len() - 1
    }

    /// An accessor; its index. `more` are further members, each with a comma before it.
    pub(crate) fn accessor(
        &mut self,
        bytes: &[u8],
        count: usize,
        kind: &str,
        component: u32,
        more: &str,
    ) -> usize {
        let view = self.view(bytes);
        self.accessors.push(format!(
            r#"{{"bufferView":{view},"count":{count},"type":"{kind}","componentType":{component}{more}}}"#
        ));
        self.accessors.len() - 1
    }

    /// An accessor of floats; its index.
    pub(crate) fn floats(&mut self, kind: &str, values: &[f32]) -> usize {
        let bytes: Vec<u8> = values.iter().flat_map(|v| v.to_le_bytes()).collect();
        self.accessor(&bytes, values.len() / width(kind), kind, 5126, "")
    }

    /// An accessor of 16-bit unsigned integers; its index.
    pub(crate) fn shorts(&mut self, kind: &str, values: &[u16]) -> usize {
        let bytes: Vec<u8> = values.iter().flat_map(|v| v.to_le_bytes()).collect();
        self.accessor(&bytes, values.len() / width(kind), kind, 5123, "")
    }

    fn json(&self, uri: &str, rest: &str) -> String {
        format!(
            r#"{{"asset":{{"version":"2.0"}},"buffers":[{{"byteLength":{}{uri}}}],"bufferViews":[{}],"accessors":[{}],{rest}}}"#,
            self.bytes.len(),
            self.views.join(","),
            self.accessors.join(",")
        )
    }

    /// A GLB. `rest` are the other members of the JSON.
    pub(crate) fn glb(&self, rest: &str) -> Vec<u8> {
        let mut json = self.json("", rest).into_bytes();
        json.resize(json.len().next_multiple_of(4), b' ');
        let mut out = b"glTF\x02\0\0\0".to_vec();
        out.extend((28 + json.len() as u32 + self.bytes.len() as u32).to_le_bytes());
        out.extend((json.len() as u32).to_le_bytes());
        out.extend(b"JSON");
        out.extend(json);
        out.extend((self.bytes.len() as u32).to_le_bytes());
        out.extend(b"BIN\0");
        out.extend(&self.bytes);
        out
    }

    /// A `.gltf` whose buffer is a `data:` URI.
    pub(crate) fn gltf(&self, rest: &str) -> String {
        let uri = format!(r#","uri":"data:application/octet-stream;base64,{}""#, base64(&self.bytes));
        self.json(&uri, rest)
    }

    /// A `.gltf` whose buffer is a file beside it.
    pub(crate) fn gltf_beside(&self, file: &str, rest: &str) -> String {
        self.json(&format!(r#","uri":"{file}""#), rest)
    }

    /// The opened file.
    pub(crate) fn open(&self, rest: &str) -> Result<SceneFile, Error> {
        Folder::new().open("scene.glb", &self.glb(rest))
    }

    /// The scene in its rest pose.
    pub(crate) fn scene(&self, rest: &str) -> Scene {
        let scene = self.open(rest).and_then(|f| f.at(None)).unwrap_or_else(|e| panic!("{e}"));
        scene.validate().unwrap_or_else(|e| panic!("{e} of {rest}"));
        scene
    }

    /// The text of the error that opening or posing gives.
    pub(crate) fn error(&self, rest: &str) -> String {
        match self.open(rest).and_then(|f| f.at(None)) {
            Ok(_) => panic!("no error"),
            Err(e) => e.to_string(),
        }
    }
}

/// One mesh `wall` of one primitive with these members, under one node.
pub(crate) fn one_mesh(primitive: &str) -> String {
    format!(r#""nodes":[{{"mesh":0}}],"meshes":[{{"name":"wall","primitives":[{{{primitive}}}]}}]"#)
}

/// [`one_mesh`] with the positions of accessor 0.
pub(crate) fn plain_mesh() -> String {
    one_mesh(r#""attributes":{"POSITION":0}"#)
}

/// A temporary folder, gone when dropped.
pub(crate) struct Folder(pub(crate) PathBuf);

impl Folder {
    pub(crate) fn new() -> Folder {
        static NEXT: AtomicU32 = AtomicU32::new(0);
        let number = NEXT.fetch_add(1, Ordering::Relaxed);
        let path = std::env::temp_dir().join(format!("antumbra-gltf-{}-{number}", std::process::id()));
        std::fs::create_dir_all(&path).expect("a temporary folder");
        Folder(path)
    }

    pub(crate) fn write(&self, name: &str, bytes: &[u8]) -> PathBuf {
        let path = self.0.join(name);
        std::fs::write(&path, bytes).expect("a temporary file");
        path
    }

    pub(crate) fn open(&self, name: &str, bytes: &[u8]) -> Result<SceneFile, Error> {
        antumbra_io::open(&self.write(name, bytes))
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

fn width(kind: &str) -> usize {
    match kind {
        "SCALAR" => 1,
        "VEC2" => 2,
        "VEC3" => 3,
        "VEC4" => 4,
        _ => 16,
    }
}

pub(crate) fn base64(bytes: &[u8]) -> String {
    const DIGITS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut out = String::new();
    for three in bytes.chunks(3) {
        let bits = three.iter().enumerate().fold(0u32, |sum, (i, &b)| sum | u32::from(b) << (16 - 8 * i));
        for i in 0..4 {
            let digit = char::from(DIGITS[(bits >> (18 - 6 * i) & 63) as usize]);
            out.push(if i <= three.len() { digit } else { '=' });
        }
    }
    out
}

/// A PNG of this many pixels, red, half transparent.
pub(crate) fn png(width: u32, height: u32) -> Vec<u8> {
    let image = image::RgbaImage::from_pixel(width, height, image::Rgba([255, 0, 0, 128]));
    let mut out = std::io::Cursor::new(Vec::new());
    image.write_to(&mut out, image::ImageFormat::Png).expect("a PNG");
    out.into_inner()
}

/// True if all coordinates differ by less than 1e-6.
pub(crate) fn close<const N: usize>(a: [f32; N], b: [f32; N]) -> bool {
    a.iter().zip(&b).all(|(x, y)| (x - y).abs() < 1e-6)
}
