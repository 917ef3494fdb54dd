//! Time of a further view of a volume, compared with the first view and with drawing alone.
//! `docs/benchmarks/further-views.md` gives the command and the figures.

#![allow(clippy::unwrap_used, clippy::expect_used, reason = "a benchmark may end in a panic")]

use std::borrow::Cow;
use std::sync::Arc;
use std::time::Instant;

use cvr::registry::{Names, renderer};
use cvr_core::codec::{
    Agreement, DecodeError, DecodedForm, Decoder, Resource, Settings, ShaderDecode, WgslModule,
    encode_temporary,
};
use cvr_core::render::{Camera, ControlPoint, Filter, Renderer, TransferFunction, View};
use cvr_core::volume::{
    BrickKey, DenseVolume, Extent, FiniteVolume, FrameIndex, Level, ReferenceFrames, SampleType, Samples,
    VolumeLayout,
};
use cvr_engine::{Device, DeviceChoice, DrawSource, Drawing};

const EDGE: u32 = 64;
const VIEWS: u16 = 24;

fn volume() -> FiniteVolume {
    let value = |i: u32| {
        let [x, y, z] = [i % EDGE, i / EDGE % EDGE, i / EDGE / EDGE].map(f64::from);
        let wave = (0.19 * x + 0.06 * z).sin() * (0.14 * y - 0.04 * x).cos() * (0.1 * z + 0.4).sin();
        (127.5 + 127.5 * wave) as u8
    };
    let layout = VolumeLayout::scalar(Extent::cube(EDGE).unwrap(), SampleType::U8);
    let samples = Samples::U8((0..EDGE.pow(3)).map(value).collect());
    FiniteVolume::new(DenseVolume::new(layout, samples).unwrap())
}

fn view(i: u16) -> View {
    let point = |value, rgba| ControlPoint { value, rgba };
    let function = TransferFunction::new(vec![
        point(0.0, [0.1, 0.1, 0.8, 0.0]),
        point(127.0, [0.9, 0.7, 0.2, 0.05]),
        point(255.0, [1.0, 0.9, 0.8, 0.3]),
    ]);
    let camera = Camera { azimuth: f64::from(i) * 360.0 / f64::from(VIEWS), ..Camera::default() };
    View {
        size: [128, 128],
        camera,
        termination: 0.999,
        filter: Filter::Linear,
        ..View::new(function.unwrap())
    }
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

fn ms<T>(run: impl FnOnce() -> T) -> (f64, T) {
    let start = Instant::now();
    let made = run();
    (start.elapsed().as_secs_f64() * 1000.0, made)
}

/// First view, further view and drawing alone, in milliseconds.
fn measure(device: &Device, renderer: &dyn Renderer, source: &DrawSource<'_>) -> [f64; 3] {
    let layout = source.layout();
    let plan = |i| renderer.plan(&view(i), &layout).unwrap();
    device.forget_pipelines();
    let (first, mut drawing) = ms(|| {
        let drawing = Drawing::new(device, &plan(0), source, view(0).filter).unwrap();
        drawing.draw().unwrap();
        drawing
    });
    let (mut further, mut alone) = (Vec::new(), Vec::new());
    for i in 1..VIEWS {
        further.push(
            ms(|| {
                drawing.set_inputs(&plan(i)).unwrap();
                drawing.draw().unwrap();
            })
            .0,
        );
        alone.push(ms(|| drawing.draw().unwrap()).0);
    }
    [first, median(further), median(alone)]
}

/// A decoder whose snippet reads the number of stages from a buffer.
#[derive(Debug)]
struct StagesRead {
    inner: Box<dyn Decoder>,
    source: String,
}

impl StagesRead {
    fn new(id: &str, inner: Box<dyn Decoder>) -> Self {
        let source = inner.shader().unwrap().module().source.to_owned();
        let asked = format!("{id}_stages()");
        assert!(source.contains(&asked));
        Self { source: source.replace(&asked, &format!("{id}_asked(0u)")), inner }
    }
}

impl Decoder for StagesRead {
    fn layout(&self) -> &VolumeLayout {
        self.inner.layout()
    }

    fn decode_brick(
        &self,
        key: BrickKey,
        references: &dyn ReferenceFrames,
        out: &mut [f32],
    ) -> Result<(), DecodeError> {
        self.inner.decode_brick(key, references, out)
    }

    fn decoded_form(&self) -> DecodedForm {
        self.inner.decoded_form()
    }

    fn shader(&self) -> Option<&dyn ShaderDecode> {
        Some(self)
    }
}

impl ShaderDecode for StagesRead {
    fn module(&self) -> WgslModule<'_> {
        WgslModule { source: &self.source, ..self.inner.shader().unwrap().module() }
    }

    fn agreement(&self) -> Agreement {
        self.inner.shader().unwrap().agreement()
    }

    fn resources(&self, frame: FrameIndex) -> Result<Vec<Resource<'_>>, DecodeError> {
        let mut resources = self.inner.shader().unwrap().resources(frame)?;
        resources.push(Resource { name: "asked", words: Cow::Owned(vec![u32::from(Level::ALL_STAGES)]) });
        Ok(resources)
    }
}

fn decoder(names: &Names, id: &str) -> Box<dyn Decoder> {
    let codec = names.codecs().get(id).unwrap();
    let settings = codec.info().complete(&Settings::default()).unwrap();
    let stream = encode_temporary(codec.as_ref(), &settings, &volume()).unwrap();
    codec.decoder(Arc::new(stream)).unwrap()
}

fn inline<'a>(codec: &'a str, decoder: &'a dyn Decoder) -> DrawSource<'a> {
    DrawSource::Inline { codec, decoder, frame: FrameIndex::FIRST, level: Level::FULL }
}

/// Milliseconds of a picture with the number of stages as a constant, and of one that reads it, timed alternately.
fn stages(device: &Device, id: &str, decoders: [Box<dyn Decoder>; 2]) -> [f64; 2] {
    let [constant, read] = decoders;
    let read = StagesRead::new(id, read);
    let view = view(0);
    let draw = |decoder: &dyn Decoder| {
        let plan = renderer("raycasting").unwrap().plan(&view, decoder.layout()).unwrap();
        let drawing = Drawing::new(device, &plan, &inline(id, decoder), view.filter).unwrap();
        drawing.draw().unwrap();
        drawing
    };
    let [constant, read] = [constant.as_ref(), &read].map(draw);
    let pairs: Vec<_> =
        (0..VIEWS).map(|_| [&constant, &read].map(|drawing| ms(|| drawing.draw().unwrap()).0)).collect();
    [0, 1].map(|side| median(pairs.iter().map(|pair| pair[side]).collect()))
}

fn main() {
    let device = Device::open(&DeviceChoice::Auto).unwrap();
    println!("{}", device.info());
    println!(
        "| codec | renderer | first view | further view | drawing alone | further ÷ first | further ÷ alone |"
    );
    println!("|---|---|---|---|---|---|---|");
    let names = Names::new().unwrap();
    for id in ["raw", "s3dc", "tvq"] {
        let decoder = decoder(&names, id);
        for label in ["raycasting", "slicing"] {
            let source = inline(id, decoder.as_ref());
            let [first, further, alone] = measure(&device, renderer(label).unwrap().as_ref(), &source);
            println!(
                "| {id} | {label} | {first:.1} ms | {further:.1} ms | {alone:.1} ms | {:.3} | {:.2} |",
                further / first,
                further / alone
            );
        }
    }
    println!("\n| codec | stages in the text | stages read at run time |\n|---|---|---|");
    for id in ["hvq", "tvq"] {
        let [constant, read] = stages(&device, id, [decoder(&names, id), decoder(&names, id)]);
        println!("| {id} | {constant:.1} ms | {read:.1} ms, {:.2} × |", read / constant);
    }
}
