//! The header of an NPY file: a Python dictionary of three entries, and nothing more general than that is read.
//!
//! Source: R. Kern, "A Simple File Format for NumPy Arrays", NEP 1, 2007; versions 2 and 3 as in `numpy.lib.format`.

use super::super::mesh::quote;

/// Longest header; NumPy itself warns from 10,000 bytes on.
pub(super) const LONGEST: usize = 1 << 16;

/// What the header says.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(super) struct Header {
    /// Type as NumPy writes it, e.g. `<f4`.
    pub(super) descr: String,
    /// First index fastest.
    pub(super) fortran: bool,
    pub(super) shape: Vec<usize>,
}

/// Parses the dictionary, e.g. `{'descr': '<f4', 'fortran_order': False, 'shape': (2, 3), }`.
pub(super) fn parse(text: &[u8]) -> Result<Header, String> {
    let mut words = Words { rest: text };
    let (mut descr, mut fortran, mut shape) = (None, None, None);
    words.expect(b'{')?;
    while !words.take(b'}') {
        let key = words.string()?;
        words.expect(b':')?;
        match key {
            b"descr" => {
                if words.peek() == Some(b'[') {
                    return Err("structured arrays are not supported".to_owned());
                }
                descr = Some(String::from_utf8_lossy(words.string()?).into_owned());
            }
            b"fortran_order" => {
                fortran = Some(match words.letters() {
                    b"True" => true,
                    b"False" => false,
                    other => return Err(format!("bad header: fortran_order is {}", quote(other))),
                });
            }
            b"shape" => shape = Some(words.tuple()?),
            other => return Err(format!("bad header: unknown key {}", quote(other))),
        }
        if !words.take(b',') {
            words.expect(b'}')?;
            break;
        }
    }
    match (descr, fortran, shape) {
        (Some(descr), Some(fortran), Some(shape)) => Ok(Header { descr, fortran, shape }),
        _ => Err("bad header: 'descr', 'fortran_order' or 'shape' is missing".to_owned()),
    }
}

struct Words<'a> {
    rest: &'a [u8],
}

impl<'a> Words<'a> {
    fn peek(&mut self) -> Option<u8> {
        self.rest = self.rest.trim_ascii_start();
        self.rest.first().copied()
    }

    fn take(&mut self, byte: u8) -> bool {
        let found = self.peek() == Some(byte);
        self.rest = &self.rest[usize::from(found)..];
        found
    }

    fn expect(&mut self, byte: u8) -> Result<(), String> {
        if self.take(byte) {
            return Ok(());
        }
        Err(format!("bad header: {} where '{}' was expected", quote(self.rest), char::from(byte)))
    }

    fn while_is(&mut self, is: impl Fn(u8) -> bool) -> &'a [u8] {
        self.peek();
        let len = self.rest.iter().position(|b| !is(*b)).unwrap_or(self.rest.len());
        let (word, rest) = self.rest.split_at(len);
        self.rest = rest;
        word
    }

    fn letters(&mut self) -> &'a [u8] {
        self.while_is(|b| b.is_ascii_alphabetic())
    }

    fn string(&mut self) -> Result<&'a [u8], String> {
        let mark = if self.take(b'"') { b'"' } else { self.expect(b'\'').map(|()| b'\'')? };
        let word = self.while_is(|b| b != mark);
        self.expect(mark)?;
        Ok(word)
    }

    fn tuple(&mut self) -> Result<Vec<usize>, String> {
        let mut shape = Vec::new();
        self.expect(b'(')?;
        while !self.take(b')') {
            let digits = self.while_is(|b| b.is_ascii_digit());
            let size = std::str::from_utf8(digits).ok().and_then(|d| d.parse().ok());
            shape.push(size.ok_or_else(|| {
                format!(
                    "bad header: {} where an array size was expected",
                    quote([digits, self.rest].concat().as_slice())
                )
            })?);
            // Python 2 wrote long integers with this letter.
            self.take(b'L');
            if !self.take(b',') {
                self.expect(b')')?;
                break;
            }
        }
        // NumPy itself knows 64 at most.
        if shape.len() > 64 { Err("bad header: too many dimensions".to_owned()) } else { Ok(shape) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reads_what_numpy_writes() {
        let header = |shape: &[usize], descr: &str, fortran| {
            Ok(Header { descr: descr.to_owned(), fortran, shape: shape.to_vec() })
        };
        let text = b"{'descr': '<f4', 'fortran_order': False, 'shape': (2, 3, 3), }      \n";
        assert_eq!(parse(text), header(&[2, 3, 3], "<f4", false));
        assert_eq!(parse(b"{'descr':'|u1','fortran_order':True,'shape':(5,)}"), header(&[5], "|u1", true));
        assert_eq!(
            parse(b"{'shape': (7L,), 'fortran_order': False, 'descr': \">f8\"}"),
            header(&[7], ">f8", false)
        );
        assert_eq!(
            parse(b"{'descr': '<f4', 'fortran_order': False, 'shape': ()}"),
            header(&[], "<f4", false)
        );
    }

    #[test]
    fn refuses_the_rest() {
        for text in [
            &b""[..],
            b"{",
            b"{'descr': '<f4'}",
            b"{'descr': [('x', '<f4')], 'fortran_order': False, 'shape': ()}",
            b"{'descr': '<f4', 'fortran_order': 1, 'shape': ()}",
            b"{'descr': '<f4', 'fortran_order': False, 'shape': (-1,)}",
            b"{'descr': '<f4', 'fortran_order': False, 'shape': (99999999999999999999999,)}",
            b"{'descr': '<f4', 'fortran_order': False, 'shape': ((((((",
            b"{'descr': '<f4', 'fortran_order': False, 'shape': (1 2)}",
            b"{'descr': '<f4",
        ] {
            assert!(parse(text).is_err(), "{}", String::from_utf8_lossy(text));
        }
    }
}
