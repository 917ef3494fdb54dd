//! Colour volumes on the device compared with their mirror, for every origin of their opacity.

use std::sync::Arc;

use cvr_core::codec::Site;
use cvr_core::metrics::AgreementRule;
use cvr_core::render::{ColourOpacity, Filter, OpacityTable, Projection, Renderer, Shading, View};
use cvr_core::volume::{DenseVolume, Extent, FiniteVolume, SampleType, Samples, VolumeLayout};
use cvr_engine::testing::test_device;
use cvr_raycasting::Raycasting;
use cvr_slicing::Slicing;

use super::scenes::{camera, draw_by, mirror_by, rule, source, sums_single, view};
use super::subjects::{codec, encoded, settings};

/// Soft structures with a different shape in each channel.
pub fn coloured(sample: SampleType) -> FiniteVolume {
    let extent = Extent::try_from([21, 18, 25]).unwrap();
    let layout = VolumeLayout { channels: 3, ..VolumeLayout::scalar(extent, sample) };
    let value = |p: [u32; 3], channel: usize| {
        let [x, y, z] = p.map(f64::from);
        let waves = [
            (0.6 * x).sin() * (0.4 * y).cos(),
            (0.5 * y + 0.2 * z).sin(),
            (0.3 * (x + z)).cos() * (0.5 * y).sin(),
        ];
        0.5 + 0.5 * waves[channel]
    };
    let values = (0..extent.voxels() as usize).flat_map(|i| [0, 1, 2].map(|c| value(extent.position(i), c)));
    let samples = match sample {
        SampleType::F32 => Samples::F32(values.map(|v| (v * 8.0 - 3.0) as f32).collect()),
        _ => Samples::U8(values.map(|v| (v * 255.0).round() as u8).collect()),
    };
    FiniteVolume::new(DenseVolume::new(layout, samples).unwrap())
}

/// Reds show, dark colours do not.
fn table() -> ColourOpacity {
    let edge = 5;
    let entries: Vec<f32> = (0..edge * edge * edge).map(|i| if i % edge >= 3 { 0.3 } else { 0.01 }).collect();
    ColourOpacity::Table(Arc::new(OpacityTable::new(edge, &entries).unwrap()))
}

pub fn views(sample: SampleType, volume: &FiniteVolume) -> Vec<View> {
    let plain = View {
        value_range: volume.range(),
        camera: camera(35.0, 25.0, Projection::Perspective),
        ..view(if sample == SampleType::F32 { SampleType::I8 } else { sample }, [65, 49], Filter::Linear)
    };
    let mut views: Vec<_> =
        [ColourOpacity::Luminance, ColourOpacity::Channel(0), ColourOpacity::Channel(2), table()]
            .map(|colour_opacity| View { colour_opacity, ..plain.clone() })
            .to_vec();
    let lit: Vec<_> = views.iter().map(|v| View { shading: Some(Shading::default()), ..v.clone() }).collect();
    views.extend(lit);
    views
}

#[test]
fn colours_agree_with_the_mirror_whatever_decides_their_opacity() {
    let Some(device) = test_device("colour::agrees") else { return };
    let slicing = Slicing::default();
    let mut renderers: Vec<&dyn Renderer> = vec![&Raycasting];
    if sums_single(device, "colour::agrees, by slices") {
        renderers.push(&slicing);
    }
    let mut breaches = Vec::new();
    for (id, pairs, sample) in [
        ("raw", &[][..], SampleType::U8),
        ("s3dc", &[("block", "4"), ("index_bits", "8")], SampleType::U8),
        ("raw", &[], SampleType::F32),
    ] {
        let volume = coloured(sample);
        let codec = codec(id);
        let decoder = encoded(codec.as_ref(), &settings(pairs), &volume);
        for site in [Site::Inline, Site::Deferred, Site::Host] {
            let source = source(device, site, id, decoder.as_ref());
            for view in views(sample, &volume) {
                for &renderer in &renderers {
                    let (picture, drawing) = draw_by(device, renderer, &view, &source);
                    let expected = mirror_by(renderer, &view, decoder.as_ref());
                    let name = format!("{id} {sample} {site} {:?}", view.colour_opacity.weights());
                    match rule(drawing.filtering()).check(&expected, &picture) {
                        Ok(found) if found.visible_pixels < 100 => {
                            breaches.push(format!("{name}: hardly visible"));
                        }
                        Ok(_) => {}
                        Err(e) => breaches.push(format!("{name}, lit {}: {e}", view.shading.is_some())),
                    }
                }
            }
        }
    }
    assert!(breaches.is_empty(), "{} breaches:\n{}", breaches.len(), breaches.join("\n"));
}

/// Swapped channels, another origin of opacity, another range of light: each must be detected.
#[test]
fn a_wrong_colour_is_seen() {
    let Some(device) = test_device("colour::twins") else { return };
    let volume = coloured(SampleType::U8);
    let raw = codec("raw");
    let decoder = encoded(raw.as_ref(), &settings(&[]), &volume);
    let source = source(device, Site::Inline, "raw", decoder.as_ref());
    let right = views(SampleType::U8, &volume).remove(0);
    let (picture, _) = draw_by(device, &Raycasting, &right, &source);
    AgreementRule::MANUAL.check(&mirror_by(&Raycasting, &right, decoder.as_ref()), &picture).unwrap();
    for colour_opacity in [ColourOpacity::Channel(1), table()] {
        let wrong = View { colour_opacity, ..right.clone() };
        let expected = mirror_by(&Raycasting, &wrong, decoder.as_ref());
        assert!(AgreementRule::MANUAL.check(&expected, &picture).is_err());
    }
    let mut swapped = picture.clone();
    swapped.pixels_mut().iter_mut().for_each(|pixel| pixel.swap(0, 2));
    assert!(AgreementRule::MANUAL.check(&picture, &swapped).is_err());
}
