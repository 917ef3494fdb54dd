//! One record per cell: the names are public and meant to last.

use cvr_core::volume::Replaced;
use cvr_engine::{RayPieces, TextureFallback};
use serde::{Deserialize, Serialize};

/// How a cell ended.
#[derive(Copy, Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Status {
    /// Ran, and kept its promises.
    Ok,
    /// Did not run, or broke its error bound or value range; `error` says why.
    #[default]
    Failed,
}

/// Writes [`Record`]; the figures that are listed stand behind all other columns but those from `series` on, which came after
/// them.
macro_rules! record {
    ($($figure:ident)*) => {
        /// The result of one cell. `None` = not measured or not defined; in CSV an empty field. PSNR of identical data is
        /// infinite: `inf` in CSV, `null` in JSON with `max_abs_error` 0.
        #[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
        pub struct Record {
            /// Volume name.
            pub volume: String,
            /// Codec id; behind a colon its setting `name`, if it has one (`external:sz3`).
            pub codec: String,
            /// Settings, `name=value` separated by spaces.
            pub settings: String,
            /// Decode site.
            pub site: String,
            /// Filter.
            pub filter: String,
            /// Renderer: its id, with the settings that differ from the defaults.
            pub renderer: String,
            /// Scene name.
            pub scene: String,
            /// Adapter name, or `cpu`.
            pub device: String,
            /// Driver and its version.
            pub driver: String,
            /// How it ended.
            pub status: Status,
            /// Why it failed.
            pub error: Option<String>,
            /// Voxels of all frames.
            pub voxels: u64,
            /// Frames.
            pub frames: u32,
            /// Bits of the whole file per voxel.
            pub bits_per_voxel: Option<f64>,
            /// Length of the encoded file.
            pub file_bytes: Option<u64>,
            /// Bytes in device memory for the volume.
            pub resident_bytes: Option<u64>,
            /// Wall seconds to encode.
            pub encode_seconds: Option<f64>,
            /// Wall seconds to decode all frames on the CPU.
            pub decode_seconds: Option<f64>,
            /// Voxels decoded per wall second on the CPU.
            pub decode_voxels_per_second: Option<f64>,
            /// PSNR of the voxels; peak = max − min, integers rounded first.
            pub psnr_db: Option<f64>,
            /// The same without 4³ blocks within 2 % of the modal value.
            pub foreground_psnr_db: Option<f64>,
            /// Largest difference of a voxel, integers rounded first.
            pub max_abs_error: Option<f64>,
            /// The codec's promise for it.
            pub error_bound: Option<f64>,
            /// PSNR of the picture against the reference (uncompressed, manual linear), per visible pixel.
            pub image_psnr_db: Option<f64>,
            /// SSIM against the reference, per visible pixel.
            pub image_ssim: Option<f64>,
            /// PSNR against raw under the same site and filter.
            pub codec_image_psnr_db: Option<f64>,
            /// SSIM against raw under the same site and filter.
            pub codec_image_ssim: Option<f64>,
            /// Median frame time.
            pub frame_ms: Option<f64>,
            /// Interquartile range of the frame time.
            pub frame_ms_iqr: Option<f64>,
            /// Median process CPU time per frame.
            pub frame_cpu_ms: Option<f64>,
            /// Which clock `frame_ms` used: `timestamp` or `wall`.
            pub frame_clock: Option<String>,
            /// Median of the paired ratio to raw texture + hardware linear.
            pub relative_frame_time: Option<f64>,
            /// The picture, relative to the report.
            pub image: Option<String>,
            /// Whole-frame PSNR of the picture.
            pub image_psnr_whole_db: Option<f64>,
            /// Whole-frame SSIM of the picture.
            pub image_ssim_whole: Option<f64>,
            /// The error picture, relative to the report.
            pub error_image: Option<String>,
            /// `hardware` or `manual`: who interpolated.
            pub filtering: Option<String>,
            /// Interquartile range of the paired ratio.
            pub relative_frame_time_iqr: Option<f64>,
            /// Pairs that were timed.
            pub frame_pairs: Option<u32>,
            /// Samples on which the generated shader, or a texture unit that decodes blocks, and the CPU decoder disagree
            /// beyond what is stated of them.
            pub parity_mismatches: Option<u64>,
            /// NaN, infinite and subnormal samples replaced before encoding.
            pub replaced_samples: u64,
            /// Remarks, separated by `; `.
            pub notes: Option<String>,
            /// Median time in which the device decodes the frame into a texture, at the site *deferred*; by the device's
            /// timestamps where all runs have believable ones, else by the wall clock. `frame_ms` does not hold it. Cells of one
            /// codec and its settings share the decode, and so this figure.
            pub device_decode_ms: Option<f64>,
            /// Bytes on the device while it decodes that frame: those of `resident_bytes`, scratch buffers, and the buffer
            /// through which texels go into the texture. Staging for uploads is not counted.
            pub device_decode_bytes: Option<u64>,
            /// Whether empty macrocells are skipped. The columns that follow are those of such cells.
            #[serde(default)]
            pub skipping: bool,
            /// What skipping gains: median of the paired ratio of the frame time without it to that with it.
            pub skipping_gain: Option<f64>,
            /// Interquartile range of that ratio.
            pub skipping_gain_iqr: Option<f64>,
            /// Share of macrocells that show nothing in this scene, `0.0..=1.0`.
            pub empty_macrocells: Option<f64>,
            /// Pixels in which the picture differs, in any bit, from that without skipping; any fails the cell.
            pub skipping_mismatches: Option<u64>,
            /// Wall seconds on the CPU to decode the first frame macrocell by macrocell for the ranges of its values, once per
            /// volume, codec and settings. No frame time holds it.
            pub macrocell_seconds: Option<f64>,
            /// Stages of the stream that were decoded, of those that it has; `None` for all. Errors and times are those of this
            /// level; the file, and so its rate, is that of all stages.
            #[serde(default)]
            pub stages: Option<u8>,
            /// PSNR of red, green and blue, with the peak of the whole volume; of colour volumes alone.
            pub psnr_red_db: Option<f64>,
            /// Of green.
            pub psnr_green_db: Option<f64>,
            /// Of blue.
            pub psnr_blue_db: Option<f64>,
            /// First frame that is drawn, counted from 0.
            #[serde(default)]
            pub first_frame: u32,
            /// Last frame that is drawn. Of several, errors of pictures are pooled, times are medians.
            #[serde(default)]
            pub last_frame: u32,
            /// The figures of the single frames, relative to the report; of volumes of several frames alone.
            pub frame_figures: Option<String>,
            /// Histogram of the errors of the voxels, relative to the report.
            #[serde(default)]
            pub error_histogram: Option<String>,
            $(
                #[doc = concat!("`", stringify!($figure), "`, as `cvr_core::metrics::figures` and `docs/user/evaluation.md` define it.")]
                #[serde(default)]
                pub $figure: Option<f64>,
            )*
            /// The settings that make another method of the codec and not another rate of the same, `name=value` separated by
            /// spaces, as the codec lists them: cells that agree in codec and series lie on one curve.
            #[serde(default)]
            pub series: String,
            /// Pixels of the reference that are visible, in all frames that are drawn. 0: the scene shows nothing, and no
            /// figure of pictures is defined.
            #[serde(default)]
            pub visible_pixels: Option<u64>,
            /// Bytes of the encoded file without its header: what the codec wrote, codebooks included.
            #[serde(default)]
            pub payload_bytes: Option<u64>,
            /// Resolution that was decoded; 0 is the full one, and each step halves every axis. Pictures are drawn at the volume's
            /// size, and compared with the reference of the full volume; errors of voxels are those of the level brought to the
            /// volume's size by the filter *linear*.
            #[serde(default)]
            pub resolution: u8,
        }

        impl Record {
            /// The figures that are listed, with their columns' names.
            pub fn figures_mut(&mut self) -> Vec<(&'static str, &mut Option<f64>)> {
                vec![$((stringify!($figure), &mut self.$figure)),*]
            }

            /// A figure that is listed; `None` for other columns too.
            #[must_use]
            pub fn figure(&self, name: &str) -> Option<f64> {
                match name {
                    $(stringify!($figure) => self.$figure,)*
                    _ => None,
                }
            }
        }

        /// Whether a column is a figure that is listed.
        #[must_use]
        pub fn is_listed(name: &str) -> bool {
            [$(stringify!($figure)),*].contains(&name)
        }
    };
}

cvr_core::for_each_figure!(record);

/// Spread (interquartile range over median) of the paired ratio above which a frame time is flagged: the middle half
/// of the pairs then spans more than a quarter of the value that is reported.
pub const NOISY_SPREAD: f64 = 0.25;

impl Record {
    /// Enters a figure, where it is one that is listed, or one of pictures.
    pub fn enter(&mut self, name: &str, value: Option<f64>) {
        let figure = match name {
            "image_psnr_db" => Some(&mut self.image_psnr_db),
            "image_psnr_whole_db" => Some(&mut self.image_psnr_whole_db),
            "codec_image_psnr_db" => Some(&mut self.codec_image_psnr_db),
            "image_ssim" => Some(&mut self.image_ssim),
            "image_ssim_whole" => Some(&mut self.image_ssim_whole),
            "codec_image_ssim" => Some(&mut self.codec_image_ssim),
            _ => self.figures_mut().into_iter().find(|(listed, _)| *listed == name).map(|(_, figure)| figure),
        };
        if let Some(figure) = figure {
            *figure = value;
        }
    }

    /// Whether the scene shows nothing, so that its pictures and frame times say nothing of a codec.
    #[must_use]
    pub fn shows_nothing(&self) -> bool {
        self.visible_pixels == Some(0)
    }

    /// Bits per voxel of what the codec wrote, without the file's header. Records of versions that did not tell them
    /// apart have those of the whole file.
    #[must_use]
    pub fn payload_bits_per_voxel(&self) -> Option<f64> {
        let payload = self.payload_bytes.filter(|_| self.voxels > 0);
        payload.map(|bytes| bytes as f64 * 8.0 / self.voxels as f64).or(self.bits_per_voxel)
    }

    /// Adds a remark.
    pub fn remark(&mut self, text: &str) {
        match &mut self.notes {
            Some(notes) => notes.extend(["; ", text]),
            None => self.notes = Some(text.to_owned()),
        }
    }

    /// Remarks on what stands in for texture formats and filters that a device lacks, in the cell's own texture and
    /// in that of the baseline.
    pub fn flag_fallbacks(&mut self, own: Option<TextureFallback>, baseline: Option<TextureFallback>) {
        if let Some(own) = own {
            self.remark(&own.to_string());
        }
        if let Some(baseline) = baseline {
            self.remark(&format!("baseline of the frame time: {baseline}"));
        }
    }

    /// Remarks on rays that a device could not walk at once, in the cell and in the baseline: their frame times are those of
    /// all pieces.
    pub fn flag_ray_pieces(&mut self, own: Option<RayPieces>, baseline: Option<RayPieces>) {
        if let Some(own) = own {
            self.remark(&own.to_string());
        }
        if let Some(baseline) = baseline {
            self.remark(&format!("baseline of the frame time: {baseline}"));
        }
    }

    /// Remarks on slices that are summed in half precision although the cell asked for single.
    /// The baseline of a frame time is summed so too.
    pub fn flag_blending(&mut self, in_half: bool, has_baseline: bool) {
        if in_half {
            let too = if has_baseline { ", in the baseline too" } else { "" };
            self.remark(&format!(
                "the device cannot blend single precision: slices are summed in half precision{too}"
            ));
        }
    }

    /// Remarks on what was not drawn, or encoded, as the volume's file has it. The volume has so many samples.
    pub fn flag_replaced(&mut self, replaced: Replaced, samples: u64) {
        if let Some(told) = replaced.in_words(samples) {
            self.remark(&told);
        }
        if replaced.rounded > 0 {
            self.remark(&format!(
                "{} samples of the input were rounded to single precision",
                replaced.rounded
            ));
        }
    }

    /// Remarks on a frame time whose pairs disagree by more than [`NOISY_SPREAD`].
    pub fn flag_noise(&mut self) {
        if let (Some(ratio), Some(iqr)) = (self.relative_frame_time, self.relative_frame_time_iqr)
            && iqr > NOISY_SPREAD * ratio
        {
            let percent = 100.0 * iqr / ratio;
            self.remark(&format!(
                "noisy timing: the middle half of the paired ratios spans {percent:.0} % of their median"
            ));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_noisy_timings_are_flagged() {
        let timed = |iqr| Record {
            relative_frame_time: Some(2.0),
            relative_frame_time_iqr: Some(iqr),
            notes: Some("from the encoder".to_owned()),
            ..Record::default()
        };
        for (iqr, noisy) in [(0.0, false), (0.5, false), (0.51, true), (4.0, true)] {
            let mut record = timed(iqr);
            record.flag_noise();
            let notes = record.notes.unwrap();
            assert_eq!(notes.contains("; noisy timing: "), noisy, "{iqr}: {notes}");
            assert!(notes.starts_with("from the encoder"), "{notes}");
        }
        let mut alone = Record { notes: None, ..timed(1.0) };
        alone.flag_noise();
        assert!(
            alone.notes.unwrap().starts_with("noisy timing: the middle half of the paired ratios spans 50 %")
        );
        let mut untimed = Record::default();
        untimed.flag_noise();
        assert_eq!(untimed.notes, None);
    }

    #[test]
    fn what_a_device_lacks_is_remarked() {
        let mut record = Record::default();
        record.flag_fallbacks(None, None);
        assert_eq!(record.notes, None);
        let fallback = TextureFallback::ManualForFloat32;
        record.flag_fallbacks(Some(fallback), Some(fallback));
        let expected = "single-precision textures cannot be filtered: the shader filters; baseline of the frame time: \
                        single-precision textures cannot be filtered: the shader filters";
        assert_eq!(record.notes.as_deref(), Some(expected));
        let mut record = Record::default();
        record.flag_ray_pieces(None, None);
        assert_eq!(record.notes, None);
        record.flag_ray_pieces(Some(RayPieces { samples: 64, pieces: 4 }), None);
        let expected = "rays walked in 4 pieces of 64 samples: this device ends loops that take longer";
        assert_eq!(record.notes.as_deref(), Some(expected));
        let mut record = Record::default();
        record.flag_blending(false, true);
        assert_eq!(record.notes, None);
        record.flag_blending(true, false);
        assert!(record.notes.unwrap().ends_with("summed in half precision"));
    }
}
