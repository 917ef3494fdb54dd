//! A scene on the command line.

use clap::Args;
use cvr_core::pipeline::number::{AZIMUTH, EARLY_TERMINATION, ELEVATION, ROLL, STEP_VOXELS, ZOOM};
use cvr_core::pipeline::{FilePath, FrameRange, Scene, SceneOpacity, TransferDomain, parse_colour};
use cvr_core::render::{
    Camera, ClipBox, ColourOpacity, ControlPoint, Filter, Light, Preset, Projection, Shading,
    TransferFunction,
};

use crate::exit::BadInput;
use crate::experiment::inputs::scenes::read_table;

/// What to draw, and how.
#[derive(Debug, Args)]
pub struct SceneArgs {
    /// Width and height of the picture in pixels, as 512x512.
    #[arg(long, default_value = "512x512", value_parser = size)]
    size: [u32; 2],
    /// Degrees around the vertical axis.
    #[arg(long, default_value_t = AZIMUTH.default(), allow_negative_numbers = true)]
    azimuth: f64,
    /// Degrees above the horizon.
    #[arg(long, default_value_t = ELEVATION.default(), allow_negative_numbers = true)]
    elevation: f64,
    /// Clockwise turn of the camera in degrees; 180 turns the picture upside down.
    #[arg(long, default_value_t = ROLL.default(), allow_negative_numbers = true)]
    roll: f64,
    /// Magnification; 1 fits the volume.
    #[arg(long, default_value_t = ZOOM.default())]
    zoom: f64,
    /// Parallel rays instead of perspective.
    #[arg(long)]
    orthographic: bool,
    #[arg(long, value_name = "POINTS|PRESET", help = transfer_function_help(), allow_hyphen_values = true)]
    transfer_function: Option<String>,
    /// Control values are fractions of the volume's range.
    #[arg(long)]
    range: bool,
    /// What decides the opacity of colours: luminance, red, green, blue, or a volume file of 2³ to 64³ opacities from 0
    /// to 1, red along x, green along y, blue along z.
    #[arg(long, value_name = "CHANNEL|FILE", default_value = "luminance", value_parser = opacity)]
    opacity: SceneOpacity,
    /// The frame of a sequence, counted from 0.
    #[arg(long, value_name = "N", default_value_t = 0)]
    frame: u32,
    /// Light surfaces (Blinn and Phong's model over the gradient of the values).
    #[arg(long)]
    shading: bool,
    /// Where light comes from: camera (over the viewer's left shoulder), or X,Y,Z along the volume's axes towards a light
    /// that does not move, as 1,-1,2; implies --shading.
    #[arg(long, value_name = "camera|X,Y,Z", value_parser = light, allow_hyphen_values = true)]
    light: Option<Shading>,
    /// Draw only this box: lower and upper corner in shares of the extent from 0 to 1, as 0,0,0:1,1,0.5.
    #[arg(long, value_name = "X,Y,Z:X,Y,Z", value_parser = clip_box, allow_hyphen_values = true)]
    clip_box: Option<ClipBox>,
    /// Colour behind the volume, as #203040.
    #[arg(long, value_name = "#rrggbb", default_value = Scene::DEFAULT_BACKGROUND, value_parser = background)]
    background: Background,
    /// Distance between samples in voxels, 0.01 to 1000.
    #[arg(long, default_value_t = STEP_VOXELS.default() as f32)]
    step_voxels: f32,
    /// Opacity above 0 at which a ray ends; 1 = every ray runs to its end.
    #[arg(long, default_value_t = EARLY_TERMINATION.default() as f32)]
    early_termination: f32,
    /// nearest, linear or optimised-linear.
    #[arg(long, default_value = "linear", value_parser = filter)]
    pub filter: Filter,
}

/// RGB, `0.0..=1.0`.
type Background = [f32; 3];

impl SceneArgs {
    /// The scene.
    pub fn scene(&self) -> Result<Scene, BadInput> {
        if !ZOOM.allows(self.zoom) || !STEP_VOXELS.allows_single(self.step_voxels) {
            return Err(BadInput("--zoom must be positive, --step-voxels from 0.01 to 1000".to_owned()));
        }
        if !AZIMUTH.allows(self.azimuth) || !ELEVATION.allows(self.elevation) {
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
        if !EARLY_TERMINATION.allows_single(self.early_termination) {
            return Err(BadInput("--early-termination is an opacity above 0 and at most 1".to_owned()));
        }
        let (control_points, domain) = self.transfer_function()?;
        let mut scene = Scene {
            name: "command line".to_owned(),
            volumes: None,
            size: self.size,
            camera,
            control_points,
            domain,
            step_voxels: self.step_voxels,
            early_termination: self.early_termination,
            background: self.background,
            shading: self.light.or_else(|| self.shading.then(Shading::default)),
            clip: self.clip_box.filter(|clip| *clip != ClipBox::WHOLE),
            opacity: self.opacity.clone(),
            frames: FrameRange { first: self.frame, last: self.frame },
        };
        read_table(&mut scene)?;
        Ok(scene)
    }

    /// Control points and the meaning of their values.
    fn transfer_function(&self) -> Result<(Vec<ControlPoint>, TransferDomain), BadInput> {
        let Some(text) = &self.transfer_function else { return Ok((grey_ramp(), TransferDomain::Range)) };
        if let Some(preset) = Preset::named(text) {
            return Ok((preset.control_points(), TransferDomain::Range));
        }
        if !text.contains(':') {
            let known = presets();
            return Err(BadInput(format!(
                "--transfer-function `{text}`: write control points VALUE:#rrggbbaa, or one of {known}"
            )));
        }
        let (found, most) = (text.split(',').count(), TransferFunction::MAX_POINTS);
        if found > most {
            return Err(BadInput(format!(
                "--transfer-function has {found} control points; it may have {most}: leave out those that lie on the \
                 line between their neighbours"
            )));
        }
        let points: Vec<_> =
            text.split(',').map(control_point).collect::<Result<_, _>>().map_err(BadInput)?;
        if !self.range {
            return Ok((points, TransferDomain::Data));
        }
        match points.iter().find(|point| !(0.0..=1.0).contains(&point.value)) {
            Some(point) => {
                let value = point.value;
                Err(BadInput(format!("control point at {value}: with --range, values lie from 0 to 1")))
            }
            None => Ok((points, TransferDomain::Range)),
        }
    }
}

/// Names of all presets.
fn presets() -> String {
    Preset::ALL.iter().map(|preset| preset.name).collect::<Vec<_>>().join(", ")
}

fn transfer_function_help() -> String {
    let (presets, most) = (presets(), TransferFunction::MAX_POINTS);
    format!(
        "Control points VALUE:#rrggbbaa separated by commas, at most {most}. The opacity is that of one voxel length. \
         Between points the function is exactly linear; two points with one value are a step. Values are data units, or \
         0..1 of the volume's range with --range. Or a preset over that range: {presets} [default: grey, \
         transparent below a tenth of the range]"
    )
}

/// Transparent below a tenth of the range, then increasingly bright and opaque.
fn grey_ramp() -> Vec<ControlPoint> {
    let point = |value, grey, alpha| ControlPoint { value, rgba: [grey, grey, grey, alpha] };
    vec![point(0.1, 0.2, 0.0), point(0.5, 0.7, 0.05), point(1.0, 1.0, 0.5)]
}

fn opacity(text: &str) -> Result<SceneOpacity, String> {
    match ColourOpacity::NAMED.into_iter().find(|(name, ..)| *name == text) {
        Some((_, _, opacity)) => Ok(SceneOpacity::Known(opacity)),
        None => FilePath::literal(text).map(SceneOpacity::File).map_err(|e| e.to_string()),
    }
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

fn background(text: &str) -> Result<Background, String> {
    let help = || format!("`{text}`: write an opaque colour, as #203040");
    parse_colour(text).filter(|(_, alpha)| alpha.is_none()).map(|(rgb, _)| rgb).ok_or_else(help)
}

/// Three numbers between commas.
fn triple(text: &str) -> Option<[f32; 3]> {
    let numbers: Vec<f32> = text.split(',').map(|t| t.trim().parse().ok()).collect::<Option<_>>()?;
    numbers.try_into().ok()
}

fn light(text: &str) -> Result<Shading, String> {
    if text == "camera" {
        return Ok(Shading::default());
    }
    let help = || format!("`{text}`: write camera, or X,Y,Z towards the light, not all 0, as 1,-1,2");
    let direction = triple(text).filter(|d| Shading::is_direction(*d)).ok_or_else(help)?;
    Ok(Shading { light: Light::Fixed, direction, ..Shading::default() })
}

fn clip_box(text: &str) -> Result<ClipBox, String> {
    let help = || format!("`{text}`: write two corners in shares from 0 to 1, as 0,0,0:1,1,0.5");
    let corner = |t: &str| triple(t).filter(|shares| shares.iter().all(|s| (0.0..=1.0).contains(s)));
    let corners = text.split_once(':').and_then(|(low, high)| Some((corner(low)?, corner(high)?)));
    let (low, high) = corners.ok_or_else(help)?;
    let clip = ClipBox { low, high };
    match clip.empty_axis() {
        Some(axis) => {
            Err(format!("`{text}`: empty along {}; the lower corner comes first", ["x", "y", "z"][axis]))
        }
        None => Ok(clip),
    }
}
