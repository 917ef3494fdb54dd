//! Multiplies an experiment out: the cells to run, and reasons for the others.

use std::collections::HashSet;
use std::fmt;

use super::{Cell, CodecSweep, Experiment, Known, PipelineAxes, Sweep};
use crate::codec::{Codec, Granularity, Registry, Settings, Site};
use crate::render::{Filter, RendererInfo};

/// Limits of this machine and build. By default there are none.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Capabilities {
    /// Sites that are not available, each with the reason in words ("this device has no 3-D textures").
    pub missing_sites: Vec<(Site, String)>,
}

/// An experiment, multiplied out.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Resolution {
    /// The cells to run, each once. The order is: volume, codec, settings, scene, renderer, site, filter, skipping,
    /// stages; each in the order of the configuration.
    pub cells: Vec<Cell>,
    /// The combinations that cannot run, in the same order.
    pub refused: Vec<Refusal>,
}

/// A combination that cannot run.
#[derive(Clone, Debug, PartialEq)]
pub struct Refusal {
    /// The combination.
    pub cell: Cell,
    /// Why.
    pub reason: Reason,
}

/// Why a combination cannot run. Its `Display` is a sentence for the report.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Reason {
    /// The codec cannot be decoded there.
    Site {
        /// Codec id.
        codec: String,
        /// The site asked for.
        site: Site,
        /// The sites that it offers.
        offered: Vec<Site>,
    },
    /// [`Filter::OptimisedLinear`] at a site that does not decode single voxels. There the filter reads decoded voxels
    /// and does not call the codec.
    FilterNeedsInline {
        /// The site asked for.
        site: Site,
    },
    /// The renderer, with these settings, does not draw layer by layer.
    NoLayers {
        /// The site asked for.
        site: Site,
        /// Label of the renderer.
        renderer: String,
        /// Labels with which renderers of this build can do it.
        offered: Vec<String>,
    },
    /// [`Filter::OptimisedLinear`] with a codec that has no fast path.
    NoFetchCell {
        /// Codec id.
        codec: String,
        /// Codecs of this build that have one.
        offered: Vec<String>,
    },
    /// The codec has fewer stages.
    Stages {
        /// Codec id.
        codec: String,
        /// Stages asked for.
        asked: u8,
        /// Stages that it has with these settings.
        most: u8,
    },
    /// The codec has fewer resolutions.
    Resolution {
        /// Codec id.
        codec: String,
        /// Resolution asked for.
        asked: u8,
        /// Resolutions that it has with these settings, the full one included.
        resolutions: u8,
    },
    /// The codec refuses the settings, in its own words.
    Settings(String),
    /// This machine or build lacks something.
    Missing(String),
    /// The same combination came before, written in another way.
    Repeated,
}

impl fmt::Display for Reason {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Site { codec, site, offered } => {
                let offered: Vec<&str> = offered.iter().map(|s| s.name()).collect();
                let offered = if offered.is_empty() { "none".to_owned() } else { offered.join(", ") };
                write!(f, "codec {codec} cannot be decoded at site {site}; it offers: {offered}")
            }
            Self::FilterNeedsInline { site } => write!(
                f,
                "filter {}: site {site} filters decoded texels and never calls the codec's fetch_cell; use \
                 filter linear, or site inline",
                Filter::OptimisedLinear
            ),
            Self::NoLayers { site, renderer, offered } => {
                let offered = if offered.is_empty() { "none".to_owned() } else { offered.join(" or ") };
                write!(
                    f,
                    "site {site}: renderer {renderer} does not draw layer by layer; renderers that do: {offered}"
                )
            }
            Self::NoFetchCell { codec, offered } => {
                let offered = if offered.is_empty() { "none".to_owned() } else { offered.join(", ") };
                write!(
                    f,
                    "filter {}: codec {codec} has no fetch_cell (codecs that have one: {offered}); use filter linear",
                    Filter::OptimisedLinear
                )
            }
            Self::Stages { codec, asked, most: 1 } => write!(
                f,
                "stages {asked}: codec {codec} has no stages that could be left out; use stages \"all\""
            ),
            Self::Stages { codec, asked, most } => {
                write!(f, "stages {asked}: codec {codec} has {most} stages; use 1 to {most}, or \"all\"")
            }
            Self::Resolution { codec, asked, resolutions: 0 | 1 } => {
                write!(f, "resolution {asked}: codec {codec} has the full resolution alone; use resolution 0")
            }
            Self::Resolution { codec, asked, resolutions } => {
                let most = resolutions - 1;
                write!(f, "resolution {asked}: codec {codec} has resolutions 0 to {most} with these settings")
            }
            Self::Settings(problem) | Self::Missing(problem) => f.write_str(problem),
            Self::Repeated => {
                f.write_str("the same settings stand earlier in the configuration, written in another way")
            }
        }
    }
}

/// Multiplies an experiment out.
///
/// A combination that a codec, a renderer or the machine rules out becomes a refusal with its first reason. No
/// combination is dropped without a reason.
#[must_use]
pub fn resolve(experiment: &Experiment, known: &Known<'_>, capabilities: &Capabilities) -> Resolution {
    let mut resolution = Resolution::default();
    let mut codecs: Vec<ResolvedCodec> =
        experiment.codecs.iter().flat_map(|sweep| settings_of(sweep, known)).collect();
    // All other axes name nothing twice.
    let mut seen = HashSet::new();
    for codec in &mut codecs {
        if !seen.insert(format!("{} {}", codec.id, codec.settings)) {
            codec.problem = Some(Reason::Repeated);
        }
    }
    for volume in &experiment.volumes {
        for codec in &codecs {
            for scene in experiment.scenes_of(&volume.name) {
                for Axes { renderer, site, filter, skipping, level } in axes(experiment) {
                    let cell = Cell {
                        volume: volume.name.clone(),
                        codec: codec.id.clone(),
                        settings: codec.settings.clone(),
                        scene: scene.name.clone(),
                        renderer: renderer.to_owned(),
                        site,
                        filter,
                        skipping,
                        stages: level.0,
                        resolution: level.1,
                    };
                    let reason = codec
                        .problem
                        .clone()
                        .or_else(|| renderer_problem(renderer, known))
                        .or_else(|| {
                            let unsupported =
                                |c| unsupported(known.codecs, c, &codec.settings, (site, filter));
                            codec.codec.and_then(unsupported)
                        })
                        .or_else(|| codec.codec.and_then(|c| missing_level(c, &codec.settings, level)))
                        .or_else(|| undrawable(renderer, site, known.renderers))
                        .or_else(|| site_problem(site, capabilities));
                    match reason {
                        Some(reason) => resolution.refused.push(Refusal { cell, reason }),
                        None => resolution.cells.push(cell),
                    }
                }
            }
        }
    }
    resolution
}

/// One codec with one set of settings.
struct ResolvedCodec<'a> {
    id: String,
    settings: Settings,
    codec: Option<&'a dyn Codec>,
    problem: Option<Reason>,
}

/// All settings of one `[[codec]]` table. The first setting in the file varies slowest.
fn settings_of<'a>(sweep: &CodecSweep, known: &Known<'a>) -> Vec<ResolvedCodec<'a>> {
    let codec = known.codecs.get(&sweep.id);
    let resolved = |written: Settings| {
        let checked = codec.as_ref().map_err(ToString::to_string).and_then(|codec| {
            let complete = codec.info().complete(&written).map_err(|e| e.to_string())?;
            let problem = codec.encoder(&complete).err().map(|e| Reason::Settings(e.to_string()));
            Ok((complete, problem))
        });
        let (settings, problem) =
            checked.unwrap_or_else(|problem| (written, Some(Reason::Settings(problem))));
        let codec = codec.as_ref().ok().copied().map(AsRef::as_ref);
        ResolvedCodec { id: sweep.id.clone(), settings, codec, problem }
    };
    Sweep::combinations(&sweep.sweeps).into_iter().map(resolved).collect()
}

/// One combination of the pipeline's axes.
#[derive(Copy, Clone)]
struct Axes<'a> {
    renderer: &'a str,
    site: Site,
    filter: Filter,
    skipping: bool,
    /// Stages and resolution.
    level: (Option<u8>, u8),
}

fn axes(experiment: &Experiment) -> impl Iterator<Item = Axes<'_>> {
    let PipelineAxes { renderers, sites, filters, skipping, stages, resolutions } = &experiment.pipeline;
    let levels = move || {
        resolutions.iter().flat_map(move |&resolution| stages.iter().map(move |&stages| (stages, resolution)))
    };
    renderers.iter().flat_map(move |renderer| {
        sites.iter().flat_map(move |&site| {
            filters.iter().flat_map(move |&filter| {
                let axes = move |skipping| {
                    levels().map(move |level| Axes { renderer, site, filter, skipping, level })
                };
                skipping.iter().flat_map(move |&skipping| axes(skipping))
            })
        })
    })
}

fn renderer_problem(renderer: &str, known: &Known<'_>) -> Option<Reason> {
    let missing = || Reason::Missing(format!("this build has no renderer {renderer}"));
    let id = renderer.split(',').next().unwrap_or_default();
    (!known.renderers.iter().any(|info| info.id == id)).then(missing)
}

/// Why a codec with these (complete) settings does not offer a site with a filter. `None` if it does. The reason names
/// codecs of `codecs` that do.
#[must_use]
pub fn unsupported(
    codecs: &Registry,
    codec: &dyn Codec,
    settings: &Settings,
    (site, filter): (Site, Filter),
) -> Option<Reason> {
    let info = codec.info();
    if !codec.offers(settings, site) {
        let offered = Site::ALL.into_iter().filter(|site| codec.offers(settings, *site)).collect();
        return Some(Reason::Site { codec: info.id.to_owned(), site, offered });
    }
    match filter {
        Filter::OptimisedLinear if site.granularity() != Granularity::Voxel => {
            Some(Reason::FilterNeedsInline { site })
        }
        Filter::OptimisedLinear if !info.fetch_cell => {
            let offered = codecs.iter().map(|c| c.info()).filter(|i| i.fetch_cell).map(|i| i.id.to_owned());
            Some(Reason::NoFetchCell { codec: info.id.to_owned(), offered: offered.collect() })
        }
        Filter::Nearest | Filter::Linear | Filter::OptimisedLinear => None,
    }
}

/// Why a codec with these (complete) settings cannot decode this number of stages or this resolution. `None` if it can.
/// All stages (`None`) and resolution 0 are always possible. A codec with one stage accepts no number.
#[must_use]
pub fn missing_level(
    codec: &dyn Codec,
    settings: &Settings,
    (stages, resolution): (Option<u8>, u8),
) -> Option<Reason> {
    let id = || codec.info().id.to_owned();
    let most = codec.stages(settings);
    if let Some(asked) = stages.filter(|asked| *asked > most || most == 1) {
        return Some(Reason::Stages { codec: id(), asked, most });
    }
    let resolutions = codec.resolutions(settings);
    let missing = resolution > 0 && resolution >= resolutions;
    missing.then(|| Reason::Resolution { codec: id(), asked: resolution, resolutions })
}

/// Why a renderer with this label cannot draw from a site. `None` if it can.
#[must_use]
pub fn undrawable(label: &str, site: Site, renderers: &[&RendererInfo]) -> Option<Reason> {
    match site.granularity() {
        // Every renderer asks for single voxels, wherever they lie.
        Granularity::Voxel | Granularity::Brick | Granularity::Frame => None,
        Granularity::Layer if renderers.iter().any(|info| info.draws_layers(label)) => None,
        Granularity::Layer => {
            let offered = renderers.iter().filter_map(|info| info.layers_label()).collect();
            Some(Reason::NoLayers { site, renderer: label.to_owned(), offered })
        }
    }
}

fn site_problem(site: Site, capabilities: &Capabilities) -> Option<Reason> {
    let missing = capabilities.missing_sites.iter().find(|(s, _)| *s == site);
    missing.map(|(_, reason)| Reason::Missing(format!("site {site}: {reason}")))
}
