//! `cvr shader`

use std::path::PathBuf;
use std::process::ExitCode;
use std::str::FromStr as _;
use std::sync::Arc;

use cvr_core::codec::{Decoder, FrameStore, Settings, Site, encode_temporary};
use cvr_core::pipeline::{undrawable, unsupported};
use cvr_core::render::Plan;
use cvr_core::shader::{BindingLimits, Request, generate};
use cvr_core::volume::{FrameIndex, Level, ValueRange};

use super::memory_args::MemoryArgs;
use super::opened::{LevelArgs, Opened};
use super::scene_args::SceneArgs;
use super::settings_args::settings;
use super::volume_args::{RawArgs, is_container};
use crate::exit::BadInput;
use crate::experiment::inputs::volumes::LoadedVolume;
use crate::input::{Generator, generate as generate_volume};
use crate::registry::{Names, renderer};
use crate::site;
use crate::site::coded::CodedFrame;
use crate::site::target::Target;

const EXAMPLES: &str = "\
Examples:
  cvr shader --codec s3dc
  cvr shader --codec hvq --site deferred --shading
  cvr shader --codec vq --renderer slicing,geometry=axis --site ring";

/// Arguments of `cvr shader`.
#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLES)]
pub struct Args {
    /// A container (`.cvr`), or a volume to encode with --codec [default: a generated volume].
    file: Option<PathBuf>,
    /// Codec id, for a volume that is not a container.
    #[arg(long, default_value = "s3dc")]
    codec: String,
    /// A setting of the codec.
    #[arg(long = "set", value_name = "NAME=VALUE")]
    set: Vec<String>,
    #[arg(long, default_value = "inline", value_parser = Site::from_str, help = super::render::site_help())]
    site: Site,
    /// The renderer and its settings that differ from the defaults, as slicing,geometry=axis; see `cvr renderers`.
    #[arg(long, default_value = "raycasting")]
    renderer: String,
    #[command(flatten)]
    scene: SceneArgs,
    #[command(flatten)]
    level: LevelArgs,
    #[command(flatten)]
    memory: MemoryArgs,
    #[command(flatten)]
    raw: RawArgs,
}

/// Prints the generated shaders: the decoding passes, if the site has any, then the drawing shader. If the texture that
/// holds a volume depends on the device, the shader is for the texture of this machine's device, and the first line
/// names it. No device is needed.
///
/// # Errors
/// When arguments or file are unusable, or the shader cannot be made.
pub fn run(args: &Args) -> Result<ExitCode, BadInput> {
    run_with(args, &Names::new()?)
}

/// As [`run`], with the codecs of a registry.
///
/// # Errors
/// As [`run`].
pub fn run_with(args: &Args, names: &Names) -> Result<ExitCode, BadInput> {
    args.memory.allow();
    let renderer = renderer(&args.renderer).map_err(BadInput)?;
    let (codec, settings, decoder, level) = open(args, names)?;
    let known = names.codecs().get(&codec)?.as_ref();
    let refused = unsupported(names.codecs(), known, &settings, (args.site, args.scene.filter))
        .or_else(|| undrawable(&args.renderer, args.site, names.known().renderers));
    if let Some(reason) = refused {
        return Err(BadInput(reason.to_string()));
    }
    let range = ValueRange { min: 0.0, max: 1.0 };
    let view = args.scene.scene()?.view(range, args.scene.filter)?;
    let view = view.at_resolution(decoder.layout(), level.resolution, decoder.coarse_shift(level.resolution));
    let layout = decoder.layout().at_resolution(level.resolution);
    let plan = site::of(args.site).plan(renderer.as_ref(), &view, &layout)?;
    say!("{}", text(args, (&codec, decoder.as_ref(), level), &plan)?.trim_end());
    Ok(ExitCode::SUCCESS)
}

/// Id, settings, decoder and level of the volume.
type Source = (String, Settings, Arc<dyn Decoder>, Level);

fn open(args: &Args, names: &Names) -> Result<Source, BadInput> {
    if let Some(file) = args.file.as_ref().filter(|f| is_container(f)) {
        let opened = Opened::open(file, names, FrameStore::DEFAULT_MB)?;
        let level = args.level.of(opened.codec.as_ref(), &opened.stream.spec().settings)?;
        let settings = opened.stream.spec().settings.clone();
        return Ok((opened.codec.info().id.to_owned(), settings, opened.decoder, level));
    }
    let codec = names.codecs().get(&args.codec)?;
    let volume = match &args.file {
        Some(file) => args.raw.load(file)?.volume,
        None => {
            let extent = cvr_core::volume::Extent::cube(16)?;
            let sample = cvr_core::volume::SampleType::U8;
            let dense = generate_volume(Generator::SheppLogan, extent, sample, 0)?;
            LoadedVolume::new(String::new(), String::new(), dense).volume
        }
    };
    let settings = settings(codec.info(), &args.set)?;
    let level = args.level.of(codec.as_ref(), &settings)?;
    let stream = encode_temporary(codec.as_ref(), &settings, &volume)?;
    let decoder = FrameStore::open_mb(codec.decoder(Arc::new(stream))?.into(), FrameStore::DEFAULT_MB);
    Ok((args.codec.clone(), settings, decoder, level))
}

fn text(
    args: &Args,
    (codec, decoder, level): (&str, &dyn Decoder, Level),
    plan: &Plan,
) -> Result<String, BadInput> {
    let coded = CodedFrame { codec, decoder, key: (FrameIndex::FIRST, level) };
    let holding = site::of(args.site);
    let (head, target) = match holding.holder() {
        None => (String::new(), Target::Cpu { reason: None }),
        Some(holder) => {
            let target = Target::open("auto")?;
            let holder = holder(coded, &target).map_err(BadInput)?;
            (format!("// Site {}, on {}: {holder}.\n", args.site, target.name()), target)
        }
    };
    let mut texts = holding.passes(coded, plan).map_err(BadInput)?;
    let source = holding.source(coded, plan, &target).map_err(BadInput)?;
    for pass in &plan.passes {
        let shader = generate(&Request {
            program: &pass.pipeline.program(),
            layout: &decoder.layout().at_resolution(level.resolution),
            source: source.clone(),
            filter: Some(args.scene.filter),
            limits: BindingLimits::default(),
        })?;
        texts.push(shader.wgsl);
    }
    Ok(head + &texts.join("\n// ==== next pass\n\n"))
}
