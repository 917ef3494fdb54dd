//! The device's picture compared with the CPU mirror's: sites × filters × cameras × volumes.

use cvr_core::codec::Site;
use cvr_core::render::{Camera, Filter, Light, Projection, View};
use cvr_core::volume::SampleType;
use cvr_engine::Device;
use cvr_engine::testing::test_device;

use super::scenes::{camera, clipped, draw, lit, mirror, rule, source, textured, view};
use super::subjects::{ODD, codec, encoded, settings};

use Projection::{Orthographic, Perspective};

const ISOTROPIC: [f64; 3] = [1.0; 3];

/// A volume through a codec.
struct Subject {
    codec: &'static str,
    settings: &'static [(&'static str, &'static str)],
    size: [u32; 3],
    spacing: [f64; 3],
    sample: SampleType,
}

/// Oblique, along each axis (the middle column of an odd picture then runs along voxel faces), straight from above and
/// below, and so near that the volume exceeds the picture.
fn cameras() -> Vec<Camera> {
    vec![
        camera(30.0, 20.0, Perspective),
        camera(-130.0, -35.0, Orthographic),
        camera(0.0, 0.0, Perspective),
        camera(0.0, 0.0, Orthographic),
        camera(90.0, 0.0, Orthographic),
        camera(180.0, 0.0, Perspective),
        camera(45.0, 90.0, Perspective),
        camera(0.0, -90.0, Orthographic),
        Camera { zoom: 6.0, ..camera(20.0, 10.0, Orthographic) },
        // The eye all but touches the bounding sphere.
        Camera { field_of_view: 170.0, zoom: 20.0, ..camera(45.0, 35.0, Perspective) },
    ]
}

/// Draws `views` of a subject with every filter at every site that its codec offers. Each breach is a sentence.
fn breaches(device: &Device, subject: &Subject, views: &[View]) -> (usize, Vec<String>) {
    let codec = codec(subject.codec);
    let volume = textured(subject.size, subject.spacing, subject.sample);
    let decoder = encoded(codec.as_ref(), &settings(subject.settings), &volume);
    let mut drawn = 0;
    let mut breaches = Vec::new();
    for (filter, sites) in [
        (Filter::Nearest, &[Site::Inline, Site::Host][..]),
        (Filter::Linear, &[Site::Inline, Site::Host]),
        (Filter::OptimisedLinear, if codec.info().fetch_cell { &[Site::Inline] } else { &[] }),
    ] {
        let sources = sites.iter().map(|&site| source(device, site, subject.codec, decoder.as_ref()));
        let sources: Vec<_> = sources.collect();
        for view in views {
            let view = View { filter, ..view.clone() };
            let expected = mirror(&view, decoder.as_ref());
            for (site, source) in sites.iter().zip(&sources) {
                let (picture, filtering) = draw(device, &view, source);
                let name = || {
                    let Subject { codec, settings, size, spacing, sample } = subject;
                    let (camera, step) = (view.camera, view.step_voxels);
                    format!(
                        "{codec} {settings:?} {size:?} {spacing:?} {sample}, {site} {filter}, {:?}, step {step}, \
                         until {}, {camera:?}, {:?}, {:?}",
                        view.size, view.termination, view.shading, view.clip
                    )
                };
                drawn += 1;
                match rule(filtering).check(&expected, &picture) {
                    Ok(found) if found.visible_pixels < 100 => {
                        breaches.push(format!(
                            "{}: {} visible pixels prove little",
                            name(),
                            found.visible_pixels
                        ));
                    }
                    Ok(_) => {}
                    Err(e) => breaches.push(format!("{}: {e}", name())),
                }
            }
        }
    }
    (drawn, breaches)
}

fn assert_none(found: &[(usize, Vec<String>)]) {
    let drawn: usize = found.iter().map(|(drawn, _)| drawn).sum();
    let all: Vec<_> = found.iter().flat_map(|(_, breaches)| breaches.as_slice()).collect();
    let shown: Vec<_> = all.iter().take(20).map(|b| b.as_str()).collect();
    assert!(all.is_empty(), "{} of {drawn} pictures:\n{}", all.len(), shown.join("\n"));
}

/// Every camera, with alternating steps, ends of rays and shapes of the picture.
fn views(sample: SampleType, cameras: Vec<Camera>) -> Vec<View> {
    let shapes = [[65, 49], [40, 63]].into_iter().cycle();
    let rays = [(0.5, 1.0), (1.7, 0.9), (0.5, 0.9), (1.7, 1.0), (0.8, 0.999)].into_iter().cycle();
    let varied = cameras.into_iter().zip(shapes).zip(rays);
    varied
        .map(|((camera, size), (step_voxels, termination))| View {
            camera,
            step_voxels,
            termination,
            ..view(sample, size, Filter::Linear)
        })
        .collect()
}

#[test]
fn an_odd_anisotropic_volume() {
    let Some(device) = test_device("pictures::odd_anisotropic") else { return };
    let spacing = [1.0, 1.5, 0.7];
    let found = [
        Subject { codec: "raw", settings: &[], size: ODD, spacing, sample: SampleType::U8 },
        Subject {
            codec: "s3dc",
            settings: &[("block", "3x5x2"), ("index_bits", "4")],
            size: ODD,
            spacing,
            sample: SampleType::F32,
        },
    ]
    .map(|subject| breaches(device, &subject, &views(subject.sample, cameras())));
    assert_none(&found);
}

#[test]
fn an_isotropic_cube() {
    let Some(device) = test_device("pictures::isotropic_cube") else { return };
    let found = [
        Subject { codec: "raw", settings: &[], size: [32; 3], spacing: ISOTROPIC, sample: SampleType::F32 },
        Subject {
            codec: "s3dc",
            settings: &[("block", "8"), ("index_bits", "2")],
            size: [32; 3],
            spacing: ISOTROPIC,
            sample: SampleType::U8,
        },
    ]
    .map(|subject| breaches(device, &subject, &views(subject.sample, cameras())));
    assert_none(&found);
}

#[test]
fn a_single_voxel() {
    let Some(device) = test_device("pictures::single_voxel") else { return };
    let found = ["raw", "s3dc"].map(|codec| {
        let subject =
            Subject { codec, settings: &[], size: [1; 3], spacing: ISOTROPIC, sample: SampleType::U8 };
        breaches(device, &subject, &views(subject.sample, cameras()))
    });
    assert_none(&found);
}

/// Parallel views along an axis, with steps that put every sample of a ray on the face between two voxels.
#[test]
fn samples_on_voxel_faces() {
    let Some(device) = test_device("pictures::voxel_faces") else { return };
    let axis = |azimuth, elevation, step_voxels, size| View {
        camera: camera(azimuth, elevation, Orthographic),
        step_voxels,
        ..view(SampleType::U8, size, Filter::Linear)
    };
    let found = [([32; 3], ISOTROPIC), ([12, 18, 24], [1.0, 1.5, 2.0])].map(|(size, spacing)| {
        let subject = Subject { codec: "raw", settings: &[], size, spacing, sample: SampleType::U8 };
        let views: Vec<_> = [(0.0, 0.0), (90.0, 0.0), (180.0, 0.0), (270.0, 0.0), (0.0, 90.0), (0.0, -90.0)]
            .into_iter()
            .flat_map(|(azimuth, elevation)| {
                [1.0, 2.0, 3.0, 4.0].map(|step| axis(azimuth, elevation, step, [65, 49]))
            })
            .collect();
        breaches(device, &subject, &views)
    });
    assert_none(&found);
}

/// Every camera lit, clipped, or both, alternately. The light follows the camera or the volume.
#[test]
fn lit_and_clipped_volumes() {
    let Some(device) = test_device("pictures::lit_and_clipped") else { return };
    let found = [
        Subject { codec: "raw", settings: &[], size: ODD, spacing: [1.0, 1.5, 0.7], sample: SampleType::U8 },
        Subject {
            codec: "s3dc",
            settings: &[("block", "4"), ("index_bits", "8")],
            size: [32; 3],
            spacing: ISOTROPIC,
            sample: SampleType::F32,
        },
    ]
    .map(|subject| {
        let plain = views(subject.sample, cameras());
        let light = |i: usize| if i.is_multiple_of(2) { Light::Camera } else { Light::Fixed };
        let dressed = plain.iter().enumerate().flat_map(|(i, view)| {
            // If a gradient is almost zero, the weights of a texture unit determine its direction. So no single sample
            // may dominate a pixel.
            let view = &View { step_voxels: view.step_voxels.min(0.5), ..view.clone() };
            let lit = lit(view.clone(), light(i));
            match i % 3 {
                0 => vec![lit.clone(), clipped(lit)],
                1 => vec![clipped(view.clone()), lit],
                _ => vec![clipped(lit)],
            }
        });
        breaches(device, &subject, &dressed.collect::<Vec<_>>())
    });
    assert_none(&found);
}
