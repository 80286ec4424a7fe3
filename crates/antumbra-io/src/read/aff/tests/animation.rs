//! Motion.

use super::*;

/// Position of the first corner at `time`.
fn corner(file: &AffFile, time: f32) -> [f32; 3] {
    file.at(Some(time)).unwrap().soup.positions[0][0]
}

#[test]
fn translations_run_through_their_inner_keys() {
    let file = file(&format!(
        "x ball {{ {TRIANGLE} }} a 0 1 10
         k ball {{ transl 5  -0.5 0 -3 0 0 0 0  0 0 0 0 0 0 0  .5 0 1 0 0 0 0  1 0 0 0 0 0 0  1.5 0 -3 0 0 0 0 }}"
    ));
    assert_eq!(file.time_span(), Some([0.0, 1.0]));
    assert_near(corner(&file, 0.0), [0.0; 3]);
    assert_near(corner(&file, 0.5), [0.0, 1.0, 0.0]);
    assert_near(corner(&file, 1.0), [0.0; 3]);
    // Tangents 2 and 0 at equal steps: the Hermite cubic at one half is 0.5 + 2 / 8.
    assert_near(corner(&file, 0.25), [0.0, 0.75, 0.0]);
    for outside in [-9.0, 9.0, f32::NAN, f32::INFINITY] {
        assert_near(corner(&file, outside), [0.0; 3]);
    }
}

#[test]
fn tension_continuity_and_bias_bend_the_curve() {
    let at_half = |tcb: &str| {
        let keys = format!("0 0 0 0 0 0 0  1 1 0 0 {tcb}  2 5 0 0 0 0 0  3 5 0 0 0 0 0");
        corner(&file(&format!("x a {{ {TRIANGLE} }} a 0 3 4 k a {{ transl 4 {keys} }}")), 1.5)[0]
    };
    // The arriving tangent is (4 + 0) / 2; leaving ones are by equation 9 of Kochanek and Bartels, steps 1 and 4.
    for (tcb, leaving) in [("0 0 0", 2.5), ("1 0 0", 0.0), ("0 1 0", 1.0), ("0 0 1", 1.0), ("0 0 -1", 4.0)] {
        let expected = 3.0 + (leaving - 2.0) / 8.0;
        assert!((at_half(tcb) - expected).abs() < 1e-5, "{tcb}: {} instead of {expected}", at_half(tcb));
    }
}

#[test]
fn rotations_turn_evenly_and_more_than_once() {
    let file = file(&format!(
        "x a {{ xs 1 1 1 1 0 0 0 1 0 0 {{ {TRIANGLE} }} }}
         k a {{ rot 7  0 0 0 2 0 0 0 0  1 0 0 2 90 0 0 0  2 0 0 2 180 0 0 0  3 0 0 2 270 0 0 0
                4 0 0 2 360 0 0 0  5 0 0 2 450 0 0 0  6 0 0 2 540 0 0 0 }}"
    ));
    assert_eq!(file.time_span(), Some([1.0, 5.0]));
    for step in 0..=16 {
        let time = 1.0 + 0.25 * step as f32;
        let angle = time * std::f32::consts::FRAC_PI_2;
        assert_near(corner(&file, time), [angle.cos(), angle.sin(), 0.0]);
    }
}

#[test]
fn scales_come_first_and_the_last_keys_of_a_name_count() {
    let keys = |s: f32| (0..4).map(|t| format!(" {t} {s} 1 1 0 0 0")).collect::<String>();
    let turn = (0..4).map(|t| format!(" {t} 0 0 1 90 0 0 0")).collect::<String>();
    let text = format!(
        "x a {{ {TRIANGLE} }} k a {{ scale 4 {} }} k a {{ scale 4 {} rot 4 {turn} }}",
        keys(7.0),
        keys(3.0)
    );
    assert_near(file(&text).at(None).unwrap().soup.positions[0][1], [0.0, 3.0, 0.0]);
}

#[test]
fn hidden_transforms_have_no_triangles() {
    let file =
        file(&format!("{TRIANGLE} x a {{ x b {{ {TRIANGLE} }} }} a 0 3 4 k a {{ visibility 2  1 0  2 1 }}"));
    let counts = [0.5, 1.0, 1.9, 2.0].map(|t| file.at(Some(t)).unwrap().soup.len());
    assert_eq!(counts, [2, 1, 1, 2]);
}

#[test]
fn animated_triangles_move_straight() {
    let file = file(
        "a -1 3 9
         tpa 2  0  0 0 0 0 0 1  1 0 0 0 0 1  0 1 0 0 0 1
                2  4 0 0 0 1 0  5 0 0 0 1 0  4 1 0 0 1 0",
    );
    assert_eq!(file.time_span(), Some([-1.0, 3.0]));
    assert_eq!(file.at(None).unwrap().soup.positions[0][0], [0.0; 3]);
    assert_near(corner(&file, 0.5), [1.0, 0.0, 0.0]);
    assert_near(corner(&file, 9.0), [4.0, 0.0, 0.0]);
    let half = 0.5_f32.sqrt();
    assert_near(file.at(Some(1.0)).unwrap().soup.normals[0][0], [0.0, half, half]);
}

#[test]
fn the_camera_flies() {
    let file = file(
        "v from 0 0 10 at 0 0 0 up 0 1 0 angle 40 hither 1 resolution 8 6 a 0 3 4
         k camera { transl 4 0 1 2 3 0 0 0  1 1 2 3 0 0 0  2 1 2 3 0 0 0  3 1 2 3 0 0 0
                    rot 4 0 0 1 0 90 0 0 0  1 0 1 0 90 0 0 0  2 0 1 0 90 0 0 0  3 0 1 0 90 0 0 0 }",
    );
    let camera = &file.at(None).unwrap().cameras[0];
    assert_near(camera.eye, [1.0, 2.0, 3.0]);
    assert_near(camera.target, [-9.0, 2.0, 3.0]);
    assert_near(camera.up, [0.0, 1.0, 0.0]);
}

#[test]
fn named_lights_fly() {
    let file = file(
        "la lamp 9 9 9  1 1 1  l 0 0 0
         k lamp { transl 4  0 0 0 0 0 0 0  1 1 0 0 0 0 0  2 2 0 0 0 0 0  3 3 0 0 0 0 0 }",
    );
    assert_eq!(file.time_span(), Some([1.0, 2.0]));
    assert_near(file.at(Some(1.5)).unwrap().lights[0].position, [1.5, 0.0, 0.0]);
    assert_near(file.at(Some(1.5)).unwrap().lights[1].position, [0.0; 3]);
}

#[test]
fn nothing_moves_without_keys() {
    let file = file(&format!("x a {{ {TRIANGLE} }} a 0 3 4"));
    assert_eq!(file.time_span(), None);
    assert_eq!(file.at(Some(1.0)).unwrap().soup.len(), 1);
}

#[test]
fn keys_may_run_backwards() {
    // As in the first robot: the later keys are never reached.
    let file = file(&format!(
        "x a {{ {TRIANGLE} }} a 0 9 4
         k a {{ transl 6 0 0 0 0 0 0 0  1 1 0 0 0 0 0  4 4 0 0 0 0 0  2 9 0 0 0 0 0  3 9 0 0 0 0 0  5 9 0 0 0 0 0 }}"
    ));
    for time in [0.0, 1.0, 1.5, 2.5, 3.0, 4.0, 9.0] {
        assert!(corner(&file, time)[0].is_finite());
    }
    assert_near(corner(&file, 1.0), [1.0, 0.0, 0.0]);
    assert_near(corner(&file, 9.0), [9.0, 0.0, 0.0]);
}
