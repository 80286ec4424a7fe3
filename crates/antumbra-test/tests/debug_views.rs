//! The debug views of every method: one number a sample, none where there is no sample, and what some must agree on.

use antumbra::mask::{NONE, SHADOWED};
use antumbra::methods::{CATALOGUE, Method, Options, Samples, create};
use antumbra::scene::Triangle;
use antumbra_test::Case;

fn made(name: &str) -> Box<dyn Method> {
    create(name, &Options::default()).expect("in the catalogue")
}

fn draw(
    method: &mut dyn Method,
    view: &str,
    triangles: &[Triangle],
    samples: Samples<'_>,
    light: [f32; 3],
) -> Vec<f32> {
    let numbers = method.debug_view(view, triangles, samples, light).expect("good input");
    numbers.unwrap_or_else(|| panic!("{} has a view {view}", method.name()))
}

/// Pictures with background, samples in no order without a camera, one at the light itself, none at all, no casters.
#[test]
fn every_view_has_one_number_a_sample_and_nan_exactly_where_there_is_none() {
    let case = Case::builtin("single", [61, 43]);
    let (triangles, light) = (&case.triangles[..], case.light);
    let picture = case.samples.view();
    assert!(
        picture.positions.iter().any(|p| p[0].is_nan()) && !picture.positions.iter().all(|p| p[0].is_nan())
    );
    let mut odd = picture.positions.to_vec();
    odd.reverse();
    odd[70] = light;
    odd[71] = [1.0, f32::NAN, 2.0];
    let asked = [
        picture,
        Samples { positions: &odd, ..picture },
        Samples::list(&odd),
        Samples::list(&odd[..50]),
        Samples::list(&[]),
    ];
    for info in CATALOGUE {
        let mut method = made(info.name);
        let views = method.debug_views();
        assert!(!views.is_empty(), "{}: issue B asks for a picture of every method", info.name);
        for (i, view) in views.iter().enumerate() {
            let named = format!("{} {}", info.name, view.name);
            assert!(!view.shows.is_empty() && view.name != "list", "{named}");
            assert!(views[..i].iter().all(|other| other.name != view.name), "{named} is there twice");
            for samples in asked {
                for triangles in [triangles, &[]] {
                    let numbers = draw(method.as_mut(), view.name, triangles, samples, light);
                    assert_eq!(numbers.len(), samples.positions.len(), "{named}");
                    for (number, p) in numbers.iter().zip(samples.positions) {
                        assert_eq!(number.is_nan(), p.iter().any(|v| v.is_nan()), "{named} at {p:?}");
                        assert!(
                            number.is_nan() || (*number >= 0.0 && number.is_finite()),
                            "{named} at {p:?}"
                        );
                    }
                }
            }
            let bad = [[[0.0, f32::NAN, 0.0]; 3]];
            assert!(method.debug_view(view.name, &bad, picture, light).is_err(), "{named}");
        }
        assert_eq!(method.debug_view("no such view", triangles, picture, light), Ok(None), "{}", info.name);
        // Drawing leaves nothing behind.
        let mut mask = vec![77; case.expected.len()];
        method.shadow(triangles, picture, light, &mut mask).expect("good input");
        if info.exact {
            assert_eq!(mask, case.expected, "{}", info.name);
        }
    }
}

#[test]
fn views_of_different_methods_agree_on_what_they_count() {
    for spec in ["lattice", "room"] {
        let case = Case::builtin(spec, [64, 40]);
        let (triangles, samples, light) = (&case.triangles[..], case.samples.view(), case.light);
        let view = |method: &str, view: &str| draw(made(method).as_mut(), view, triangles, samples, light);
        // The definition, and the volumes counted along eye rays.
        let blockers = view("oracle", "blockers");
        for method in ["cssv", "zpass"] {
            let volumes = view(method, "volumes");
            assert!(
                (0..blockers.len())
                    .all(|i| blockers[i].to_bits() == volumes[i].to_bits() || volumes[i].is_nan())
            );
        }
        // Numbers that are 0 exactly where a sample is lit.
        let levels = [view("ptsv", "level"), view("cptsv", "level"), view("dpsv-hybrid", "depth"), blockers];
        for numbers in levels {
            for (number, m) in numbers.iter().zip(&case.expected) {
                assert!(
                    if *m == NONE { number.is_nan() } else { (*number > 0.0) == (*m == SHADOWED) },
                    "{spec}"
                );
            }
        }
        for method in ["cube-map", "dual-paraboloid"] {
            let mut mask = vec![77; case.expected.len()];
            made(method).shadow(triangles, samples, light, &mut mask).expect("good input");
            let errors = view(method, "errors");
            assert!(errors.iter().any(|v| *v > 0.0), "{method} is never wrong on {spec}: nothing was tested");
            for (i, (number, truth)) in errors.iter().zip(&case.expected).enumerate() {
                let class = match (mask[i], *truth) {
                    (_, NONE) => continue,
                    (m, truth) if m == truth => 0.0,
                    (_, SHADOWED) => 1.0,
                    _ => 2.0,
                };
                assert_eq!(*number, class, "{method} {spec} sample {i}");
            }
        }
        // A tile of 8 x 8 pixels is one packet, or its parts.
        let packets = view("ray-cast", "packet");
        assert!(packets.iter().all(|n| n.is_nan() || (1.0..=64.0).contains(n)));
        assert!(packets.contains(&64.0) && packets.iter().any(|n| *n < 64.0), "{spec}");
    }
}
