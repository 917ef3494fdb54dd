//! `cvr shader`

use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::Arc;

use cvr_core::codec::{Decoder, Site, encode_temporary};
use cvr_core::pipeline::{undrawable, unsupported};
use cvr_core::render::Plan;
use cvr_core::shader::{
    BindingLimits, DeferredShaders, Request, ResourceSize, Source, TextureSampling, generate,
};
use cvr_core::volume::{FrameIndex, Level, ValueRange};

use super::memory_args::MemoryArgs;
use super::opened::{LevelArgs, Opened};
use super::scene_args::SceneArgs;
use super::settings_args::settings;
use super::volume_args::{RawArgs, is_container};
use crate::exit::BadInput;
use crate::experiment::host_texture::HostTexture;
use crate::experiment::target::Target;
use crate::experiment::volumes::LoadedVolume;
use crate::input::{Generator, generate as generate_volume};
use crate::registry::{Names, renderer};

const EXAMPLES: &str = "\
Examples:
  cvr shader --codec s3dc
  cvr shader --codec hvq --site deferred --shading
  cvr shader --codec vq --renderer slicing,geometry=axis --site ring";

/// Arguments of `cvr shader`.
#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLES)]
pub struct Args {
    /// A container (`.cvr`), or a volume to encode with --codec; default a generated one.
    file: Option<PathBuf>,
    /// Codec id, for a volume that is no container.
    #[arg(long, default_value = "s3dc")]
    codec: String,
    /// A setting of the codec.
    #[arg(long = "set", value_name = "NAME=VALUE")]
    set: Vec<String>,
    /// Where voxels are decoded: inline, deferred, ring or host.
    #[arg(long, default_value = "inline", value_parser = super::render::site)]
    site: Site,
    /// The renderer, and settings of it that are not the default, as slicing,geometry=axis; see `cvr renderers`.
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

/// Prints the generated shaders, at the sites *deferred* and *ring* the passes that decode and then the one that draws. At the
/// site *host* it is the shader for the texture that this machine's device has, which the first line names; no device is
/// needed.
///
/// # Errors
/// When arguments or file are unusable, or the shader cannot be made.
pub fn run(args: &Args) -> Result<ExitCode, BadInput> {
    args.memory.allow();
    let names = Names::new()?;
    let renderer = renderer(&args.renderer).map_err(BadInput)?;
    let (codec, decoder, level) = open(args, &names)?;
    let info = names.codecs().get(&codec)?.info();
    if let Some(reason) = unsupported(names.codecs(), info, args.site, args.scene.filter) {
        return Err(BadInput(reason.to_string()));
    }
    let range = ValueRange { min: 0.0, max: 1.0 };
    let view = args.scene.scene()?.view(range, args.scene.filter)?;
    let plan = match args.site {
        Site::Ring => match undrawable(&args.renderer, args.site, names.known().renderers) {
            Some(reason) => return Err(BadInput(reason.to_string())),
            None => renderer.plan_layers(&view, decoder.layout())?,
        },
        _ => renderer.plan(&view, decoder.layout())?,
    };
    say!("{}", text(args, (&codec, decoder.as_ref(), level), &plan)?.trim_end());
    Ok(ExitCode::SUCCESS)
}

fn open(args: &Args, names: &Names) -> Result<(String, Box<dyn Decoder>, Level), BadInput> {
    if let Some(file) = args.file.as_ref().filter(|f| is_container(f)) {
        let opened = Opened::open(file, names)?;
        let level = args.level.of(opened.codec.as_ref(), &opened.stream.spec().settings)?;
        return Ok((opened.codec.info().id.to_owned(), opened.decoder, level));
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
    Ok((args.codec.clone(), codec.decoder(Arc::new(stream))?, level))
}

fn text(
    args: &Args,
    (codec, decoder, level): (&str, &dyn Decoder, Level),
    plan: &Plan,
) -> Result<String, BadInput> {
    let form = decoder.decoded_form();
    let decoded = Source::Texture { form, sampling: TextureSampling::Hardware, padded: None };
    let limits = BindingLimits::default();
    let (mut head, mut texts) = (String::new(), Vec::new());
    let key = (FrameIndex::FIRST, level);
    let source = match (args.site, decoder.shader()) {
        (Site::Host, _) => {
            let target = Target::open("auto")?;
            let texture = HostTexture::of(&target, decoder, key)?;
            head = format!("// Site host, on {}: {texture}.\n", target.name());
            texture.source(decoder, key)
        }
        (Site::Deferred, _) => {
            let shaders = DeferredShaders::generate(codec, decoder, key, form.format, limits)?;
            texts.extend(shaders.texts().map(str::to_owned));
            decoded
        }
        (Site::Ring, _) => {
            let axis = plan.passes.iter().find_map(|pass| pass.pipeline.layers());
            let axis = axis.ok_or_else(|| BadInput("the plan does not draw layer by layer".to_owned()))?;
            let key_form = (form.format, axis);
            let shaders = DeferredShaders::generate_layers(codec, decoder, key, key_form, limits)?;
            texts.extend(shaders.texts().map(str::to_owned));
            Source::Ring { form, sampling: TextureSampling::Hardware, axis }
        }
        (_, None) => return Err(BadInput(format!("codec `{codec}` does not decode in a shader"))),
        (_, Some(shader)) => {
            let resources = shader.resources(key.0)?.iter().map(ResourceSize::of).collect();
            Source::Inline { codec, module: shader.module(), resources, frame: key.0, level: key.1 }
        }
    };
    for pass in &plan.passes {
        let shader = generate(&Request {
            program: &pass.pipeline.program(),
            layout: decoder.layout(),
            source: source.clone(),
            filter: Some(args.scene.filter),
            limits,
        })?;
        texts.push(shader.wgsl);
    }
    Ok(head + &texts.join("\n// ==== next pass\n\n"))
}
