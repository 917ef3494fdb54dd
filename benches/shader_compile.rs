//! Time until generated shaders have drawn, and the number of copies of the decoder in each.
//!
//! ```text
//! MESA_SHADER_CACHE_DISABLE=true cargo bench --bench shader_compile [-- CODEC …]
//! ```
//!
//! Every codec × channels × renderer × filter × optics at the site *inline*, then the decoding and dumping passes. Each
//! shader is generated, compiled and run once over a few pixels, because drivers compile as late as that. The CPU time
//! of the process is measured, because other work on the machine does not affect it.

#[path = "../tests/host/copies.rs"]
#[allow(dead_code, clippy::unwrap_used, reason = "it is a module of tests, which use the rest")]
mod copies;

use std::error::Error;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::{Duration, Instant};

use cvr::registry::{Names, renderer};
use cvr_core::codec::{Codec, Decoder, SettingValue, Settings, Site, encode_temporary};
use cvr_core::render::{
    ClipBox, ControlPoint, Filter, MacrocellRanges, Pass, Shading, TransferFunction, View,
};
use cvr_core::shader::{BindingLimits, GeneratedShader, Request, ResourceSize, Source, generate};
use cvr_core::volume::{
    DenseVolume, Extent, FiniteVolume, FrameIndex, Level, SampleType, Samples, VolumeLayout,
};
use cvr_engine::{Device, DeviceChoice, DrawSource, Drawing, VolumeTexture, process_cpu_time};

type Outcome<T> = Result<T, Box<dyn Error>>;

/// Not a multiple of any block.
const SIZE_VOXELS: [u32; 3] = [9, 7, 5];
const SIZE_PIXELS: [u32; 2] = [8, 8];
const RENDERERS: [&str; 2] = ["raycasting", "slicing"];
const FRAME: (FrameIndex, Level) = (FrameIndex::FIRST, Level::FULL);

/// The parts of a scene besides its transfer function.
#[derive(Copy, Clone)]
enum Optics {
    Unlit,
    Lit,
    /// Lit, clipped, and empty space skipped.
    Everything,
}

/// The defaults of every codec, and settings with which its snippet takes another path. Settings whose volumes have no
/// snippet are left out.
const MORE: [(&str, &[(&str, &str)]); 5] = [
    ("tvq", &[("payload", "variable"), ("rate", "0.5")]),
    ("s3dc", &[("block", "3x5x2")]),
    ("wavelet", &[("block", "8"), ("filter", "haar")]),
    ("wavelet", &[("block", "16"), ("filter", "5-3")]),
    ("zfp", &[("rate", "16")]),
];

fn main() -> Outcome<()> {
    let wanted: Vec<String> = std::env::args().skip(1).filter(|arg| !arg.starts_with("--")).collect();
    if std::env::var_os("MESA_SHADER_CACHE_DISABLE").is_none() {
        eprintln!(
            "MESA_SHADER_CACHE_DISABLE is not set: shaders of an earlier run may be found in Mesa's cache."
        );
    }
    let device = Device::open(&DeviceChoice::Auto)?;
    println!("{}\n", device.info());
    let names = Names::new()?;
    let mut slowest = (Duration::ZERO, String::new());
    print!("| codec | channels |");
    for renderer in RENDERERS {
        for filter in Filter::ALL {
            print!(" {renderer}, {filter} |");
        }
    }
    println!(" decode | dump | dump cells |\n|{}", "---|".repeat(2 + 2 * Filter::ALL.len() + 3));
    for codec in names.codecs().iter() {
        let id = codec.info().id;
        if !wanted.is_empty() && !wanted.iter().any(|w| w == id) {
            continue;
        }
        let more = MORE.iter().filter(|(of, _)| *of == id).map(|(_, pairs)| *pairs);
        for pairs in [&[][..]].into_iter().chain(more) {
            if !codec.offers(&codec.info().complete(&given(pairs))?, Site::Inline) {
                continue;
            }
            for channels in [1, 3] {
                let row = Row { device: &device, codec: codec.as_ref(), pairs, channels };
                let (cells, longest) = row.measured()?;
                println!("| {} | {channels} | {} |", row.label(), cells.join(" | "));
                slowest = slowest.max(longest);
            }
        }
    }
    println!("\nslowest: {:.2} s, {}", slowest.0.as_secs_f64(), slowest.1);
    Ok(())
}

/// Settings of a row.
fn given(pairs: &[(&str, &str)]) -> Settings {
    pairs.iter().map(|(name, value)| ((*name).to_owned(), SettingValue::from(*value))).collect()
}

/// One codec with its settings.
struct Row<'a> {
    device: &'a Device,
    codec: &'a dyn Codec,
    pairs: &'a [(&'a str, &'a str)],
    channels: u32,
}

impl Row<'_> {
    fn label(&self) -> String {
        let pairs = self.pairs.iter().map(|(name, value)| format!(", {name} = {value}"));
        format!("{}{}", self.codec.info().id, pairs.collect::<String>())
    }

    /// The columns, and the slowest of all shaders.
    fn measured(&self) -> Outcome<(Vec<String>, (Duration, String))> {
        let stream = encode_temporary(self.codec, &given(self.pairs), &volume(self.channels)?)?;
        let decoder = self.codec.decoder(Arc::new(stream))?;
        let decoder = decoder.as_ref();
        let (mut cells, mut slowest) = (Vec::new(), (Duration::ZERO, String::new()));
        let mut noted = |time: Duration, what: &str| {
            let what = format!("{}, {} channels, {what}", self.label(), self.channels);
            eprintln!("{:.2} s {what}", time.as_secs_f64());
            slowest = std::mem::take(&mut slowest).max((time, what));
        };
        for label in RENDERERS {
            for filter in Filter::ALL {
                if filter == Filter::OptimisedLinear && !self.codec.info().fetch_cell {
                    cells.push("–".to_owned());
                    continue;
                }
                let mut scenes = Vec::new();
                for (optics, name) in
                    [(Optics::Unlit, "unlit"), (Optics::Lit, "lit"), (Optics::Everything, "everything")]
                {
                    let view = view(filter, optics, decoder)?;
                    let (time, copies) = self.drawn(label, &view, decoder)?;
                    noted(time, &format!("{label}, {filter}, {name}"));
                    scenes.push(format!("{:.2} ({copies})", time.as_secs_f64()));
                }
                cells.push(scenes.join(", "));
            }
        }
        let id = self.codec.info().id;
        let source = DrawSource::Inline { codec: id, decoder, frame: FRAME.0, level: FRAME.1 };
        let dump = |template| self.device.dump_source(&source, template).map(drop);
        let mut pass = |what: &str, run: &dyn Fn() -> Result<(), cvr_engine::EngineError>| {
            self.device.forget_pipelines();
            let before = clock();
            run()?;
            let time = clock() - before;
            noted(time, what);
            cells.push(format!("{:.2}", time.as_secs_f64()));
            Outcome::Ok(())
        };
        pass("decode", &|| VolumeTexture::decode(self.device, id, decoder, FRAME.0, FRAME.1).map(drop))?;
        pass("dump", &|| dump(cvr_shaders::DUMP))?;
        match self.codec.info().fetch_cell {
            true => pass("dump cells", &|| dump(cvr_shaders::DUMP_CELL))?,
            false => cells.push("–".to_owned()),
        }
        Ok((cells, slowest))
    }

    /// CPU time until a shader has drawn, and its number of decoders. Slices are compiled twice, for drawing and for
    /// the check; the time is their mean.
    fn drawn(&self, label: &str, view: &View, decoder: &dyn Decoder) -> Outcome<(Duration, u64)> {
        let id = self.codec.info().id;
        let plan = renderer(label)?.plan(view, decoder.layout())?;
        let source = DrawSource::Inline { codec: id, decoder, frame: FRAME.0, level: FRAME.1 };
        self.device.forget_pipelines();
        let before = clock();
        let drawing = Drawing::new(self.device, &plan, &source, view.filter)?;
        drawing.draw_timed()?;
        let time = clock() - before;
        let [pass] = &plan.passes[..] else { return Err("a plan of several passes".into()) };
        let shaders = if pass.pipeline.proxies().is_some() { 2 } else { 1 };
        Ok((time / shaders, copies::decoders(id, &shader(pass, view.filter, id, decoder)?)))
    }
}

/// CPU time of this process. If the system does not report it, elapsed time.
fn clock() -> Duration {
    static START: std::sync::LazyLock<Instant> = std::sync::LazyLock::new(Instant::now);
    process_cpu_time().unwrap_or_else(|| START.elapsed())
}

fn shader(pass: &Pass, filter: Filter, codec: &str, decoder: &dyn Decoder) -> Outcome<GeneratedShader> {
    let shader = decoder.shader().ok_or("a codec without a snippet")?;
    let resources = shader.resources(FRAME.0)?.iter().map(ResourceSize::of).collect();
    let source = Source::Inline { codec, module: shader.module(), resources, frame: FRAME.0, level: FRAME.1 };
    Ok(generate(&Request {
        program: &pass.pipeline.program(),
        layout: decoder.layout(),
        source,
        filter: Some(filter),
        limits: BindingLimits::default(),
    })?)
}

fn view(filter: Filter, optics: Optics, decoder: &dyn Decoder) -> Outcome<View> {
    let point = |value, alpha| ControlPoint { value, rgba: [1.0, 0.5, 0.25, alpha] };
    let function = TransferFunction::new(vec![point(20.0, 0.0), point(100.0, 0.3), point(200.0, 0.1)])?;
    let view = View { size: SIZE_PIXELS, filter, ..View::new(function) };
    Ok(match optics {
        Optics::Unlit => view,
        Optics::Lit => View { shading: Some(Shading::default()), ..view },
        Optics::Everything => {
            let never = AtomicBool::new(false);
            let ranges = MacrocellRanges::decode(decoder, FRAME.0, FRAME.1, &never)?;
            let macrocells = ranges.map(|ranges| Arc::new(ranges.classify(&view.transfer_function)));
            let clip = Some(ClipBox { low: [0.0, 0.3, 0.0], high: [0.9, 1.0, 0.6] });
            View { shading: Some(Shading::default()), clip, macrocells, ..view }
        }
    })
}

fn volume(channels: u32) -> Outcome<FiniteVolume> {
    let extent = Extent::try_from(SIZE_VOXELS)?;
    let layout = VolumeLayout { channels, ..VolumeLayout::scalar(extent, SampleType::U8) };
    let samples = (0..layout.samples() as u32).map(|i| (i.wrapping_mul(2_654_435_761) >> 24) as u8);
    Ok(FiniteVolume::new(DenseVolume::new(layout, Samples::U8(samples.collect()))?))
}
