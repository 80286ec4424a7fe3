//! Statements that make triangles.

use super::model::{Corner, MAX_TRIANGLES, Morph, MorphKey, Source};
use super::parse::Parser;
use super::tessellate;
use super::tokens::{Outcome, Tokens};

impl Parser {
    /// Refuses `more` triangles beyond [`MAX_TRIANGLES`].
    fn room_for(&self, tokens: &Tokens<'_>, more: usize) -> Outcome<()> {
        let have = self.model.faces.positions.len() + self.model.morphs.len();
        if more <= MAX_TRIANGLES.saturating_sub(have) {
            return Ok(());
        }
        Err(tokens.fail(format_args!("more than {MAX_TRIANGLES} triangles with all includes")))
    }

    /// Adds `triangles` in the current fill.
    fn add(
        &mut self,
        tokens: &Tokens<'_>,
        texture: Option<&str>,
        triangles: impl ExactSizeIterator<Item = [Corner; 3]>,
    ) -> Outcome<()> {
        self.room_for(tokens, triangles.len())?;
        let material = self.material(tokens, texture)?;
        let first = self.model.faces.positions.len();
        for corners in triangles {
            self.model.faces.push(corners, material);
        }
        self.add_run(tokens, Source::Faces, first, self.model.faces.positions.len())
    }

    /// `c base radius apex radius`.
    pub(super) fn cone(&mut self, tokens: &mut Tokens<'_>) -> Outcome<()> {
        let base = tokens.numbers("base")?;
        let base_radius = tokens.number("base radius")?;
        let apex = tokens.numbers("apex")?;
        let apex_radius = tokens.number("apex radius")?;
        let triangles = tessellate::cone(base, base_radius, apex, apex_radius)
            .ok_or_else(|| tokens.fail("base and apex are the same point"))?;
        self.add(tokens, None, triangles.into_iter())
    }

    /// `s centre radius`.
    pub(super) fn sphere(&mut self, tokens: &mut Tokens<'_>) -> Outcome<()> {
        let center = tokens.numbers("centre")?;
        let radius = tokens.number("radius")?;
        self.add(tokens, None, tessellate::sphere(center, radius).into_iter())
    }

    /// `p n` corners, or `pp n` corners with normals.
    pub(super) fn polygon(&mut self, tokens: &mut Tokens<'_>, with_normals: bool) -> Outcome<()> {
        let count = tokens.count("corners", if with_normals { 6 } else { 3 })?;
        if count < 3 {
            return Err(tokens.fail(format_args!("{count} corners, at least 3 are needed")));
        }
        self.room_for(tokens, count - 2)?;
        let mut corners = Vec::with_capacity(count);
        for _ in 0..count {
            let position = tokens.floats("corner")?;
            let normal = if with_normals { tokens.floats("normal")? } else { [0.0; 3] };
            corners.push(Corner { position, normal, ..Corner::default() });
        }
        let positions: Vec<_> = corners.iter().map(|c| c.position).collect();
        let triangles = tessellate::polygon(&positions, &mut self.ears).map_err(|why| tokens.fail(why))?;
        self.add(tokens, None, triangles.into_iter().map(|t| t.map(|i| corners[i as usize])))
    }

    /// `tt texture`, or `ttp texture` with normals: three corners.
    pub(super) fn textured_triangle(&mut self, tokens: &mut Tokens<'_>, with_normals: bool) -> Outcome<()> {
        let texture = tokens.name("the texture's name")?;
        let mut corners = [Corner::default(); 3];
        for corner in &mut corners {
            corner.position = tokens.floats("corner")?;
            if with_normals {
                corner.normal = tokens.floats("normal")?;
            }
            corner.uv = tokens.floats("texture coordinates")?;
        }
        self.add(tokens, Some(&texture), std::iter::once(corners))
    }

    /// `tpa n`, then n times a time and three corners with normals.
    pub(super) fn animated_triangle(&mut self, tokens: &mut Tokens<'_>) -> Outcome<()> {
        let count = tokens.count("times", 19)?;
        if count == 0 {
            return Err(tokens.fail("at least one time is needed"));
        }
        self.room_for(tokens, 1)?;
        let material = self.material(tokens, None)?;
        let first = self.model.morph_keys.len();
        for _ in 0..count {
            let [time] = tokens.floats("time")?;
            let mut key = MorphKey { time, positions: [[0.0; 3]; 3], normals: [[0.0; 3]; 3] };
            for corner in 0..3 {
                key.positions[corner] = tokens.floats("corner")?;
                key.normals[corner] = tokens.floats("normal")?;
            }
            self.model.morph_keys.push(key);
        }
        let index = self.model.morphs.len();
        self.model.morphs.push(Morph { first, count, material });
        self.add_run(tokens, Source::Morphs, index, index + 1)
    }

    /// `m vertices n … [normals n …] [texturecoords n name …] triangles n …`.
    pub(super) fn mesh(&mut self, tokens: &mut Tokens<'_>) -> Outcome<()> {
        tokens.expect("vertices")?;
        let vertices = vectors(tokens, "vertices")?;
        let normals = if tokens.take(b"normals") { Some(vectors(tokens, "normals")?) } else { None };
        let mut uvs = None;
        let mut texture = None;
        if tokens.take(b"texturecoords") {
            let count = tokens.count("texturecoords", 2)?;
            texture = Some(tokens.name("the texture's name")?);
            let mut pairs = Vec::with_capacity(count);
            for _ in 0..count {
                pairs.push(tokens.floats("texturecoords")?);
            }
            uvs = Some(pairs);
        }
        tokens.expect("triangles")?;
        let kinds = 1 + usize::from(normals.is_some()) + usize::from(uvs.is_some());
        let count = tokens.count("triangles", 3 * kinds)?;
        self.room_for(tokens, count)?;
        let material = self.material(tokens, texture.as_deref())?;
        let first = self.model.faces.positions.len();
        for _ in 0..count {
            let mut corners = [Corner::default(); 3];
            for corner in &mut corners {
                corner.position = vertices[tokens.index("vertex", vertices.len())?];
            }
            if let Some(normals) = &normals {
                for corner in &mut corners {
                    corner.normal = normals[tokens.index("normal", normals.len())?];
                }
            }
            if let Some(uvs) = &uvs {
                for corner in &mut corners {
                    corner.uv = uvs[tokens.index("texture coordinate", uvs.len())?];
                }
            }
            self.model.faces.push(corners, material);
        }
        self.add_run(tokens, Source::Faces, first, self.model.faces.positions.len())
    }
}

fn vectors(tokens: &mut Tokens<'_>, what: &str) -> Outcome<Vec<[f32; 3]>> {
    let count = tokens.count(what, 3)?;
    let mut vectors = Vec::with_capacity(count);
    for _ in 0..count {
        vectors.push(tokens.floats(what)?);
    }
    Ok(vectors)
}
