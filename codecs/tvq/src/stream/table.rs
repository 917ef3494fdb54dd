//! Tables: how to read the blocks of one sub-volume, in words.

use cvr_groups::Scale;

use super::geometry::{BOOK_WORDS, Geometry, Payload, TABLE_HEAD, VALUE_BITS, VOXELS};

/// The partitions, in the order of their codebooks. The mean is stage 0.
#[derive(Copy, Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Partition {
    /// The rest of the lowest octant.
    Low = 1,
    /// The three octants with one high axis.
    Band = 2,
    /// The others.
    High = 3,
}

impl Partition {
    /// All of them, in order.
    pub const ALL: [Self; 3] = [Self::Low, Self::Band, Self::High];
}

/// One codebook of a table.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub struct BookForm {
    /// Its first entry.
    pub first: u32,
    /// Codewords.
    pub size: u32,
    /// Bits of a code. 0 if there is one codeword, the zero vector.
    pub width: u32,
    /// What entries count.
    pub scale: Scale,
    /// Partition that it belongs to.
    pub partition: Partition,
}

/// The table of one sub-volume.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Table {
    /// Codes of means count 2^mean_shift.
    pub mean_shift: u32,
    /// Payload `fixed`: bits of a mean. Payload `variable`: bits of a code of any codebook.
    pub width: u32,
    /// Payload `fixed`: code of the smallest mean.
    pub mean_base: u32,
    /// Payload `fixed`: first word of its indices in a frame.
    pub start: u32,
    /// Payload `fixed`: words from one channel to the next.
    pub channel_words: u32,
    /// Codebooks.
    pub books: Vec<BookForm>,
}

impl Table {
    /// As a stream and a shader hold it.
    #[must_use]
    pub fn words(&self) -> Vec<u32> {
        let mut words = vec![self.mean_shift, self.width, self.mean_base, self.start, self.channel_words];
        for book in &self.books {
            let form = book.width | book.scale.form() | (book.partition as u32) << 16;
            words.extend([book.first, book.size, form]);
        }
        words
    }

    /// Bits of one block: its mean and a code of every codebook.
    #[must_use]
    pub fn block_bits(&self) -> u64 {
        u64::from(self.width) + self.books.iter().map(|b| u64::from(b.width)).sum::<u64>()
    }

    /// Reads and checks a table.
    ///
    /// # Errors
    /// A sentence, where a number is outside its range.
    pub fn read(words: &[u32], g: &Geometry, entries: u64) -> Result<Self, String> {
        let [mean_shift, width, mean_base, start, channel_words] = words[..TABLE_HEAD as usize] else {
            return Err(format!("a table of {} words", words.len()));
        };
        if mean_shift > VALUE_BITS || width > 16 || mean_base > 0xffff {
            return Err(format!("means of {width} bits from {mean_base} times 2^{mean_shift}"));
        }
        let books = words[TABLE_HEAD as usize..].chunks_exact(BOOK_WORDS as usize);
        let books =
            books.map(|book| Self::read_book(book, g.entry_bits, entries)).collect::<Result<Vec<_>, _>>()?;
        if !books.is_sorted_by_key(|book| book.partition) {
            return Err("codebooks are not in the order of their partitions".to_owned());
        }
        if g.payload == Payload::Variable && books.iter().any(|book| book.size > 1 << width) {
            return Err(format!("a codebook is larger than codes of {width} bits can name"));
        }
        Ok(Self { mean_shift, width, mean_base, start, channel_words, books })
    }

    fn read_book(words: &[u32], entry_bits: u32, entries: u64) -> Result<BookForm, String> {
        let [first, size, form] = *words else { return Err("a codebook is cut".to_owned()) };
        let (width, scale) = (form & 31, Scale::of_form(form));
        let partition = Partition::ALL.into_iter().find(|p| *p as u32 == form >> 16);
        let end = u64::from(first) + u64::from(size) * VOXELS as u64;
        // Codewords are counted from the first of all codebooks.
        let whole = first % VOXELS as u32 == 0;
        let fits = whole && form & 0xe0 == 0 && width <= 16 && scale.fits(entry_bits) && size <= 1 << 16;
        match partition {
            Some(partition) if fits && end <= entries => {
                Ok(BookForm { first, size, width, scale, partition })
            }
            _ => Err(format!("a codebook of {size} codewords from entry {first} on, of the form {form:#x}")),
        }
    }
}

/// Words that the blocks of a sub-volume take in one channel.
#[must_use]
pub fn fixed_words(table: &Table, blocks: u64) -> u64 {
    (table.block_bits() * blocks).div_ceil(32)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_codebook_lies_within_the_entries_and_begins_where_a_codeword_does() {
        let read = |first| Table::read_book(&[first, 4, (Partition::Low as u32) << 16 | 2], 8, 6 * 64);
        assert_eq!(read(128).unwrap().first, 128);
        for first in [1, 63, 127, 192, u32::MAX - 63] {
            let problem = read(first).unwrap_err();
            assert!(problem.contains(&format!("4 codewords from entry {first} on")), "{problem}");
        }
    }
}
