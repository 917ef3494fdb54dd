//! The encoder of blocks that decode on their own.

use cvr_core::codec::{EncodeError, EncodeReport, Encoder, Progress};
use cvr_core::container::StreamWriter;
use cvr_core::volume::{BrickSource, VolumeLayout};

use crate::blocks::{self, Filter, Target};
use crate::encode::rate::USUAL;
use crate::settings::{self, Options};
use crate::transform;

/// Encodes with one set of settings.
#[derive(Debug)]
pub struct BlockEncoder(pub Options);

/// What blocks aim at. Where nothing is asked for, integers lose nothing.
fn target(options: &Options, layout: &VolumeLayout) -> Target {
    match options.target {
        settings::Target::BitsPerVoxel(bits) => Target::BitsPerVoxel(bits),
        settings::Target::Psnr(psnr) => Target::Psnr(psnr),
        settings::Target::MaxError(bound) => Target::MaxError(bound),
        _ if layout.sample.is_integer() => Target::Lossless,
        _ => {
            let (bits, bytes) = USUAL;
            let voxels = layout.extent.voxels() as f64 * f64::from(layout.frames);
            Target::BitsPerVoxel(bits.max(8.0 * bytes * f64::from(layout.frames) / voxels))
        }
    }
}

impl Encoder for BlockEncoder {
    fn encode(
        &mut self,
        source: &dyn BrickSource,
        out: &mut dyn StreamWriter,
        run: &Progress<'_>,
    ) -> Result<EncodeReport, EncodeError> {
        let filter = match self.0.filter {
            transform::Filter::FiveThree => Filter::FiveThree,
            _ => Filter::Haar,
        };
        let options =
            blocks::Options { block: self.0.block, filter, target: target(&self.0, source.layout()) };
        blocks::encode(&options, source, out, run)
    }
}
