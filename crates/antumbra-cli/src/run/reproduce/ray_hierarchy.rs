//! What OA11 says about the nodes that its variants visit.

use anyhow::Result;

use super::bench::{Bench, Setting, counter};
use super::markdown::{grouped, ratio, short, table, times};
use super::settings::{CITY, FOREST, HAIR, MUSEUM, MUSEUM_FINE, ROBOTS, ROOM, SPONZA};
use super::{Finding, Section, Verdict};

const VARIANTS: [&str; 7] = [
    "rh-spheres",
    "rh-spheres-sorted",
    "rh-precise",
    "rh-precise-sorted",
    "rh-precise-sea",
    "rh-precise-eatp",
    "rh-precise-seatp",
];

/// Moments of the robots' 50 s.
const MOMENTS: [f32; 7] = [2.0, 6.25, 10.0, 18.0, 25.0, 30.0, 40.0];

/// Moments of the museum's 6 s.
const VIEWS: [f32; 4] = [0.5, 2.0, 3.5, 5.0];

fn robots(bench: &mut Bench<'_>) -> Vec<Setting> {
    MOMENTS.iter().filter_map(|&t| bench.resolve(&ROBOTS.at(t))).collect()
}

fn moment(setting: &Setting) -> String {
    let [width, height] = setting.size;
    match setting.time {
        Some(t) => format!("{}, {t} s", setting.name),
        None => format!("{}, {width} x {height}", setting.name),
    }
}

fn visits(bench: &mut Bench<'_>, setting: &Setting, variant: &str) -> Result<u64> {
    Ok(counter(&bench.count(setting, variant)?, "node_visits"))
}

/// Node visits of all `variants` in all `settings`.
fn all_visits(bench: &mut Bench<'_>, settings: &[Setting], variants: &[&str]) -> Result<Vec<Vec<u64>>> {
    settings.iter().map(|s| variants.iter().map(|v| visits(bench, s, v)).collect()).collect()
}

fn visit_table(settings: &[Setting], variants: &[&str], counts: &[Vec<u64>]) -> String {
    let mut head = vec!["node visits"];
    head.extend(variants);
    let rows: Vec<Vec<String>> = settings
        .iter()
        .zip(counts)
        .map(|(s, counts)| std::iter::once(moment(s)).chain(counts.iter().map(|&n| short(n))).collect())
        .collect();
    table(&head, &rows)
}

/// Smallest and largest of a column.
fn range(counts: &[Vec<u64>], column: usize) -> [u64; 2] {
    let values = counts.iter().map(|row| row[column]);
    [values.clone().min().unwrap_or(0), values.max().unwrap_or(0)]
}

pub(super) const FRAMES: Section = Section {
    key: "frames",
    title: "Nodes per frame, robots",
    claim: "In the BART robots at 1024 x 1024 every improvement lowers the number of nodes processed, frame by frame.",
    source: "OA11, section 5, figure 6(a)",
    published: "in the text: close to 50 M for both sphere variants where the camera faces a wall (frame 160), a couple of hundred for the \
                precise ones there; the figure's axis cannot be read from the text",
    run: frames,
};

fn frames(bench: &mut Bench<'_>) -> Result<Finding> {
    let settings = robots(bench);
    let counts = all_visits(bench, &settings, &VARIANTS)?;
    let place = bench.place(&settings[0])?;
    let [low, high] = range(&counts, 0);
    let [sorted_low, sorted_high] = range(&counts, 1);
    let [best_low, best_high] = range(&counts, 6);
    // Within an order of magnitude of the one number that the text gives.
    let in_range =
        (5_000_000..=500_000_000).contains(&high) && (5_000_000..=500_000_000).contains(&sorted_high);
    let few = counts.iter().any(|row| row[2] < 1_000);
    let least = counts.iter().flatten().min().copied().unwrap_or(0);
    let mut body = visit_table(&settings, &VARIANTS, &counts);
    body += &format!(
        "\n{} triangles, {} samples. The file's camera; moments of its 50 s, as the paper does not say how its frames are spread over them.\n\n\
         Where the numbers differ, and why:\n\n\
         - *No frame gets by with a couple of hundred nodes.* Every triangle is tested against the (at most four) children of the root before anything \
         can be rejected: {} tests, of the {} of the least frame here. The paper's count must leave this pass 0 out.\n\
         - *Facing.* The paper culls triangles that face the light (section 3.6). Without that, every lit surface meets its own rays all the way to \
         the leaves, which is most of what is left in the sorted frames. Culling changes the casters of open meshes, so it is off here.\n\
         - *Light.* It is at 0,45,100: the file's own stands over the sky and leaves whole frames dark.\n",
        grouped(place.triangles as u64),
        grouped(place.samples as u64),
        short(4 * place.triangles as u64),
        short(least),
    );
    let ours = format!(
        "rh-spheres {} to {}, rh-spheres-sorted {} to {}, rh-precise-seatp {} to {}",
        short(low),
        short(high),
        short(sorted_low),
        short(sorted_high),
        short(best_low),
        short(best_high)
    );
    let verdict = match (in_range, few) {
        (true, true) => Verdict::Holds,
        (true, false) => Verdict::Partly,
        _ => Verdict::Differs,
    };
    Ok(Finding { verdict, ours, body })
}

pub(super) const SORTING: Section = Section {
    key: "sorting",
    title: "Sorting rays",
    claim: "Sorting the rays by direction gives up to orders of magnitude fewer node visits where depth is discontinuous, and little where the \
            picture is coherent.",
    source: "OA11, section 5, table 2; section 6",
    published: "museum (75,948 triangles), four views: Spheres 19.89, 317.91, 5.77, 2199.22 M nodes against 2.66, 6.79, 5.40, 6.60 M sorted; Precise \
                17.58, 292.84, 2.25, 2163.30 M against 0.82, 2.24, 2.20, 1.97 M: 1.02 to 1098 times fewer",
    run: sorting,
};

fn sorting(bench: &mut Bench<'_>) -> Result<Finding> {
    let mut settings = Vec::new();
    for museum in [MUSEUM, MUSEUM_FINE] {
        settings.extend(VIEWS.iter().filter_map(|&t| bench.resolve(&museum.at(t))));
    }
    let others = [ROOM, CITY, FOREST, HAIR, HAIR.sized([2048, 2048])];
    settings.extend(others.iter().filter_map(|s| bench.resolve(s)));
    settings.extend(robots(bench));
    let counts = all_visits(bench, &settings, &VARIANTS[..4])?;
    let rows: Vec<Vec<String>> = settings
        .iter()
        .zip(&counts)
        .map(|(s, c)| {
            let mut row = vec![moment(s)];
            row.extend(c.iter().map(|&n| short(n)));
            row.extend([times(ratio(c[0], c[1])), times(ratio(c[2], c[3]))]);
            row
        })
        .collect();
    let head = [
        "node visits",
        "spheres",
        "spheres, sorted",
        "precise",
        "precise, sorted",
        "gain, spheres",
        "gain, precise",
    ];
    let mut body = table(&head, &rows);
    let fewer = counts.iter().all(|c| c[1] <= c[0] && c[3] <= c[2]);
    let gains = counts.iter().flat_map(|c| [ratio(c[0], c[1]), ratio(c[2], c[3])]);
    let (least, most) = gains.fold((f64::INFINITY, 0.0), |(l, m), g| (g.min(l), g.max(m)));
    body += "\nThe gain belongs to the view: how many of its 2 x 2 quads lie across depth edges. The paper's four views of the museum are not published, so its \
             range is to be compared, not its columns. It grows with what lies across such edges: with finer moving triangles (the fine museum), with \
             thin hairs before a wall, and with the resolution there, because wide cones near the leaves are met by every triangle anew. It is \
             nothing where the camera faces a wall (robots, 30 s), as the paper finds at its frame 160. What keeps our largest gain below the paper's: front faces \
             are not culled here, so sorted frames, too, have every lit surface meet its own rays; those are most of their visits.\n\n\
             Spheres gain less than the precise test, as in the paper: large triangles visit everything near them however the rays are sorted.\n";
    let ours = format!("{} to {} times fewer", times(least), times(most));
    let verdict = match (fewer, most >= 10.0) {
        (true, true) => Verdict::Holds,
        (true, false) => Verdict::Partly,
        _ => Verdict::Differs,
    };
    Ok(Finding { verdict, ours, body })
}

pub(super) const PRECISE: Section = Section {
    key: "precise",
    title: "Precise cones",
    claim: "The precise cone test visits fewer nodes than bounding spheres, most so with large triangles.",
    source: "OA11, sections 3.2 and 5, figure 6(a)",
    published: "always fewer; most where large triangles align with the light (a couple of hundred against 50 M); museum, small triangles: 1.02 to 3.4 \
                times fewer (table 2, computed from its numbers)",
    run: precise,
};

fn precise(bench: &mut Bench<'_>) -> Result<Finding> {
    let mut settings = robots(bench);
    settings.extend(
        [MUSEUM.at(2.0), SPONZA.sized([1024, 1024]), ROOM, CITY].iter().filter_map(|s| bench.resolve(s)),
    );
    let counts = all_visits(bench, &settings, &VARIANTS[..4])?;
    let rows: Vec<Vec<String>> = settings
        .iter()
        .zip(&counts)
        .map(|(s, c)| {
            vec![
                moment(s),
                short(c[0]),
                short(c[2]),
                times(ratio(c[0], c[2])),
                short(c[1]),
                short(c[3]),
                times(ratio(c[1], c[3])),
            ]
        })
        .collect();
    let head =
        ["node visits", "spheres", "precise", "gain", "spheres, sorted", "precise, sorted", "gain, sorted"];
    let body = format!(
        "{}\nThe gain is larger with sorted rays, as the paper observes: a narrow cone can tell a triangle from its sphere, a wide one cannot.\n",
        table(&head, &rows)
    );
    let fewer = counts.iter().all(|c| c[2] <= c[0] && c[3] <= c[1]);
    let gains = counts.iter().flat_map(|c| [ratio(c[0], c[2]), ratio(c[1], c[3])]);
    let (least, most) = gains.fold((f64::INFINITY, 0.0), |(l, m), g| (g.min(l), g.max(m)));
    let ours = format!("{} to {} times fewer", times(least), times(most));
    Ok(Finding { verdict: Verdict::of(fewer), ours, body })
}

pub(super) const EARLY: Section = Section {
    key: "early-accept",
    title: "Early accept and two passes",
    claim: "Early accept (SEA) visits fewer nodes than sorting alone, and two passes (SEATP) fewer still.",
    source: "OA11, section 5, figure 7",
    published: "\"the number of nodes culled is steadily improved with each new optimization\"; no number in the text",
    run: early,
};

fn early(bench: &mut Bench<'_>) -> Result<Finding> {
    let mut settings = robots(bench);
    settings.extend([SPONZA, ROOM, CITY].iter().filter_map(|s| bench.resolve(s)));
    let columns = [VARIANTS[3], VARIANTS[4], VARIANTS[6]];
    let counts = all_visits(bench, &settings, &columns)?;
    let mut body = visit_table(&settings, &columns, &counts);
    let sea = counts.iter().filter(|c| c[1] < c[0]).count();
    let seatp = counts.iter().filter(|c| c[2] < c[1]).count();
    let n = counts.len();
    body += "\nTwo passes gain where large triangles shadow much of the picture. Where pass 1 shadows less than 15 % of the rays the tree is not \
             rebuilt, and the order of the triangles is all that changed: then the counts of SEA and SEATP are equal but for what threads see of one \
             another's dead nodes, a few in a thousand either way.\n";
    let total = |k: usize| counts.iter().map(|c| c[k]).sum::<u64>();
    let ours = format!(
        "SEA fewer in {sea} of {n} frames, SEATP fewer than SEA in {seatp} of {n}; all frames together {}, {}, {}",
        short(total(0)),
        short(total(1)),
        short(total(2))
    );
    // A count that threads may move by a few thousandths is not a regression.
    let close = counts.iter().all(|c| c[1] <= c[0] && c[2] as f64 <= c[1] as f64 * 1.01);
    let verdict = if sea == n && seatp == n {
        Verdict::Holds
    } else if close && total(2) < total(1) && total(1) < total(0) {
        Verdict::Partly
    } else {
        Verdict::Differs
    };
    Ok(Finding { verdict, ours, body })
}
