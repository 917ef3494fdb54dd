//! A picture: premultiplied RGBA in single precision.

use std::path::Path;

use crate::file::write_whole;

/// Premultiplied RGBA, `0.0..=1.0`, row 0 at the top.
#[derive(Clone, PartialEq)]
pub struct Image {
    size: [u32; 2],
    pixels: Vec<[f32; 4]>,
}

/// Why a picture could not be written.
#[derive(Debug, thiserror::Error)]
#[error("{path}: {problem}")]
pub struct ImageError {
    path: String,
    problem: String,
}

impl std::fmt::Debug for Image {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Image").field("size", &self.size).finish_non_exhaustive()
    }
}

impl Image {
    /// A transparent picture of `size` (width, height).
    #[must_use]
    pub fn new(size: [u32; 2]) -> Self {
        Self { size, pixels: vec![[0.0; 4]; size[0] as usize * size[1] as usize] }
    }

    /// An image from pixels in rows. `None` if their number does not match `size`.
    #[must_use]
    pub fn from_pixels(size: [u32; 2], pixels: Vec<[f32; 4]>) -> Option<Self> {
        (pixels.len() == size[0] as usize * size[1] as usize).then_some(Self { size, pixels })
    }

    /// Width and height.
    #[must_use]
    pub const fn size(&self) -> [u32; 2] {
        self.size
    }

    /// Pixels in rows.
    #[must_use]
    pub fn pixels(&self) -> &[[f32; 4]] {
        &self.pixels
    }

    /// Pixels in rows, to be written.
    pub fn pixels_mut(&mut self) -> &mut [[f32; 4]] {
        &mut self.pixels
    }

    /// RGB over an opaque background (`0.0..=1.0`), clamped.
    #[must_use]
    pub fn over(&self, background: [f32; 3]) -> Vec<[f32; 3]> {
        let blend = |p: &[f32; 4]| [0, 1, 2].map(|c| (p[c] + (1.0 - p[3]) * background[c]).clamp(0.0, 1.0));
        self.pixels.iter().map(blend).collect()
    }

    /// RGB over an opaque background in 8 bits, rows of `3 × width` bytes.
    #[must_use]
    pub fn to_rgb8(&self, background: [f32; 3]) -> Vec<u8> {
        self.over(background).into_iter().flatten().map(|v| (v * 255.0).round() as u8).collect()
    }

    /// The picture over an opaque background as a PNG file.
    ///
    /// # Errors
    /// When the encoder refuses its size.
    pub fn to_png(&self, background: [f32; 3]) -> Result<Vec<u8>, ImageError> {
        to_png(self.size, &self.to_rgb8(background))
    }

    /// Writes the picture over an opaque background as PNG. The file appears only when it is complete.
    ///
    /// # Errors
    /// When the file cannot be written.
    pub fn write_png(&self, path: &Path, background: [f32; 3]) -> Result<(), ImageError> {
        write_png(path, self.size, &self.to_rgb8(background))
    }
}

/// 8-bit RGB rows as a PNG file.
///
/// # Errors
/// When the encoder refuses the size, or it is not that of the rows.
pub fn to_png(size: [u32; 2], rgb: &[u8]) -> Result<Vec<u8>, ImageError> {
    let mut bytes = Vec::new();
    image::write_buffer_with_format(
        &mut std::io::Cursor::new(&mut bytes),
        rgb,
        size[0],
        size[1],
        image::ExtendedColorType::Rgb8,
        image::ImageFormat::Png,
    )
    .map_err(|e| ImageError { path: "a picture".to_owned(), problem: e.to_string() })?;
    Ok(bytes)
}

/// Writes 8-bit RGB rows as PNG. The file appears only when it is complete.
///
/// # Errors
/// When the file cannot be written.
pub fn write_png(path: &Path, size: [u32; 2], rgb: &[u8]) -> Result<(), ImageError> {
    let fail = |problem: String| ImageError { path: path.display().to_string(), problem };
    let bytes = to_png(size, rgb).map_err(|e| fail(e.problem))?;
    write_whole(path, |file| file.write_all(&bytes)).map_err(|e: std::io::Error| fail(e.to_string()))
}
