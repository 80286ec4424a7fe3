//! Key frames: `k name { transl n … rot n … scale n … visibility n … }`.

use super::affine::Quaternion;
use super::model::{Animation, MAX_KEYS};
use super::spline::{Key, PointTrack, RotationTrack};
use super::tokens::{Outcome, Tokens, quote};

/// Fewest keys of a spline: its first and last only shape the curve.
const FEWEST: usize = 4;

/// Reads the braces of a `k` and what is in them. `keys_left` counts down over all of a scene.
pub(super) fn animation(tokens: &mut Tokens<'_>, keys_left: &mut usize) -> Outcome<Animation> {
    tokens.expect("{")?;
    let mut animation = Animation::default();
    loop {
        match tokens.next() {
            Some(b"}") => return Ok(animation),
            Some(b"transl") => animation.translation = Some(points(tokens, "transl", keys_left)?),
            Some(b"scale") => animation.scale = Some(points(tokens, "scale", keys_left)?),
            Some(b"rot") => animation.rotation = Some(rotations(tokens, keys_left)?),
            Some(b"visibility") => animation.visibility = visibility(tokens, keys_left)?,
            Some(word) => {
                let known = "transl, rot, scale and visibility";
                return Err(
                    tokens.fail(format_args!("unknown kind of keys {}; known are {known}", quote(word)))
                );
            }
            None => return Err(tokens.fail("the file ends before '}'")),
        }
    }
}

fn count(
    tokens: &mut Tokens<'_>,
    what: &str,
    fewest: usize,
    words_each: usize,
    keys_left: &mut usize,
) -> Outcome<usize> {
    let count = tokens.count(what, words_each)?;
    if count < fewest {
        return Err(tokens.fail(format_args!("{what}: {count} keys, at least {fewest} are needed")));
    }
    *keys_left = keys_left
        .checked_sub(count)
        .ok_or_else(|| tokens.fail(format_args!("{what}: more than {MAX_KEYS} keys in all")))?;
    Ok(count)
}

fn points(tokens: &mut Tokens<'_>, what: &str, keys_left: &mut usize) -> Outcome<PointTrack> {
    let count = count(tokens, what, FEWEST, 7, keys_left)?;
    let mut keys = Vec::with_capacity(count);
    for _ in 0..count {
        let [time, x, y, z, tension, continuity, bias] = tokens.numbers(what)?;
        keys.push(Key { time, value: [x, y, z], tcb: [tension, continuity, bias] });
    }
    Ok(PointTrack::new(&keys))
}

fn rotations(tokens: &mut Tokens<'_>, keys_left: &mut usize) -> Outcome<RotationTrack> {
    let count = count(tokens, "rot", FEWEST, 8, keys_left)?;
    let mut keys = Vec::with_capacity(count);
    for _ in 0..count {
        let [time, x, y, z, degrees, tension, continuity, bias] = tokens.numbers("rot")?;
        keys.push(Key {
            time,
            value: Quaternion::about([x, y, z], degrees),
            tcb: [tension, continuity, bias],
        });
    }
    Ok(RotationTrack::new(&keys))
}

fn visibility(tokens: &mut Tokens<'_>, keys_left: &mut usize) -> Outcome<Vec<(f64, bool)>> {
    let count = count(tokens, "visibility", 1, 2, keys_left)?;
    let mut keys = Vec::with_capacity(count);
    for _ in 0..count {
        keys.push((tokens.number("visibility")?, tokens.integer("visibility")? != 0));
    }
    Ok(keys)
}
