//! Whether the picture of the device agrees with that of the CPU mirror.

use super::{SizeMismatch, visible};
use crate::render::Image;

/// What two pictures of one scene must keep.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct AgreementRule {
    /// Purpose of the rule.
    pub name: &'static str,
    /// A pixel agrees when no channel differs by more than this.
    pub within: f32,
    /// Fraction of the visible pixels that must agree.
    pub fraction: f64,
    /// No channel of any pixel may differ by more than this.
    pub limit: f32,
}

/// Tolerances, all in one place. Floats are not exact across devices, so pictures cannot be equal. Each bound is tight
/// enough for a picture shifted by one pixel to fail.
///
/// | rule     | visible pixels that agree | within | none beyond | because                                          |
/// |----------|---------------------------|--------|-------------|--------------------------------------------------|
/// | MANUAL   | 99.9 %                    | 1/255  | 4/255       | same arithmetic; fused and reordered operations  |
/// | HARDWARE | 100 %                     | 8/255  | 8/255       | texture units weigh with 8 bits                  |
impl AgreementRule {
    /// Filtered by the shader, by the mirror's own arithmetic. With the filter *nearest* a sample that lies within
    /// rounding of a voxel's face may still fall to either side, on one pixel in thousands.
    pub const MANUAL: Self =
        Self { name: "manual filter", within: 1.0 / 255.0, fraction: 0.999, limit: 4.0 / 255.0 };
    /// Filtered by the texture unit.
    pub const HARDWARE: Self =
        Self { name: "hardware filter", within: 8.0 / 255.0, fraction: 1.0, limit: 8.0 / 255.0 };
    /// Rounding of `n/255 − m/255` in single precision must not decide.
    const SLACK: f32 = 1e-6;

    /// Checks a device's picture against the mirror's.
    ///
    /// A pixel counts as visible if it is visible in either picture. Two blank pictures agree and prove little: see
    /// [`ImageAgreement::visible_pixels`].
    ///
    /// # Errors
    /// When the rule is broken, or the pictures differ in size.
    pub fn check(&self, mirror: &Image, device: &Image) -> Result<ImageAgreement, Disagreement> {
        let agreement = image_agreement(mirror, device, self.within)?;
        let kept =
            agreement.fraction >= self.fraction && agreement.max_difference <= self.limit + Self::SLACK;
        if kept { Ok(agreement) } else { Err(Disagreement::Rule { rule: *self, agreement }) }
    }
}

/// How far two pictures agree.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct ImageAgreement {
    /// Fraction of the visible pixels that agree; 1 when none is visible.
    pub fraction: f64,
    /// Largest difference of a channel, premultiplied RGBA, over *all* pixels; infinite for a value that is not a number.
    pub max_difference: f32,
    /// Where it is: x, y.
    pub worst_pixel: [u32; 2],
    /// Pixels that are visible in either picture.
    pub visible_pixels: u64,
}

/// Why two pictures do not agree.
#[derive(Copy, Clone, Debug, PartialEq, thiserror::Error)]
pub enum Disagreement {
    /// Sizes differ.
    #[error(transparent)]
    Size(#[from] SizeMismatch),
    /// A tolerance is exceeded.
    #[error(
        "{}: {:.3} % of {} visible pixels within {:.0}/255 (needed: {:.1} %), largest difference {:.1}/255 at {:?} \
         (limit: {:.0}/255)",
        rule.name, agreement.fraction * 100.0, agreement.visible_pixels, rule.within * 255.0, rule.fraction * 100.0,
        agreement.max_difference * 255.0, agreement.worst_pixel, rule.limit * 255.0
    )]
    Rule {
        /// The rule.
        rule: AgreementRule,
        /// What was found.
        agreement: ImageAgreement,
    },
}

/// Compares two pictures channel by channel: which fraction of the visible pixels differs by no more than `within`
/// (for instance 1/255), and what the largest difference is.
///
/// # Errors
/// When the pictures differ in size.
pub fn image_agreement(a: &Image, b: &Image, within: f32) -> Result<ImageAgreement, SizeMismatch> {
    SizeMismatch::check(a, b)?;
    let (mut seen, mut agreeing) = (0u64, 0u64);
    let (mut max_difference, mut worst) = (0.0f32, 0);
    for (at, (a, b)) in a.pixels().iter().zip(b.pixels()).enumerate() {
        let difference = (0..4).map(|c| (a[c] - b[c]).abs()).fold(0.0f32, |m, d| {
            // A comparison with NaN is false: it must not pass for agreement.
            if d.is_nan() { f32::INFINITY } else { m.max(d) }
        });
        if difference > max_difference {
            (max_difference, worst) = (difference, at);
        }
        if visible(a) || visible(b) {
            seen += 1;
            agreeing += u64::from(difference <= within + AgreementRule::SLACK);
        }
    }
    let width = a.size()[0].max(1) as usize;
    Ok(ImageAgreement {
        fraction: if seen == 0 { 1.0 } else { agreeing as f64 / seen as f64 },
        max_difference,
        worst_pixel: [(worst % width) as u32, (worst / width) as u32],
        visible_pixels: seen,
    })
}

/// The picture moved by whole pixels (right and down), transparent where nothing moves in: what a test of a
/// comparator must reject.
#[must_use]
pub fn shifted(image: &Image, dx: i32, dy: i32) -> Image {
    let [width, height] = image.size();
    let mut out = Image::new(image.size());
    for y in 0..height {
        for x in 0..width {
            let (u, v) = (i64::from(x) - i64::from(dx), i64::from(y) - i64::from(dy));
            if (0..i64::from(width)).contains(&u) && (0..i64::from(height)).contains(&v) {
                let at = |x: i64, y: i64| (y * i64::from(width) + x) as usize;
                out.pixels_mut()[at(x.into(), y.into())] = image.pixels()[at(u, v)];
            }
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    const STEP: f32 = 1.0 / 255.0;

    fn gradient() -> Image {
        let pixel = |i: u32| {
            let (x, y) = (i % 50, i / 50);
            let inside = (10..40).contains(&x) && (10..40).contains(&y);
            if inside { [x as f32 / 50.0, y as f32 / 50.0, 0.5, 1.0] } else { [0.0; 4] }
        };
        Image::from_pixels([50, 50], (0..2500).map(pixel).collect()).unwrap()
    }

    #[test]
    fn equal_pictures_keep_every_rule_and_a_shift_by_one_pixel_none() {
        let a = gradient();
        for rule in [AgreementRule::MANUAL, AgreementRule::HARDWARE] {
            let equal = rule.check(&a, &a).unwrap();
            assert_eq!((equal.fraction, equal.max_difference, equal.visible_pixels), (1.0, 0.0, 900));
            for (dx, dy) in [(1, 0), (0, 1), (-1, 0), (0, -1)] {
                assert!(rule.check(&a, &shifted(&a, dx, dy)).is_err(), "{} {dx} {dy}", rule.name);
            }
        }
    }

    #[test]
    fn a_change_of_one_bit_is_noticed() {
        let a = gradient();
        let mut b = a.clone();
        b.pixels_mut()[1225][2] = f32::from_bits(0.5f32.to_bits() + 1);
        let agreement = image_agreement(&a, &b, 0.0).unwrap();
        assert!(agreement.max_difference > 0.0);
        assert_eq!(agreement.worst_pixel, [25, 24]);
    }

    #[test]
    fn the_manual_rule_ends_where_it_says() {
        let a = gradient();
        let at = |i: usize| (10 + i / 30) * 50 + 10 + i % 30; // the i-th of 900 visible pixels
        let with = |pixels: usize, steps: f32| {
            let mut b = a.clone();
            (0..pixels).for_each(|i| b.pixels_mut()[at(i)][2] += steps * STEP);
            AgreementRule::MANUAL.check(&a, &b)
        };
        assert!(with(900, 1.0).is_ok(), "one step everywhere");
        assert!(with(900, 1.1).is_err(), "more than one step everywhere");
        assert!(with(1, 2.0).is_err(), "1 of 900 is more than 0.1 %");
        assert!(with(1, 4.1).is_err());
    }

    #[test]
    fn a_few_pixels_may_differ_up_to_the_limit() {
        let a = Image::from_pixels([100, 20], vec![[0.5, 0.5, 0.5, 1.0]; 2000]).unwrap();
        let with = |pixels: usize, steps: f32| {
            let mut b = a.clone();
            (0..pixels).for_each(|i| b.pixels_mut()[i][0] += steps * STEP);
            AgreementRule::MANUAL.check(&a, &b)
        };
        assert!(with(2, 4.0).is_ok());
        assert!(with(3, 4.0).is_err());
        let error = with(1, 5.0).unwrap_err();
        assert_eq!(
            error.to_string(),
            "manual filter: 99.950 % of 2000 visible pixels within 1/255 (needed: 99.9 %), largest difference \
             5.0/255 at [0, 0] (limit: 4/255)"
        );
    }

    #[test]
    fn hardware_may_differ_everywhere_by_eight_steps_and_nowhere_by_nine() {
        let a = gradient();
        let mut b = a.clone();
        b.pixels_mut().iter_mut().for_each(|p| p[2] += 8.0 * STEP);
        assert!(AgreementRule::HARDWARE.check(&a, &b).is_ok());
        b.pixels_mut()[0][2] += STEP;
        assert!(AgreementRule::HARDWARE.check(&a, &b).is_err(), "an invisible pixel counts too");
    }

    #[test]
    fn what_is_no_number_does_not_agree() {
        let a = gradient();
        let mut b = a.clone();
        b.pixels_mut()[1225][0] = f32::NAN;
        assert_eq!(image_agreement(&a, &b, 1.0).unwrap().max_difference, f32::INFINITY);
        assert!(AgreementRule::HARDWARE.check(&a, &b).is_err());
        assert!(image_agreement(&a, &Image::new([1, 1]), 1.0).is_err());
    }
}
