//! `cvr render`

use std::path::PathBuf;
use std::process::ExitCode;
use std::str::FromStr as _;
use std::sync::Arc;

use cvr_core::codec::{Block, Codec, Decoder, Settings, Site, encode_temporary};
use cvr_core::pipeline::{undrawable, unsupported};
use cvr_core::render::DecodedFrame;
use cvr_core::volume::{FrameIndex, Level, Replaced, ValueRange};

use super::memory_args::MemoryArgs;
use super::opened::{DecodedFramesArgs, LevelArgs, Opened};
use super::output::Output;
use super::scene_args::SceneArgs;
use super::volume_args::{RawArgs, check_output, is_container};
use crate::exit::{BadInput, SOME_FAILED};
use crate::experiment::inputs::blank;
use crate::experiment::measured::reference::{RAW, check_range};
use crate::experiment::records::record::Record;
use crate::experiment::running::single::{Single, SingleError};
use crate::registry::{Names, renderer};
use crate::site::expected::Expected;
use crate::site::target::Target;

const EXAMPLES: &str = "\
Examples:
  cvr render head.nrrd head.png --azimuth 45 --transfer-function tissue --shading
  cvr render head.cvr head.png --site deferred --renderer slicing,geometry=axis --stages 2
  cvr render flow.raw flow.png --dims 64x64x64 --dtype f32 --frames 24 --frame 23 --transfer-function heat
  cvr render fibres.nii.gz fibres.png --opacity red --range --transfer-function 0.1:#ffffff00,1:#ffffff80

The voxels that the device decodes are compared with the CPU decoder, as in `cvr run`. If a voxel differs by more than the
codec states, the difference is printed, nothing is written, and the exit code is 1. Lines that begin with `note:` are
the notes of a run: replaced samples, fallbacks of formats, half-precision sums, rays in pieces, and \"shader not run\" if
the CPU mirror draws.";

/// Arguments of `cvr render`.
#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLES)]
pub struct Args {
    /// A volume or a container (`.cvr`).
    file: PathBuf,
    #[arg(help = Output::help(&[Output::Png]))]
    out: PathBuf,
    #[command(flatten)]
    scene: SceneArgs,
    #[arg(long, value_parser = Site::from_str, help = format!("{} [default: the first that the codec offers]", site_help()))]
    site: Option<Site>,
    /// The renderer and its settings that differ from the defaults, as slicing,geometry=axis; see `cvr renderers`.
    #[arg(long, default_value = "raycasting")]
    renderer: String,
    /// What draws: auto, cpu, vulkan, gl, a part of an adapter's name, or #N of `cvr devices`.
    #[arg(long, default_value = "auto")]
    device: String,
    /// Skip the comparison of decoded voxels with the CPU decoder.
    #[arg(long)]
    no_check: bool,
    #[command(flatten)]
    level: LevelArgs,
    #[command(flatten)]
    frames: DecodedFramesArgs,
    #[command(flatten)]
    memory: MemoryArgs,
    #[command(flatten)]
    raw: RawArgs,
}

/// Draws a picture. Decoded voxels are compared with the CPU decoder as in a run.
///
/// # Errors
/// When arguments, file, device or output are unusable.
pub fn run(args: &Args) -> Result<ExitCode, BadInput> {
    run_with(args, &Names::new()?)
}

/// As [`run`], with the codecs of a registry.
///
/// # Errors
/// As [`run`].
pub fn run_with(args: &Args, names: &Names) -> Result<ExitCode, BadInput> {
    args.memory.allow();
    check_output(&args.out, &args.file)?;
    Output::of(&args.out, &[Output::Png])?;
    let renderer = renderer(&args.renderer).map_err(BadInput)?;
    let scene = args.scene.scene()?;
    let opened = open(args, names)?;
    let (codec, decoder, level) = (opened.codec.info().id, opened.decoder.as_ref(), opened.level);
    let offered = || Site::ALL.into_iter().find(|site| opened.codec.offers(&opened.settings, *site));
    let site = args.site.or_else(offered).unwrap_or(Site::Host);
    let refused =
        unsupported(names.codecs(), opened.codec.as_ref(), &opened.settings, (site, args.scene.filter))
            .or_else(|| undrawable(&args.renderer, site, names.known().renderers));
    if let Some(reason) = refused {
        return Err(BadInput(reason.to_string()));
    }
    let index = FrameIndex(scene.frames.first);
    let frames = decoder.layout().frames;
    if index.0 >= frames {
        let file = args.file.display();
        return Err(BadInput(format!("--frame {}: {file} has {frames} frames, counted from 0", index.0)));
    }
    let frame = DecodedFrame::at(decoder, index, level)?;
    let range = range(decoder, (index, level), &frame)?;
    check_range(range).map_err(BadInput)?;
    let view = scene.view(range, args.scene.filter)?;
    let target = Target::open(&args.device)?;
    let expected = Expected { codec, decoder, key: (index, level), frame, block: opened.block };
    let single = Single {
        target: &target,
        renderer: renderer.as_ref(),
        view: &view,
        site,
        expected: &expected,
        check: !args.no_check,
    };
    // What a run would write into the record of such a cell.
    let mut record = Record::default();
    record.flag_replaced(opened.replaced, decoder.layout().samples());
    opened.notes.iter().for_each(|note| record.remark(note));
    let drawn = single.draw(&mut record);
    let tell_notes = || {
        for note in record.notes.iter().flat_map(|notes| notes.split("; ")) {
            eprintln!("note: {note}");
        }
    };
    let image = match drawn {
        Ok(image) => image,
        Err(SingleError::Disagrees(problem)) => {
            tell_notes();
            let file = args.file.display();
            eprintln!("failed: {file}: {problem}; nothing was written (--no-check draws all the same)");
            return Ok(ExitCode::from(SOME_FAILED));
        }
        Err(error) => return Err(error.into()),
    };
    image.write_png(&args.out, scene.background)?;
    tell_notes();
    if blank::is_blank(&image) {
        let reason = blank::reason(&view, decoder.layout().channels);
        eprintln!("warning: {} shows nothing: {reason}", args.out.display());
    }
    say!("{}: {} on {}", args.out.display(), args.renderer, target.name());
    Ok(ExitCode::SUCCESS)
}

/// The range over all frames, so that all frames of a sequence get the same transfer function. `decoded` is the frame
/// `index`.
fn range(
    decoder: &dyn Decoder,
    (index, level): (FrameIndex, Level),
    decoded: &DecodedFrame,
) -> Result<ValueRange, BadInput> {
    let mut range = ValueRange::of(decoded.values().iter().copied());
    for other in (0..decoder.layout().frames).map(FrameIndex).filter(|other| *other != index) {
        let frame = DecodedFrame::at(decoder, other, level)?;
        let of_frame = ValueRange::of(frame.values().iter().copied());
        range = range.into_iter().chain(of_frame).reduce(ValueRange::union);
    }
    Ok(range.unwrap_or(ValueRange { min: 0.0, max: 0.0 }))
}

/// The volume or stream to draw.
struct Source {
    codec: Arc<dyn Codec>,
    /// Settings of the encoder.
    settings: Settings,
    decoder: Arc<dyn Decoder>,
    level: Level,
    /// The codec's block, if it has one.
    block: Option<Block>,
    /// Samples of the volume that were replaced before encoding.
    replaced: Replaced,
    /// Remarks of the encoder.
    notes: Vec<String>,
}

/// Opens a container, or encodes any other volume with the codec `raw`.
fn open(args: &Args, names: &Names) -> Result<Source, BadInput> {
    let (codec, stream, decoder) = if is_container(&args.file) {
        let Opened { stream, codec, decoder } =
            Opened::open(&args.file, names, args.frames.decoded_frames_mb)?;
        (codec, stream, decoder)
    } else {
        let volume = args.raw.load(&args.file)?.volume;
        let raw = names.codecs().get(RAW)?;
        let stream = Arc::new(encode_temporary(raw.as_ref(), &raw.info().default_settings(), &volume)?);
        (raw.clone(), stream.clone(), raw.decoder(stream)?.into())
    };
    let spec = stream.spec();
    let level = args.level.of(codec.as_ref(), &spec.settings)?;
    let block = codec.block(&spec.settings);
    let (replaced, notes) = (spec.replaced, spec.report.notes.clone());
    Ok(Source { settings: spec.settings.clone(), codec, decoder, level, block, replaced, notes })
}

/// The help of `--site`.
pub(super) fn site_help() -> String {
    let [first @ .., last] = Site::ALL.map(Site::name);
    format!("Where voxels are decoded: {} or {last}", first.join(", "))
}
