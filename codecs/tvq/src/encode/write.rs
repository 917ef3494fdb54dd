//! Codebooks, tables and frames into tensors.

use cvr_codebook::pack::BitPacker;
use cvr_codebook::sample;
use cvr_core::codec::{EncodeError, EncodeReport};
use cvr_core::container::StreamWriter;
use serde_json::json;

use super::train::book::Book;
use super::work::{Coded, Kept, Work};
use crate::stream::geometry::{Geometry, Parameters, Payload, VOXELS, block_grid};
use crate::stream::table::{BookForm, Table};
use crate::stream::{CODEBOOK, HEADS, INDEX, TABLES};

/// All parts of a stream except codebooks.
#[derive(Debug)]
pub struct Written {
    /// By set and sub-volume.
    pub tables: Vec<Vec<Table>>,
    /// Codebooks of a table.
    pub books: u32,
    /// Per frame: heads and indices.
    pub frames: Vec<(Vec<u32>, Vec<u32>)>,
    /// Sentences for the user.
    pub notes: Vec<String>,
    /// For the record.
    pub training: serde_json::Value,
}

impl Work<'_> {
    /// Codebooks, tables and frames into tensors.
    pub fn write(
        &self,
        written: Written,
        (coded, kept): (&[Vec<Coded>], Option<&Kept>),
        out: &mut dyn StreamWriter,
    ) -> Result<EncodeReport, EncodeError> {
        let mut entries = Vec::new();
        let mut codebooks = Vec::new();
        for set in coded {
            let codes =
                || set.iter().flat_map(|c| &c.books).flat_map(|book| book.codebook.codes().iter().copied());
            entries.push(codes().count() as u64);
            codebooks.push(packed_entries(codes(), self.entry_bits()));
        }
        let parameters = Parameters {
            payload: self.options.payload,
            grid: block_grid(self.layout.extent).to_array(),
            subvolume: self.options.subvolume,
            offset: self.quantiser.offset(),
            step: self.quantiser.step(),
            entry_bits: self.entry_bits(),
            books: written.books,
            tables: self.sets.len() as u32,
            entries,
            frame_words: written.frames.iter().map(|f| f.1.len() as u64).collect(),
            training: written.training,
        };
        let Some(geometry) = Geometry::new(&self.layout, &parameters) else {
            return Err(EncodeError::Unsupported("sizes are outside the stream's ranges".to_owned()));
        };
        for (tables, codebook) in written.tables.iter().zip(&codebooks) {
            for table in tables {
                out.append_words(TABLES, &table.words())?;
            }
            out.append_words(CODEBOOK, codebook)?;
        }
        for (heads, index) in &written.frames {
            if self.options.payload == Payload::Variable {
                out.append_words(HEADS, heads)?;
            }
            out.append_words(INDEX, index)?;
        }
        let sub_volumes = geometry.sub_grid.voxels();
        out.shape(TABLES, &[self.sets.len() as u64, sub_volumes, geometry.table_words().into()])?;
        if self.options.payload == Payload::Variable {
            out.shape(HEADS, &[self.layout.frames.into(), geometry.frame_heads()])?;
        }
        out.parameters_of(&parameters)?;
        let error_bound = self.worst(coded, kept)?;
        Ok(EncodeReport { error_bound: Some(error_bound), notes: written.notes })
    }

    /// The largest error of a sample, integers rounded.
    fn worst(&self, coded: &[Vec<Coded>], kept: Option<&Kept>) -> Result<f64, EncodeError> {
        let mut worst = 0.0_f64;
        for (s, (set, domains)) in coded.iter().zip(&self.sets).enumerate() {
            for (d, (coded, domain)) in set.iter().zip(domains).enumerate() {
                let coder = self.coder(&coded.books, coded.mean_shift, 0.0);
                let kept = kept.map(|kept| &kept[s][d][..]);
                worst = worst.max(coder.worst(self.source, domain, &coded.planes, kept, self.run)?);
            }
        }
        Ok(worst)
    }

    /// The record that every stream holds.
    pub fn record(&self, coded: &[Vec<Coded>], payload: &serde_json::Value) -> serde_json::Value {
        let codewords: usize = coded.iter().flatten().flat_map(|c| &c.books).map(Book::size).sum();
        json!({
            "initial": self.options.training.initial.name(),
            "generator": sample::GENERATOR,
            "seed": self.options.training.seed,
            "codewords": codewords,
            "payload": payload,
        })
    }
}

/// Entries of codebooks in words.
#[must_use]
pub fn packed_entries(codes: impl Iterator<Item = u16>, bits: u32) -> Vec<u32> {
    let (mut packer, mut words) = (BitPacker::new(bits), Vec::new());
    codes.for_each(|code| packer.push(code.into(), &mut words));
    packer.flush(&mut words);
    if words.is_empty() {
        words.push(0);
    }
    words
}

/// Forms of a table's codebooks, beginning at entry `first`. With `widths` each has its own width.
pub fn forms(books: &[Book], first: &mut u32, widths: bool) -> Vec<BookForm> {
    let form = |book: &Book| {
        let size = book.size() as u32;
        let begin = *first;
        *first += size * VOXELS as u32;
        BookForm {
            first: begin,
            size,
            width: if widths { book.width() } else { 0 },
            scale: book.scale,
            partition: book.partition,
        }
    };
    books.iter().map(form).collect()
}
