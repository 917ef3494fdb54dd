//! Golden pictures on disk, and the comparison with them.
//!
//! A golden is a PNG of premultiplied RGBA: the colour over black, and the opacity. It is written only with
//! `CVR_BLESS=1`. A missing golden fails the test.

use std::path::{Path, PathBuf};

use cvr_core::metrics::{AgreementRule, image_agreement};
use cvr_core::render::Image;
use image::{ImageFormat, RgbaImage};

/// Folder of the goldens, and folder for pictures that differ.
pub struct Goldens {
    pub folder: PathBuf,
    pub failures: PathBuf,
    /// Whether goldens are written instead of compared.
    pub bless: bool,
}

/// 8 bits store a picture within half a step, which is added to [`AgreementRule::MANUAL`].
const RULE: AgreementRule = AgreementRule {
    name: "golden picture",
    within: 1.0 / 255.0,
    fraction: AgreementRule::MANUAL.fraction,
    limit: 4.0 / 255.0,
};

impl Goldens {
    /// Those of this project.
    pub fn of_project() -> Self {
        let target = Path::new(env!("CARGO_TARGET_TMPDIR")).parent().unwrap();
        Self {
            folder: Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/golden"),
            failures: target.join("golden-failures"),
            bless: std::env::var_os("CVR_BLESS").is_some_and(|v| v == "1"),
        }
    }

    /// Compares a picture with the golden of this name.
    ///
    /// # Errors
    /// A sentence that names the golden, how far the pictures differ, and where the actual picture and the
    /// difference lie; or that there is no golden.
    pub fn check(&self, name: &str, picture: &Image) -> Result<(), String> {
        let path = self.folder.join(format!("{name}.png"));
        let actual = eight_bits(picture);
        if self.bless {
            return save(&path, &actual);
        }
        let bytes = std::fs::read(&path)
            .map_err(|e| format!("{}: {e}; CVR_BLESS=1 writes it, for you to look at", path.display()))?;
        let golden = image::load_from_memory_with_format(&bytes, ImageFormat::Png)
            .map_err(|e| format!("{}: {e}", path.display()))?
            .to_rgba8();
        let Err(problem) = RULE.check(&of_bytes(&golden), &of_bytes(&actual)) else { return Ok(()) };
        let [shown, difference] =
            ["actual", "diff"].map(|kind| self.failures.join(format!("{name}.{kind}.png")));
        std::fs::create_dir_all(&self.failures).map_err(|e| e.to_string())?;
        save(&shown, &actual)?;
        save(&difference, &differences(&golden, &actual))?;
        let [path, shown, difference] = [path, shown, difference].map(|p| p.display().to_string());
        Err(format!("{path}: {problem}; see {shown} and {difference}"))
    }
}

fn eight_bits(picture: &Image) -> RgbaImage {
    let [width, height] = picture.size();
    let bytes = picture.pixels().iter().flatten().map(|v| (v.clamp(0.0, 1.0) * 255.0).round() as u8);
    RgbaImage::from_raw(width, height, bytes.collect()).unwrap()
}

fn of_bytes(picture: &RgbaImage) -> Image {
    let pixels = picture.pixels().map(|p| p.0.map(|v| f32::from(v) / 255.0));
    Image::from_pixels([picture.width(), picture.height()], pixels.collect()).unwrap()
}

/// Differences of colour and opacity, multiplied by 16, opaque. Blank for pictures of different size.
fn differences(a: &RgbaImage, b: &RgbaImage) -> RgbaImage {
    let mut out = RgbaImage::from_pixel(b.width(), b.height(), image::Rgba([0, 0, 0, 255]));
    for (x, y, pixel) in out.enumerate_pixels_mut() {
        if let (Some(a), Some(b)) = (a.get_pixel_checked(x, y), b.get_pixel_checked(x, y)) {
            let difference = |c: usize| a.0[c].abs_diff(b.0[c]);
            let seen = |c| difference(c).max(difference(3)).saturating_mul(16);
            pixel.0 = [seen(0), seen(1), seen(2), 255];
        }
    }
    out
}

fn save(path: &Path, picture: &RgbaImage) -> Result<(), String> {
    picture.save_with_format(path, ImageFormat::Png).map_err(|e| format!("{}: {e}", path.display()))
}

/// A picture with a gradient inside and nothing around.
fn sample_picture() -> Image {
    let pixel = |i: u32| match (i % 16, i / 16) {
        (x @ 4..12, y @ 4..12) => [x as f32 / 16.0, y as f32 / 16.0, 0.1, 0.9],
        _ => [0.0; 4],
    };
    Image::from_pixels([16, 16], (0..256).map(pixel).collect()).unwrap()
}

fn goldens(folder: &Path, bless: bool) -> Goldens {
    Goldens { folder: folder.to_owned(), failures: folder.join("failures"), bless }
}

#[test]
fn a_missing_golden_fails_and_is_not_written() {
    let folder = tempfile::tempdir().unwrap();
    let problem = goldens(folder.path(), false).check("none", &sample_picture()).unwrap_err();
    assert!(problem.contains("none.png") && problem.contains("CVR_BLESS=1"), "{problem}");
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
}

#[test]
fn a_blessed_golden_is_kept_and_a_difference_is_shown() {
    let folder = tempfile::tempdir().unwrap();
    goldens(folder.path(), true).check("a", &sample_picture()).unwrap();
    let compared = goldens(folder.path(), false);
    compared.check("a", &sample_picture()).unwrap();
    assert!(!compared.failures.exists());

    let mut other = sample_picture();
    other.pixels_mut()[100][1] += 5.0 / 255.0;
    let problem = compared.check("a", &other).unwrap_err();
    for name in ["a.actual.png", "a.diff.png"] {
        let path = compared.failures.join(name);
        assert!(problem.contains(path.to_str().unwrap()), "{problem}");
        let picture = image::open(path).unwrap().to_rgba8();
        assert_eq!(picture.dimensions(), (16, 16));
    }
    let difference = image::open(compared.failures.join("a.diff.png")).unwrap().to_rgba8();
    let bright: Vec<[u8; 4]> = difference.pixels().map(|p| p.0).filter(|p| p[..3] != [0; 3]).collect();
    assert_eq!(bright, [[0, 80, 0, 255]], "the one pixel that differs, by 5 steps");
}

#[test]
fn the_rule_ends_where_it_says() {
    let folder = tempfile::tempdir().unwrap();
    goldens(folder.path(), true).check("a", &sample_picture()).unwrap();
    let changed = |pixels: usize, steps: f32| {
        let mut other = sample_picture();
        let inside = other.pixels_mut().iter_mut().filter(|p| p[3] > 0.0);
        inside.take(pixels).for_each(|p| p[1] += steps / 255.0);
        goldens(folder.path(), false).check("a", &other).is_ok()
    };
    assert!(changed(64, 1.0), "every pixel by one step");
    assert!(!changed(64, 2.0), "every pixel by two");
    assert!(!changed(1, 2.0), "one of 64 is more than a thousandth");
    let shifted = cvr_core::metrics::shifted(&sample_picture(), 1, 0);
    assert!(goldens(folder.path(), false).check("a", &shifted).is_err());
    assert!(goldens(folder.path(), false).check("a", &Image::new([15, 16])).is_err());
    assert!(image_agreement(&sample_picture(), &shifted, 0.0).unwrap().visible_pixels > 64);
}
