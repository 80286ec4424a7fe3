//! Reads the statements of a file and of all that it includes into a [`Model`].

use std::collections::BTreeMap;
use std::path::Path;

use antumbra::scene::Object;

use crate::Error;

use super::affine::{Affine, Quaternion};
use super::files::{Files, SourceFile};
use super::fills::Fills;
use super::keyframes;
use super::model::{
    Animation, Light, MAX_BRACES, MAX_INCLUDE_DEPTH, MAX_INCLUDES, MAX_KEYS, MAX_PIECES, MAX_TEXT, Model,
    Motion, Node, Run, Source, View,
};
use super::tessellate::EarBudget;
use super::tokens::{Outcome, Tokens, quote};

/// Longest name of an object; of a longer way to it, the end is kept.
const LONGEST_PATH: usize = 200;

/// Reads `path` and what it includes.
pub(super) fn read(path: &Path) -> Result<Model, Error> {
    let mut parser = Parser::new(path).map_err(|source| Error::io(path, source))?;
    parser.file(0).map_err(|what| Error::content(path, what))?;
    Ok(parser.finish())
}

/// A file or a pair of braces that is open.
struct Scope {
    node: u32,
    /// Set for includes and named transforms: these are objects.
    label: Option<String>,
    /// Made when the first triangle comes.
    object: Option<u32>,
    /// Line of the opening brace; 0 for a file, which no brace closes.
    line: u32,
}

/// The state of reading. `model` grows; the rest is what the next statement depends on.
pub(super) struct Parser {
    pub(super) model: Model,
    pub(super) files: Files,
    pub(super) fills: Fills,
    pub(super) ears: EarBudget,
    /// File whose statements are being read.
    pub(super) file: usize,
    scopes: Vec<Scope>,
    /// Files being read, outermost first.
    open_files: Vec<usize>,
    animation_by_name: BTreeMap<String, u32>,
    uses_of_object_name: BTreeMap<String, u32>,
    detail: i64,
    includes: usize,
    text_read: usize,
    keys_left: usize,
}

impl Parser {
    fn new(path: &Path) -> std::io::Result<Parser> {
        let files = Files::new(path)?;
        let name = path.file_stem().map_or_else(String::new, |s| s.to_string_lossy().into_owned());
        let world = Node { parent: 0, motion: Motion::Fixed(Affine::IDENTITY) };
        let model = Model { path: path.to_owned(), name, nodes: vec![world], ..Model::default() };
        Ok(Parser {
            model,
            files,
            fills: Fills::default(),
            ears: EarBudget::default(),
            file: 0,
            scopes: Vec::new(),
            open_files: Vec::new(),
            animation_by_name: BTreeMap::new(),
            uses_of_object_name: BTreeMap::new(),
            detail: 0,
            includes: 0,
            text_read: 0,
            keys_left: MAX_KEYS,
        })
    }

    fn finish(mut self) -> Model {
        self.model.camera_animation = self.animation_by_name.get("camera").copied();
        self.model.faces.positions.shrink_to_fit();
        self.model.faces.normals.shrink_to_fit();
        self.model.faces.uvs.shrink_to_fit();
        self.model.faces.material.shrink_to_fit();
        self.model.morph_keys.shrink_to_fit();
        self.model
    }

    /// Reads all statements of a file, those of its includes where they are included.
    fn file(&mut self, index: usize) -> Outcome<()> {
        let SourceFile { name, text, .. } = self.files.get(index);
        let mut tokens = Tokens::new(&name, &text);
        self.text_read += text.len();
        if self.text_read > MAX_TEXT {
            return Err(
                tokens.fail(format_args!("with all includes the text is longer than {MAX_TEXT} bytes"))
            );
        }
        let outer_file = std::mem::replace(&mut self.file, index);
        let scope =
            Scope { node: self.node(), label: Some(self.files.get(index).stem()), object: None, line: 0 };
        self.scopes.push(scope);
        self.open_files.push(index);
        while let Some(word) = tokens.next() {
            self.statement(&mut tokens, word)?;
            tokens.statement = "";
        }
        let line = self.scope().line;
        if line != 0 {
            return Err(tokens.fail(format_args!("the file ends, but the '{{' of line {line} is still open")));
        }
        self.open_files.pop();
        self.scopes.pop();
        self.file = outer_file;
        Ok(())
    }

    fn statement(&mut self, tokens: &mut Tokens<'_>, word: &[u8]) -> Outcome<()> {
        const KNOWN: [&str; 22] = [
            "v", "l", "la", "b", "f", "fm", "c", "s", "p", "pp", "i", "d", "tt", "ttp", "tpa", "x", "xs",
            "}", "a", "am", "k", "m",
        ];
        let Some(statement) = KNOWN.into_iter().find(|known| known.as_bytes() == word) else {
            return Err(tokens.fail(format_args!("unknown statement {}", quote(word))));
        };
        tokens.statement = statement;
        match statement {
            "v" => self.viewpoint(tokens),
            "l" => self.light(tokens, None),
            "la" => {
                let name = tokens.name("the light's name")?;
                self.light(tokens, Some(name))
            }
            "b" | "am" => tokens.numbers::<3>("colour").map(|_| ()),
            "f" => self.fills.plain(tokens, self.file, &self.files),
            "fm" => self.fills.extended(tokens, self.file, &self.files),
            "c" => self.cone(tokens),
            "s" => self.sphere(tokens),
            "p" => self.polygon(tokens, false),
            "pp" => self.polygon(tokens, true),
            "tt" => self.textured_triangle(tokens, false),
            "ttp" => self.textured_triangle(tokens, true),
            "tpa" => self.animated_triangle(tokens),
            "m" => self.mesh(tokens),
            "i" => self.include(tokens),
            "d" => {
                self.detail = tokens.integer("detail level")?;
                Ok(())
            }
            "x" => self.animated_transform(tokens),
            "xs" => self.static_transform(tokens),
            "a" => self.animation_times(tokens),
            "k" => self.key_frames(tokens),
            // A closing brace.
            _ => self.close(tokens),
        }
    }

    fn scope(&self) -> &Scope {
        // Only called while a file is open: its scope is there.
        &self.scopes[self.scopes.len() - 1]
    }

    /// The transform that statements stand in.
    fn node(&self) -> u32 {
        self.scopes.last().map_or(0, |scope| scope.node)
    }

    fn open(&mut self, tokens: &mut Tokens<'_>, motion: Motion, label: Option<String>) -> Outcome<()> {
        tokens.expect("{")?;
        if self.scopes.len() >= MAX_BRACES {
            return Err(tokens.fail(format_args!("more than {MAX_BRACES} nested braces and files")));
        }
        limit(tokens, "transforms", self.model.nodes.len())?;
        let node = self.model.nodes.len() as u32;
        self.model.nodes.push(Node { parent: self.node(), motion });
        self.scopes.push(Scope { node, label, object: None, line: tokens.line });
        Ok(())
    }

    fn close(&mut self, tokens: &Tokens<'_>) -> Outcome<()> {
        if self.scope().line == 0 {
            return Err(tokens.fail("no '{' of this file is open"));
        }
        self.scopes.pop();
        Ok(())
    }

    fn static_transform(&mut self, tokens: &mut Tokens<'_>) -> Outcome<()> {
        let scale = tokens.numbers("scale")?;
        let axis = tokens.numbers("rotation axis")?;
        let degrees = tokens.number("rotation angle")?;
        let translation = tokens.numbers("translation")?;
        let map = Affine::from_parts(translation, Quaternion::about(axis, degrees), scale);
        self.open(tokens, Motion::Fixed(map), None)
    }

    fn animated_transform(&mut self, tokens: &mut Tokens<'_>) -> Outcome<()> {
        let name = tokens.name("the transform's name")?;
        let animation = self.animation_named(tokens, &name)?;
        self.open(tokens, Motion::Animated(animation), Some(name))
    }

    /// Keys are found by name, before or after they are used.
    fn animation_named(&mut self, tokens: &Tokens<'_>, name: &str) -> Outcome<u32> {
        if let Some(&index) = self.animation_by_name.get(name) {
            return Ok(index);
        }
        limit(tokens, "animations", self.model.animations.len())?;
        let index = self.model.animations.len() as u32;
        self.model.animations.push(Animation::default());
        self.animation_by_name.insert(name.to_owned(), index);
        Ok(index)
    }

    /// Of two with the same name the later counts: parts of cars and robots are included with their keys.
    fn key_frames(&mut self, tokens: &mut Tokens<'_>) -> Outcome<()> {
        let name = tokens.name("the animation's name")?;
        let index = self.animation_named(tokens, &name)?;
        self.model.animations[index as usize] = keyframes::animation(tokens, &mut self.keys_left)?;
        Ok(())
    }

    fn animation_times(&mut self, tokens: &mut Tokens<'_>) -> Outcome<()> {
        let [start, end] = tokens.numbers("start and end")?;
        if start > end {
            return Err(tokens.fail(format_args!("the start {start} is after the end {end}")));
        }
        // How many frames a film would have; here any time can be asked for.
        tokens.integer("number of frames")?;
        self.model.span = Some([start, end]);
        Ok(())
    }

    fn viewpoint(&mut self, tokens: &mut Tokens<'_>) -> Outcome<()> {
        let (mut from, mut at, mut up, mut angle) = (None, None, [0.0, 1.0, 0.0], 45.0);
        loop {
            if tokens.take(b"from") {
                from = Some(tokens.numbers("from")?);
            } else if tokens.take(b"at") {
                at = Some(tokens.numbers("at")?);
            } else if tokens.take(b"up") {
                up = tokens.numbers("up")?;
            } else if tokens.take(b"angle") {
                angle = tokens.number("angle")?;
                if !(0.001..180.0).contains(&angle) {
                    return Err(tokens.fail(format_args!("angle {angle} is not between 0 and 180")));
                }
            } else if tokens.take(b"hither") {
                tokens.number("hither")?;
            } else if tokens.take(b"resolution") {
                tokens.numbers::<2>("resolution")?;
            } else {
                break;
            }
        }
        match (from, at) {
            (Some(from), Some(at)) => self.model.view = Some(View { from, at, up, angle: angle as f32 }),
            _ => return Err(tokens.fail("'from' and 'at' are needed")),
        }
        Ok(())
    }

    fn light(&mut self, tokens: &mut Tokens<'_>, name: Option<String>) -> Outcome<()> {
        limit(tokens, "lights", self.model.lights.len())?;
        let animation = name.as_deref().map(|name| self.animation_named(tokens, name)).transpose()?;
        let position = tokens.floats("position")?;
        let color = if tokens.number_follows() { tokens.floats("colour")? } else { [1.0; 3] };
        let name = name.unwrap_or_default();
        self.model.lights.push(Light { name, position, color, node: self.node(), animation });
        Ok(())
    }

    fn include(&mut self, tokens: &mut Tokens<'_>) -> Outcome<()> {
        let detail = tokens.integer("detail level")?;
        let name = tokens.name("a file name")?;
        if detail > self.detail {
            return Ok(());
        }
        self.includes += 1;
        if self.includes > MAX_INCLUDES {
            return Err(tokens.fail(format_args!("more than {MAX_INCLUDES} includes")));
        }
        if self.open_files.len() >= MAX_INCLUDE_DEPTH || self.scopes.len() >= MAX_BRACES {
            return Err(
                tokens.fail(format_args!("{name}: more than {MAX_INCLUDE_DEPTH} files within each other"))
            );
        }
        let index = self
            .files
            .include(self.file, &name)
            .map_err(|why| tokens.fail(format_args!("cannot read '{name}': {why}")))?;
        if self.open_files.contains(&index) {
            return Err(tokens.fail(format_args!("'{name}' includes itself")));
        }
        self.file(index)
    }

    /// The object that triangles belong to here: the innermost include or named transform.
    fn object(&mut self, tokens: &Tokens<'_>) -> Outcome<u32> {
        let innermost = self.scopes.iter().rposition(|scope| scope.label.is_some()).unwrap_or(0);
        if let Some(object) = self.scopes[innermost].object {
            return Ok(object);
        }
        limit(tokens, "objects", self.model.objects.len())?;
        // The main file is only named where nothing else is.
        let labels = self.scopes[usize::from(innermost > 0)..=innermost].iter();
        let path = labels.filter_map(|scope| scope.label.as_deref()).collect::<Vec<_>>().join("/");
        let skipped = path.chars().count().saturating_sub(LONGEST_PATH);
        let mut name: String = path.chars().skip(skipped).collect();
        let uses = self.uses_of_object_name.entry(name.clone()).or_default();
        *uses += 1;
        if *uses > 1 {
            name = format!("{name} {uses}");
        }
        let object = self.model.objects.len() as u32;
        self.model.objects.push(Object { name });
        self.scopes[innermost].object = Some(object);
        Ok(object)
    }

    /// Notes that the triangles of `source` from `first` up to `end` stand here.
    pub(super) fn add_run(
        &mut self,
        tokens: &Tokens<'_>,
        source: Source,
        first: usize,
        end: usize,
    ) -> Outcome<()> {
        if first == end {
            return Ok(());
        }
        let (node, object) = (self.node(), self.object(tokens)?);
        if let Some(last) = self.model.runs.last_mut()
            && (last.node, last.object, last.source) == (node, object, source)
        {
            last.count += end - first;
        } else {
            self.model.runs.push(Run { node, object, source, first, count: end - first });
        }
        Ok(())
    }
}

/// Refuses one more piece of a kind there are [`MAX_PIECES`] of.
pub(super) fn limit(tokens: &Tokens<'_>, what: &str, len: usize) -> Outcome<()> {
    if len < MAX_PIECES {
        return Ok(());
    }
    Err(tokens.fail(format_args!("more than {MAX_PIECES} {what}")))
}
