//! `cvr presets`

use std::process::ExitCode;

use cvr_core::render::{ControlPoint, Preset};

/// Lists named transfer functions, each with the control points that `--range --transfer-function` takes.
#[must_use]
pub fn run() -> ExitCode {
    for preset in Preset::ALL {
        say!("{}  {}", preset.name, preset.doc);
        let points: Vec<String> = preset.control_points().iter().map(written).collect();
        say!("    {}", points.join(","));
        say!("");
    }
    ExitCode::SUCCESS
}

/// `0.5:#c8a060c0`, its colour to 8 bits.
fn written(point: &ControlPoint) -> String {
    let [r, g, b, a] = point.rgba.map(|v| (v.clamp(0.0, 1.0) * 255.0).round() as u8);
    format!("{}:#{r:02x}{g:02x}{b:02x}{a:02x}", point.value)
}
