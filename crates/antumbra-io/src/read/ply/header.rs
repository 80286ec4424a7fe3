//! The header: which elements follow, and how they are written.

use super::super::mesh::{Text, quote};

/// How the body is written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Format {
    Ascii,
    Little,
    Big,
}

/// A scalar type.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Scalar {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    F32,
    F64,
}

impl Scalar {
    fn named(name: &[u8]) -> Result<Scalar, String> {
        Ok(match name {
            b"char" | b"int8" => Scalar::I8,
            b"uchar" | b"uint8" => Scalar::U8,
            b"short" | b"int16" => Scalar::I16,
            b"ushort" | b"uint16" => Scalar::U16,
            b"int" | b"int32" => Scalar::I32,
            b"uint" | b"uint32" => Scalar::U32,
            b"float" | b"float32" => Scalar::F32,
            b"double" | b"float64" => Scalar::F64,
            _ => return Err(format!("unknown type {}", quote(name))),
        })
    }

    /// Bytes in a binary body.
    pub(super) fn size(self) -> usize {
        match self {
            Scalar::I8 | Scalar::U8 => 1,
            Scalar::I16 | Scalar::U16 => 2,
            Scalar::I32 | Scalar::U32 | Scalar::F32 => 4,
            Scalar::F64 => 8,
        }
    }

    /// The value that stands for 1 in a colour; 0 for floating point.
    pub(super) fn full(self) -> f64 {
        match self {
            Scalar::I8 => 127.0,
            Scalar::U8 => 255.0,
            Scalar::I16 => 32_767.0,
            Scalar::U16 => 65_535.0,
            Scalar::I32 => f64::from(i32::MAX),
            Scalar::U32 => f64::from(u32::MAX),
            Scalar::F32 | Scalar::F64 => 0.0,
        }
    }
}

/// One column of an element.
#[derive(Clone, Debug)]
pub(super) struct Property {
    pub(super) name: String,
    /// Type of the value, or of a list's items.
    pub(super) value: Scalar,
    /// Type of a list's length; `None` for a single value.
    pub(super) count: Option<Scalar>,
}

/// A table of the body.
#[derive(Clone, Debug)]
pub(super) struct Element {
    pub(super) name: String,
    pub(super) count: u64,
    pub(super) properties: Vec<Property>,
}

impl Element {
    /// Position of the first property that has one of the names.
    pub(super) fn find(&self, names: &[&str]) -> Option<usize> {
        names.iter().find_map(|name| self.properties.iter().position(|p| p.name == *name))
    }
}

/// What the header says.
#[derive(Clone, Debug)]
pub(super) struct Header {
    pub(super) format: Format,
    pub(super) elements: Vec<Element>,
    /// Where the body begins.
    pub(super) body: usize,
}

/// More than any program writes; bounds the work for each row of a hostile file.
const MOST: usize = 1000;

/// Reads the header; errors name the line.
pub(super) fn read(bytes: &[u8]) -> Result<Header, String> {
    let mut lines = Lines { bytes, at: 0, number: 0 };
    if lines.next() != Some(&b"ply"[..]) {
        return Err("not a PLY file: it does not begin with 'ply'".to_owned());
    }
    let mut format = None;
    let mut elements: Vec<Element> = Vec::new();
    loop {
        let Some(line) = lines.next() else {
            return Err("the header has no 'end_header': truncated?".to_owned());
        };
        if line == b"end_header" {
            break;
        }
        read_line(line, &mut format, &mut elements).map_err(|e| format!("line {}: {e}", lines.number))?;
    }
    let format = format.ok_or("the header has no 'format' line")?;
    Ok(Header { format, elements, body: lines.at })
}

fn read_line(line: &[u8], format: &mut Option<Format>, elements: &mut Vec<Element>) -> Result<(), String> {
    let mut words = Text { bytes: line, at: 0 };
    let mut word = || words.word().unwrap_or_default();
    let text = |word: &[u8]| String::from_utf8_lossy(word).into_owned();
    match word() {
        b"comment" | b"obj_info" | b"" => {}
        b"format" => {
            *format = Some(match word() {
                b"ascii" => Format::Ascii,
                b"binary_little_endian" => Format::Little,
                b"binary_big_endian" => Format::Big,
                other => return Err(format!("unknown format {}", quote(other))),
            });
        }
        b"element" => {
            let (name, count) = (word(), word());
            let count = std::str::from_utf8(count).ok().and_then(|c| c.parse().ok());
            let count = count.ok_or_else(|| format!("element {} has no proper count", quote(name)))?;
            elements.push(Element { name: text(name), count, properties: Vec::new() });
        }
        b"property" => {
            let element = elements.last_mut().ok_or("a property before any element")?;
            let first = word();
            let (count, value) = if first == b"list" {
                let count = Scalar::named(word())?;
                if count.full() == 0.0 {
                    return Err("the length of a list must be an integer".to_owned());
                }
                (Some(count), Scalar::named(word())?)
            } else {
                (None, Scalar::named(first)?)
            };
            let name = text(word());
            element.properties.push(Property { name, value, count });
            if element.properties.len() > MOST {
                return Err(format!("more than {MOST} properties"));
            }
        }
        other => return Err(format!("{} is no PLY keyword", quote(other))),
    }
    if elements.len() > MOST { Err(format!("more than {MOST} elements")) } else { Ok(()) }
}

/// Lines that end in `\n` or `\r\n`.
struct Lines<'a> {
    bytes: &'a [u8],
    at: usize,
    number: usize,
}

impl<'a> Lines<'a> {
    fn next(&mut self) -> Option<&'a [u8]> {
        let rest = &self.bytes[self.at..];
        let len = rest.iter().position(|b| *b == b'\n')?;
        self.at += len + 1;
        self.number += 1;
        Some(rest[..len].trim_ascii_end())
    }
}
