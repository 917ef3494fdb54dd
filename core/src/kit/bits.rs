//! Numbers of any width in words, lowest bits first.

/// The number of `width` bits, at most 32, that begins at bit `bit` from word `first` on.
///
/// # Panics
/// When it lies outside.
#[must_use]
#[inline]
pub fn number(words: &[u32], first: usize, bit: u32, width: u32) -> u32 {
    if width == 0 {
        return 0;
    }
    let (word, shift) = (first + (bit >> 5) as usize, bit & 31);
    let mut number = words[word] >> shift;
    if shift + width > 32 {
        number |= words[word + 1] << (32 - shift);
    }
    number & (u32::MAX >> (32 - width))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_number_may_cross_a_word() {
        let words = [0xf000_0000, 0x1234_5678, 0x9abc_def0];
        assert_eq!(number(&words, 0, 28, 12), 0x78f);
        assert_eq!(number(&words, 1, 0, 32), 0x1234_5678);
        assert_eq!(number(&words, 1, 16, 32), 0xdef0_1234);
        assert_eq!(number(&words, 2, 31, 1), 1);
        assert_eq!(number(&words, 0, u32::MAX, 0), 0, "no bits are read nowhere");
    }
}
