use super::*;

fn point(value: f32, alpha: f32) -> ControlPoint {
    ControlPoint { value, rgba: [alpha, 0.0, 1.0, alpha] }
}

fn function(points: &[(f32, f32)]) -> TransferFunction {
    TransferFunction::new(points.iter().map(|&(value, alpha)| point(value, alpha)).collect()).unwrap()
}

/// Unit in the last place of 1.
const ULP: f64 = f32::EPSILON as f64;

/// The straight line in double precision.
fn line(points: &[ControlPoint], value: f32) -> [f64; 4] {
    let after = points.partition_point(|p| p.value <= value);
    let (a, b) = (points[after.saturating_sub(1)], points[after.min(points.len() - 1)]);
    let [x, low, high] = [value, a.value, b.value].map(f64::from);
    let t = if high > low { ((x - low) / (high - low)).max(0.0) } else { 0.0 };
    std::array::from_fn(|c| f64::from(a.rgba[c]) * (1.0 - t) + f64::from(b.rgba[c]) * t)
}

/// Numbers without a pattern, 0 to 1.
fn noise() -> impl FnMut() -> f32 {
    let mut state = 1_u32;
    move || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (state >> 8) as f32 / (1 << 24) as f32
    }
}

/// Colours without a pattern at these values.
fn coloured(values: impl IntoIterator<Item = f32>) -> TransferFunction {
    let mut next = noise();
    let point = |value| ControlPoint { value, rgba: std::array::from_fn(|_| next()) };
    TransferFunction::new(values.into_iter().map(point).collect()).unwrap()
}

/// The shader's result, computed from the table and the uniform that it reads.
fn by_table(f: &TransferFunction, value: f32) -> [f32; 4] {
    let (table, uniform) = (f.table(), f.search_keys());
    let texel = |i: usize, row: usize| table[row * (table.len() / TransferFunction::TABLE_ROWS) + i];
    let passed = |keys: &[f32]| keys.iter().filter(|key| value >= **key).count();
    let ends = |segment: usize| [texel(segment, 2)[0], texel(segment, 2)[1]];
    let (segment, ends) = match f.search() {
        SegmentSearch::Every { points } => {
            let key = |i: u32| uniform[i as usize / 4][i as usize % 4];
            (0..points).fold((0, [key(0); 2]), |found, i| {
                let next = [key(i), key((i + 1).min(points - 1))];
                if value >= key(i) { (i as usize + 1, next) } else { found }
            })
        }
        SegmentSearch::Guide { wide } => {
            let [first, last, per_unit, most] = uniform[0];
            let cell = ((value.clamp(first, last) - first) * per_unit).min(most) as usize;
            guided(texel(cell, 0), wide, value, ends)
        }
        SegmentSearch::Tree { levels } => {
            let at = (0..levels)
                .fold(0, |at, level| 5 * at + passed(&texel((5_usize.pow(level) - 1) / 4 + at, 0)));
            let at = at.min(SegmentSearch::TREE_END);
            (at, ends(at))
        }
    };
    let (low, high, share) = (texel(segment, 1), texel(segment + 1, 1), share_of(value, ends));
    std::array::from_fn(|c| low[c] + (high[c] - low[c]) * share)
}

/// The segment that a cell of a guide leads to, and its ends.
fn guided(
    [below, a, b, c]: [f32; 4],
    wide: bool,
    value: f32,
    ends: impl Fn(usize) -> [f32; 2],
) -> (usize, [f32; 2]) {
    let below = below as usize;
    if wide {
        let segment = below + [a, b, c].iter().filter(|key| value >= **key).count();
        return (segment, ends(segment));
    }
    if value >= b { (below + 1, [b, c]) } else { (below, [a, b]) }
}

/// Critical values of a function: its points, their neighbours, values between them and beyond.
fn telling(f: &TransferFunction) -> Vec<f32> {
    let mut values = vec![f32::MIN, f32::MAX, 0.0, -0.0, f32::MIN_POSITIVE, -f32::MIN_POSITIVE];
    for pair in f.points().windows(2) {
        let [a, b] = [pair[0].value, pair[1].value];
        values.extend([a, b, a.next_up(), a.next_down(), b.next_up(), b.next_down()]);
        let between = |t: f64| (f64::from(a) + (f64::from(b) - f64::from(a)) * t) as f32;
        values.extend([0.001, 0.25, 0.5, 0.75, 0.999].map(between));
    }
    values.retain(|v| v.is_finite() && !v.is_subnormal());
    values
}

/// Functions of every kind, with their expected search.
fn kinds() -> Vec<(&'static str, TransferFunction, SegmentSearch)> {
    let every = |points| SegmentSearch::Every { points };
    let guide = |wide| SegmentSearch::Guide { wide };
    let tree = |levels| SegmentSearch::Tree { levels };
    let even = |n: u16| (0..n).map(move |i| f32::from(i) * 65535.0 / f32::from(n - 1));
    // Each value is 1.1 times the one before. Most lie in one cell of any guide.
    let growing = |n: i32| (0..n).map(move |i| 1e-8 * 1.1_f32.powi(i));
    let crowded = |n: u16| (0..n - 1).map(|i| f32::from(i) * 1e-3).chain([65535.0]);
    vec![
        ("two", coloured([0.0, 255.0]), every(2)),
        ("one unit wide", coloured([1.0, 1.0_f32.next_up()]), every(2)),
        ("narrow peak", coloured([0.0, 290.0, 300.0, 310.0, 65535.0]), every(5)),
        ("steps", coloured([0.0, 5.0, 5.0, 9.0, 9.0, 9.0, 12.0, 12.0]), every(8)),
        ("window", coloured([-1024.0, -160.0, 240.0, 30000.0]), every(4)),
        ("all of f32", coloured([f32::MIN, -1.0, 1e-37, f32::MAX]), every(4)),
        ("all of f32, two", coloured([f32::MIN, f32::MAX]), every(2)),
        ("smallest", coloured([f32::MIN_POSITIVE, f32::MIN_POSITIVE.next_up(), 2e-38]), every(3)),
        ("small and large", coloured([-1e30, -1e-30, 0.0, 1e-30, 1.1e-30, 1e30]), every(6)),
        ("nine", coloured(even(9)), guide(false)),
        ("256", coloured(even(256)), guide(false)),
        ("4096", coloured(even(4096)), guide(false)),
        ("shifted", coloured((0..2000).map(|i| 1e6 + i as f32)), guide(false)),
        ("three by three", coloured((0..300).map(|i| (i / 3 * 5000 + i % 3) as f32)), guide(true)),
        ("24 crowded", coloured(crowded(24)), tree(2)),
        ("25 crowded", coloured(crowded(25)), tree(3)),
        ("400 growing", coloured(growing(400)), tree(4)),
        ("tiny", coloured((0..100).map(|i| f32::MIN_POSITIVE * (1.0 + i as f32))), tree(3)),
        ("huge", coloured((0..700).map(|i| (i as f32 - 350.0) * 9.7e35)), tree(5)),
        ("4096 crowded", coloured(crowded(4096)), tree(6)),
    ]
}

#[test]
fn every_function_is_its_straight_lines() {
    for (name, f, _) in kinds() {
        for value in telling(&f) {
            let (got, want) = (f.classify(value), line(f.points(), value));
            let error = got.iter().zip(want).map(|(g, w)| (f64::from(*g) - w).abs()).fold(0.0, f64::max);
            assert!(error <= 3.0 * ULP, "{name} at {value:e}: {got:?} for {want:?}");
        }
    }
}

#[test]
fn points_have_their_colour_to_the_bit_and_the_later_of_two_holds() {
    for (name, f, _) in kinds() {
        let (first, last) = (f.points()[0], f.points()[f.points().len() - 1]);
        for (i, p) in f.points().iter().enumerate() {
            if f.points().get(i + 1).is_none_or(|next| next.value > p.value) {
                assert_eq!(f.classify(p.value), p.rgba, "{name}: point {i}");
            }
        }
        assert_eq!(f.classify(f32::MIN.max(first.value.next_down())), first.rgba, "{name}");
        assert_eq!(f.classify(f32::MAX.min(last.value.next_up())), last.rgba, "{name}");
    }
    let leading = function(&[(1.0, 0.25), (1.0, 0.5), (2.0, 0.75), (2.0, 1.0)]);
    let alphas =
        [-5.0, 1.0_f32.next_down(), 1.0, 2.0_f32.next_down(), 2.0, 9.0].map(|v| leading.classify(v)[3]);
    assert!((alphas[3] - 0.75).abs() < 1e-6);
    assert_eq!([alphas[0], alphas[1], alphas[2], alphas[4], alphas[5]], [0.25, 0.25, 0.5, 1.0, 1.0]);
}

#[test]
fn the_shader_reads_what_the_cpu_computes_with() {
    for (name, f, search) in kinds() {
        assert_eq!(f.search(), search, "{name}");
        let all = telling(&f);
        // The table is large. Some hundred values of each function are enough.
        for &value in all.iter().step_by(1 + all.len() / 400) {
            assert_eq!(by_table(&f, value), f.classify(value), "{name} at {value:e}");
        }
    }
}

/// A shader may round a position in cells. The neighbouring cell leads to the same segment there.
#[test]
fn a_guide_holds_beside_the_border_of_its_cells() {
    for (name, f, search) in kinds() {
        let SegmentSearch::Guide { wide } = search else { continue };
        let (table, [first, last, per_unit, most]) = (f.table(), f.search_keys()[0]);
        for value in telling(&f) {
            let position = (value.clamp(first, last) - first) * per_unit;
            for nudged in [position - 2e-3, position + 2e-3] {
                let cell = table[nudged.clamp(0.0, most) as usize];
                let (segment, ends) = guided(cell, wide, value, |segment| f.ends(segment));
                assert_eq!(segment.min(f.points().len()), f.segment(value), "{name} at {value:e}");
                assert_eq!(ends, f.ends(segment), "{name} at {value:e}");
            }
        }
    }
}

/// 65536 labels have more steps than a function may have. Each of 2048 neighbouring labels has its own colour.
#[test]
fn labels_have_their_own_colours_and_no_neighbours() {
    for first in [0_u16, 30_000, 63_488] {
        let colour = |label: u16| {
            [f32::from(label % 7) / 7.0, f32::from(label % 11) / 11.0, 0.5, f32::from(label % 2)]
        };
        let labels = || first..=first + 2047;
        let steps = labels().flat_map(|label| {
            let half = |by: f32| f32::from(label) + by;
            [half(-0.5), half(0.5)].map(|value| ControlPoint { value, rgba: colour(label) })
        });
        let f = TransferFunction::new(steps.collect()).unwrap();
        assert_eq!(f.points().len(), TransferFunction::MAX_POINTS);
        for label in labels() {
            let value = f32::from(label);
            assert_eq!(f.classify(value), colour(label));
            assert_eq!(by_table(&f, value + 0.25), colour(label));
            let alone = ValueRange { min: value - 0.5, max: value + 0.25 };
            assert_eq!(f.is_transparent(alone), label % 2 == 0, "{label}");
        }
    }
    // One label of 65536 shows. Its neighbours do not.
    let one = function(&[
        (0.0, 0.0),
        (41_999.5, 0.0),
        (41_999.5, 1.0),
        (42_000.5, 1.0),
        (42_000.5, 0.0),
        (65_535.0, 0.0),
    ]);
    assert_eq!([41_999.0, 42_000.0, 42_001.0].map(|v| one.classify(v)[3]), [0.0, 1.0, 0.0]);
}

/// The failing twin: a table of equal entries, the former implementation.
#[test]
fn a_table_of_1024_entries_is_no_such_function() {
    let wrong = |f: &TransferFunction| {
        let domain = f.domain();
        let entry =
            |i: usize| line(f.points(), (f64::from(domain.min) + i as f64 / 1023.0 * domain.span()) as f32);
        let seen = |value: f32| {
            let at = (f64::from(value) - f64::from(domain.min)) * 1023.0 / domain.span();
            let low = at.clamp(0.0, 1023.0).floor().min(1022.0);
            let (a, b, t) = (entry(low as usize), entry(low as usize + 1), at.clamp(0.0, 1023.0) - low);
            std::array::from_fn::<f64, 4, _>(|c| a[c] + (b[c] - a[c]) * t)
        };
        let inside = telling(f).into_iter().filter(|v| *v >= domain.min && *v <= domain.max);
        let off =
            inside.map(|v| (0..4).map(|c| (seen(v)[c] - line(f.points(), v)[c]).abs()).fold(0.0, f64::max));
        off.fold(0.0, f64::max)
    };
    let peak = function(&[(0.0, 0.0), (290.0, 0.0), (300.0, 1.0), (310.0, 0.0), (65535.0, 0.0)]);
    let window = function(&[(-1024.0, 0.0), (-160.0, 0.0), (240.0, 1.0), (30000.0, 1.0)]);
    assert!(wrong(&peak) > 0.5 && wrong(&window) > 0.01, "{} {}", wrong(&peak), wrong(&window));
    assert_eq!(peak.classify(300.0)[3], 1.0);
}

#[test]
fn a_window_inside_a_wide_range_is_not_shifted() {
    let f = function(&[(-1024.0, 0.0), (-160.0, 0.0), (240.0, 1.0), (30_000.0, 1.0)]);
    for hu in -160_i16..=240 {
        let want = (f32::from(hu) + 160.0) / 400.0;
        assert!((f.classify(f32::from(hu))[3] - want).abs() <= 3.0 * f32::EPSILON, "{hu}");
    }
}

#[test]
fn what_is_transparent_shows_nothing_and_what_shows_is_not() {
    let f = function(&[(0.0, 0.0), (10.0, 0.0), (11.0, 1.0)]);
    let transparent = |min, max| f.is_transparent(ValueRange { min, max });
    assert!(transparent(-50.0, 9.9) && transparent(3.0, 3.0) && transparent(3.0, 10.0));
    assert!(!transparent(3.0, 10.0_f32.next_up()) && !transparent(10.5, 99.0) && !transparent(12.0, 13.0));
    assert!(!transparent(f32::NAN, 1.0) && !transparent(1.0, f32::NAN));
    assert!(transparent(f32::MIN, -1.0) && !transparent(f32::MIN, f32::MAX));
}

/// Most transfer functions begin at the first visible value. Air lies below.
#[test]
fn beyond_its_ends_a_function_is_what_it_is_there() {
    let window = function(&[(10.0, 0.0), (11.0, 1.0), (12.0, 0.0)]);
    let transparent = |min, max| window.is_transparent(ValueRange { min, max });
    assert!(transparent(-50.0, 9.9) && transparent(0.0, 10.0) && transparent(12.0, 900.0));
    assert!(!transparent(0.0, 10.0_f32.next_up()) && !transparent(11.99, 900.0));
    assert!(!transparent(12.0_f32.next_down(), 900.0) && !transparent(0.0, 900.0));
    let ends = function(&[(10.0, 0.5), (11.0, 0.0), (12.0, 0.5)]);
    let transparent = |min, max| ends.is_transparent(ValueRange { min, max });
    assert!(!transparent(-50.0, -20.0) && !transparent(20.0, 50.0) && !transparent(10.9, 11.1));
    assert!(transparent(11.0, 11.0));
}

/// A range is transparent exactly if every value in it is. Tested with few values.
#[test]
fn transparency_is_that_of_every_value() {
    let mut next = noise();
    for _ in 0..200 {
        let mut values: Vec<f32> =
            (0..2 + (next() * 10.0) as usize).map(|_| (next() * 12.0).floor()).collect();
        values.push(12.0);
        values.push(-1.0);
        values.sort_by(f32::total_cmp);
        let points: Vec<_> =
            values.iter().map(|&value| point(value, if next() < 0.7 { 0.0 } else { 0.5 })).collect();
        let f = TransferFunction::new(points).unwrap();
        let at = |i: i32| i as f32 / 4.0 - 2.0;
        for (first, last) in (0..64).flat_map(|first| (first..64).map(move |last| (first, last))) {
            let every = (first..=last).all(|i| f.classify(at(i))[3] <= 0.0);
            let range = ValueRange { min: at(first), max: at(last) };
            assert_eq!(f.is_transparent(range), every, "{range:?} of {:?}", f.points());
        }
    }
}

#[test]
fn a_subnormal_value_is_zero() {
    let f = function(&[(-1.0, 0.0), (1e-40, 1.0), (1.0, 1.0)]);
    assert_eq!(f.points()[1].value, 0.0);
    let step = function(&[(-1.0, 1.0), (0.0, 1.0), (f32::MIN_POSITIVE, 0.0), (1.0, 0.0)]);
    assert!(!step.is_transparent(ValueRange { min: 1e-40, max: 1.0 }));
}

#[test]
fn refuses_what_is_no_function() {
    let refused = |points| TransferFunction::new(points).unwrap_err();
    assert_eq!(refused(vec![point(1.0, 0.0)]), TransferFunctionError::TooFew(1));
    assert_eq!(refused(vec![point(1.0, 0.0), point(0.0, 1.0)]), TransferFunctionError::Order(2));
    assert_eq!(refused(vec![point(1.0, 0.0), point(1.0, 1.0)]), TransferFunctionError::Flat);
    assert_eq!(refused(vec![point(1e-40, 0.0), point(2e-40, 1.0)]), TransferFunctionError::Flat);
    let many = refused((0..=4096).map(|i| point(i as f32, 0.0)).collect());
    assert_eq!(many.to_string(), "a transfer function has at most 4096 control points, this has 4097");
}
