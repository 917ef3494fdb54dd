//! `cvr render`

use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::Arc;

use cvr_core::codec::{Decoder, Site, encode_temporary};
use cvr_core::pipeline::{undrawable, unsupported};
use cvr_core::render::DecodedFrame;
use cvr_core::volume::{FrameIndex, Level, ValueRange};

use super::memory_args::MemoryArgs;
use super::opened::{LevelArgs, Opened};
use super::scene_args::SceneArgs;
use super::volume_args::{RawArgs, check_output, is_container};
use crate::exit::BadInput;
use crate::experiment::stage::{RAW, check_range};
use crate::experiment::target::{Decoded, Target, VoxelSource};
use crate::registry::{Names, renderer};

const EXAMPLES: &str = "\
Examples:
  cvr render head.nrrd head.png --azimuth 45 --transfer-function tissue --shading
  cvr render head.cvr head.png --site deferred --renderer slicing,geometry=axis --stages 2
  cvr render flow.raw flow.png --dims 64x64x64 --dtype f32 --frames 24 --frame 23 --transfer-function heat
  cvr render fibres.nii.gz fibres.png --opacity red --range --transfer-function 0.1:#ffffff00,1:#ffffff80";

/// Arguments of `cvr render`.
#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLES)]
pub struct Args {
    /// A volume or a container (`.cvr`).
    file: PathBuf,
    /// The PNG file to write.
    out: PathBuf,
    #[command(flatten)]
    scene: SceneArgs,
    /// Where voxels are decoded: inline, deferred, ring or host.
    #[arg(long, default_value = "inline", value_parser = site)]
    site: Site,
    /// The renderer, and settings of it that are not the default, as slicing,geometry=axis; see `cvr renderers`.
    #[arg(long, default_value = "raycasting")]
    renderer: String,
    /// What draws: auto, cpu, a part of an adapter's name, or #N of `cvr devices`.
    #[arg(long, default_value = "auto")]
    device: String,
    #[command(flatten)]
    level: LevelArgs,
    #[command(flatten)]
    memory: MemoryArgs,
    #[command(flatten)]
    raw: RawArgs,
}

/// Draws a picture.
///
/// # Errors
/// When arguments, file, device or output are unusable.
pub fn run(args: &Args) -> Result<ExitCode, BadInput> {
    args.memory.allow();
    check_output(&args.out, &args.file)?;
    let names = Names::new()?;
    let renderer = renderer(&args.renderer).map_err(BadInput)?;
    let scene = args.scene.scene()?;
    let (codec, decoder, level) = open(args, &names)?;
    let refused = unsupported(names.codecs().get(&codec)?.info(), args.site, args.scene.filter)
        .or_else(|| undrawable(&args.renderer, args.site, names.known().renderers));
    if let Some(reason) = refused {
        return Err(BadInput(reason.to_string()));
    }
    let index = FrameIndex(scene.frames.first);
    let frames = decoder.layout().frames;
    if index.0 >= frames {
        let file = args.file.display();
        return Err(BadInput(format!("--frame {}: {file} has {frames} frames, counted from 0", index.0)));
    }
    let frame = Arc::new(DecodedFrame::decode_stages(decoder.as_ref(), index, level.stages)?);
    let range = range(decoder.as_ref(), (index, level), &frame)?;
    check_range(range).map_err(BadInput)?;
    let target = Target::open(&args.device)?;
    let decoded = match args.site {
        Site::Host => Decoded::Host(target.upload(decoder.as_ref(), (index, level), frame)?),
        Site::Ring => Decoded::Ring(frame),
        Site::Deferred => {
            Decoded::Deferred(target.decode(&codec, decoder.as_ref(), (index, level), &frame)?)
        }
        _ => Decoded::Inline,
    };
    let source = VoxelSource { codec: &codec, decoder: decoder.as_ref(), frame: index, level, decoded };
    let picture = target.picture(renderer.as_ref(), &scene.view(range, args.scene.filter)?, &source)?;
    picture.image()?.write_png(&args.out, scene.background)?;
    say!("{}: {} on {}", args.out.display(), args.renderer, target.name());
    Ok(ExitCode::SUCCESS)
}

/// The range of all frames, so that those of a sequence are drawn alike; `decoded` is the frame `index`.
fn range(
    decoder: &dyn Decoder,
    (index, level): (FrameIndex, Level),
    decoded: &DecodedFrame,
) -> Result<ValueRange, BadInput> {
    let mut range = ValueRange::of(decoded.values().iter().copied());
    for other in (0..decoder.layout().frames).map(FrameIndex).filter(|other| *other != index) {
        let frame = DecodedFrame::decode_stages(decoder, other, level.stages)?;
        let of_frame = ValueRange::of(frame.values().iter().copied());
        range = range.into_iter().chain(of_frame).reduce(ValueRange::union);
    }
    Ok(range.unwrap_or(ValueRange { min: 0.0, max: 0.0 }))
}

/// An encoded volume as it is, any other through the codec `raw`.
fn open(args: &Args, names: &Names) -> Result<(String, Box<dyn Decoder>, Level), BadInput> {
    if is_container(&args.file) {
        let opened = Opened::open(&args.file, names)?;
        let level = args.level.of(opened.codec.as_ref(), &opened.stream.spec().settings)?;
        return Ok((opened.codec.info().id.to_owned(), opened.decoder, level));
    }
    let volume = args.raw.load(&args.file)?.volume;
    let raw = names.codecs().get(RAW)?;
    let settings = raw.info().default_settings();
    let level = args.level.of(raw.as_ref(), &settings)?;
    let stream = encode_temporary(raw.as_ref(), &settings, &volume)?;
    Ok((RAW.to_owned(), raw.decoder(Arc::new(stream))?, level))
}

/// A site by its name.
pub(super) fn site(text: &str) -> Result<Site, String> {
    let known = Site::ALL.map(Site::name).join(" or ");
    Site::ALL.into_iter().find(|s| s.name() == text).ok_or_else(|| format!("`{text}`: {known}"))
}
