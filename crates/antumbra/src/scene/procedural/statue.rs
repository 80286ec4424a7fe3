//! A veiled figure in a niche: one dense closed surface.

use super::Arguments;
use super::build::{Builder, Place};
use super::math::{V3, fractal, lerp, noise, smoothstep, turn, wave};

/// Sections of the figure from the hem to the crown: height, middle (x, z), half width, half depth, depth of folds.
const SECTIONS: [[f64; 6]; 15] = [
    [0.00, 0.00, 0.00, 0.42, 0.38, 0.046],
    [0.08, 0.00, 0.00, 0.39, 0.36, 0.046],
    [0.35, 0.01, 0.00, 0.33, 0.30, 0.040],
    [0.70, 0.03, 0.01, 0.30, 0.26, 0.032],
    [0.95, 0.05, 0.01, 0.295, 0.25, 0.024],
    [1.12, 0.03, 0.00, 0.245, 0.20, 0.016],
    [1.26, 0.01, 0.01, 0.280, 0.215, 0.013],
    [1.40, 0.00, 0.01, 0.320, 0.200, 0.009],
    [1.49, 0.00, 0.00, 0.295, 0.175, 0.006],
    [1.55, 0.00, 0.00, 0.220, 0.155, 0.002],
    [1.60, -0.005, 0.005, 0.168, 0.143, 0.000],
    [1.67, -0.01, 0.015, 0.134, 0.142, 0.000],
    [1.74, -0.01, 0.02, 0.137, 0.152, 0.000],
    [1.81, -0.01, 0.01, 0.137, 0.157, 0.000],
    [1.84, -0.01, 0.01, 0.134, 0.155, 0.000],
];
const CROWN: f64 = 0.125;
/// Shares of the rows that close the surface below and above.
const CAPS: [f64; 2] = [0.03, 0.07];
const PLINTH: f64 = 0.9;

pub(super) fn statue(arguments: &Arguments, b: &mut Builder) {
    niche(b);
    // Twice as many rows as columns make about square cells.
    let columns = ((arguments.size.saturating_sub(b.len()) as f64 / 4.0).sqrt() as usize).max(8);
    let seed = arguments.seed;
    b.object("statue").paint("marble", 0xf1ece2);
    b.within(Place::at([0.0, PLINTH, 0.0]).turned(0.04), |b| {
        b.surface([columns, 2 * columns], [true, false], |u, v| figure(1.0 - u, v, seed));
    });
    b.light([-1.55, 3.3, 2.5], 0xfff2dd, 3.1).camera([1.25, 1.95, 5.0], [0.05, 1.98, 0.0], 37.0);
}

/// All six numbers of the section at height `y`: cubic Hermite curves with central differences as slopes.
fn section(y: f64) -> [f64; 6] {
    let last = SECTIONS.len() - 1;
    let k = SECTIONS.iter().rposition(|s| s[0] <= y).unwrap_or(0).min(last - 1);
    let at = |i: usize| SECTIONS[i];
    let slope = |i: usize, c: usize| {
        let (before, after) = (at(i.saturating_sub(1)), at((i + 1).min(last)));
        (after[c] - before[c]) / (after[0] - before[0])
    };
    let h = at(k + 1)[0] - at(k)[0];
    let t = (y - at(k)[0]) / h;
    std::array::from_fn(|c| {
        let (p, q, m, n) = (at(k)[c], at(k + 1)[c], slope(k, c) * h, slope(k + 1, c) * h);
        p + t * (m + t * (3.0 * (q - p) - 2.0 * m - n + t * (2.0 * (p - q) + m + n)))
    })
}

/// 1 at the middle, falling to nothing some `width` away.
fn bump(distance: f64, width: f64) -> f64 {
    let x = distance / width;
    let y = 1.0 / (1.0 + x * x);
    y * y
}

fn figure(u: f64, v: f64, seed: u64) -> V3 {
    let top = SECTIONS[SECTIONS.len() - 1][0];
    let body = ((v - CAPS[0]) / (1.0 - CAPS[0] - CAPS[1])).clamp(0.0, 1.0);
    let foot = (v / CAPS[0]).min(1.0);
    let (dome, rise) = turn(0.25 * ((v - 1.0 + CAPS[1]) / CAPS[1]).clamp(0.0, 1.0));
    let y = lerp(0.0, top, body);
    let [_, cx, cz, width, depth, folds] = section(y);
    let (cos, sin) = turn(u);
    // The domain of the noise is the surface itself, so that nothing shows where `u` closes.
    let p = [cos * width, y + CROWN * rise, sin * depth];
    let sway = noise([2.2 * cos, 1.1 * y, 2.2 * sin], seed);
    let drapery = 0.55 * wave(9.0 * u + 0.7 * sway + 0.25 * y)
        + 0.3 * wave(17.0 * u + 1.1 * sway - 0.3 * y)
        + 0.25 * wave(4.0 * u + 1.6 * y + 0.6 * sway);
    // A sash and the edge of the veil run around at a slant.
    let slant = y - 1.08 - 0.05 * cos;
    let veil = y - 0.62 - 0.16 * cos - 0.05 * wave(5.0 * u);
    let mut d = folds * drapery + 0.022 * bump(slant, 0.03) - 0.02 * smoothstep(-0.015, 0.015, -veil);
    let front = smoothstep(-0.2, 0.6, sin);
    // Forearms under the veil, that meet in front.
    d += front * 0.065 * bump(y - 1.17 - 0.07 * (1.0 - cos.abs()), 0.09);
    d += front * 0.03 * bump(cos, 0.22) * bump(y - 1.25, 0.06);
    // A face that is guessed more than seen: nose, eyes, mouth, chin.
    let across = cos * width;
    d += front * 0.026 * bump(across, 0.018) * bump(y - 1.745, 0.034);
    d -= front * 0.012 * (bump(across - 0.045, 0.028) + bump(across + 0.045, 0.028)) * bump(y - 1.778, 0.022);
    d += front * 0.009 * bump(across, 0.045) * bump(y - 1.700, 0.012);
    d += front * 0.014 * bump(across, 0.04) * bump(y - 1.660, 0.02);
    // It is set back into the hood.
    let oval = (across / 0.085) * (across / 0.085) + ((y - 1.735) / 0.125) * ((y - 1.735) / 0.125);
    d -= front * 0.02 * (1.0 - smoothstep(0.85, 1.15, oval));
    // The chisel and the grain of the stone.
    let scaled = |s: f64| p.map(|c| c * s);
    d += 0.004 * fractal(scaled(7.0), seed + 1) + 0.0003 * noise(scaled(160.0), seed + 2);
    let r = foot * dome;
    [cx + r * cos * (width + d), y + CROWN * rise, cz + r * sin * (depth + d)]
}

fn niche(b: &mut Builder) {
    const RADIUS: f64 = 0.95;
    const SPRING: f64 = 2.75;
    const HALF: f64 = 3.4;
    const TOP: f64 = 4.6;
    b.object("floor").tiles(
        [-HALF, -1.2],
        [HALF, 3.6],
        0.0,
        [12, 10],
        [("slate", 0x77797c), ("limestone", 0xb9b1a1)],
    );
    b.object("niche").paint("niche", 0x9c7f6a);
    let arc = |u: f64| turn(0.5 * u);
    b.surface([48, 1], [false, false], |u, v| {
        let (cos, sin) = arc(u);
        [-RADIUS * cos, SPRING * v, -RADIUS * sin]
    });
    b.surface([48, 24], [false, false], |u, v| {
        let ((cos, sin), (c, s)) = (arc(u), turn(0.25 * v));
        [-RADIUS * cos * c, SPRING + RADIUS * s, -RADIUS * sin * c]
    });
    b.object("wall").paint("wall", 0xbfae98);
    for side in [-1.0, 1.0] {
        b.quad([
            [side * RADIUS, 0.0, 0.0],
            [side * HALF, 0.0, 0.0],
            [side * HALF, TOP, 0.0],
            [side * RADIUS, TOP, 0.0],
        ]);
    }
    b.surface([48, 1], [false, false], |u, v| {
        let (cos, sin) = arc(u);
        [-RADIUS * cos, lerp(SPRING + RADIUS * sin, TOP, v), 0.0]
    });
    b.object("frame").paint("frame", 0xd9cdb8);
    b.surface([48, 12], [false, true], |u, v| {
        let ((cos, sin), (c, s)) = (arc(u), turn(v));
        let r = RADIUS + 0.09 + 0.07 * c;
        [-r * cos, SPRING + r * sin, 0.02 + 0.07 * s]
    });
    for side in [-1.0, 1.0] {
        b.block_on([side * 1.05, 0.0, 0.04], [0.26, 0.3, 0.2])
            .block_on([side * 1.05, SPRING - 0.16, 0.04], [0.26, 0.16, 0.2]);
        b.within(Place::at([side * 1.05, 0.3, 0.06]), |b| {
            // A fluted half column.
            b.surface([60, 12], [true, false], |u, v| {
                let (cos, sin) = turn(u);
                let r = lerp(0.095, 0.08, v) * (1.0 - 0.06 * wave(15.0 * u).abs());
                [r * cos, (SPRING - 0.46) * v, -r * sin]
            });
        });
        b.block([side * HALF - 0.25, 0.0, -0.05], [side * HALF + 0.25, TOP, 0.25]);
    }
    b.block([-HALF, TOP - 0.35, -0.05], [HALF, TOP, 0.3]);
    b.object("plinth").paint("plinth", 0xcabfae);
    let profile = [
        [0.0, 0.0],
        [0.62, 0.0],
        [0.62, 0.14],
        [0.56, 0.17],
        [0.53, 0.23],
        [0.5, 0.26],
        [0.5, 0.7],
        [0.53, 0.74],
        [0.56, 0.8],
        [0.56, PLINTH],
        [0.0, PLINTH],
    ];
    b.lathe(&profile, 8);
}
