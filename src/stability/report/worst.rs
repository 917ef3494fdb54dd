//! The worst pictures: the original's, the codec's, and the trivial codec's at the same rate, side by side. They are
//! drawn again, which costs less than keeping the pictures of all cells.

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use cvr_core::render::{Image, to_png};
use cvr_core::stability::{Reason, Subject, Trial};
use minijinja::{Value, context};
use rayon::prelude::*;

use crate::experiment::files::folder::OutFolder;
use crate::experiment::files::names::IMAGES;
use crate::stability::atlas::Atlas;
use crate::stability::drawing::{BACKGROUND, Stage};
use crate::stability::plan::Plan;
use crate::stability::row::Row;
use crate::stability::scenes::Provocation;

/// How many are shown.
const SHOWN: usize = 18;
/// Pixels between two pictures.
const BETWEEN: usize = 2;

/// Draws them into `images/`, and what the page says of them.
pub fn values(out: &OutFolder, plan: &Plan, atlas: &Atlas) -> Result<Vec<Value>, String> {
    let rows = atlas.worst(SHOWN);
    let pictures: Vec<Value> = rows
        .par_iter()
        .enumerate()
        .map(|(index, row)| {
            let Some(([width, height], bytes)) = draw(row, plan)? else { return Ok(None) };
            out.write(&name(index + 1), &bytes).map_err(|e| e.to_string())?;
            let decibels = |rmse: Option<f64>| rmse.map_or(0.0, |r| -20.0 * r.log10());
            Ok(Some(context! {
                src => Value::from_safe_string(format!("data:image/png;base64,{}", STANDARD.encode(bytes))),
                width => width * 2,
                height => height * 2,
                label => &row.label,
                subject => &row.subject,
                value => row.value,
                dial => &row.dial,
                scene => &row.scene,
                reason => row.reason.map(Reason::name),
                own => format!("{:.1}", decibels(row.image_rmse)),
                trivial => match row.trivial_image_rmse {
                    Some(rmse) if rmse > 0.0 => format!("{:.1} dB", decibels(Some(rmse))),
                    _ => "exact".to_owned(),
                },
                rate => row.bits_per_voxel.map(|bits| format!("{bits:.2}")),
            }))
        })
        .collect::<Result<Vec<_>, String>>()?
        .into_iter()
        .flatten()
        .collect();
    Ok(pictures)
}

/// Name of the file of a row, counted from 1.
pub fn name(number: usize) -> String {
    format!("{IMAGES}/worst-{number:02}.png")
}

/// Width and height in pixels, and a PNG file.
type Drawn = ([usize; 2], Vec<u8>);

/// The three pictures of a row; `None` where the codec has none.
fn draw(row: &Row, plan: &Plan) -> Result<Option<Drawn>, String> {
    let contestant = plan.contestants.iter().find(|c| c.label == row.label);
    let (Some(contestant), Some(subject), Some(scene)) =
        (contestant, Subject::named(&row.subject), Provocation::named(&row.scene))
    else {
        return Ok(None);
    };
    let stage = Stage::new(subject, row.step - 1, &[scene], [plan.config.edge, plan.config.picture])?;
    let trial = Trial::of(contestant.codec.as_ref(), &contestant.settings, stage.volume());
    let (Some(trivial), Some(scene)) = (trial.trivial(stage.volume()), stage.scenes().first()) else {
        return Ok(None);
    };
    if trial.frames.is_empty() {
        return Ok(None);
    }
    let own = stage.draw(scene, &stage.shown(&trial.frames)?)?;
    let trivial = stage.draw(scene, &stage.shown(&trivial.frames)?)?;
    let (size, rgb) = side_by_side(&[&scene.reference, &own, &trivial]);
    let png = to_png(size.map(|n| n as u32), &rgb).map_err(|e| e.to_string())?;
    Ok(Some((size, png)))
}

/// Pictures of one size in a row, in 8 bits.
fn side_by_side(images: &[&Image]) -> ([usize; 2], Vec<u8>) {
    let [width, height] = images.first().map_or([0, 0], |i| i.size().map(|n| n as usize));
    let rows: Vec<Vec<u8>> = images.iter().map(|image| image.to_rgb8(BACKGROUND)).collect();
    let mut rgb = Vec::new();
    for y in 0..height {
        for (i, row) in rows.iter().enumerate() {
            rgb.extend(std::iter::repeat_n(255, if i > 0 { 3 * BETWEEN } else { 0 }));
            rgb.extend_from_slice(&row[3 * width * y..3 * width * (y + 1)]);
        }
    }
    ([images.len() * width + images.len().saturating_sub(1) * BETWEEN, height], rgb)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pictures_stand_side_by_side() {
        let picture = |v: f32| Image::from_pixels([2, 1], vec![[v, v, v, 1.0]; 2]).unwrap();
        let (size, rgb) = side_by_side(&[&picture(0.0), &picture(1.0)]);
        assert_eq!(size, [6, 1]);
        let grey: Vec<u8> = rgb.chunks_exact(3).map(|p| p[0]).collect();
        assert_eq!(grey, [0, 0, 255, 255, 255, 255]);
        assert_eq!(rgb.len(), 18);
    }
}
