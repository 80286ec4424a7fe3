//! The body: values in order, whatever their type and byte order.

use super::super::mesh::{Text, number, quote};
use super::header::{Element, Format, Property, Scalar};

const ENDED: &str = "the file ends early: truncated?";

/// A walk over the body's values.
#[derive(Clone, Debug)]
pub(super) struct Body<'a> {
    format: Format,
    text: Text<'a>,
}

impl<'a> Body<'a> {
    /// At the body's begin, `at` in the file.
    pub(super) fn new(bytes: &'a [u8], at: usize, format: Format) -> Body<'a> {
        Body { format, text: Text { bytes, at } }
    }

    /// Where the next value is: ", line 12" in ASCII, nothing in binary files.
    pub(super) fn place(&self) -> String {
        match self.format {
            Format::Ascii => format!(", line {}", self.text.line()),
            Format::Little | Format::Big => String::new(),
        }
    }

    /// The next value. All types but large doubles fit, exactly.
    pub(super) fn value(&mut self, scalar: Scalar) -> Result<f64, String> {
        if self.format == Format::Ascii {
            let word = self.text.word().ok_or(ENDED)?;
            // Rounded once, to the declared type.
            return match scalar {
                Scalar::F32 => number::<f32>(word).map(f64::from),
                _ => number::<f64>(word),
            };
        }
        let rest = &self.text.bytes[self.text.at..];
        let mut raw = [0; 8];
        let size = scalar.size();
        let bytes = rest.get(..size).ok_or(ENDED)?;
        raw[..size].copy_from_slice(bytes);
        if self.format == Format::Big {
            raw[..size].reverse();
        }
        self.text.at += size;
        let [a, b, c, d, ..] = raw;
        Ok(match scalar {
            Scalar::I8 => f64::from(a as i8),
            Scalar::U8 => f64::from(a),
            Scalar::I16 => f64::from(i16::from_le_bytes([a, b])),
            Scalar::U16 => f64::from(u16::from_le_bytes([a, b])),
            Scalar::I32 => f64::from(i32::from_le_bytes([a, b, c, d])),
            Scalar::U32 => f64::from(u32::from_le_bytes([a, b, c, d])),
            Scalar::F32 => f64::from(f32::from_le_bytes([a, b, c, d])),
            Scalar::F64 => f64::from_le_bytes(raw),
        })
    }

    /// The length of a list, checked against what is left of the file.
    pub(super) fn list_len(&mut self, count: Scalar, item: Scalar) -> Result<usize, String> {
        let value = self.value(count)?;
        if value < 0.0 || value.fract() != 0.0 || value.is_nan() {
            return Err(format!("a list cannot have {value} entries"));
        }
        let most = self.most(self.item_size(item));
        if value > most as f64 {
            return Err(format!(
                "a list of {value} entries, but the file has room for {most} at most: truncated?"
            ));
        }
        Ok(value as usize)
    }

    /// Passes over one property of one row.
    pub(super) fn skip(&mut self, property: &Property) -> Result<(), String> {
        let values = match property.count {
            Some(count) => self.list_len(count, property.value)?,
            None => 1,
        };
        if self.format == Format::Ascii {
            for _ in 0..values {
                self.text.word().ok_or(ENDED)?;
            }
            return Ok(());
        }
        let end = self.text.at + values * property.value.size();
        if end > self.text.bytes.len() {
            return Err(ENDED.to_owned());
        }
        self.text.at = end;
        Ok(())
    }

    /// Passes over a whole element.
    pub(super) fn skip_element(&mut self, element: &Element) -> Result<(), String> {
        // Rows without columns take no bytes, so that their number is bounded by nothing.
        if element.properties.is_empty() {
            return Ok(());
        }
        for row in 0..self.rows(element)? {
            for property in &element.properties {
                self.skip(property).map_err(|e| format!("{} {row}{}: {e}", element.name, self.place()))?;
            }
        }
        Ok(())
    }

    /// The number of rows, checked against what is left of the file.
    pub(super) fn rows(&self, element: &Element) -> Result<usize, String> {
        let size = |p: &Property| self.item_size(p.count.unwrap_or(p.value));
        let row: usize = element.properties.iter().map(size).sum();
        let most = self.most(row.max(1));
        if element.count > most as u64 {
            let name = quote(element.name.as_bytes());
            return Err(format!(
                "the header declares {} rows of {name}, but the file has room for {most} at most: truncated?",
                element.count
            ));
        }
        Ok(element.count as usize)
    }

    /// Fewest bytes of a value: in ASCII a digit and a blank.
    fn item_size(&self, scalar: Scalar) -> usize {
        if self.format == Format::Ascii { 2 } else { scalar.size() }
    }

    /// How many things of a size still fit. The last word of a text needs no blank behind it.
    fn most(&self, size: usize) -> usize {
        let slack = usize::from(self.format == Format::Ascii);
        (self.text.bytes.len() - self.text.at + slack) / size
    }
}
