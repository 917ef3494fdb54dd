//! Every renderer × its settings × lit × clipped × skipping × projection × site × filter × channels is generated and
//! validated.
//!
//! Renderers and settings are enumerated from the registry. Pictures with equal shader texts are generated once.

use std::collections::{BTreeMap, HashMap, HashSet};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use cvr::registry::{Names, renderer, renderers};
use cvr_codec_tests::offering;
use cvr_core::codec::{Decoder, Settings, Site};
use cvr_core::render::{
    ClipBox, Filter, Light, MacrocellRanges, Pass, Pipeline, Plan, Projection, RendererInfo, Shading, Stage,
    View,
};
use cvr_core::shader::{
    BindingLimits, GeneratedShader, Program, Request, ShaderError, Source, TextureSampling, generate,
};
use cvr_core::volume::{FrameIndex, Level, SampleType};
use rayon::prelude::*;

use super::combinations::{interesting, source, view};
use super::copies::held;
use super::volumes::{opened, varied};

/// Properties of a view besides camera and colours.
#[derive(Copy, Clone, Debug, Default, PartialEq, Eq)]
pub struct Optics {
    pub lit: Option<Light>,
    pub clipped: bool,
    pub skipping: bool,
}

impl Optics {
    /// Each with and without each.
    pub fn all() -> Vec<Self> {
        let lights = [None, Some(Light::Camera)];
        let clips = lights.into_iter().flat_map(|lit| [false, true].map(|clipped| (lit, clipped)));
        clips
            .flat_map(|(lit, clipped)| [false, true].map(|skipping| Self { lit, clipped, skipping }))
            .collect()
    }

    /// All at once.
    pub const EVERYTHING: Self = Self { lit: Some(Light::Camera), clipped: true, skipping: true };

    /// A view with these properties, for a decoder.
    pub fn of(self, view: View, decoder: &dyn Decoder) -> View {
        let macrocells = self.skipping.then(|| {
            let never = AtomicBool::new(false);
            let ranges = MacrocellRanges::decode(decoder, FrameIndex::FIRST, Level::FULL, &never);
            Arc::new(ranges.unwrap().unwrap().classify(&view.transfer_function))
        });
        View { macrocells, ..self.drawn(view) }
    }

    /// A view with shading and clip box. Skipping is unchanged.
    pub fn drawn(self, view: View) -> View {
        let shading = self.lit.map(|light| {
            let direction = match light {
                Light::Camera => Shading::default().direction,
                Light::Fixed => [1.0, -0.6, 0.8],
            };
            Shading { light, direction, ..Shading::default() }
        });
        let clip = self.clipped.then_some(ClipBox { low: [0.0, 0.3, 0.0], high: [0.9, 1.0, 0.6] });
        View { shading, clip, ..view }
    }
}

/// The labels of a renderer under every combination of its settings' values.
pub fn labels(info: &RendererInfo) -> Vec<String> {
    let mut all = vec![Settings::default()];
    for setting in info.settings {
        let with = |settings: &Settings| {
            let values = interesting(&setting.kind).into_iter();
            let set = values.map(|value| {
                let mut settings = settings.clone();
                settings.set(setting.name, value);
                settings
            });
            set.collect::<Vec<_>>()
        };
        all = all.iter().flat_map(with).collect();
    }
    all.iter().map(|settings| info.label(settings).unwrap()).collect()
}

/// The shader of a plan's only pass.
fn made(
    program: &Program,
    filter: Filter,
    decoder: &dyn Decoder,
    source: &Source<'_>,
) -> Result<GeneratedShader, ShaderError> {
    generate(&Request {
        program,
        layout: decoder.layout(),
        source: source.clone(),
        filter: Some(filter),
        limits: BindingLimits::default(),
    })
}

fn the_pass(plan: &Plan) -> &Pass {
    let [pass] = &plan.passes[..] else { panic!("several passes") };
    pass
}

/// The program of a pass, and the program in pieces if it follows rays.
fn and_guarded(pipeline: &Pipeline) -> Vec<Program> {
    let in_pieces = pipeline.guarded_program().filter(|_| matches!(pipeline.stage, Stage::Rays(_)));
    [Some(pipeline.program()), in_pieces].into_iter().flatten().collect()
}

#[test]
fn every_scene_of_every_renderer_is_generated_and_validated() {
    let names = Names::new().unwrap();
    let codecs: Vec<_> = names.codecs().iter().flat_map(|codec| [(codec, 1), (codec, 3)]).collect();
    let mut counts: BTreeMap<(&str, String), (usize, HashSet<_>)> = BTreeMap::new();
    for info in renderers().iter().map(|r| r.info()) {
        for (codec, channels) in &codecs {
            let id = codec.info().id;
            let volume = varied([17, 9, 20], SampleType::U8, *channels);
            let default = || codec.info().complete(&codec.info().default_settings()).unwrap();
            let settings = offering(codec.as_ref(), Site::Inline).unwrap_or_else(default);
            let decoder = opened(codec.as_ref(), &settings, &volume);
            // Pass, filter and source determine the text of a shader.
            let mut distinct: HashMap<(Pipeline, Site, String), (Filter, TextureSampling)> = HashMap::new();
            for label in labels(info) {
                let renderer = renderer(&label).unwrap();
                for (optics, projection) in Optics::all()
                    .into_iter()
                    .flat_map(|o| [Projection::Perspective, Projection::Orthographic].map(|p| (o, p)))
                {
                    let view = optics.of(view(Filter::Linear, projection), decoder.as_ref());
                    for (site, sampling) in [
                        (Site::Inline, TextureSampling::Manual),
                        (Site::Host, TextureSampling::Manual),
                        (Site::Host, TextureSampling::Hardware),
                        (Site::Ring, TextureSampling::Manual),
                        (Site::Ring, TextureSampling::Hardware),
                    ] {
                        if !codec.offers(&settings, site) || site == Site::Ring && !info.draws_layers(&label)
                        {
                            continue; // refused before a plan is asked for
                        }
                        let plan = match site {
                            Site::Ring => renderer.plan_layers(&view, decoder.layout()),
                            _ => renderer.plan(&view, decoder.layout()),
                        };
                        let plan = plan.unwrap_or_else(|e| panic!("{label}: {e}"));
                        let pass = the_pass(&plan);
                        for filter in Filter::ALL {
                            let by_cells = filter == Filter::OptimisedLinear;
                            if by_cells && !(site == Site::Inline && codec.info().fetch_cell) {
                                continue; // refused before a shader is asked for
                            }
                            let key = (pass.pipeline.clone(), site, format!("{sampling:?} {filter}"));
                            let (pictures, shaders) = counts.entry((id, label.clone())).or_default();
                            *pictures += 1;
                            shaders.insert((channels, key.clone()));
                            distinct.insert(key, (filter, sampling));
                        }
                    }
                }
            }
            let problems: Vec<String> = distinct
                .par_iter()
                .flat_map(|((pipeline, site, how), (filter, sampling))| {
                    let source = source(id, decoder.as_ref(), *site, *sampling);
                    let made = |program| {
                        let shader = made(&program, *filter, decoder.as_ref(), &source);
                        shader.map_err(|e| e.to_string()).and_then(|shader| held(id, &shader)).err()
                    };
                    let problems = and_guarded(pipeline).into_iter().filter_map(made);
                    problems.map(|e| format!("{id} {site} {how}: {e}")).collect::<Vec<_>>()
                })
                .collect();
            assert!(problems.is_empty(), "{}", problems.join("\n"));
        }
    }
    // One snapshot per codec, so that another codec changes none of them.
    let mut of_codecs: BTreeMap<&str, Vec<String>> = BTreeMap::new();
    for ((id, label), (pictures, shaders)) in counts {
        let line = format!("{label}: {pictures} pictures, {} shaders", shaders.len());
        of_codecs.entry(id).or_default().push(line);
    }
    assert_eq!(of_codecs.len(), names.codecs().iter().count());
    for (id, lines) in of_codecs {
        insta::assert_snapshot!(format!("scenes_of_{id}"), lines.join("\n"));
    }
}

/// The test of the test: a pass without one of its modules, or with one of its own twice, is detected.
#[test]
fn no_module_can_be_left_out() {
    let names = Names::new().unwrap();
    let codec = names.codecs().get("raw").unwrap();
    let volume = varied([17, 9, 20], SampleType::U8, 1);
    let decoder = opened(codec.as_ref(), &codec.info().default_settings(), &volume);
    let source = source("raw", decoder.as_ref(), Site::Inline, TextureSampling::Manual);
    for label in renderers().iter().flat_map(|r| labels(r.info())) {
        let renderer = renderer(&label).unwrap();
        for optics in [Optics::default(), Optics::EVERYTHING] {
            let view = optics.of(view(Filter::Linear, Projection::Perspective), decoder.as_ref());
            let whole = renderer.plan(&view, decoder.layout()).unwrap();
            for program in and_guarded(&the_pass(&whole).pipeline) {
                let make = |program: &Program| made(program, view.filter, decoder.as_ref(), &source);
                let text = make(&program).unwrap().wgsl;
                for i in 0..program.modules.len() {
                    let [mut without, mut twice] = [program.clone(), program.clone()];
                    let gone = without.modules.remove(i);
                    twice.modules.push(gone.clone());
                    assert!(make(&twice).is_err(), "{label}: {} may stand twice", gone.name());
                    // A shared module that is the only one of its kind is added automatically.
                    let same = make(&without).is_ok_and(|shader| shader.wgsl.len() == text.len());
                    assert!(same || make(&without).is_err(), "{label}: {} is not needed", gone.name());
                }
                for i in 0..program.offered.len() {
                    let mut without = program.clone();
                    let gone = without.offered.remove(i);
                    let found = make(&without);
                    let same = found.as_ref().is_ok_and(|shader| shader.wgsl == text);
                    // So is a module that alone declares another used name.
                    let noticed = if text.contains(gone.source()) { same || found.is_err() } else { same };
                    assert!(noticed, "{label}: {}", gone.name());
                }
            }
        }
    }
}

/// If a renderer calls an undeclared function, or one that a view must choose, the error names it.
#[test]
fn a_missing_function_is_named() {
    let names = Names::new().unwrap();
    let codec = names.codecs().get("raw").unwrap();
    let volume = varied([9; 3], SampleType::U8, 1);
    let decoder = opened(codec.as_ref(), &codec.info().default_settings(), &volume);
    let source = source("raw", decoder.as_ref(), Site::Inline, TextureSampling::Manual);
    let view = view(Filter::Nearest, Projection::Perspective);
    let plan = renderer("raycasting").unwrap().plan(&view, decoder.layout()).unwrap();
    let mut program = the_pass(&plan).pipeline.program();
    let gather = program.modules.pop().unwrap();
    let problem =
        |program: &Program| made(program, view.filter, decoder.as_ref(), &source).unwrap_err().to_string();
    let error = problem(&program);
    assert!(error.contains("`gather`") && error.contains("shaders/rays/follow.wgsl:"), "{error}");
    assert!(error.contains("neither this program's modules nor the shared ones declare `gather`"), "{error}");
    program.modules.push(gather);
    program.offered.retain(|module| !module.name().contains("every_sample"));
    let error = problem(&program);
    assert!(error.contains("`next_sample` is declared by shaders/skipping/next_sample.wgsl"), "{error}");
    assert!(
        error.contains("shaders/skipping/every_sample.wgsl: the program is to offer one of them"),
        "{error}"
    );
}
