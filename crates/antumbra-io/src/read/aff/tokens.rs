//! Words and numbers of one file, with the line to blame.

use std::fmt::Display;

/// What reading gives: the value, or one line that says where and why not.
pub(super) type Outcome<T> = Result<T, String>;

/// Longest name that is taken: of a transform, an animation, a file.
const LONGEST_NAME: usize = 256;

/// Largest magnitude of a number: what fits `f32`, so that nothing becomes infinite by storing it.
const LARGEST: f64 = f32::MAX as f64;

/// A cursor over the words of a text. Words end at white space and braces; `#` and `%` at the start of a word begin a
/// comment that lasts to the end of the line.
pub(super) struct Tokens<'t> {
    text: &'t [u8],
    at: usize,
    /// Line of the word read last.
    pub(super) line: u32,
    /// Line the cursor is on.
    cursor_line: u32,
    file: &'t str,
    /// What is being read, for messages; empty between statements.
    pub(super) statement: &'static str,
}

impl<'t> Tokens<'t> {
    pub(super) fn new(file: &'t str, text: &'t [u8]) -> Tokens<'t> {
        let text = text.strip_prefix(b"\xef\xbb\xbf").unwrap_or(text);
        Tokens { text, at: 0, line: 1, cursor_line: 1, file, statement: "" }
    }

    /// Bytes from the start of the text to the cursor: tells statements of one line apart.
    pub(super) fn offset(&self) -> usize {
        self.at
    }

    /// A message about the word read last.
    pub(super) fn fail(&self, what: impl Display) -> String {
        let colon = if self.statement.is_empty() { "" } else { ": " };
        format!("{} line {}: {}{colon}{what}", self.file, self.line, self.statement)
    }

    fn skip_blank(&mut self) {
        while let Some(&byte) = self.text.get(self.at) {
            match byte {
                b'\n' => self.cursor_line = self.cursor_line.saturating_add(1),
                b'#' | b'%' => {
                    let rest = &self.text[self.at..];
                    // The line's end itself is counted by the next turn.
                    self.at += rest.iter().position(|&b| b == b'\n').unwrap_or(rest.len());
                    continue;
                }
                // 26 is the end mark of old DOS editors.
                b' ' | b'\t' | b'\r' | 11 | 12 | 26 => {}
                _ => return,
            }
            self.at += 1;
        }
    }

    /// The next word, if there is one.
    pub(super) fn next(&mut self) -> Option<&'t [u8]> {
        self.skip_blank();
        self.line = self.cursor_line;
        let rest = &self.text[self.at..];
        let length = match rest.first()? {
            b'{' | b'}' => 1,
            _ => rest
                .iter()
                .position(|b| matches!(b, b' ' | b'\t' | b'\r' | b'\n' | b'{' | b'}' | 11 | 12 | 26))
                .unwrap_or(rest.len()),
        };
        self.at += length;
        Some(&rest[..length])
    }

    /// The next word, left where it is.
    pub(super) fn peek(&self) -> Option<&'t [u8]> {
        Tokens { ..*self }.next()
    }

    /// Takes the next word if it is `word`.
    pub(super) fn take(&mut self, word: &[u8]) -> bool {
        let found = self.peek() == Some(word);
        if found {
            self.next();
        }
        found
    }

    /// Takes the next word, which must be `word`.
    pub(super) fn expect(&mut self, word: &str) -> Outcome<()> {
        match self.next() {
            Some(found) if found == word.as_bytes() => Ok(()),
            Some(found) => Err(self.fail(format_args!("expected '{word}', found {}", quote(found)))),
            None => Err(self.fail(format_args!("expected '{word}', found the end of the file"))),
        }
    }

    fn required(&mut self, what: &str) -> Outcome<&'t [u8]> {
        self.next().ok_or_else(|| self.fail(format_args!("the file ends where {what} should follow")))
    }

    /// A name: any word but a brace.
    pub(super) fn name(&mut self, what: &str) -> Outcome<String> {
        let word = self.required(what)?;
        if matches!(word, b"{" | b"}") {
            return Err(self.fail(format_args!("expected {what}, found {}", quote(word))));
        }
        if word.len() > LONGEST_NAME {
            return Err(self.fail(format_args!("{what} is longer than {LONGEST_NAME} bytes")));
        }
        Ok(String::from_utf8_lossy(word).chars().map(|c| if c.is_control() { '?' } else { c }).collect())
    }

    /// A finite number that fits `f32`.
    pub(super) fn number(&mut self, what: &str) -> Outcome<f64> {
        let word = self.required(what)?;
        match parse_number(word) {
            Some(value) if value.abs() <= LARGEST => Ok(value),
            Some(value) if value.is_nan() => {
                Err(self.fail(format_args!("{what}: {} is not a finite number", quote(word))))
            }
            Some(_) => Err(self.fail(format_args!("{what}: {} is too large a number", quote(word)))),
            None => Err(self.fail(format_args!("{what}: expected a number, found {}", quote(word)))),
        }
    }

    /// `N` numbers.
    pub(super) fn numbers<const N: usize>(&mut self, what: &str) -> Outcome<[f64; N]> {
        let mut values = [0.0; N];
        for value in &mut values {
            *value = self.number(what)?;
        }
        Ok(values)
    }

    /// `N` numbers, single precision.
    pub(super) fn floats<const N: usize>(&mut self, what: &str) -> Outcome<[f32; N]> {
        Ok(self.numbers::<N>(what)?.map(|value| value as f32))
    }

    /// True if a number follows.
    pub(super) fn number_follows(&self) -> bool {
        self.peek().and_then(parse_number).is_some()
    }

    /// A whole number.
    pub(super) fn integer(&mut self, what: &str) -> Outcome<i64> {
        let word = self.required(what)?;
        let parsed = std::str::from_utf8(word).ok().and_then(|text| text.parse().ok());
        parsed
            .ok_or_else(|| self.fail(format_args!("{what}: expected a whole number, found {}", quote(word))))
    }

    /// How many of something follow, `words_each` words a piece. A count that the rest of the file cannot hold is
    /// refused here, so nothing is ever allocated on the word of a number alone.
    pub(super) fn count(&mut self, what: &str, words_each: usize) -> Outcome<usize> {
        let value = self.integer(what)?;
        let Ok(count) = usize::try_from(value) else {
            return Err(self.fail(format_args!("{what}: {value} is negative")));
        };
        // A word takes two bytes: a digit and a blank; the last may end the file.
        let room = (self.text.len() - self.at).div_ceil(2) / words_each.max(1);
        if count > room {
            return Err(self.fail(format_args!("{what}: {count} are announced, the file holds fewer")));
        }
        Ok(count)
    }

    /// An index below `len`.
    pub(super) fn index(&mut self, what: &str, len: usize) -> Outcome<usize> {
        let value = self.integer(what)?;
        match usize::try_from(value) {
            Ok(index) if index < len => Ok(index),
            _ => Err(self.fail(format_args!("{what} index {value} is out of range (there are {len})"))),
        }
    }
}

fn parse_number(word: &[u8]) -> Option<f64> {
    std::str::from_utf8(word).ok()?.parse().ok()
}

/// A word as it may stand in a message: printable, quoted and short.
pub(super) fn quote(word: &[u8]) -> String {
    let text = String::from_utf8_lossy(&word[..word.len().min(40)]);
    format!("'{}'{}", text.escape_debug(), if word.len() > 40 { "..." } else { "" })
}
