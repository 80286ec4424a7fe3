//! What a face of the cube measures directions from: its axis, or, if the light is so far away that it sees all samples in almost one
//! direction, a point among them ([`Aim`]). Differences of directions would be lost in the rounding of f32 otherwise: a hundred scene sizes away
//! all bounds would be wider by half a pixel, ten thousand away by fifty.

use antumbra_predicates::aim::Aim;
use antumbra_predicates::filter::LIMIT;
use antumbra_predicates::tile::{NEAREST, Region};

use super::frame::{FACES, Frame};
use super::leaves::direction;
use super::tuning::{NARROW, SIGHT_LEAST, SIGHT_PLACES, SIGHT_SAMPLES};

/// How a face sees.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Sight {
    pub(super) frame: Frame,
    pub(super) aim: Aim,
    /// Of all samples of the face ([`Aim::depth_of`]).
    pub(super) depth: f32,
    /// The same ([`Aim::weight`]).
    pub(super) weight: [f32; 2],
    /// Packed bounds of samples that are in the face for certain are larger ([`Region::pack`]).
    pub(super) within: [f32; 8],
    /// Nearness of the farthest sample, and what to shift its bits by: [`Sight::nearness`].
    farthest: u32,
    shift: u32,
}

/// All faces.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Sights {
    pub(super) faces: [Sight; FACES],
    /// Some face measures from a point.
    pub(super) any_far: bool,
}

impl Sights {
    /// By some of the samples.
    pub(super) fn new(light: [f32; 3], positions: &[[f32; 3]]) -> Sights {
        let (mut bounds, mut counts) = ([Region::EMPTY; FACES], [0; FACES]);
        let mut all = 0;
        for i in 0..SIGHT_PLACES {
            // Multiples of the golden ratio are spread evenly, whatever repeats in a picture.
            let part = u64::from(i.wrapping_mul(0x9e37_79b9));
            let Some(&p) = positions.get(((part * positions.len() as u64) >> 32) as usize) else {
                break;
            };
            if let Some((face, at)) = direction(p, light) {
                bounds[face] = bounds[face].union(&Region { lo: at, hi: at });
                counts[face] += 1;
                all += 1;
                if all == SIGHT_SAMPLES {
                    break;
                }
            }
        }
        let faces = std::array::from_fn(|face| {
            let bounds = if counts[face] < SIGHT_LEAST { Region::EMPTY } else { bounds[face] };
            Sight::new(Frame::of(face), light, &bounds)
        });
        Sights { faces, any_far: faces.iter().any(|sight| !sight.aim.is_straight()) }
    }
}

impl Sight {
    fn new(frame: Frame, light: [f32; 3], bounds: &Region) -> Sight {
        let light = frame.turn(light);
        let middle = [0, 1, 2].map(|k| 0.5 * (bounds.lo[k] + bounds.hi[k]));
        let size = [0, 1, 2].map(|k| 0.5 * (bounds.hi[k] - bounds.lo[k]));
        // False for empty bounds.
        let is_narrow = size[0] < NARROW && size[1] < NARROW && size[2] < NARROW * middle[2];
        let aim = if is_narrow { Aim::at(light, middle) } else { Aim::straight(light) };
        let within = within(aim.slope(), 12.0 * f32::EPSILON);
        Sight { frame, aim, within, depth: 1.0, weight: [1.0; 2], farthest: 0, shift: 0 }
    }

    /// The samples of the face are known.
    pub(super) fn bound(&mut self, samples: &Region) {
        if samples.lo[0] > samples.hi[0] {
            return;
        }
        self.depth = self.aim.depth_of(samples);
        self.weight = self.aim.weight(samples);
        self.farthest = samples.lo[2].to_bits();
        // Half of the numbers for samples, half for what is nearer.
        let range = samples.hi[2].to_bits() - self.farthest;
        self.shift = (u32::BITS - range.leading_zeros()).saturating_sub(15).min(12);
    }

    /// How near a triangle comes to the light: larger is nearer. Only for the order of the tests.
    #[inline(always)]
    pub(super) fn nearness(&self, r: f32) -> u16 {
        (r.to_bits().saturating_sub(self.farthest) >> self.shift).min(u32::from(u16::MAX)) as u16
    }
}

/// Packed bounds ([`Region::pack`]) than which those of samples are larger that are within the face, by `room`, and at lengths that f32 can hold.
pub(super) const fn within([x, y]: [f32; 2], room: f32) -> [f32; 8] {
    let (edge, none) = (-1.0 + room, f32::NEG_INFINITY);
    [edge - x, edge - y, 1.0 / LIMIT, none, edge + x, edge + y, -1.0 / NEAREST, none]
}
