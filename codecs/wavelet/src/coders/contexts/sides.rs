//! What reads coefficients, and what writes given ones.

use std::ops::Range;

use super::band::Side;
use super::binarisation::{read, read_bit, write, write_bit};
use super::models::Models;
use crate::coders::fault::Fault;
use crate::coders::range::{Decoder, Encoder};

/// Reads coefficients.
#[derive(Debug)]
pub struct Reading<'a, 'b>(pub &'a mut Decoder<'b>);

impl Side for Reading<'_, '_> {
    #[inline]
    fn segment(&mut self, models: &mut Models, _: Range<usize>) -> Result<bool, Fault> {
        read_bit(self.0, &mut models.segment)
    }

    #[inline]
    fn coefficient(
        &mut self,
        models: &mut Models,
        _: usize,
        class: usize,
        negative: impl Fn() -> (usize, usize),
    ) -> Result<i32, Fault> {
        read(self.0, models, class, negative)
    }
}

/// Writes given coefficients of a part of a band.
#[derive(Debug)]
pub struct Writing<'a> {
    /// What takes the bits.
    pub encoder: &'a mut Encoder,
    /// The coefficients.
    pub coefficients: &'a [i32],
}

impl Side for Writing<'_> {
    #[inline]
    fn segment(&mut self, models: &mut Models, places: Range<usize>) -> Result<bool, Fault> {
        let any = self.coefficients[places].iter().any(|c| *c != 0);
        write_bit(self.encoder, &mut models.segment, any);
        Ok(any)
    }

    #[inline]
    fn coefficient(
        &mut self,
        models: &mut Models,
        place: usize,
        class: usize,
        negative: impl Fn() -> (usize, usize),
    ) -> Result<i32, Fault> {
        let value = self.coefficients[place];
        write(self.encoder, models, value, class, negative);
        Ok(value)
    }
}
