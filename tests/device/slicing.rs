//! Slices on the device against their mirror, and against rays.

use cvr_core::codec::Site;
use cvr_core::metrics::AgreementRule;
use cvr_core::render::{
    Blending, Camera, ClipBox, ControlPoint, Filter, Image, Projection, Shading, TransferFunction, View,
};
use cvr_core::volume::SampleType;
use cvr_engine::testing::test_device;
use cvr_raycasting::Raycasting;
use cvr_slicing::{Geometry, OpacityCorrection, Slicing};

use super::scenes::{camera, draw_by, mirror_by, rule, source, sums_single, textured, view};
use super::subjects::{ODD, codec, encoded, settings};

use Projection::{Orthographic, Perspective};

const GEOMETRIES: [Geometry; 3] = [Geometry::Planes, Geometry::Axis, Geometry::Shells];

fn views() -> Vec<View> {
    let clip = ClipBox { low: [0.1, 0.0, 0.3], high: [0.8, 0.7, 1.0] };
    let plain =
        |camera, step_voxels| View { camera, step_voxels, ..view(SampleType::U8, [65, 49], Filter::Linear) };
    vec![
        plain(camera(30.0, 20.0, Perspective), 0.5),
        plain(camera(-130.0, -35.0, Orthographic), 1.7),
        plain(camera(0.0, 0.0, Orthographic), 1.0),
        plain(camera(90.0, 0.0, Perspective), 0.8),
        plain(Camera { zoom: 6.0, ..camera(20.0, 80.0, Perspective) }, 0.5),
        View { clip: Some(clip), ..plain(camera(44.0, 10.0, Perspective), 0.6) },
        View { shading: Some(Shading::default()), ..plain(camera(46.0, 10.0, Orthographic), 1.0) },
    ]
}

#[test]
fn every_geometry_site_and_filter_agrees_with_the_mirror() {
    let Some(device) = test_device("slicing::geometries") else { return };
    if !sums_single(device, "slicing::geometries") {
        return;
    }
    let s3dc = codec("s3dc");
    let volume = textured(ODD, [1.0, 1.5, 0.7], SampleType::U8);
    let decoder = encoded(s3dc.as_ref(), &settings(&[("block", "4"), ("index_bits", "4")]), &volume);
    let mut breaches = Vec::new();
    for (filter, sites) in [
        (Filter::Nearest, &[Site::Inline, Site::Host][..]),
        (Filter::Linear, &[Site::Inline, Site::Deferred, Site::Host]),
        (Filter::OptimisedLinear, &[Site::Inline]),
    ] {
        for view in views() {
            let view = View { filter, ..view };
            for geometry in GEOMETRIES {
                let slicing = Slicing { geometry, ..Slicing::default() };
                let expected = mirror_by(&slicing, &view, decoder.as_ref());
                for &site in sites {
                    let source = source(device, site, "s3dc", decoder.as_ref());
                    let (picture, drawing) = draw_by(device, &slicing, &view, &source);
                    if let Err(e) = rule(drawing.filtering()).check(&expected, &picture) {
                        breaches.push(format!("{geometry:?} {site} {filter} {:?}: {e}", view.camera));
                    }
                }
            }
        }
    }
    assert!(breaches.is_empty(), "{}", breaches.join("\n"));
}

#[test]
fn half_precision_and_the_interpolated_correction_agree_too() {
    let Some(device) = test_device("slicing::blending") else { return };
    let raw = codec("raw");
    let decoder = encoded(raw.as_ref(), &settings(&[]), &textured([32; 3], [1.0; 3], SampleType::U8));
    let source = source(device, Site::Inline, "raw", decoder.as_ref());
    let view = view(SampleType::U8, [64, 64], Filter::Linear);
    for geometry in GEOMETRIES {
        for opacity_correction in [OpacityCorrection::Exact, OpacityCorrection::Lerp] {
            let slicing = Slicing { geometry, opacity_correction, blending: Blending::Float16 };
            let (picture, drawing) = draw_by(device, &slicing, &view, &source);
            assert_eq!(drawing.blending(), Some(Blending::Float16));
            let expected = mirror_by(&slicing, &view, decoder.as_ref());
            AgreementRule::HARDWARE.check(&expected, &picture).unwrap();
        }
    }
    // Sums in single precision are nearer to the mirror than sums in half precision.
    let off = |blending| {
        let slicing = Slicing { blending, ..Slicing::default() };
        let (picture, drawing) = draw_by(device, &slicing, &view, &source);
        let expected = mirror_by(&slicing, &view, decoder.as_ref());
        let pairs = expected.pixels().iter().flatten().zip(picture.pixels().iter().flatten());
        (drawing.blending(), pairs.map(|(a, b)| f64::from((a - b).abs())).sum::<f64>())
    };
    let (single, half) = (off(Blending::Float32), off(Blending::Float16));
    println!("summed difference: {single:?} {half:?}");
    assert!(single.0 == Some(Blending::Float16) || single.1 < half.1);
}

/// Mean difference of two pictures over the pixels that show anything in the first, in 255ths.
fn mean_difference(a: &Image, b: &Image) -> f64 {
    let visible = a.pixels().iter().filter(|pixel| pixel[3] > 0.0).count().max(1);
    let pairs = a.pixels().iter().flat_map(|p| &p[..3]).zip(b.pixels().iter().flat_map(|p| &p[..3]));
    pairs.map(|(a, b)| f64::from((a - b).abs())).sum::<f64>() * 255.0 / (3 * visible) as f64
}

#[test]
fn slices_show_what_rays_show_at_the_same_step() {
    let Some(device) = test_device("slicing::against_rays") else { return };
    let raw = codec("raw");
    let decoder = encoded(raw.as_ref(), &settings(&[]), &textured([40, 33, 37], [1.0; 3], SampleType::U8));
    let source = source(device, Site::Inline, "raw", decoder.as_ref());
    for azimuth in [0.0, 20.0, 40.0, 50.0, 70.0, 90.0] {
        for projection in [Perspective, Orthographic] {
            let view = View {
                camera: camera(azimuth, 15.0, projection),
                ..view(SampleType::U8, [96, 96], Filter::Linear)
            };
            let (rays, _) = draw_by(device, &Raycasting, &view, &source);
            for geometry in GEOMETRIES {
                let slicing = Slicing { geometry, ..Slicing::default() };
                let (slices, _) = draw_by(device, &slicing, &view, &source);
                let mean = mean_difference(&rays, &slices);
                assert!(mean < 2.0, "{geometry:?} at {azimuth}°, {projection:?}: {mean}");
            }
            // The picture if a slice of half a voxel counted as a whole one.
            let denser: Vec<_> = view
                .transfer_function
                .points()
                .iter()
                .map(|p| ControlPoint {
                    rgba: [p.rgba[0], p.rgba[1], p.rgba[2], 1.0 - (1.0 - p.rgba[3]).powi(2)],
                    ..*p
                })
                .collect();
            let uncorrected =
                View { transfer_function: TransferFunction::new(denser).unwrap().into(), ..view.clone() };
            let (slices, _) = draw_by(device, &Slicing::default(), &uncorrected, &source);
            assert!(mean_difference(&rays, &slices) > 4.0, "{}", mean_difference(&rays, &slices));
        }
    }
}
