//! People who walk across a square at night, around its one lamp.

use super::Arguments;
use super::build::{Builder, Place};
use super::math::{Rng, V3, add, around, lerp, turn, wave};

const HALF: f64 = 17.0;
const LAMP: V3 = [0.0, 4.3, 0.0];
/// Seconds until everybody is where the random numbers put them.
const MEETING: f64 = 5.0;
/// Metres a cycle of two steps.
const STRIDE: f64 = 1.45;

pub(super) fn crowd(arguments: &Arguments, b: &mut Builder) {
    square(b);
    let mut k = 0;
    loop {
        let before = b.len();
        let mut rng = Rng::new(arguments.seed, k);
        let person = Person::new(&mut rng);
        b.object(format!("person {}", k + 1));
        person.draw(b, arguments.time);
        k += 1;
        let last = b.len() - before;
        if b.len() + last / 2 >= arguments.size {
            break;
        }
    }
    b.light(LAMP, 0xffe6bd, 8.0).camera([5.5, 7.6, 15.5], [0.0, 0.4, 0.6], 46.0);
}

fn square(b: &mut Builder) {
    b.object("square");
    b.tiles([-HALF; 2], [HALF; 2], 0.0, [17, 17], [("granite", 0xa39c92), ("basalt", 0x8b857d)]);
    b.object("lamp post").paint("iron", 0x2f3438);
    let post = [
        [0.0, 0.0],
        [0.34, 0.0],
        [0.34, 0.18],
        [0.2, 0.3],
        [0.14, 0.8],
        [0.085, 0.95],
        [0.06, 3.2],
        [0.09, 3.3],
        [0.05, 3.4],
        [0.05, 3.95],
        [0.16, 4.02],
        [0.0, 4.02],
    ];
    b.lathe(&post, 16);
    for k in 0..6 {
        let t = f64::from(k) / 6.0;
        b.bar(around(0.15, t, 4.02), around(0.24, t, 4.55), 0.012, 5);
    }
    b.lathe(&[[0.0, 4.55], [0.3, 4.55], [0.2, 4.7], [0.05, 4.8], [0.0, 4.95]], 6);
    b.object("benches").paint("bench", 0x7a5234);
    for k in 0..6 {
        let t = (f64::from(k) + 0.5) / 6.0;
        b.within(Place::at(around(2.6, t, 0.0)).turned(0.25 - t), |b| {
            for i in 0..4 {
                let z = -0.2 + 0.13 * f64::from(i);
                b.block([-0.8, 0.43, z - 0.05], [0.8, 0.47, z + 0.05]);
            }
            for x in [-0.6, 0.6] {
                b.block([x - 0.04, 0.0, -0.2], [x + 0.04, 0.43, 0.2]);
            }
        });
    }
}

/// Someone: how they look and where they go.
struct Person {
    middle: V3,
    heading: f64,
    speed: f64,
    phase: f64,
    height: f64,
    girth: f64,
    skirt: bool,
    umbrella: bool,
    colours: [(&'static str, u32); 4],
}

impl Person {
    fn new(rng: &mut Rng) -> Person {
        // Four ways across the square, none through the lamp and its benches.
        let (middle, heading, speed) = loop {
            let heading = 0.25 * rng.below(4) as f64 + 0.1 + rng.range(-0.05, 0.05);
            let [x, _, z] = around(HALF * 0.85 * rng.unit().sqrt(), rng.unit(), 0.0);
            let (cos, sin) = turn(heading);
            if (x * cos - z * sin).abs() > 3.4 {
                break ([x, 0.0, z], heading, rng.range(1.0, 1.6));
            }
        };
        let skin = rng.pick(&[
            ("skin 1", 0xe8bf9f),
            ("skin 2", 0xc68e63),
            ("skin 3", 0x8d5a3b),
            ("skin 4", 0xf1d0b5),
        ]);
        let coat = rng.pick(&[
            ("red coat", 0xb23a3a),
            ("blue coat", 0x34568b),
            ("mustard coat", 0xd9a441),
            ("green coat", 0x4b7a5a),
            ("cream coat", 0xe5dcc8),
            ("plum coat", 0x6b4468),
            ("teal coat", 0x2f7f86),
        ]);
        let legs =
            rng.pick(&[("denim", 0x3d5275), ("black", 0x2b2b30), ("khaki", 0x9a8a64), ("grey", 0x6d7076)]);
        let hair = rng.pick(&[
            ("dark hair", 0x2a1f1a),
            ("brown hair", 0x5d3b24),
            ("fair hair", 0xc9a15b),
            ("grey hair", 0x9b9b98),
        ]);
        Person {
            middle,
            heading,
            speed,
            phase: rng.unit(),
            height: rng.range(0.88, 1.08),
            girth: rng.range(0.9, 1.15),
            skirt: rng.unit() < 0.3,
            umbrella: rng.unit() < 0.12,
            colours: [skin, coat, legs, hair],
        }
    }

    fn draw(&self, b: &mut Builder, time: f64) {
        let walked = self.speed * (time - MEETING);
        let (cos, sin) = turn(self.heading);
        let foot = add(self.middle, [sin * walked, 0.0, cos * walked]);
        let gait = walked / STRIDE + self.phase;
        let h = self.height;
        let place = Place::at(foot).turned(self.heading).scaled([h * self.girth, h, h * self.girth]);
        b.within(place, |b| self.figure(b, gait));
    }

    /// Walks towards +z; heights are those of somebody 1.75 m tall.
    fn figure(&self, b: &mut Builder, gait: f64) {
        let [skin, coat, legs, hair] = self.colours;
        // The hips are highest when the legs pass each other, twice in a cycle.
        let bob = 0.022 * wave(2.0 * gait + 0.25) - 0.03;
        let hip = 0.92 + bob;
        for (side, phase) in [(-1.0, gait), (1.0, gait + 0.5)] {
            let swing = 0.072 * wave(phase);
            let bend = 0.02 + 0.13 * wave(phase + 0.17).max(0.0);
            let joint = [side * 0.09, hip, 0.0];
            let knee = add(joint, limb(0.45, swing));
            let ankle = add(knee, limb(0.43, swing - bend));
            b.paint(legs.0, legs.1).tube(&[joint, knee, ankle], 6, |t| lerp(0.085, 0.05, t));
            let toe = add(ankle, limb(0.2, swing - bend + 0.25));
            b.paint("shoe", 0x2a2320).tube(
                &[add(ankle, [0.0, -0.03, -0.05]), add(toe, [0.0, -0.04, 0.0])],
                5,
                |_| 0.042,
            );
            let shoulder = [side * 0.21, 1.42 + bob, 0.0];
            let lifted = self.umbrella && side > 0.0;
            let (arm, elbow) = if lifted { (0.06, 0.3) } else { (-0.055 * wave(phase), 0.05) };
            let joint = add(shoulder, limb(0.29, arm));
            let hand = add(joint, limb(0.27, arm + elbow));
            b.paint(coat.0, coat.1).tube(&[shoulder, joint, hand], 5, |t| lerp(0.06, 0.038, t));
            b.paint(skin.0, skin.1).sphere(hand, 0.045, 6);
            if lifted {
                let top = add(hand, [0.0, 0.85, -0.05]);
                b.paint("stick", 0x3a2a20).bar(add(hand, [0.0, -0.1, 0.0]), top, 0.012, 4);
                b.paint("umbrella", 0xa8324a);
                b.within(Place::at(top), |b| {
                    b.lathe(&[[0.0, 0.02], [0.3, -0.04], [0.6, -0.22], [0.3, -0.02], [0.0, 0.05]], 10);
                });
            }
        }
        let hem = if self.skirt { 0.5 } else { 0.84 };
        let wide = if self.skirt { 0.24 } else { 0.165 };
        let profile = [
            [0.0, hem],
            [wide, hem],
            [0.15, 0.98],
            [0.135, 1.12],
            [0.185, 1.36],
            [0.15, 1.46],
            [0.05, 1.5],
            [0.0, 1.5],
        ];
        b.paint(coat.0, coat.1).within(Place::at([0.0, bob, 0.0]).scaled([1.1, 1.0, 0.8]), |b| {
            b.lathe(&profile, 8);
        });
        b.paint(skin.0, skin.1).bar([0.0, 1.46 + bob, 0.0], [0.0, 1.58 + bob, 0.01], 0.05, 6);
        b.sphere([0.0, 1.64 + bob, 0.02], 0.108, 10);
        b.paint(hair.0, hair.1).sphere([0.0, 1.67 + bob, -0.012], 0.112, 10);
    }
}

/// From a joint to the next one, `long` away, hanging down and swung forwards by `turns`.
fn limb(long: f64, turns: f64) -> V3 {
    let (cos, sin) = turn(turns);
    [0.0, -long * cos, long * sin]
}
