//! Every codec × settings × sample type × channels × renderer × site × filter × projection is generated and validated,
//! or refused with a reason in a table.
//!
//! Everything is enumerated from the registry and the codecs' own schemas, so a newly registered codec or renderer is
//! tested at once.

use std::cell::OnceCell;
use std::collections::BTreeMap;
use std::sync::Arc;

use cvr::registry::{Names, renderers};
use cvr::site::coded::CodedFrame;
use cvr::site::target::Target;
use cvr_codec_tests::offering;
use cvr_core::codec::{
    CodecInfo, DecodedBy, Decoder, Granularity, SettingKind, SettingValue, Settings, Site,
};
use cvr_core::pipeline::{
    Capabilities, CodecSweep, Document, Experiment, FilePath, PipelineAxes, Reason, Resolution, Sweep,
    Volume, VolumeSource, resolve,
};
use cvr_core::render::{Camera, ControlPoint, Filter, Projection, Renderer, TransferFunction, View};
use cvr_core::shader::{
    BindingLimits, DeferredShaders, GeneratedShader, Program, Request, Source, TextureSampling,
    generate_decode,
};
use cvr_core::volume::{Axis, FrameIndex, Level, SampleType};
use rayon::prelude::*;

use super::configs::COMPARE;
use super::copies::{decoders, held};
use super::once::{generated_once, in_text, once};
use super::volumes::{declined_or_opened, opened, varied};

const KEY: (FrameIndex, Level) = (FrameIndex::FIRST, Level::FULL);

/// Not a multiple of any block.
const SIZE: [u32; 3] = [7, 5, 6];

/// The extreme values of a setting.
pub fn interesting(kind: &SettingKind) -> Vec<SettingValue> {
    let texts = |texts: &[&str]| texts.iter().map(|t| SettingValue::Text((*t).to_owned())).collect();
    match kind {
        SettingKind::Integer { min, max } => [*min, *max].map(SettingValue::Integer).into(),
        SettingKind::OneOf(numbers) => numbers.iter().map(|n| SettingValue::Integer(*n)).collect(),
        SettingKind::Float { min, max } => [*min, *max].map(SettingValue::Float).into(),
        SettingKind::Choice(words) => texts(words),
        SettingKind::Boolean => [false, true].map(SettingValue::Boolean).into(),
        SettingKind::Block { max } => texts(&["1", "3x5x2", "4", &max.to_string()]),
        // Only the codec knows the meaning of a text. The default is valid for every volume.
        SettingKind::Text { .. } => Vec::new(),
    }
}

/// Largest product of one codec's settings that is tried completely.
const PRODUCT: usize = 32;

/// All products of the interesting values of a codec's settings. If there are too many: each value of every setting
/// with each value of the first, the others at their defaults.
fn sweeps(info: &CodecInfo) -> Vec<CodecSweep> {
    let of = |sweeps: Vec<Sweep>| CodecSweep { id: info.id.to_owned(), sweeps };
    let all: Vec<Sweep> = info
        .settings
        .iter()
        .map(|s| Sweep { name: s.name.to_owned(), values: interesting(&s.kind) })
        .filter(|sweep| !sweep.values.is_empty())
        .collect();
    if all.iter().map(|s| s.values.len()).product::<usize>() <= PRODUCT {
        return vec![of(all)];
    }
    let Some((first, others)) = all.split_first() else { return Vec::new() };
    let mut sweeps = vec![of(vec![first.clone()])];
    for other in others {
        let default = info.default_settings();
        let mut other = other.clone();
        other.values.retain(|value| default.get(&other.name) != Some(value));
        sweeps.push(of(vec![first.clone(), other]));
    }
    sweeps
}

/// Every renderer with its defaults, and with the settings for a ring of layers.
fn labels() -> Vec<String> {
    let mut labels: Vec<String> = renderers().iter().map(|r| r.info().id.to_owned()).collect();
    labels.extend(renderers().iter().filter_map(|r| r.info().layers_label()));
    labels
}

/// Everything that the registry offers, as one experiment.
pub fn everything(names: &Names) -> Experiment {
    let experiment = Document::parse("x.toml", COMPARE).unwrap().experiment(&names.known()).unwrap();
    let source = VolumeSource::file(FilePath::literal("v.nrrd").unwrap());
    Experiment {
        volumes: vec![Volume { name: "v".to_owned(), source }],
        codecs: names.codecs().iter().flat_map(|codec| sweeps(codec.info())).collect(),
        pipeline: PipelineAxes {
            renderers: labels(),
            sites: Site::ALL.to_vec(),
            filters: Filter::ALL.to_vec(),
            skipping: vec![false],
            stages: vec![None],
            resolutions: vec![0],
        },
        ..experiment
    }
}

pub fn view(filter: Filter, projection: Projection) -> View {
    let point = |value, alpha| ControlPoint { value, rgba: [1.0, 0.5, 0.25, alpha] };
    let function = TransferFunction::new(vec![point(0.0, 0.0), point(100.0, 1.0)]).unwrap();
    View {
        size: [64, 48],
        camera: Camera { projection, ..Camera::default() },
        termination: 0.999,
        filter,
        ..View::new(function)
    }
}

/// The voxel source of a decoder at a site. Layers lie across z until [`shader`] sets another axis.
pub fn source<'a>(
    codec: &'a str,
    decoder: &'a dyn Decoder,
    site: Site,
    sampling: TextureSampling,
) -> Source<'a> {
    let (coded, holding) = (CodedFrame { codec, decoder, key: KEY }, cvr::site::of(site));
    // A plan for any site. It determines only the axis.
    let renderer = cvr::registry::renderer("slicing,geometry=axis").unwrap();
    let view = view(Filter::Linear, Projection::Perspective);
    let plan = holding.plan(renderer.as_ref(), &view, decoder.layout()).unwrap();
    let source = holding.source(coded, &plan, &Target::Cpu { reason: None });
    let mut source = source.unwrap_or_else(|problem| panic!("{codec} at the site {site}: {problem}"));
    match &mut source {
        Source::Texture { sampling: by, .. } => *by = sampling,
        Source::Ring { sampling: by, axis, .. } => (*by, *axis) = (sampling, Axis::Z),
        _ => {}
    }
    source
}

/// The shader of a picture's only pass.
pub fn shader(
    renderer: &dyn Renderer,
    view: &View,
    decoder: &dyn Decoder,
    source: &Source<'_>,
) -> Result<Arc<GeneratedShader>, String> {
    let mut source = source.clone();
    let plan = match source {
        Source::Ring { .. } => renderer.plan_layers(view, decoder.layout()),
        _ => renderer.plan(view, decoder.layout()),
    };
    let plan = plan.map_err(|e| format!("renderer: {e}"))?;
    let [pass] = &plan.passes[..] else { panic!("{}: several passes", renderer.info().id) };
    if let (Source::Ring { axis, .. }, Some(across)) = (&mut source, pass.pipeline.layers()) {
        *axis = across;
    }
    let request = Request {
        program: &pass.pipeline.program(),
        layout: decoder.layout(),
        source,
        filter: Some(view.filter),
        limits: BindingLimits::default(),
    };
    generated_once(&request).map_err(|problem| format!("generator: {problem}"))
}

/// The pass that packs the result of a codec's passes, or that decodes layers across z with its snippet.
fn decode_pass(codec: &str, decoder: &dyn Decoder) -> Result<Arc<GeneratedShader>, String> {
    if decoder.frame_decode().is_none() {
        return layer_pass(codec, decoder, Axis::Z);
    }
    let (key, format) = ((FrameIndex::FIRST, Level::FULL), decoder.decoded_form().format);
    DeferredShaders::generate(codec, decoder, key, format, BindingLimits::default())
        .map(|shaders| Arc::new(shaders.pack))
        .map_err(|problem| format!("decode pass: {problem}"))
}

/// The pass that decodes layers across an axis.
fn layer_pass(codec: &str, decoder: &dyn Decoder, axis: Axis) -> Result<Arc<GeneratedShader>, String> {
    let (key, format) = ((FrameIndex::FIRST, Level::FULL), decoder.decoded_form().format);
    let asked = decoder.shader().map(|_| source(codec, decoder, Site::Inline, TextureSampling::Manual));
    once(&(codec, asked, in_text(decoder.layout()), format, axis), || {
        DeferredShaders::generate_layers(codec, decoder, key, (format, axis), BindingLimits::default())
            .map(|shaders| shaders.pack)
            .map_err(|problem| format!("layers across {axis:?}: {problem}"))
    })
}

/// One codec with one set of settings, combined with everything else: the number of shaders, and the refusals.
fn pictures(
    names: &Names,
    resolution: &Resolution,
    codec: &str,
    settings: &Settings,
) -> BTreeMap<String, u32> {
    let mut counts = BTreeMap::new();
    for sample in SampleType::ALL {
        for channels in [1, 3] {
            let codec = names.codecs().get(codec).unwrap();
            let cells =
                resolution.cells.iter().filter(|c| c.codec == codec.info().id && c.settings == *settings);
            let volume = varied(SIZE, sample, channels);
            let decoder = match declined_or_opened(codec.as_ref(), settings, &volume) {
                Ok(decoder) => decoder,
                Err(problem) => {
                    let key = format!("{} declines volumes: {problem}", codec.info().id);
                    *counts.entry(key).or_default() += cells.count() as u32;
                    continue;
                }
            };
            let decoded_by = OnceCell::new();
            for cell in cells {
                // A renderer with settings is only here for the ring. For a codec, its other shaders equal those of its
                // defaults.
                if cell.renderer.contains(',') && cell.site.granularity() != Granularity::Layer {
                    continue;
                }
                let renderer = cvr::registry::renderer(&cell.renderer).unwrap();
                for projection in [Projection::Perspective, Projection::Orthographic] {
                    for sampling in [TextureSampling::Hardware, TextureSampling::Manual] {
                        if cell.site.granularity() == Granularity::Voxel
                            && sampling == TextureSampling::Manual
                        {
                            continue; // there is no texture to sample
                        }
                        let source = source(&cell.codec, decoder.as_ref(), cell.site, sampling);
                        let view = view(cell.filter, projection);
                        let decoded = match cell.site.decoded_by() {
                            DecodedBy::Passes => decoded_by
                                .get_or_init(|| decode_pass(&cell.codec, decoder.as_ref()).map(drop))
                                .clone(),
                            DecodedBy::Shader | DecodedBy::Cpu => Ok(()),
                        };
                        let drawn = shader(renderer.as_ref(), &view, decoder.as_ref(), &source);
                        let outcome = match decoded.and(drawn) {
                            Ok(shader) => {
                                held(&cell.codec, &shader).unwrap_or_else(|e| panic!("{}: {e}", cell.id()));
                                "generated".to_owned()
                            }
                            Err(problem) => problem,
                        };
                        let key = format!(
                            "{} {} {} {}, {channels} channel(s): {outcome}",
                            cell.codec, cell.renderer, cell.site, cell.filter
                        );
                        *counts.entry(key).or_default() += 1;
                    }
                }
            }
        }
    }
    counts
}

#[test]
fn everything_is_generated_and_validated_or_refused_with_a_reason() {
    let names = Names::new().unwrap();
    let resolution = resolve(&everything(&names), &names.known(), &Capabilities::default());
    let mut codecs: Vec<(&str, &Settings)> = Vec::new();
    for cell in &resolution.cells {
        if !codecs.contains(&(&cell.codec, &cell.settings)) {
            codecs.push((&cell.codec, &cell.settings));
        }
    }
    let of_codecs: Vec<BTreeMap<String, u32>> =
        codecs.par_iter().map(|(codec, settings)| pictures(&names, &resolution, codec, settings)).collect();
    let mut table: BTreeMap<String, u32> = BTreeMap::new();
    for (key, count) in of_codecs.into_iter().flatten() {
        *table.entry(key).or_default() += count;
    }
    for refusal in &resolution.refused {
        let cell = &refusal.cell;
        let key = format!(
            "{} {} {} {}: refused, {}",
            cell.codec, cell.renderer, cell.site, cell.filter, refusal.reason
        );
        *table.entry(key).or_default() += 1;
    }
    // One snapshot per codec, so that another codec changes none of them.
    let mut of_codecs: BTreeMap<&str, Vec<String>> = BTreeMap::new();
    for (key, count) in &table {
        let (codec, rest) = key.split_once(' ').unwrap();
        of_codecs.entry(codec).or_default().push(format!("{count:4} × {rest}"));
    }
    assert_eq!(of_codecs.len(), names.codecs().iter().count());
    for (codec, lines) in of_codecs {
        insta::assert_snapshot!(format!("combinations_of_{codec}"), lines.join("\n"));
    }
}

/// Resolving refuses exactly what cannot be drawn: the generator refuses the same.
#[test]
fn the_generator_cannot_make_what_resolving_refuses() {
    let names = Names::new().unwrap();
    let resolution = resolve(&everything(&names), &names.known(), &Capabilities::default());
    assert!(!resolution.refused.is_empty());
    for refusal in &resolution.refused {
        let cell = &refusal.cell;
        let codec = names.codecs().get(&cell.codec).unwrap();
        if matches!(refusal.reason, Reason::Settings(_)) {
            assert!(codec.encoder(&cell.settings).is_err(), "{}: {}", cell.id(), refusal.reason);
            continue; // there is nothing to encode with
        }
        let decoder = opened(codec.as_ref(), &cell.settings, &varied(SIZE, SampleType::U8, 1));
        let renderer = cvr::registry::renderer(&cell.renderer).unwrap();
        if cell.site.decoded_by().on_device() && decoder.shader().is_none() {
            continue; // there is nothing to generate from
        }
        let source = source(&cell.codec, decoder.as_ref(), cell.site, TextureSampling::Hardware);
        let view = view(cell.filter, Projection::Perspective);
        let made = shader(renderer.as_ref(), &view, decoder.as_ref(), &source);
        assert!(made.is_err(), "refused without need: {}: {}", cell.id(), refusal.reason);
    }
}

#[test]
fn what_the_machine_lacks_is_refused_with_its_reason() {
    let names = Names::new().unwrap();
    let experiment = everything(&names);
    let all = resolve(&experiment, &names.known(), &Capabilities::default());
    let missing = vec![(Site::Host, "this device has no 3-D textures".to_owned())];
    let some = resolve(&experiment, &names.known(), &Capabilities { missing_sites: missing });
    assert!(some.cells.iter().all(|c| c.site != Site::Host) && !some.cells.is_empty());
    assert_eq!(
        some.cells.len() + some.refused.len(),
        all.cells.len() + all.refused.len(),
        "nothing vanishes"
    );
    let lacking =
        some.refused.iter().filter(|r| r.reason.to_string().contains("this device has no 3-D textures"));
    assert_eq!(lacking.count(), all.cells.iter().filter(|c| c.site == Site::Host).count());
}

/// Through the template that writes every voxel, too.
#[test]
fn every_snippet_is_valid_for_scalars_and_colour() {
    let names = Names::new().unwrap();
    let resolution = resolve(&everything(&names), &names.known(), &Capabilities::default());
    let mut generated = 0;
    let mut seen: Vec<(&str, &Settings)> = Vec::new();
    for cell in resolution.cells.iter().filter(|c| c.site == Site::Inline) {
        if seen.contains(&(&cell.codec, &cell.settings)) {
            continue;
        }
        seen.push((&cell.codec, &cell.settings));
        let codec = names.codecs().get(&cell.codec).unwrap();
        for (sample, channels) in SampleType::ALL.into_iter().flat_map(|s| [(s, 1), (s, 3)]) {
            let decoder = opened(codec.as_ref(), &cell.settings, &varied(SIZE, sample, channels));
            let pass = decode_pass(&cell.codec, decoder.as_ref());
            let pass = pass.unwrap_or_else(|e| panic!("{} {sample} {channels}: {e}", cell.id()));
            assert!(decoders(&cell.codec, &pass) <= 1, "{}", cell.id());
            for axis in Axis::ALL {
                let pass = layer_pass(&cell.codec, decoder.as_ref(), axis);
                pass.unwrap_or_else(|e| panic!("{} {sample} {channels}: {e}", cell.id()));
            }
            let dumps = [Some(cvr_shaders::DUMP), codec.info().fetch_cell.then_some(cvr_shaders::DUMP_CELL)];
            for template in dumps.into_iter().flatten() {
                let request = Request {
                    program: &Program::dump(template),
                    layout: decoder.layout(),
                    source: source(&cell.codec, decoder.as_ref(), Site::Inline, TextureSampling::Manual),
                    filter: None,
                    limits: BindingLimits::default(),
                };
                let made = generated_once(&request);
                let shader = made.unwrap_or_else(|e| panic!("{} {sample} {channels}: {e}", cell.id()));
                assert_eq!(decoders(&cell.codec, &shader), 1, "{}", cell.id());
                let text = &shader.wgsl;
                assert_eq!(text.contains("alias Voxel = vec3<f32>;"), channels == 3);
                generated += 1;
            }
        }
    }
    assert!(generated >= 10 * names.codecs().iter().count(), "{generated} shaders");
}

/// The test of these tests: with one wrong letter in a codec's snippet, its shader is refused, with the snippet's file.
#[test]
fn a_damaged_snippet_is_refused() {
    let names = Names::new().unwrap();
    for codec in names.codecs().iter() {
        let id = codec.info().id;
        let Some(settings) = offering(codec.as_ref(), Site::Inline) else { continue }; // there is no snippet
        let decoder = opened(codec.as_ref(), &settings, &varied(SIZE, SampleType::U8, 1));
        let whole = source(id, decoder.as_ref(), Site::Inline, TextureSampling::Manual);
        let Source::Inline { module, resources, .. } = &whole else { panic!("inline was asked for") };
        assert!(module.file.starts_with(&format!("codecs/{id}/src/")), "{}", module.file);
        let renderer = &renderers()[0];
        let view = view(Filter::Linear, Projection::Perspective);
        for (from, to) in [
            ("-> vec4<f32>", "-> vec3<f32>"),
            ("{", ""),
            (&*format!("fn {id}_fetch("), &*format!("fn {id}_fetc(")),
        ] {
            let damaged = module.source.replacen(from, to, 1);
            assert_ne!(damaged, module.source);
            let file = module.file;
            let mut module = module.clone();
            module.source = &damaged;
            let (frame, level) = (FrameIndex::FIRST, Level::FULL);
            let source = Source::Inline { codec: id, module, resources: resources.clone(), frame, level };
            let problem = shader(renderer.as_ref(), &view, decoder.as_ref(), &source).unwrap_err();
            assert!(problem.contains(id), "{problem}");
            let format = decoder.decoded_form().format;
            let pass =
                generate_decode(&source, decoder.layout(), (format, Axis::X), BindingLimits::default());
            let problem = pass.unwrap_err().to_string();
            assert!(problem.contains(file), "{problem}");
        }
    }
}
