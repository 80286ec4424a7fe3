//! What SOA11 says about test-and-set operations.

use antumbra::methods::{Ptsv, PtsvTuning, Stats};
use anyhow::Result;

use super::bench::{Bench, Setting, counter};
use super::markdown::{ratio, short, table, times};
use super::settings::{BUILDING, CITY, ROOM, SPONZA};
use super::{Finding, Section, Verdict};

/// Tests of a frustum with a tile or a sample: what the paper counts for its own method.
fn tests(stats: &Stats) -> u64 {
    counter(stats, "node_visits") + counter(stats, "leaf_tests")
}

fn ptsv(bench: &mut Bench<'_>, setting: &Setting, cull: bool) -> Result<Stats> {
    if !cull {
        return bench.count(setting, "ptsv");
    }
    let isa = bench.isa;
    // Without its front faces an open mesh casts another shadow.
    bench.run(setting, "ptsv without front faces", false, || {
        let tuning = PtsvTuning { cull_front_faces: true, ..PtsvTuning::default() };
        Ok(Box::new(Ptsv::with_tuning(isa, tuning)))
    })
}

const SMALL: [usize; 2] = [1024, 1024];
const LARGE: [usize; 2] = [4096, 4096];

pub(super) const GROWTH: Section = Section {
    key: "growth",
    title: "Growth with resolution",
    claim: "Sixteen times the samples need about two to four times the test-and-set operations in PTSV, and about 16 times in z-pass.",
    source: "SOA11, section 4, figure 7",
    published: "\"between about two to four times\" for PTSV, \"around 16 times\" for z-pass, from 1024 x 1024 to 4096 x 4096",
    run: growth,
};

fn growth(bench: &mut Bench<'_>) -> Result<Finding> {
    let mut rows = Vec::new();
    let (mut culled_growth, mut all_growth, mut pass_growth) = (Vec::new(), Vec::new(), Vec::new());
    for setting in [SPONZA, BUILDING, CITY, ROOM] {
        let mut counts = Vec::new();
        for size in [SMALL, LARGE] {
            let Some(setting) = bench.resolve(&setting.sized(size)) else { continue };
            counts.push([
                tests(&ptsv(bench, &setting, true)?),
                tests(&ptsv(bench, &setting, false)?),
                counter(&bench.count(&setting, "zpass")?, "stencil_updates"),
            ]);
        }
        let [small, large] = counts[..] else { continue };
        let name = bench.resolve(&setting).map_or(setting.name, |s| s.name);
        for (k, list) in [&mut culled_growth, &mut all_growth, &mut pass_growth].into_iter().enumerate() {
            let method = ["PTSV, back faces only", "PTSV", "z-pass"][k];
            let r = ratio(large[k], small[k]);
            list.push(r);
            rows.push(vec![format!("{name}: {method}"), short(small[k]), short(large[k]), times(r)]);
        }
    }
    let mut body = table(&["test-and-set operations", "1024 x 1024", "4096 x 4096", "growth"], &rows);
    body += "\nPTSV: tests of a frustum with a tile (`node_visits`) or with a sample (`leaf_tests`). z-pass: stencil updates, one for each sample and each face \
             that it is crossed for, as a stencil buffer would be asked for them (`stencil_updates`; ours adds to whole nodes where it can).\n\n\
             With front faces as casters, every lit surface is refined down to each of its own samples, and that part grows 16 times; the tests of tiles, which grow \
             with the length of shadow outlines, outweigh it. So culling changes the growth little, and the operations by a factor of about two, as in the \
             paper (2.2 at the lower, 2.4 at the higher resolution).\n";
    let span = |list: &[f64]| {
        let (l, h) = list.iter().fold((f64::INFINITY, 0.0f64), |(l, h), &v| (l.min(v), h.max(v)));
        (l, h)
    };
    let ((cl, ch), (al, ah), (pl, ph)) = (span(&culled_growth), span(&all_growth), span(&pass_growth));
    let ours = format!(
        "PTSV {} to {} times (back faces only), {} to {} (all faces); z-pass {} to {}",
        times(cl),
        times(ch),
        times(al),
        times(ah),
        times(pl),
        times(ph)
    );
    let pass = pl > 12.0 && ph < 20.0;
    let verdict = if pass && cl >= 1.5 && ch <= 4.5 {
        Verdict::Holds
    } else if pass && ch < 8.0 {
        Verdict::Partly
    } else {
        Verdict::Differs
    };
    Ok(Finding { verdict, ours, body })
}

pub(super) const CULLING: Section = Section {
    key: "culling",
    title: "Culling one facing",
    claim: "Leaving out the triangles that face the light about halves the test-and-set operations of PTSV on closed meshes.",
    source: "SOA11, sections 3.5 and 4, figure 7",
    published: "without culling \"roughly 2.2 times for the lower, and around 2.4 times for the higher resolution\"",
    run: culling,
};

/// Closed meshes: a tessellated ball, cubes on the lattice, plates, a furnished room, and a block of houses.
const CLOSED: [Setting; 5] = [
    Setting::new("builtin:fan", "builtin:fan", SMALL),
    Setting::new("builtin:lattice", "builtin:lattice", SMALL),
    Setting::new("builtin:layers", "builtin:layers", SMALL),
    ROOM,
    CITY,
];

fn culling(bench: &mut Bench<'_>) -> Result<Finding> {
    let mut rows = Vec::new();
    let mut gains = Vec::new();
    for setting in CLOSED {
        for size in [SMALL, [2048, 2048]] {
            let Some(setting) = bench.resolve(&setting.sized(size)) else { continue };
            let all = ptsv(bench, &setting, false)?;
            let culled = ptsv(bench, &setting, true)?;
            let gain = ratio(tests(&all), tests(&culled));
            gains.push(gain);
            let [width, height] = setting.size;
            rows.push(vec![
                format!("{}, {width} x {height}", setting.name),
                short(tests(&all)),
                short(tests(&culled)),
                times(gain),
                short(all.shadowed as u64),
                short(culled.shadowed as u64),
            ]);
        }
    }
    let head = [
        "test-and-set operations",
        "all faces",
        "back faces only",
        "ratio",
        "shadowed",
        "shadowed, back faces only",
    ];
    let mut body = table(&head, &rows);
    body += "\nThe ratio is what visible lit surfaces weigh against shadow outlines: they are refined to their own samples for nothing. It is larger \
             where simple shapes fill the picture (lattice), and smaller where most triangles lie in each other's shadow, so that neither facing gets far down the \
             pyramid (layers: 300 plates over one another). It grows with the resolution, as in the paper. The last two columns tell that the casters are closed: \
             the shadows are the same but for samples at their very edges.\n";
    gains.sort_by(f64::total_cmp);
    let middle = gains[gains.len() / 2];
    let (least, most) = (gains[0], gains[gains.len() - 1]);
    let ours = format!(
        "{} to {} times the operations without culling, median {}",
        times(least),
        times(most),
        times(middle)
    );
    let verdict = if (1.5..=3.5).contains(&middle) {
        if least > 1.3 && most < 5.0 { Verdict::Holds } else { Verdict::Partly }
    } else {
        Verdict::Differs
    };
    Ok(Finding { verdict, ours, body })
}
