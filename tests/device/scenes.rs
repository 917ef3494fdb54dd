//! Views, and their pictures by the device and by the CPU mirror.

use std::sync::Arc;

use cvr::site::coded::CodedFrame;
use cvr::site::expected::{Checked, Expected};
use cvr::site::picture::VoxelSource;
use cvr::site::target::Target;
use cvr_core::codec::{Decoder, Site};
use cvr_core::metrics::AgreementRule;
use cvr_core::render::{
    Camera, ClipBox, ControlPoint, DecodedFrame, Filter, Image, Light, Projection, Renderer, Shading,
    TransferFunction, View,
};
use cvr_core::shader::TextureSampling;
use cvr_core::volume::{FiniteVolume, FrameIndex, Level, SampleType};
use cvr_engine::testing::lacking;
use cvr_engine::{Device, DrawSource, Drawing, VolumeTexture};
use cvr_raycasting::Raycasting;

use super::subjects::{hash, volume};

/// Lowest and highest value of the volumes that these scenes show.
pub fn domain(sample: SampleType) -> (f32, f32) {
    match sample.integer_range() {
        Some((low, high)) => (low as f32, high as f32),
        None => (-1000.0, 1000.0),
    }
}

/// A haze with a bright band, over the whole domain.
pub fn transfer_function(sample: SampleType) -> Arc<TransferFunction> {
    let (low, high) = domain(sample);
    let point = |t: f32, rgba| ControlPoint { value: low + (high - low) * t, rgba };
    let points = vec![
        point(0.0, [0.1, 0.1, 0.8, 0.0]),
        point(0.3, [0.1, 0.4, 0.8, 0.02]),
        point(0.5, [0.9, 0.7, 0.2, 0.3]),
        point(0.7, [0.9, 0.3, 0.1, 0.1]),
        point(1.0, [1.0, 1.0, 1.0, 0.6]),
    ];
    Arc::new(TransferFunction::new(points).unwrap())
}

/// From the front, right and above, half a voxel per step, to the end of each ray.
pub fn view(sample: SampleType, size: [u32; 2], filter: Filter) -> View {
    View {
        size,
        camera: Camera { zoom: 1.2, ..Camera::default() },
        filter,
        ..View::new(transfer_function(sample))
    }
}

/// The same view, its surfaces lit from the side.
pub fn lit(view: View, light: Light) -> View {
    let direction = [0.8, -0.5, 0.6];
    View { shading: Some(Shading { light, direction, ..Shading::default() }), ..view }
}

/// The same view of a box whose faces lie between voxel faces and cut the volume on four sides.
pub fn clipped(view: View) -> View {
    View { clip: Some(ClipBox { low: [0.0, 0.21, 0.13], high: [0.83, 0.9, 1.0] }), ..view }
}

/// A camera at this azimuth and elevation.
pub fn camera(azimuth: f64, elevation: f64, projection: Projection) -> Camera {
    Camera { azimuth, elevation, projection, zoom: 1.2, ..Camera::default() }
}

/// Decoded in the shader.
pub fn inline<'a>(codec: &'a str, decoder: &'a dyn Decoder) -> DrawSource<'a> {
    DrawSource::Inline { codec, decoder, frame: FrameIndex::FIRST, level: Level::FULL }
}

/// Decoded layer by layer, while slices are drawn.
pub fn ring<'a>(codec: &'a str, decoder: &'a dyn Decoder) -> DrawSource<'a> {
    DrawSource::Ring { codec, decoder, frame: FrameIndex::FIRST, level: Level::FULL }
}

/// Decoded on the CPU, in a texture.
pub fn host(device: &Device, decoder: &dyn Decoder) -> DrawSource<'static> {
    let frame = DecodedFrame::decode(decoder, FrameIndex::FIRST).unwrap();
    let texture =
        VolumeTexture::upload(device, decoder.layout(), frame.values(), decoder.decoded_form()).unwrap();
    DrawSource::Texture(Arc::new(texture))
}

/// Decoded by the device, in a texture.
pub fn deferred(device: &Device, codec: &str, decoder: &dyn Decoder) -> DrawSource<'static> {
    let (frame, level) = (FrameIndex::FIRST, Level::FULL);
    let (texture, _) = VolumeTexture::decode(device, codec, decoder, frame, level).unwrap();
    DrawSource::Texture(Arc::new(texture))
}

/// The source of a site.
pub fn source<'a>(device: &Device, site: Site, codec: &'a str, decoder: &'a dyn Decoder) -> DrawSource<'a> {
    let target = Target::Device(device.clone());
    let coded = CodedFrame { codec, decoder, key: (FrameIndex::FIRST, Level::FULL) };
    let decoded = || DecodedFrame::decode(decoder, coded.key.0).map(Arc::new).map_err(|e| e.to_string());
    VoxelSource::prepare(&target, site, coded, &decoded).unwrap().held.source(coded).unwrap()
}

/// The result of a run's own comparison of a held frame.
pub fn checked(device: &Device, site: Site, codec: &str, decoder: &dyn Decoder) -> Checked {
    let target = Target::Device(device.clone());
    let key = (FrameIndex::FIRST, Level::FULL);
    let frame = Arc::new(DecodedFrame::decode(decoder, key.0).unwrap());
    let expected = Expected { codec, decoder, key, frame, block: None };
    let decoded = || Ok(expected.frame.clone());
    let held = VoxelSource::prepare(&target, site, expected.coded(), &decoded).unwrap().held;
    held.check(&target, &expected, false).unwrap().unwrap()
}

/// A raycast picture on the device, and whether its texture unit interpolated.
pub fn draw(device: &Device, view: &View, source: &DrawSource<'_>) -> (Image, TextureSampling) {
    let (image, drawing) = draw_by(device, &Raycasting, view, source);
    (image, drawing.filtering())
}

/// A picture on the device by any renderer, and its filtering unit.
pub fn draw_by(
    device: &Device,
    renderer: &dyn Renderer,
    view: &View,
    source: &DrawSource<'_>,
) -> (Image, Drawing) {
    let plan = match source {
        DrawSource::Ring { .. } => renderer.plan_layers(view, &source.layout()).unwrap(),
        _ => renderer.plan(view, &source.layout()).unwrap(),
    };
    let drawing = Drawing::new(device, &plan, source, view.filter).unwrap();
    drawing.draw_timed().unwrap();
    (drawing.read_image().unwrap(), drawing)
}

/// The same raycast picture by the CPU mirror.
pub fn mirror(view: &View, decoder: &dyn Decoder) -> Image {
    mirror_by(&Raycasting, view, decoder)
}

/// The same picture by the CPU mirror of any renderer.
pub fn mirror_by(renderer: &dyn Renderer, view: &View, decoder: &dyn Decoder) -> Image {
    let frame = DecodedFrame::decode(decoder, FrameIndex::FIRST).unwrap();
    let mut image = Image::new(view.size);
    renderer.reference(view, &frame, &mut image).unwrap();
    image
}

/// Tolerance between a picture and its mirror, by filtering unit.
pub fn rule(filtering: TextureSampling) -> AgreementRule {
    match filtering {
        TextureSampling::Hardware => AgreementRule::HARDWARE,
        TextureSampling::Manual => AgreementRule::MANUAL,
    }
}

/// Whether slices are summed in single precision, as the rule for manual filters requires. If a device blends in half
/// precision, a line says which part of this test did not run.
pub fn sums_single(device: &Device, what: &str) -> bool {
    let single = device.blends_single();
    if !single {
        lacking(what, &"no blending in single precision");
    }
    single
}

/// Smooth structures of a few voxels with a little noise, over the whole domain.
pub fn textured(size: [u32; 3], spacing: [f64; 3], sample: SampleType) -> FiniteVolume {
    let (low, high) = domain(sample);
    let (low, high) = (f64::from(low), f64::from(high));
    volume(size, spacing, sample, |p| {
        let [x, y, z] = p.map(f64::from);
        let waves = (0.9 * x + 0.3 * z).sin() * (0.7 * y - 0.2 * x).cos() * (0.5 * z + 0.4).sin();
        let noise = f64::from(hash(p)) / f64::from(u32::MAX) - 0.5;
        low + (high - low) * (0.5 + 0.42 * waves + 0.15 * noise)
    })
}
