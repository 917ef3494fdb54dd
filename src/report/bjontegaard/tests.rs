//! Against SciPy and another program (`reference.py`), and cases without a difference.

use super::*;

#[derive(serde::Deserialize)]
struct Reference {
    interpolants: Vec<Interpolant>,
    differences: Vec<Difference>,
}

#[derive(serde::Deserialize)]
struct Interpolant {
    knots: Vec<(f64, f64)>,
    values: Vec<(f64, f64)>,
    integral: [f64; 3],
}

#[derive(serde::Deserialize)]
struct Difference {
    anchor: Vec<(f64, f64)>,
    test: Vec<(f64, f64)>,
    decibels: f64,
    percent: f64,
}

fn reference() -> Reference {
    serde_json::from_str(include_str!("reference.json")).unwrap()
}

/// Largest difference to SciPy over all values and integrals.
fn largest_error(of: impl Fn(&[(f64, f64)]) -> Option<Pchip>) -> f64 {
    let mut largest: f64 = 0.0;
    for Interpolant { knots, values, integral: [low, high, expected] } in reference().interpolants {
        let pchip = of(&knots).unwrap();
        for (x, y) in values {
            largest = largest.max((pchip.at(x) - y).abs());
        }
        largest = largest.max((pchip.integral(low, high) - expected).abs());
    }
    largest
}

#[test]
fn values_and_integrals_are_those_of_scipy() {
    assert!(largest_error(Pchip::new) < 1e-9, "{}", largest_error(Pchip::new));
    // A knot that lies a thousandth elsewhere is noticed.
    let moved = |knots: &[(f64, f64)]| {
        let mut knots = knots.to_vec();
        knots[1].1 += 1e-3;
        Pchip::new(&knots)
    };
    assert!(largest_error(moved) > 1e-4);
}

#[test]
fn it_never_leaves_the_range_of_its_knots_and_refuses_what_is_no_function() {
    for Interpolant { knots, .. } in reference().interpolants {
        let pchip = Pchip::new(&knots).unwrap();
        for pair in knots.windows(2) {
            let (low, high) = (pair[0].1.min(pair[1].1), pair[0].1.max(pair[1].1));
            for i in 0..=20 {
                let y = pchip.at(pair[0].0 + (pair[1].0 - pair[0].0) * f64::from(i) / 20.0);
                assert!(low - 1e-12 <= y && y <= high + 1e-12, "{y} outside {low} to {high}");
            }
        }
    }
    let nan = [(0.0, 0.0), (1.0, f64::NAN)];
    for knots in [&[][..], &[(0.0, 1.0)], &[(1.0, 0.0), (0.0, 1.0)], &[(0.0, 0.0), (0.0, 1.0)], &nan] {
        assert_eq!(Pchip::new(knots), None, "{knots:?}");
    }
}

#[test]
fn differences_are_those_of_the_reference() {
    for Difference { anchor, test, decibels: expected, percent: larger } in reference().differences {
        let (anchor, test) = (Curve::of(anchor), Curve::of(test));
        assert!((decibels(&anchor, &test).unwrap() - expected).abs() < 1e-9);
        assert!((percent(log_rate(&anchor, &test).unwrap()) - larger).abs() < 1e-7);
        // The other way round the sign turns, and the ratio with it: means of this kind take no sides.
        assert!((decibels(&test, &anchor).unwrap() + expected).abs() < 1e-9);
        assert_eq!(decibels(&anchor, &anchor), Ok(0.0));
        assert!(expected.abs() > 0.1 && larger.abs() > 1.0, "numbers that a mistake would move");
    }
}

fn line(rates: &[f64], at_one: f64) -> Curve {
    Curve::of(rates.iter().map(|r| (*r, at_one + 20.0 * r.log10())))
}

#[test]
fn a_shifted_line_is_told_exactly() {
    let rates = [0.5, 1.0, 2.0, 4.0];
    let (anchor, test) = (line(&rates, 40.0), line(&rates, 42.0));
    assert!((decibels(&anchor, &test).unwrap() - 2.0).abs() < 1e-12);
    // 2 dB at 20 dB per decade are a tenth of a decade.
    assert!((log_rate(&anchor, &test).unwrap() + 0.1).abs() < 1e-12);
    assert!((percent(-0.1) + 20.567).abs() < 1e-3);
}

#[test]
fn too_few_points_and_too_little_in_common_are_refused() {
    let rates = [0.5, 1.0, 2.0, 4.0];
    let anchor = line(&rates, 40.0);
    assert_eq!(decibels(&anchor, &line(&rates[..3], 42.0)), Err(Refused::Few(3)));
    // Rates in common, qualities far apart: one of the two differences is defined.
    let better = line(&rates, 90.0);
    assert!((decibels(&anchor, &better).unwrap() - 50.0).abs() < 1e-12);
    assert_eq!(log_rate(&anchor, &better), Err(Refused::Apart(0.0)));
    // Of three octaves each, an overlap of one and a half is just enough.
    let shifted = |by: f64| line(&rates.map(|r| r * by), 40.0);
    assert!(decibels(&anchor, &shifted(2f64.powf(1.499))).is_ok());
    let Err(Refused::Apart(share)) = decibels(&anchor, &shifted(2f64.powf(1.501))) else {
        panic!("not refused")
    };
    assert!((0.49..0.5).contains(&share), "{share}");
}

#[test]
fn only_what_nothing_beats_is_on_a_curve() {
    let points = [
        (1.0, 30.0),
        (1.1, 29.0),
        (2.0, 35.0),
        (2.0, 36.0),
        (4.0, f64::INFINITY),
        (0.0, 50.0),
        (3.0, f64::NAN),
    ];
    assert_eq!(Curve::of(points), Curve::of([(2.0, 36.0), (1.0, 30.0)]));
    assert_eq!(Curve::of(points).points(), 2);
}
