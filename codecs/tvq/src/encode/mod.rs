//! The encoder: from the value range to the last tensor, for both payloads.
//!
//! At the bottom are the data that all steps share ([`work`]), reading of blocks ([`domain`], [`sample`]), codebooks
//! ([`train`]), codes ([`closed_loop`]) and tensors ([`write`]). [`fixed`] and [`variable`] use them and do not depend
//! on each other.

mod closed_loop;
mod domain;
mod fixed;
mod sample;
pub mod train;
mod tuned;
mod variable;
mod work;
mod write;

use cvr_codebook::Quantiser;
use cvr_core::codec::{EncodeError, EncodeReport, Encoder, Progress};
use cvr_core::container::StreamWriter;
use cvr_core::kit::value_range;
use cvr_core::volume::{BrickSource, VolumeLayout};

use crate::settings::{Options, Target};
use crate::stream::geometry::{Payload, VALUE_BITS, block};
use variable::Sum;
use work::{Kept, Sets, Work, domains};

/// Encodes with one set of settings.
#[derive(Debug)]
pub struct TvqEncoder {
    pub options: Options,
}

impl Encoder for TvqEncoder {
    /// Codes and errors of all blocks under the compared codebooks: 1.5 and 3.3 bytes per sample, measured at 256³.
    fn scratch_bytes(&self, layout: &VolumeLayout) -> u64 {
        let per_sample = match self.options.payload {
            Payload::Fixed => 2,
            Payload::Variable => 4,
        };
        per_sample * layout.samples()
    }

    fn encode(
        &mut self,
        source: &dyn BrickSource,
        out: &mut dyn StreamWriter,
        run: &Progress<'_>,
    ) -> Result<EncodeReport, EncodeError> {
        let layout = source.layout().clone();
        let range = value_range(source, block(), run)?;
        let quantiser = Quantiser::over(range, VALUE_BITS, layout.sample.is_integer())
            .map_err(EncodeError::Unsupported)?;
        let options = self.options;
        let sets = domains(&layout, &options);
        let mut work = Work { source, run, options, layout, quantiser, span: range.span(), sets };
        if let Target::Both { rate, psnr } = options.target {
            work.options.target = Target::Psnr(psnr);
            let coding = Coding::of(&mut work)?;
            if coding.bits(&work) <= rate * work.samples() {
                return coding.write(&work, out);
            }
            work.options = Options { target: Target::Rate(rate), ..options };
        }
        Coding::of(&mut work)?.write(&work, out)
    }
}

/// Codebooks and codes, and under the payload `variable` what each block keeps and what that comes to.
struct Coding {
    sets: Sets,
    kept: Option<(Kept, Sum)>,
}

impl Coding {
    /// Entries have as many bits as suits these from then on.
    fn of(work: &mut Work<'_>) -> Result<Self, EncodeError> {
        match work.options.payload {
            Payload::Fixed => Ok(Self { sets: fixed::encode(work)?, kept: None }),
            Payload::Variable => {
                let (sets, kept, sum) = variable::encode(work)?;
                Ok(Self { sets, kept: Some((kept, sum)) })
            }
        }
    }

    /// Approximate bits of the whole file.
    fn bits(&self, work: &Work<'_>) -> f64 {
        match &self.kept {
            None => fixed::bits(work, &self.sets) + work.overhead(3),
            Some((_, sum)) => sum.bits,
        }
    }

    fn write(&self, work: &Work<'_>, out: &mut dyn StreamWriter) -> Result<EncodeReport, EncodeError> {
        let written = match &self.kept {
            None => fixed::written(work, &self.sets),
            Some((kept, sum)) => variable::written(work, &self.sets, (kept, *sum))?,
        };
        work.write(written, (&self.sets, self.kept.as_ref().map(|kept| &kept.0)), out)
    }
}
