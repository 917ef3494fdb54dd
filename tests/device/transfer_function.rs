//! Transfer functions on the device: exact colours, for segments of any width, with every search.

use cvr_core::codec::{Decoder, Site};
use cvr_core::render::{
    Camera, ControlPoint, Filter, Image, Projection, Renderer as _, SegmentSearch, TransferFunction, View,
};
use cvr_core::volume::SampleType;
use cvr_engine::testing::test_device;
use cvr_engine::{Device, Drawing};
use cvr_raycasting::Raycasting;
use cvr_slicing::Slicing;

use super::former_table::with_table;
use super::scenes::{draw_by, mirror, mirror_by, rule, source};
use super::subjects::{codec, encoded, hash, settings, volume};

/// Voxels along x and z. Every value fills a column along y, the camera's direction.
const SIDE: u32 = 24;
const DEPTH: u32 = 4;

/// Opaque colours without a pattern at these values.
fn opaque(values: impl IntoIterator<Item = f32>) -> TransferFunction {
    let colour = |i: usize| [0, 1, 2].map(|c| (hash([i as u32, c, 7]) >> 8) as f32 / (1 << 24) as f32);
    let point = |(i, value): (usize, f32)| {
        let [r, g, b] = colour(i);
        ControlPoint { value, rgba: [r, g, b, 1.0] }
    };
    TransferFunction::new(values.into_iter().enumerate().map(point).collect()).unwrap()
}

/// Functions of every search, and of every depth of it.
fn kinds() -> Vec<(&'static str, SegmentSearch, TransferFunction)> {
    let every = |points| SegmentSearch::Every { points };
    let guide = |wide| SegmentSearch::Guide { wide };
    let tree = |levels| SegmentSearch::Tree { levels };
    let crowded = |n: u16| (0..n - 1).map(|i| f32::from(i) * 1e-3).chain([65535.0]);
    let labels = (0..2048).flat_map(|label| [label as f32 - 0.5, label as f32 + 0.5]);
    vec![
        ("two", every(2), opaque([0.0, 255.0])),
        ("narrow peak", every(5), opaque([0.0, 290.0, 300.0, 310.0, 65535.0])),
        ("window", every(4), opaque([-1024.0, -160.0, 240.0, 30000.0])),
        ("steps", every(8), opaque([0.0, 5.0, 5.0, 9.0, 9.0, 9.0, 12.0, 12.0])),
        ("all of f32", every(4), opaque([f32::MIN, -1.0, 1e-37, f32::MAX])),
        ("smallest", every(3), opaque([f32::MIN_POSITIVE, f32::MIN_POSITIVE.next_up(), 2e-38])),
        ("small and large", every(6), opaque([-1e30, -1e-30, 0.0, 1e-30, 1.1e-30, 1e30])),
        ("labels", guide(true), labels_of(labels)),
        ("256", guide(false), opaque((0..256).map(|i| i as f32 * 257.0))),
        ("three by three", guide(true), opaque((0..300).map(|i| (i / 3 * 5000 + i % 3) as f32))),
        ("24 crowded", tree(2), opaque(crowded(24))),
        ("25 crowded", tree(3), opaque(crowded(25))),
        ("growing", tree(4), opaque((0..400).map(|i| 1e-8 * 1.1_f32.powi(i)))),
        ("huge", tree(5), opaque((0..700).map(|i| (i as f32 - 350.0) * 9.7e35))),
        ("4096 crowded", tree(6), opaque(crowded(4096))),
    ]
}

/// Both points of a label have its colour.
fn labels_of(values: impl IntoIterator<Item = f32>) -> TransferFunction {
    let mut points = opaque(values).points().to_vec();
    for pair in points.chunks_mut(2) {
        pair[1].rgba = pair[0].rgba;
    }
    TransferFunction::new(points).unwrap()
}

/// Values at points, next to them, between them and beyond them. There is one for each column.
fn telling(f: &TransferFunction) -> Vec<f32> {
    let points = f.points();
    let mut values = vec![f32::MIN, f32::MAX, 0.0];
    let columns = (SIDE * SIDE) as usize;
    for pair in points.windows(2).step_by(1 + 8 * points.len() / columns) {
        let [a, b] = [pair[0].value, pair[1].value];
        values.extend([a, b, a.next_up(), b.next_down()]);
        let between = |t: f64| (f64::from(a) + (f64::from(b) - f64::from(a)) * t) as f32;
        values.extend([0.01, 0.5, 0.9].map(between));
    }
    values.retain(|v| v.is_finite() && !v.is_subnormal());
    values.truncate(columns);
    values
}

/// The straight line, in double precision.
fn line(f: &TransferFunction, value: f32) -> [f64; 3] {
    let points = f.points();
    let after = points.partition_point(|p| p.value <= value);
    let (a, b) = (points[after.saturating_sub(1)], points[after.min(points.len() - 1)]);
    let [x, low, high] = [value, a.value, b.value].map(f64::from);
    let t = if high > low { ((x - low) / (high - low)).max(0.0) } else { 0.0 };
    [0, 1, 2].map(|c| f64::from(a.rgba[c]) * (1.0 - t) + f64::from(b.rgba[c]) * t)
}

fn view(f: TransferFunction) -> View {
    let camera =
        Camera { azimuth: 0.0, elevation: 0.0, projection: Projection::Orthographic, ..Camera::default() };
    View { size: [72, 72], camera, filter: Filter::Nearest, ..View::new(f) }
}

/// A column for each value. Remaining columns have the first value.
fn columns(values: &[f32]) -> Box<dyn Decoder> {
    let value =
        |[x, _, z]: [u32; 3]| f64::from(values.get((z * SIDE + x) as usize).copied().unwrap_or(values[0]));
    let volume = volume([SIDE, DEPTH, SIDE], [1.0; 3], SampleType::F32, value);
    encoded(codec("raw").as_ref(), &settings(&[]), &volume)
}

/// The column that each pixel shows. `None` outside the volume.
fn seen_columns() -> Vec<Option<usize>> {
    let last = (SIDE * SIDE - 1) as f32;
    let numbers: Vec<f32> = (0..SIDE * SIDE).map(|i| i as f32).collect();
    let point = |value: f32| ControlPoint { value, rgba: [value / last, 0.0, 0.0, 1.0] };
    let view = view(TransferFunction::new(vec![point(0.0), point(last)]).unwrap());
    let image = mirror(&view, columns(&numbers).as_ref());
    let column = |p: &[f32; 4]| (p[3] > 0.99).then(|| (p[0] / p[3] * last).round() as usize);
    image.pixels().iter().map(column).collect()
}

/// Largest distance of a picture from the straight lines.
fn off(image: &Image, f: &TransferFunction, values: &[f32], columns: &[Option<usize>]) -> f64 {
    let pixels = image.pixels().iter().zip(columns).filter_map(|(p, column)| Some((p, (*column)?)));
    let distance = |(p, column): (&[f32; 4], usize)| {
        let want = line(f, values.get(column).copied().unwrap_or(values[0]));
        (0..3).map(|c| (f64::from(p[c] / p[3]) - want[c]).abs()).fold(0.0, f64::max)
    };
    pixels.map(distance).fold(0.0, f64::max)
}

/// Rounding of a ray's sum of equal samples in single precision.
const SUMMED: f64 = 2e-6;

#[test]
fn pictures_show_the_straight_lines() {
    let Some(device) = test_device("transfer_function::straight_lines") else { return };
    let seen = seen_columns();
    let shown: std::collections::BTreeSet<usize> = seen.iter().flatten().copied().collect();
    assert_eq!(shown.len(), (SIDE * SIDE) as usize, "every column is seen");
    for (name, search, f) in kinds() {
        assert_eq!(f.search(), search, "{name}");
        let values = telling(&f);
        let decoder = columns(&values);
        let view = view(f.clone());
        let by_mirror = off(&mirror(&view, decoder.as_ref()), &f, &values, &seen);
        assert!(by_mirror <= SUMMED, "{name}: the mirror is off by {by_mirror}");
        for site in [Site::Inline, Site::Host] {
            let source = source(device, site, "raw", decoder.as_ref());
            let (image, _) = draw_by(device, &Raycasting, &view, &source);
            let by_device = off(&image, &f, &values, &seen);
            assert!(by_device <= SUMMED, "{name} at {site}: off by {by_device}");
        }
    }
}

#[test]
fn slices_follow_their_mirror_at_every_depth() {
    let Some(device) = test_device("transfer_function::slices") else { return };
    for (name, _, f) in kinds() {
        let decoder = columns(&telling(&f));
        let view = view(f);
        let expected = mirror_by(&Slicing::default(), &view, decoder.as_ref());
        let source = source(device, Site::Inline, "raw", decoder.as_ref());
        let (image, drawing) = draw_by(device, &Slicing::default(), &view, &source);
        rule(drawing.filtering()).check(&expected, &image).unwrap_or_else(|e| panic!("{name}: {e}"));
    }
}

fn by_table(device: &Device, view: &View, decoder: &dyn Decoder) -> Image {
    let source = source(device, Site::Inline, "raw", decoder);
    let plan = Raycasting.plan(view, &source.layout()).unwrap();
    let plan = with_table(&plan, &view.transfer_function);
    let drawing = Drawing::new(device, &plan, &source, view.filter).unwrap();
    drawing.draw_timed().unwrap();
    drawing.read_image().unwrap()
}

/// The failing twin: a table of 1024 entries shows the straight lines of two points, but not narrow ones.
#[test]
fn a_table_of_equal_entries_is_noticed() {
    let Some(device) = test_device("transfer_function::table") else { return };
    let seen = seen_columns();
    for (name, _, f) in kinds() {
        // Single precision could not index a table of the others.
        let wrong = match name {
            "two" => false,
            "narrow peak" | "window" | "steps" | "labels" | "growing" | "4096 crowded" => true,
            _ => continue,
        };
        let mut values = telling(&f);
        if name == "two" {
            values.retain(|v| v.abs() <= 255.0);
        }
        let image = by_table(device, &view(f.clone()), columns(&values).as_ref());
        let off = off(&image, &f, &values, &seen);
        assert_eq!(off > 0.01, wrong, "{name}: the table is off by {off}");
    }
}

/// A peak in a filtered texture: 300 of 0 … 65535, and nothing 10 away from it.
#[test]
fn a_narrow_peak_shows_in_filtered_textures() {
    let Some(device) = test_device("transfer_function::narrow_peak") else { return };
    let point = |value, alpha| ControlPoint { value, rgba: [1.0, 1.0, 1.0, alpha] };
    let points = [(0.0, 0.0), (290.0, 0.0), (300.0, 1.0), (310.0, 0.0), (65535.0, 0.0)];
    let f = TransferFunction::new(points.map(|(value, alpha)| point(value, alpha)).to_vec()).unwrap();
    for (value, opaque) in [(300, true), (290, false), (310, false)] {
        let volume = volume([12; 3], [1.0; 3], SampleType::U16, |_| f64::from(value));
        let decoder = encoded(codec("raw").as_ref(), &settings(&[]), &volume);
        let view = View { filter: Filter::Linear, ..view(f.clone()) };
        let middle = (view.size[1] / 2 * view.size[0] + view.size[0] / 2) as usize;
        for site in [Site::Inline, Site::Host] {
            let source = source(device, site, "raw", decoder.as_ref());
            let (image, _) = draw_by(device, &Raycasting, &view, &source);
            let [r, g, b, a] = image.pixels()[middle];
            if opaque {
                assert!([r, g, b, a].iter().all(|c| *c > 0.999), "{site}: {:?}", image.pixels()[middle]);
            } else {
                assert!(a < 1e-3, "{site} {value}: {a}");
            }
        }
        if opaque {
            let former = by_table(device, &view, decoder.as_ref());
            assert!(former.pixels()[middle][3] < 0.01, "the table shows it: {:?}", former.pixels()[middle]);
        }
    }
}
