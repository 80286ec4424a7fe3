//! The file itself: GLB chunks or plain JSON, and whether we can read what it asks for.

use std::fs::File;
use std::io::Read;
use std::ops::Range;
use std::path::Path;

use gltf::json::Root;

use super::source::MEMORY_LIMIT;
use crate::Error;

/// Extensions that a file may require: those that are read, and those that change nothing we need.
/// Every `KHR_materials_…` is fine too: at worst a surface looks plainer than it was meant.
const UNDERSTOOD: [&str; 6] = [
    "EXT_mesh_gpu_instancing",
    "EXT_texture_webp",
    "KHR_lights_punctual",
    "KHR_mesh_quantization",
    "KHR_texture_basisu",
    "KHR_texture_transform",
];

/// A file in memory, with its JSON parsed.
pub(super) struct Container {
    /// The whole file.
    bytes: Vec<u8>,
    /// Memory that the file and its parsed JSON take, at most.
    pub(super) size: u64,
    /// Where the binary chunk lies in it, if there is one.
    binary: Option<Range<usize>>,
    /// The parsed JSON. Its indices and numbers are still unchecked.
    pub(super) root: Root,
}

impl Container {
    /// Reads `path`, splits it, parses the JSON and looks at the required extensions.
    pub(super) fn read(path: &Path) -> Result<Container, Error> {
        let bytes = read_file(path, MEMORY_LIMIT)?;
        let (json, binary) = if bytes.starts_with(b"glTF") {
            chunks(&bytes).map_err(|what| Error::content(path, what))?
        } else {
            // Some exporters write a byte order mark, which JSON does not allow.
            let start = if bytes.starts_with(b"\xEF\xBB\xBF") { 3 } else { 0 };
            (start..bytes.len(), None)
        };
        let text = &bytes[json];
        let parsed = parsed_size(text);
        if parsed > MEMORY_LIMIT / 2 {
            let what = format!("the JSON part ({} bytes) has too many items to be parsed safely", text.len());
            return Err(Error::content(path, what));
        }
        let size = bytes.len() as u64 + parsed;
        let root = Root::from_slice(text).map_err(|e| Error::content(path, json_error(text, &e)))?;
        check_version(&root.asset.version, root.asset.min_version.as_deref())
            .and_then(|()| check_extensions(&root.extensions_required))
            .map_err(|what| Error::content(path, what))?;
        Ok(Container { bytes, size, binary, root })
    }

    /// The binary chunk of a GLB.
    pub(super) fn binary(&self) -> Option<&[u8]> {
        self.bytes.get(self.binary.clone()?)
    }
}

/// Reads a regular file of at most `limit` bytes. Pipes and devices could hang or never end.
pub(super) fn read_file(path: &Path, limit: u64) -> Result<Vec<u8>, Error> {
    let metadata = std::fs::metadata(path).map_err(|e| Error::io(path, e))?;
    if !metadata.is_file() {
        return Err(Error::content(path, "not a regular file"));
    }
    let mut bytes = Vec::new();
    if metadata.len() <= limit {
        let file = File::open(path).map_err(|e| Error::io(path, e))?;
        bytes.reserve_exact(metadata.len() as usize + 1);
        file.take(limit + 1).read_to_end(&mut bytes).map_err(|e| Error::io(path, e))?;
    }
    if metadata.len().max(bytes.len() as u64) > limit {
        let what = format!("{} bytes are more than the {limit} that may be read", metadata.len());
        return Err(Error::content(path, what));
    }
    Ok(bytes)
}

/// Where the JSON and the binary chunk lie in a GLB (glTF 2.0, section 4.4).
fn chunks(bytes: &[u8]) -> Result<(Range<usize>, Option<Range<usize>>), String> {
    let word = |at: usize| {
        let four = bytes.get(at..at.checked_add(4)?)?;
        Some(u32::from_le_bytes(four.try_into().ok()?))
    };
    match word(4) {
        Some(2) => {}
        Some(version) => return Err(format!("GLB version {version}; only version 2 can be read")),
        None => return Err("the file ends inside the GLB header".into()),
    }
    let declared = word(8).ok_or("the file ends inside the GLB header")? as usize;
    if declared > bytes.len() {
        return Err(format!("the GLB header says {declared} bytes, the file has {}: cut off?", bytes.len()));
    }
    let (mut json, mut binary) = (None, None);
    let mut at = 12;
    // A tail too short for a chunk header is padding.
    while at + 8 <= declared {
        let (Some(length), Some(kind)) = (word(at), word(at + 4)) else { break };
        let start = at + 8;
        let end = start
            .checked_add(length as usize)
            .filter(|&end| end <= declared)
            .ok_or_else(|| format!("the GLB chunk at byte {at} ({length} bytes) ends past the file"))?;
        match &kind.to_le_bytes() {
            b"JSON" if json.is_none() => json = Some(start..end),
            b"BIN\0" if binary.is_none() => binary = Some(start..end),
            _ => {}
        }
        at = end;
    }
    Ok((json.ok_or("the GLB has no JSON chunk")?, binary))
}

/// An upper estimate of what the parsed JSON takes: objects become structs of up to about a kibibyte, list items
/// are at most JSON values in a list that doubled.
fn parsed_size(text: &[u8]) -> u64 {
    text.iter().fold(text.len() as u64, |sum, byte| {
        sum + match byte {
            b'{' => 1024,
            b',' | b'[' => 96,
            _ => 0,
        }
    })
}

fn json_error(text: &[u8], error: &gltf::json::Error) -> String {
    let pointer = b"KHR_animation_pointer";
    if text.windows(pointer.len()).any(|w| w == pointer) {
        return format!("{error}; KHR_animation_pointer cannot be read: export with node animations only");
    }
    format!("the JSON part cannot be read: {error}")
}

fn check_version(version: &str, min_version: Option<&str>) -> Result<(), String> {
    if version.split('.').next() != Some("2") {
        return Err(format!(
            "glTF version {version:.20}; only 2.x can be read: convert the file to glTF 2.0"
        ));
    }
    match min_version {
        Some(min) if min != "2.0" => Err(format!("needs glTF version {min:.20}; 2.0 can be read")),
        _ => Ok(()),
    }
}

fn check_extensions(required: &[String]) -> Result<(), String> {
    for name in required {
        if UNDERSTOOD.contains(&name.as_str()) || name.starts_with("KHR_materials_") {
            continue;
        }
        let remedy = match name.as_str() {
            "KHR_draco_mesh_compression" | "EXT_meshopt_compression" | "KHR_meshopt_compression" => {
                "export the file again without mesh compression"
            }
            _ => "export the file again without it",
        };
        return Err(format!("the file requires the extension {name:.60}, which cannot be read: {remedy}"));
    }
    Ok(())
}
