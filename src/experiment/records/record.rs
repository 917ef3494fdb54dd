//! One record per cell: the names are public and meant to last.

use cvr_core::volume::Replaced;
use cvr_engine::{RayPieces, TextureFallback};
use serde::{Deserialize, Serialize};

use super::columns::{Column, Format, Shown, Value, columns};
use super::pooled;

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

impl<'a> From<&'a Status> for Value<'a> {
    fn from(status: &'a Status) -> Self {
        Self::Text(Some(match status {
            Status::Ok => "ok",
            Status::Failed => "failed",
        }))
    }
}

/// Columns in the order of the fields of [`Record`]; each says what the field is, how the values of several frames become that
/// of a cell (a function of [`pooled`]), and how a report shows it ([`Shown`]).
///
/// The figures that are listed stand behind all other columns but those from `series` on, which came after them.
macro_rules! record {
    ($($figure:ident)*) => {
        columns! {
            /// Volume name.
            volume: String, of_cell, Shown::new("volume", Format::Text);
            /// Codec id; behind a colon its setting `name`, if it has one (`external:sz3`).
            codec: String, of_cell, Shown::new("codec", Format::Text);
            /// Settings, `name=value` separated by spaces.
            settings: String, of_cell, Shown::new("settings", Format::Settings);
            /// Decode site.
            site: String, of_cell, Shown::new("site", Format::Text);
            /// Filter.
            filter: String, of_cell, Shown::new("filter", Format::Text);
            /// Renderer: its id, with the settings that differ from the defaults.
            renderer: String, of_cell, Shown::new("renderer", Format::Text).secondary();
            /// Scene name.
            scene: String, of_cell, Shown::new("scene", Format::Text);
            /// Adapter name, or `cpu`.
            device: String, of_cell, Shown::new("device", Format::Text).secondary();
            /// Driver and its version.
            driver: String, of_cell, Shown::new("driver", Format::Text).secondary();
            /// How it ended.
            status: Status, of_cell, Shown::new("status", Format::Text);
            /// Why it failed.
            error: Option<String>, of_cell, Shown::new("error", Format::Text);
            /// Voxels of all frames.
            voxels: u64, of_cell, Shown::new("voxels", Format::Count).secondary();
            /// Frames.
            frames: u32, of_cell, Shown::new("frames", Format::Count).secondary();
            /// Bits of the whole file per voxel.
            bits_per_voxel: Option<f64>, of_cell,
                Shown::new("bits per voxel", Format::Short).axis("bits per voxel, whole file");
            /// Length of the encoded file.
            file_bytes: Option<u64>, of_cell, Shown::new("file", Format::Bytes).axis("size of the file, bytes");
            /// Bytes in device memory for the volume.
            resident_bytes: Option<u64>, most,
                Shown::new("in device memory", Format::Bytes).axis("in device memory, bytes").secondary();
            /// Wall seconds to encode.
            encode_seconds: Option<f64>, of_cell,
                Shown::new("encode, s", Format::Short).axis("encoding, s").secondary();
            /// Wall seconds to decode all frames on the CPU.
            decode_seconds: Option<f64>, of_cell,
                Shown::new("decode, s", Format::Short).axis("decoding on the CPU, s").secondary();
            /// Voxels decoded per wall second on the CPU.
            decode_voxels_per_second: Option<f64>, of_cell,
                Shown::new("Mvoxel/s", Format::Millions).axis("decoding on the CPU, voxels/s").secondary();
            /// PSNR of the voxels; peak = max − min, integers rounded first.
            psnr_db: Option<f64>, of_cell, Shown::figure(Format::Fixed(2));
            /// The same without 4³ blocks within 2 % of the modal value.
            foreground_psnr_db: Option<f64>, of_cell, Shown::figure(Format::Fixed(2)).secondary();
            /// Largest difference of a voxel, integers rounded first.
            max_abs_error: Option<f64>, of_cell, Shown::figure(Format::Short);
            /// The codec's promise for it.
            error_bound: Option<f64>, of_cell,
                Shown::new("bound", Format::Short).axis("bound of the error, data units");
            /// PSNR of the picture against the reference (uncompressed, manual linear), per visible pixel.
            image_psnr_db: Option<f64>, of_pictures, Shown::figure(Format::Fixed(2));
            /// SSIM against the reference, per visible pixel.
            image_ssim: Option<f64>, of_pictures, Shown::figure(Format::Fixed(4));
            /// PSNR against raw under the same site and filter.
            codec_image_psnr_db: Option<f64>, of_pictures, Shown::figure(Format::Fixed(2)).secondary();
            /// SSIM against raw under the same site and filter.
            codec_image_ssim: Option<f64>, of_pictures, Shown::figure(Format::Fixed(4)).secondary();
            /// Median frame time.
            frame_ms: Option<f64>, median, Shown::new("frame, ms", Format::Short).axis("frame time, ms");
            /// Interquartile range of the frame time.
            frame_ms_iqr: Option<f64>, median,
                Shown::new("its IQR, ms", Format::Short).axis("IQR of the frame time, ms").secondary();
            /// Median process CPU time per frame.
            frame_cpu_ms: Option<f64>, median,
                Shown::new("CPU per frame, ms", Format::Short).axis("CPU time per frame, ms").secondary();
            /// Which clock `frame_ms` used: `timestamp` or `wall`.
            frame_clock: Option<String>, first, Shown::new("clock", Format::Text).secondary();
            /// Median of the paired ratio to raw texture + hardware linear.
            relative_frame_time: Option<f64>, median,
                Shown::new("relative frame time", Format::Short).axis("frame time ÷ baseline A");
            /// The picture, relative to the report.
            image: Option<String>, first, Shown::PICTURE;
            /// Whole-frame PSNR of the picture.
            image_psnr_whole_db: Option<f64>, of_pictures, Shown::figure(Format::Fixed(2)).secondary();
            /// Whole-frame SSIM of the picture.
            image_ssim_whole: Option<f64>, of_pictures, Shown::figure(Format::Fixed(4)).secondary();
            /// The error picture, relative to the report.
            error_image: Option<String>, first, Shown::PICTURE;
            /// `hardware` or `manual`: who interpolated.
            filtering: Option<String>, first, Shown::new("filtered by", Format::Text).secondary();
            /// Interquartile range of the paired ratio.
            relative_frame_time_iqr: Option<f64>, median,
                Shown::new("its IQR", Format::Short).axis("IQR of frame time ÷ baseline A").secondary();
            /// Pairs that were timed.
            frame_pairs: Option<u32>, sum, Shown::new("pairs", Format::Count).axis("pairs timed").secondary();
            /// Samples on which the generated shader, or a texture unit that decodes blocks, and the CPU decoder disagree
            /// beyond what is stated of them.
            parity_mismatches: Option<u64>, sum, Shown::new("parity mismatches", Format::Parity).secondary();
            /// NaN, infinite and subnormal samples replaced before encoding.
            replaced_samples: u64, of_cell, Shown::new("replaced samples", Format::Count).secondary();
            /// Remarks, separated by `; `.
            notes: Option<String>, remarks, Shown::new("notes", Format::Text).secondary();
            /// Median time in which the device decodes the frame into a texture, at the site *deferred*; by the device's
            /// timestamps where all runs have believable ones, else by the wall clock. `frame_ms` does not hold it. Cells of one
            /// codec and its settings share the decode, and so this figure.
            device_decode_ms: Option<f64>, median,
                Shown::new("decode on the device, ms", Format::Short).axis("decoding on the device, ms").secondary();
            /// Bytes on the device while it decodes that frame: those of `resident_bytes`, scratch buffers, and the buffer
            /// through which texels go into the texture. Staging for uploads is not counted.
            device_decode_bytes: Option<u64>, most,
                Shown::new("on the device meanwhile", Format::Bytes)
                    .axis("on the device while decoding, bytes")
                    .secondary();
            /// Whether empty macrocells are skipped. The columns that follow are those of such cells.
            #[serde(default)]
            skipping: bool, of_cell, Shown::new("skipping", Format::Text);
            /// What skipping gains: median of the paired ratio of the frame time without it to that with it.
            skipping_gain: Option<f64>, median, Shown::new("gain of skipping", Format::Short);
            /// Interquartile range of that ratio.
            skipping_gain_iqr: Option<f64>, median, Shown::new("its IQR", Format::Short).secondary();
            /// Share of macrocells that show nothing in this scene, `0.0..=1.0`.
            empty_macrocells: Option<f64>, median, Shown::new("empty macrocells", Format::Fixed(3)).secondary();
            /// Pixels in which the picture differs, in any bit, from that without skipping; any fails the cell.
            skipping_mismatches: Option<u64>, sum,
                Shown::new("pixels that skipping changes", Format::Count).secondary();
            /// Wall seconds on the CPU to decode the first frame macrocell by macrocell for the ranges of its values, once per
            /// volume, codec and settings. No frame time holds it.
            macrocell_seconds: Option<f64>, median, Shown::new("ranges of macrocells, s", Format::Short).secondary();
            /// Stages of the stream that were decoded, of those that it has; `None` for all. Errors and times are those of this
            /// level; the file, and so its rate, is that of all stages.
            #[serde(default)]
            stages: Option<u8>, of_cell, Shown::new("stages", Format::Stages);
            /// PSNR of red, green and blue, with the peak of the whole volume; of colour volumes alone.
            psnr_red_db: Option<f64>, of_cell, Shown::figure(Format::Fixed(2)).secondary();
            /// Of green.
            psnr_green_db: Option<f64>, of_cell, Shown::figure(Format::Fixed(2)).secondary();
            /// Of blue.
            psnr_blue_db: Option<f64>, of_cell, Shown::figure(Format::Fixed(2)).secondary();
            /// First frame that is drawn, counted from 0.
            #[serde(default)]
            first_frame: u32, of_cell, Shown::new("first drawn", Format::Count).secondary();
            /// Last frame that is drawn. Of several, errors of pictures are pooled, times are medians.
            #[serde(default)]
            last_frame: u32, of_cell, Shown::new("last drawn", Format::Count).secondary();
            /// The figures of the single frames, relative to the report; of volumes of several frames alone.
            frame_figures: Option<String>, of_cell, Shown::new("figures of frames", Format::File).secondary();
            /// Histogram of the errors of the voxels, relative to the report.
            #[serde(default)]
            error_histogram: Option<String>, of_cell, Shown::new("histogram of errors", Format::File).secondary();
            [$($figure)*]
            /// The settings that make another method of the codec and not another rate of the same, `name=value` separated by
            /// spaces, as the codec lists them: cells that agree in codec and series lie on one curve.
            #[serde(default)]
            series: String, of_cell, Shown::new("curve", Format::Series).secondary();
            /// Pixels of the reference that are visible, in all frames that are drawn. 0: the scene shows nothing, and no
            /// figure of pictures is defined.
            #[serde(default)]
            visible_pixels: Option<u64>, of_pictures, Shown::new("visible pixels", Format::Count).secondary();
            /// Bytes of the encoded file without its header: what the codec wrote, codebooks included.
            #[serde(default)]
            payload_bytes: Option<u64>, of_cell,
                Shown::new("without header", Format::Bytes).axis("size without the header, bytes").secondary();
            /// Resolution that was decoded; 0 is the full one, and each step halves every axis. Pictures are drawn at the volume's
            /// size, and compared with the reference of the full volume; errors of voxels are those of the level brought to the
            /// volume's size by the filter *linear*.
            #[serde(default)]
            resolution: u8, of_cell, Shown::new("resolution", Format::Count);
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

    /// Bits per voxel of the payload: the file without its header. Records of versions that did not distinguish the two
    /// have those of the whole file.
    #[must_use]
    pub fn payload_bits_per_voxel(&self) -> Option<f64> {
        let payload = self.payload_bytes.filter(|_| self.voxels > 0);
        payload.map(|bytes| bytes as f64 * 8.0 / self.voxels as f64).or(self.bits_per_voxel)
    }

    /// Adds a remark.
    pub fn remark(&mut self, text: &str) {
        pooled::add_remark(&mut self.notes, text);
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
pub(crate) mod tests {
    use super::*;

    /// A record to start from in tests.
    pub(crate) fn record(volume: &str, codec: &str) -> Record {
        Record { volume: volume.into(), codec: codec.into(), status: Status::Ok, ..Record::default() }
    }

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
