//! Skipping empty macrocells changes no picture of the CPU mirror, bit for bit.

use std::fmt;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

use cvr::registry::{Names, renderer};
use cvr_codec_tests::offering;
use cvr_core::codec::{
    DecodeError, Decoder, Setting, SettingKind, SettingValue, Settings, Site, decode_stages,
};
use cvr_core::pipeline::parse_colour;
use cvr_core::render::{
    Camera, Cell, ClipBox, ControlPoint, DecodedFrame, Filter, Image, MacrocellRanges, Macrocells,
    Projection, RenderError, Renderer, Shading, TransferFunction, View, Voxels,
};
use cvr_core::volume::{
    BrickKey, BrickSource as _, DenseVolume, Extent, FiniteVolume, FrameIndex, Level, NoReferences,
    ReferenceFrames, Region, SampleType, Samples, VolumeLayout,
};

use super::volumes::{declined_or_opened, floats, opened, spaced, varied};

const RENDERERS: [&str; 5] = [
    "raycasting",
    "slicing",
    "slicing,geometry=axis",
    "slicing,geometry=shells",
    "slicing,opacity_correction=lerp",
];

/// Volumes of values from 0 to 255 that are mostly 0, with exceptions at critical places.
fn volumes() -> Vec<(String, DenseVolume)> {
    let mut volumes = Vec::new();
    let hash = |p: [u32; 3]| p.iter().fold(7_u32, |h, v| (h ^ v).wrapping_mul(0x9e37_79b1).rotate_left(13));
    volumes.push((
        "sparse".to_owned(),
        floats([19, 13, 34], |p| if hash(p).is_multiple_of(997) { 200.0 } else { 0.0 }),
    ));
    let checkered =
        |p: [u32; 3]| if p.iter().map(|v| v / 8).sum::<u32>().is_multiple_of(2) { 160.0 } else { 0.0 };
    volumes.push(("checkerboard".to_owned(), spaced(&floats([20, 24, 17], checkered), [1.0, 1.7, 0.4])));
    // On faces, edges and corners of macrocells, on the volume's own corners, and between.
    for hot in [[[8, 12, 3], [4, 11, 9], [16, 23, 17]], [[7, 8, 12], [15, 15, 16], [0, 0, 0]]] {
        let volume = floats([17, 24, 18], |p| if hot.contains(&p) { 255.0 } else { 0.0 });
        volumes.push((format!("hot voxels {hot:?}"), volume));
    }
    for size in [[1, 33, 17], [33, 1, 9], [1, 1, 40]] {
        let volume = floats(size, |p| if p.iter().sum::<u32>() % 16 == 8 { 130.0 } else { 0.0 });
        volumes.push((format!("slab {size:?}"), volume));
    }
    volumes
}

fn function(points: &[(f32, &str)]) -> Arc<TransferFunction> {
    let point = |(value, colour): &(f32, &str)| {
        let ([r, g, b], alpha) = parse_colour(colour).unwrap();
        ControlPoint { value: *value, rgba: [r, g, b, alpha.unwrap()] }
    };
    Arc::new(TransferFunction::new(points.iter().map(point).collect()).unwrap())
}

/// High values, from the first point on; a window between the values, which only interpolation reaches; low values.
fn functions() -> [Arc<TransferFunction>; 3] {
    [
        function(&[(60.0, "#ff804000"), (100.0, "#ffc040e0"), (255.0, "#ffffffff")]),
        function(&[
            (0.0, "#00000000"),
            (70.0, "#40ff8000"),
            (90.0, "#40ff80ff"),
            (110.0, "#40ff8000"),
            (255.0, "#00000000"),
        ]),
        function(&[(0.0, "#2040ff30"), (20.0, "#2040ff00")]),
    ]
}

/// Oblique, along each axis and within planes across it, and from very near.
fn cameras() -> Vec<Camera> {
    use Projection::{Orthographic, Perspective};
    let camera = |azimuth, elevation, projection| Camera {
        azimuth,
        elevation,
        projection,
        zoom: 1.2,
        ..Camera::default()
    };
    vec![
        camera(30.0, 20.0, Perspective),
        camera(-130.0, -35.0, Orthographic),
        camera(0.0, 0.0, Orthographic),
        camera(90.0, 0.0, Orthographic),
        camera(0.0, 90.0, Orthographic),
        camera(45.0, 0.0, Orthographic),
        camera(180.0, 0.0, Perspective),
        Camera { zoom: 5.0, ..camera(-20.0, -70.0, Perspective) },
    ]
}

/// Every camera with every filter. Steps, clip boxes and light alternate, so that all pairs occur.
fn views(function: &Arc<TransferFunction>, turn: &mut usize) -> Vec<View> {
    let mut views = Vec::new();
    for camera in cameras() {
        for filter in [Filter::Nearest, Filter::Linear] {
            for step_voxels in [0.3, 1.0, 4.7, 30.0] {
                let lit = *turn % 3 == 1;
                let clip = [None, Some(ClipBox { low: [0.2, 0.31, 0.1], high: [0.8, 0.9, 1.0] })][*turn % 2];
                // Odd, so that a column and a row of rays lie on the faces in the middle of the volume.
                let size = [[31, 25], [25, 25]][*turn % 2];
                let shading = lit.then(Shading::default);
                let plain = View { size, camera, filter, step_voxels, ..View::new(function.clone()) };
                views.push(View { shading, clip, termination: [1.0, 0.9][*turn % 2], ..plain });
                *turn += 1;
            }
        }
    }
    views
}

/// High values where the volume has low ones.
fn upside_down(volume: &DenseVolume) -> DenseVolume {
    let Samples::F32(values) = volume.samples() else { panic!("floats") };
    let samples = Samples::F32(values.iter().map(|v| 255.0 - v).collect());
    DenseVolume::new(volume.layout().clone(), samples).unwrap()
}

fn raw(volume: &DenseVolume) -> Box<dyn Decoder> {
    let names = Names::new().unwrap();
    let codec = names.codecs().get("raw").unwrap();
    opened(codec.as_ref(), &codec.info().default_settings(), &FiniteVolume::new(volume.clone()))
}

fn ranges(decoder: &dyn Decoder) -> MacrocellRanges {
    let stop = AtomicBool::new(false);
    MacrocellRanges::decode(decoder, FrameIndex::FIRST, Level::FULL, &stop).unwrap().unwrap()
}

fn skipping(view: &View, macrocells: Macrocells) -> View {
    View { macrocells: Some(Arc::new(macrocells)), ..view.clone() }
}

fn draw(renderer: &dyn Renderer, view: &View, voxels: &dyn Voxels) -> Image {
    let mut image = Image::new(view.size);
    renderer.reference(view, voxels, &mut image).unwrap();
    image
}

/// Pixels that differ in any bit.
fn mismatches(a: &Image, b: &Image) -> usize {
    let bits = |p: &[f32; 4]| p.map(f32::to_bits);
    a.pixels().iter().zip(b.pixels()).filter(|(a, b)| bits(a) != bits(b)).count()
}

fn is_visible(image: &Image) -> bool {
    image.pixels().iter().any(|p| p[3] > 0.0)
}

#[test]
fn pictures_are_the_same_bit_for_bit() {
    let (mut drawn, mut telling, mut turn) = (0, 0, 0);
    for (name, volume) in volumes() {
        let decoder = raw(&volume);
        let inverted = raw(&upside_down(&volume));
        for (function, decoder) in functions().into_iter().zip([&decoder, &decoder, &inverted]) {
            let macrocells = ranges(decoder.as_ref()).classify(&function);
            let frame = DecodedFrame::decode(decoder.as_ref(), FrameIndex::FIRST).unwrap();
            for view in views(&function, &mut turn) {
                let skipping = skipping(&view, macrocells.clone());
                // Each renderer draws every kind of view, but not every view.
                let renderer = renderer(RENDERERS[turn_of(drawn)]).unwrap();
                let without = draw(renderer.as_ref(), &view, &frame);
                let with = draw(renderer.as_ref(), &skipping, &frame);
                let differing = mismatches(&with, &without);
                assert_eq!(differing, 0, "{name}, {renderer:?}, {view:?}");
                drawn += 1;
                telling += usize::from(macrocells.empty_share() > 0.0 && is_visible(&without));
            }
        }
    }
    assert!(drawn > 1300 && telling > drawn / 4, "{telling} of {drawn} pictures tell anything");
}

/// Runs through the renderers at a pace that divides nothing else.
fn turn_of(drawn: usize) -> usize {
    (drawn + drawn / RENDERERS.len() + drawn / 64) % RENDERERS.len()
}

/// A decoded frame that counts reads.
struct Counted {
    frame: DecodedFrame,
    reads: AtomicU64,
}

impl Voxels for Counted {
    fn layout(&self) -> &VolumeLayout {
        self.frame.layout()
    }

    fn fetch(&self, p: [u32; 3]) -> Result<[f32; 4], RenderError> {
        self.reads.fetch_add(1, Ordering::Relaxed);
        self.frame.fetch(p)
    }

    fn fetch_cell(&self, p: [u32; 3], q: [u32; 3]) -> Result<Cell, RenderError> {
        self.reads.fetch_add(8, Ordering::Relaxed);
        self.frame.fetch_cell(p, q)
    }
}

#[test]
fn what_is_skipped_is_not_read() {
    let volume = floats([64, 64, 64], |p| if p.iter().all(|v| (28..36).contains(v)) { 200.0 } else { 0.0 });
    let decoder = raw(&volume);
    let macrocells = ranges(decoder.as_ref()).classify(&functions()[0]);
    assert!(macrocells.empty_share() > 0.9);
    let frame = DecodedFrame::decode(decoder.as_ref(), FrameIndex::FIRST).unwrap();
    for label in RENDERERS {
        for camera in cameras() {
            let voxels = Counted { frame: frame.clone(), reads: AtomicU64::new(0) };
            let view = View { size: [33, 33], camera, ..View::new(functions()[0].clone()) };
            let reads = |view: &View| {
                voxels.reads.store(0, Ordering::Relaxed);
                draw(renderer(label).unwrap().as_ref(), view, &voxels);
                voxels.reads.load(Ordering::Relaxed)
            };
            let (all, some) = (reads(&view), reads(&skipping(&view, macrocells.clone())));
            // Straight through the middle, most of a ray is not empty.
            assert!(some > 0 && 2 * some < all, "{label} {camera:?}: {some} of {all}");
        }
    }
}

/// Empty voxels, ten million times as long as wide: a ray along them ends, for any number of samples.
#[test]
fn rays_through_any_spacing_end() {
    let long = spaced(&floats([3, 3, 64], |_| 0.0), [1.0, 1.0, 1e7]);
    let decoder = raw(&long);
    let frame = DecodedFrame::decode(decoder.as_ref(), FrameIndex::FIRST).unwrap();
    for camera in cameras() {
        let view = View { size: [5, 5], camera, step_voxels: 1.0, ..View::new(functions()[0].clone()) };
        let skipping = skipping(&view, ranges(decoder.as_ref()).classify(&functions()[0]));
        assert!(!is_visible(&draw(renderer("raycasting").unwrap().as_ref(), &skipping, &frame)));
    }
}

/// The twins: macrocells that show too little are detected. They miss the volume's one high voxel, or they have no
/// apron and it lies just outside.
#[test]
fn macrocells_that_say_too_little_change_pictures() {
    let bright =
        function(&[(0.0, "#00000000"), (10.0, "#ffffff00"), (20.0, "#ffffffff"), (255.0, "#ffffffff")]);
    let differing =
        |label: &str, hot: [u32; 3], filter, bounds: &dyn Fn(&dyn Decoder) -> Macrocells| -> usize {
            let decoder = raw(&floats([24, 24, 24], |p| if p == hot { 255.0 } else { 0.0 }));
            let frame = DecodedFrame::decode(decoder.as_ref(), FrameIndex::FIRST).unwrap();
            let renderer = renderer(label).unwrap();
            let of = |camera: Camera| {
                let view = View { size: [49, 49], camera, filter, ..View::new(bright.clone()) };
                let without = draw(renderer.as_ref(), &view, &frame);
                assert!(is_visible(&without));
                let with = draw(renderer.as_ref(), &skipping(&view, bounds(decoder.as_ref())), &frame);
                mismatches(&with, &without)
            };
            cameras().into_iter().filter(|camera| camera.zoom < 2.0).map(of).sum()
        };
    let honest = |decoder: &dyn Decoder| ranges(decoder).classify(&bright);
    let empty = raw(&floats([24, 24, 24], |_| 0.0));
    let cleared = |_: &dyn Decoder| ranges(empty.as_ref()).classify(&bright);
    let unaproned = |decoder: &dyn Decoder| ranges(&Unaproned(decoder)).classify(&bright);
    for label in RENDERERS {
        for filter in [Filter::Nearest, Filter::Linear] {
            assert_eq!(differing(label, [12, 12, 12], filter, &honest), 0, "{label}");
            assert!(differing(label, [12, 12, 12], filter, &cleared) > 0, "{label}");
        }
        for hot in [[8, 12, 12], [12, 7, 12], [12, 12, 16]] {
            assert_eq!(differing(label, hot, Filter::Linear, &honest), 0, "{label}");
            assert!(differing(label, hot, Filter::Linear, &unaproned) > 0, "{label} {hot:?}");
        }
    }
}

/// Decodes the apron of a macrocell as the nearest voxels of the macrocell itself.
struct Unaproned<'a>(&'a dyn Decoder);

impl fmt::Debug for Unaproned<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Unaproned")
    }
}

impl Decoder for Unaproned<'_> {
    fn layout(&self) -> &VolumeLayout {
        self.0.layout()
    }

    fn decode_brick(
        &self,
        key: BrickKey,
        references: &dyn ReferenceFrames,
        out: &mut [f32],
    ) -> Result<(), DecodeError> {
        self.0.decode_brick(key, references, out)?;
        let (extent, whole) = (key.region.extent, self.layout().extent.to_array());
        let inside = |at: [u32; 3]| -> [u32; 3] {
            std::array::from_fn(|a| {
                let (origin, size) = (key.region.origin[a], extent.to_array()[a]);
                let low = u32::from(origin > 0);
                let high = if origin + size < whole[a] { size - 2 } else { size - 1 };
                at[a].clamp(low, high)
            })
        };
        let original = out.to_vec();
        for (i, value) in out.iter_mut().enumerate() {
            *value = original[extent.index(inside(extent.position(i)))];
        }
        Ok(())
    }
}

/// Checks every value of a level against the ranges of all macrocells within reach. Returns the number of checks.
fn held(decoder: &dyn Decoder, stages: u8, name: &str) -> usize {
    let (stop, level) = (AtomicBool::new(false), Level { stages, ..Level::FULL });
    let ranges = MacrocellRanges::decode(decoder, FrameIndex::FIRST, level, &stop).unwrap().unwrap();
    let extent = decoder.layout().extent;
    let frame = decode_stages(decoder, FrameIndex::FIRST, stages, &NoReferences).unwrap();
    let size = Extent::cube(Macrocells::EDGE).unwrap();
    assert_eq!(ranges.grid(), extent.blocks_of(size));
    let mut values = 0;
    for cell in (0..ranges.grid().voxels() as usize).map(|i| ranges.grid().position(i)) {
        let range = ranges.range(cell).unwrap();
        let region = Region::block(cell, size, extent).with_apron(1, extent);
        for row in region.rows() {
            let first = extent.index(row);
            for value in &frame[first..first + region.extent.x() as usize] {
                assert!(range.contains(*value), "{name} {cell:?}: {value} in {range:?}");
                values += 1;
            }
        }
    }
    values
}

/// A few values of a setting, from one end of its range to the other. For an open range, its cheap side.
fn values_of(setting: &Setting) -> Vec<SettingValue> {
    let block = |size: String| SettingValue::Text(size);
    match setting.kind {
        SettingKind::Integer { min, max } => {
            [min, (min + 14).min(max), (min + 298).min(max)].map(SettingValue::Integer).into()
        }
        SettingKind::OneOf(numbers) => {
            [0, numbers.len() / 2, numbers.len() - 1].map(|i| SettingValue::Integer(numbers[i])).into()
        }
        SettingKind::Float { min, max } => {
            [0.0, 0.03, 0.25].map(|part| SettingValue::Float(min + (max - min) * part)).into()
        }
        SettingKind::Choice(words) => words.iter().map(|w| SettingValue::Text((*w).to_owned())).collect(),
        SettingKind::Boolean => [false, true].map(SettingValue::Boolean).into(),
        SettingKind::Block { max } => {
            ["3x5x2".to_owned(), "4".to_owned(), max.min(16).to_string()].map(block).into()
        }
        SettingKind::Text { .. } => vec![setting.default.into()],
    }
}

/// Every decoded value of a codec lies in the ranges of all macrocells within reach, at each level.
#[test]
fn ranges_hold_every_decoded_value() {
    let names = Names::new().unwrap();
    let mut values = 0;
    for codec in names.codecs().iter() {
        let setting = codec.info().settings.iter().find(|s| !matches!(s.kind, SettingKind::Text { .. }));
        let choices = setting.into_iter().flat_map(values_of).map(|choice| {
            let mut settings = Settings::default();
            settings.set(setting.unwrap().name, choice);
            codec.info().complete(&settings).unwrap()
        });
        for settings in choices.chain(offering(codec.as_ref(), Site::Inline)) {
            for sample in [SampleType::U8, SampleType::I16, SampleType::F32] {
                let volume = varied([19, 8, 25], sample, 1);
                let Ok(decoder) = declined_or_opened(codec.as_ref(), &settings, &volume) else { continue };
                for stages in (1..codec.stages(&settings)).chain([Level::ALL_STAGES]) {
                    let name = format!("{settings} {sample}, stages {stages}");
                    values += held(decoder.as_ref(), stages, &name);
                }
            }
        }
    }
    assert!(values > 50_000, "{values}");
}
