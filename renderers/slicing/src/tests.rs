//! Properties of slices: opacity by length, brightness independent of the angle, proxies that cover.

use std::sync::Arc;

use cvr_core::render::mirror::Mirror;
use cvr_core::render::{
    Camera, ClipBox, ControlPoint, DecodedFrame, Image, Projection, RenderError, Renderer, TransferFunction,
    View,
};
use cvr_core::volume::{Extent, SampleType, VolumeLayout};
use glam::Vec2;

use crate::mirror::slice_opacity;
use crate::proxies::proxies;
use crate::slabs::Slabs;
use crate::{Geometry, OpacityCorrection, Slicing};

use Projection::{Orthographic, Perspective};

const GEOMETRIES: [Geometry; 3] = [Geometry::Planes, Geometry::Axis, Geometry::Shells];

fn slicing(geometry: Geometry) -> Slicing {
    Slicing { geometry, ..Slicing::default() }
}

/// Grey with this opacity per voxel length at 1, transparent at 0.
fn ramp(alpha: f32) -> Arc<TransferFunction> {
    let point = |value, alpha| ControlPoint { value, rgba: [0.5, 0.5, 0.5, alpha] };
    Arc::new(TransferFunction::new(vec![point(0.0, 0.0), point(1.0, alpha)]).unwrap())
}

fn camera(azimuth: f64, elevation: f64, projection: Projection) -> Camera {
    Camera { azimuth, elevation, projection, ..Camera::default() }
}

fn volume(size: [u32; 3], spacing: [f64; 3], value: impl Fn([u32; 3]) -> f32) -> DecodedFrame {
    let extent = Extent::try_from(size).unwrap();
    let layout = VolumeLayout { spacing, ..VolumeLayout::scalar(extent, SampleType::F32) };
    let values = (0..extent.voxels() as usize).map(|i| value(extent.position(i))).collect();
    DecodedFrame::new(layout, values).unwrap()
}

fn draw(slicing: &Slicing, view: &View, voxels: &DecodedFrame) -> Image {
    let mut image = Image::new(view.size);
    slicing.reference(view, voxels, &mut image).unwrap();
    image
}

fn brightness(image: &Image) -> f64 {
    image.pixels().iter().map(|pixel| f64::from(pixel[3])).sum::<f64>() / image.pixels().len() as f64
}

/// In a homogeneous volume, opacity depends only on the length of the path, for every geometry, step and angle.
#[test]
fn opacity_is_that_of_the_length_at_any_step_and_angle() {
    let voxels = volume([16; 3], [1.0; 3], |_| 1.0);
    for geometry in GEOMETRIES {
        for (step_voxels, azimuth, projection) in [
            (0.25, 0.0, Orthographic),
            (1.0, 30.0, Perspective),
            (3.0, 44.0, Orthographic),
            (30.0, 46.0, Perspective),
        ] {
            let camera = camera(azimuth, 20.0, projection);
            let view = View { size: [24, 24], step_voxels, camera, ..View::new(ramp(0.05)) };
            let image = draw(&slicing(geometry), &view, &voxels);
            let mirror = Mirror::new(&view, &voxels);
            for (i, pixel) in image.pixels().iter().enumerate() {
                let inside = mirror.crossing(&mirror.pixel_ray([i as u32 % 24, i as u32 / 24]));
                let length = (inside.far - inside.near).max(0.0);
                let expected = 1.0 - 0.95_f32.powf(length);
                assert!(
                    (pixel[3] - expected).abs() < 1e-4,
                    "{geometry:?}, step {step_voxels}, {azimuth}°, pixel {i}"
                );
            }
        }
    }
}

/// Largest change of brightness from one view to the next, as a fraction of the mean.
fn largest_jump(series: &[f64]) -> f64 {
    let mean = series.iter().sum::<f64>() / series.len() as f64;
    series.windows(2).map(|pair| (pair[1] - pair[0]).abs()).fold(0.0, f64::max) / mean
}

/// Brightness of a soft ball at every degree of a turn. The axis of the stack changes during it. A ball looks the same
/// from every side.
fn turn(draw: impl Fn(&View) -> Image) -> Vec<f64> {
    let view = View { size: [48, 48], step_voxels: 1.0, ..View::new(ramp(0.2)) };
    let at = |azimuth: u32| {
        let camera = camera(f64::from(azimuth), f64::from(azimuth) / 2.0, Perspective);
        brightness(&draw(&View { camera, ..view.clone() }))
    };
    (0..=120).map(at).collect()
}

fn ball(size: [u32; 3], spacing: [f64; 3]) -> DecodedFrame {
    volume(size, spacing, move |p| {
        let offset = |a: usize| (f64::from(p[a]) + 0.5 - f64::from(size[a]) / 2.0) * spacing[a];
        let radius = (offset(0).powi(2) + offset(1).powi(2) + offset(2).powi(2)).sqrt();
        (1.0 - (radius - 9.0) / 4.0).clamp(0.0, 1.0) as f32
    })
}

#[test]
fn brightness_does_not_jump_over_a_turn() {
    for voxels in [ball([28; 3], [1.0; 3]), ball([28, 14, 28], [1.0, 2.0, 1.0])] {
        for geometry in GEOMETRIES {
            for opacity_correction in [OpacityCorrection::Exact, OpacityCorrection::Lerp] {
                let slicing = Slicing { geometry, opacity_correction, ..Slicing::default() };
                let series = turn(|view| draw(&slicing, view, &voxels));
                let jump = largest_jump(&series);
                // Between two axes, the interpolated correction is off by up to a few percent, but it does not jump.
                assert!(jump < 0.004, "{geometry:?}, {opacity_correction:?}: {jump}");
                let spread =
                    series.iter().copied().fold(0.0, f64::max) / series.iter().copied().fold(1.0, f64::min);
                let allowed = if opacity_correction == OpacityCorrection::Exact { 1.015 } else { 1.03 };
                assert!(spread < allowed, "{geometry:?}, {opacity_correction:?}: {spread}");
            }
        }
    }
}

/// The same series without correction: slices keep the opacity of their thickness, which is a voxel along the main
/// axis. It shows why the correction is needed.
#[test]
fn a_stack_without_correction_is_seen_to_jump() {
    let voxels = ball([28, 14, 28], [1.0, 2.0, 1.0]);
    let series = turn(|view| {
        let y_is_main = (45.0..135.0).contains(&(view.camera.azimuth + 90.0)) && view.camera.elevation < 45.0;
        let step_voxels = if y_is_main { 2.0 } else { 1.0 };
        // One voxel's opacity for every slice, however thick it is.
        let alpha = 1.0 - 0.8_f32.powf(1.0 / step_voxels);
        draw(
            &slicing(Geometry::Axis),
            &View { step_voxels, transfer_function: ramp(alpha), ..view.clone() },
            &voxels,
        )
    });
    assert!(largest_jump(&series) > 0.05, "{}", largest_jump(&series));
}

#[test]
fn parallel_rays_turn_shells_into_planes() {
    let voxels = ball([20; 3], [1.0; 3]);
    let view = View { size: [32, 32], camera: camera(20.0, 30.0, Orthographic), ..View::new(ramp(0.3)) };
    let [planes, shells] = [Geometry::Planes, Geometry::Shells].map(|g| draw(&slicing(g), &view, &voxels));
    assert!(planes == shells);
    assert!(planes != draw(&slicing(Geometry::Axis), &view, &voxels));
}

/// The weight that the paper tabulates: that of the least squared error relative to the opacity.
#[test]
fn the_interpolated_correction_has_the_weight_of_least_relative_error() {
    // Opacities of 1, 2 and d slices for all α, each relative to α.
    let samples = |d: f64| {
        (0..10_000).map(move |i| {
            let alpha = (f64::from(i) + 0.5) / 10_000.0;
            let over = |d: f64| (1.0 - (1.0 - alpha).powf(d)) / alpha;
            (over(1.0), over(2.0), over(d))
        })
    };
    for d in [1.0, 1.1, 1.3, 1.5, 1.732, 1.9, 2.0] {
        // Least squares of (1 − t)·one + t·two against exact.
        let (mut above, mut below) = (0.0, 0.0);
        for (one, two, exact) in samples(d) {
            above += (exact - one) * (two - one);
            below += (two - one) * (two - one);
        }
        // α = 1/2 shows t: its opacities for one and two slices are 1/2 and 3/4.
        let opacity = slice_opacity(OpacityCorrection::Lerp, 0.5, d as f32, 1.0);
        let t = (f64::from(opacity) - 0.5) / 0.25;
        assert!((t - above / below).abs() < 4e-4, "d {d}: {t} for {}", above / below);
    }
}

#[test]
fn the_interpolated_correction_is_near_the_exact_one_and_never_beyond_opaque() {
    let both = |alpha, d: f32| {
        [OpacityCorrection::Exact, OpacityCorrection::Lerp].map(|c| slice_opacity(c, alpha, d * 0.7, 0.7))
    };
    for alpha in [0.001, 0.01, 0.3, 0.6, 0.9] {
        for (d, relative) in [(1.0, 1e-4), (2.0, 1e-4), (1.2, 0.03), (1.5, 0.03), (1.732, 0.03)] {
            let [exact, lerp] = both(alpha, d);
            assert!((exact - lerp).abs() <= relative * exact, "α {alpha}, d {d}: {exact} {lerp}");
        }
    }
    assert!(both(0.999, 9.0)[1] <= 1.0);
    assert!(both(0.5, 0.0)[1] == 0.0, "what the ray does not cross adds nothing");
}

/// Number of visible fragments outside all triangles of their slice, and number of all visible fragments.
fn uncovered(geometry: Geometry, view: &View, voxels: &DecodedFrame, shrink: f32) -> (usize, usize) {
    let mirror = Mirror::new(view, voxels);
    let layout = cvr_core::render::Voxels::layout(voxels);
    let slabs = Slabs::new(geometry, view, layout, mirror.rays()).unwrap();
    let triangles: Vec<_> = proxies(&slabs, view, layout, mirror.rays())
        .chunks_exact(3)
        .map(|t| (t[0].slice, [t[0], t[1], t[2]].map(|v| Vec2::from_array(v.position) * shrink)))
        .collect();
    assert!(triangles.is_sorted_by(|a, b| a.0 >= b.0), "the farthest slice comes first");
    let [width, height] = view.size;
    let (mut missing, mut all) = (0, 0);
    for (x, y) in (0..height).flat_map(|y| (0..width).map(move |x| (x, y))) {
        let ray = mirror.pixel_ray([x, y]);
        let inside = mirror.crossing(&ray);
        let end = inside.far - inside.near;
        let entry = cvr_core::render::mirror::Ray { origin: ray.origin + ray.direction * inside.near, ..ray };
        let centre =
            (Vec2::new(x as f32, y as f32) + 0.5) / Vec2::new(width as f32, height as f32) * 2.0 - 1.0;
        let centre = Vec2::new(centre.x, -centre.y);
        for slice in 0..slabs.count {
            let slab = slabs.crossing(&entry, inside.near, slice);
            // A length below a ten-thousandth of a voxel does not count.
            let shows = slab.far.min(end) - slab.near.max(0.0) > 1e-4;
            let holds = |t: &[Vec2; 3]| {
                let side = |a: Vec2, b: Vec2| (b - a).perp_dot(centre - a);
                side(t[0], t[1]) >= 0.0 && side(t[1], t[2]) >= 0.0 && side(t[2], t[0]) >= 0.0
            };
            all += usize::from(shows);
            assert!(
                !shows || slabs.crossed(&entry, inside.near, end).contains(&slice),
                "the mirror leaves one out"
            );
            missing += usize::from(shows && !triangles.iter().any(|(s, t)| *s == slice && holds(t)));
        }
    }
    (missing, all)
}

#[test]
fn proxies_cover_whatever_shows_and_shrunk_ones_do_not() {
    let voxels = volume([9, 13, 7], [1.0, 1.5, 0.7], |_| 1.0);
    let clip = ClipBox { low: [0.2, 0.0, 0.5], high: [0.9, 0.45, 1.0] };
    for geometry in GEOMETRIES {
        for (camera, step_voxels) in [
            (camera(30.0, 20.0, Perspective), 1.3),
            (camera(-130.0, -35.0, Orthographic), 0.7),
            (camera(0.0, 0.0, Orthographic), 1.0),
            (camera(90.0, -90.0, Perspective), 2.0),
            (Camera { field_of_view: 80.0, zoom: 1.5, ..camera(200.0, 60.0, Perspective) }, 40.0),
        ] {
            for clip in [None, Some(clip)] {
                let view = View { size: [23, 17], camera, step_voxels, clip, ..View::new(ramp(0.5)) };
                let (missing, all) = uncovered(geometry, &view, &voxels, 1.0);
                assert!(all > 30, "{geometry:?} {camera:?} {step_voxels}: only {all} fragments");
                assert_eq!(missing, 0, "of {all}: {geometry:?} {camera:?} {step_voxels} {clip:?}");
                let (missing, _) = uncovered(geometry, &view, &voxels, 0.6);
                assert!(missing > 0, "{geometry:?} {camera:?}: shrunk proxies still cover everything");
            }
        }
    }
}

#[test]
fn what_cannot_be_sliced_is_refused_with_a_way_out() {
    let voxels = volume([64; 3], [1.0; 3], |_| 1.0);
    let layout = cvr_core::render::Voxels::layout(&voxels);
    let refuse = |geometry, view: &View| match slicing(geometry).plan(view, layout) {
        Err(RenderError::Unsupported(text)) => text,
        other => panic!("{}", other.map_or_else(|e| e.to_string(), |_| "a plan".to_owned())),
    };
    let wide = Camera { field_of_view: 150.0, ..camera(30.0, 30.0, Perspective) };
    let view = View { camera: wide, ..View::new(ramp(0.5)) };
    assert!(refuse(Geometry::Axis, &view).contains("use planes or shells"));
    assert!(slicing(Geometry::Shells).plan(&view, layout).is_ok());
    let fine = View { step_voxels: 0.001, ..View::new(ramp(0.5)) };
    assert!(refuse(Geometry::Planes, &fine).contains("at most 65536"));
}

/// A ray beside the volume meets no slices. An empty picture needs no triangles.
#[test]
fn a_view_beside_the_volume_is_empty() {
    let voxels = volume([4; 3], [1.0; 3], |_| 1.0);
    let view = View { size: [9, 9], ..View::new(ramp(0.5)) };
    let image = draw(&slicing(Geometry::Shells), &view, &voxels);
    assert_eq!(image.pixels()[0], [0.0; 4]);
    assert!(image.pixels()[40][3] > 0.5);
    let plan = Slicing::default().plan(&view, cvr_core::render::Voxels::layout(&voxels)).unwrap();
    assert!(matches!(&plan.passes[..], [pass] if pass.inputs.vertices.len() % 3 == 0));
}
