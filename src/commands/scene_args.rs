//! A scene on the command line.

use clap::Args;
use cvr_core::pipeline::{Scene, TransferDomain, parse_colour};
use cvr_core::render::{Camera, ControlPoint, Filter, Projection};

use crate::exit::BadInput;

/// What to draw, and how.
#[derive(Debug, Args)]
pub struct SceneArgs {
    /// Width and height of the picture in pixels, as 512x512.
    #[arg(long, default_value = "512x512", value_parser = size)]
    size: [u32; 2],
    /// Degrees around the vertical axis.
    #[arg(long, default_value_t = 30.0, allow_negative_numbers = true)]
    azimuth: f64,
    /// Degrees above the horizon.
    #[arg(long, default_value_t = 20.0, allow_negative_numbers = true)]
    elevation: f64,
    /// Degrees by which the camera turns clockwise; 180 stands the picture on its head.
    #[arg(long, default_value_t = 0.0, allow_negative_numbers = true)]
    roll: f64,
    /// Magnification; 1 fits the volume.
    #[arg(long, default_value_t = 1.0)]
    zoom: f64,
    /// Parallel rays instead of perspective.
    #[arg(long)]
    orthographic: bool,
    /// Control points VALUE:#rrggbbaa separated by commas; values are data units, or 0..1 of the volume's range
    /// with --range.
    #[arg(long, value_name = "POINTS")]
    transfer_function: Option<String>,
    /// Control values are fractions of the volume's range.
    #[arg(long)]
    range: bool,
    /// Distance between samples in voxels.
    #[arg(long, default_value_t = 0.5)]
    step_voxels: f32,
    /// nearest, linear or optimised-linear.
    #[arg(long, default_value = "linear", value_parser = filter)]
    pub filter: Filter,
}

impl SceneArgs {
    /// The scene.
    pub fn scene(&self) -> Result<Scene, BadInput> {
        let positive = |x: f64| x > 0.0 && x.is_finite();
        if !positive(self.zoom) || !Scene::STEP_VOXELS.contains(&self.step_voxels) {
            return Err(BadInput("--zoom must be positive, --step-voxels from 0.01 to 1000".to_owned()));
        }
        if !self.azimuth.is_finite() || !(-90.0..=90.0).contains(&self.elevation) {
            return Err(BadInput(
                "--azimuth and --elevation are angles, the latter from -90 to 90".to_owned(),
            ));
        }
        let projection = if self.orthographic { Projection::Orthographic } else { Projection::Perspective };
        let camera = Camera {
            azimuth: self.azimuth,
            elevation: self.elevation,
            roll: self.roll,
            zoom: self.zoom,
            projection,
            ..Camera::default()
        };
        let (control_points, domain) = match &self.transfer_function {
            Some(text) => {
                let domain = if self.range { TransferDomain::Range } else { TransferDomain::Data };
                (text.split(',').map(control_point).collect::<Result<_, _>>().map_err(BadInput)?, domain)
            }
            None => (grey_ramp(), TransferDomain::Range),
        };
        Ok(Scene {
            name: "command line".to_owned(),
            volumes: None,
            size: self.size,
            camera,
            control_points,
            domain,
            step_voxels: self.step_voxels,
            early_termination: 0.999,
            background: [0.0; 3],
            shading: None,
            clip: None,
        })
    }
}

/// Transparent below a tenth of the range, then ever brighter and denser.
fn grey_ramp() -> Vec<ControlPoint> {
    let point = |value, grey, alpha| ControlPoint { value, rgba: [grey, grey, grey, alpha] };
    vec![point(0.1, 0.2, 0.0), point(0.5, 0.7, 0.05), point(1.0, 1.0, 0.5)]
}

fn size(text: &str) -> Result<[u32; 2], String> {
    let side = |t: &str| t.parse::<u32>().ok().filter(|s| (1..=Scene::MAX_SIZE).contains(s));
    let sides = text.split_once('x').and_then(|(w, h)| Some([side(w)?, side(h)?]));
    sides.ok_or_else(|| format!("`{text}`: write width and height, 1 to {}, as 512x512", Scene::MAX_SIZE))
}

fn filter(text: &str) -> Result<Filter, String> {
    let known = Filter::ALL.map(Filter::name).join(", ");
    Filter::ALL.into_iter().find(|f| f.name() == text).ok_or_else(|| format!("`{text}`: one of {known}"))
}

/// `40:#c8a060c0`.
fn control_point(text: &str) -> Result<ControlPoint, String> {
    let help = || format!("control point `{text}`: write VALUE:#rrggbbaa, as 40:#c8a060c0");
    let (value, colour) = text.split_once(':').ok_or_else(help)?;
    let value = value.trim().parse().map_err(|_| help())?;
    let ([r, g, b], alpha) = parse_colour(colour.trim()).ok_or_else(help)?;
    Ok(ControlPoint { value, rgba: [r, g, b, alpha.unwrap_or(1.0)] })
}
