//! What codecs of blocks share, so that each writes down its own idea alone.
//!
//! The kit lies in `core` and is no crate of its own, since it is made of nothing but core's types and every codec already
//! names `core`. A decoder needs a [`BlockGrid`], its tensors as [`PartedTensor`]s, and one of two traits for its frames:
//! [`BlockFrame`] where voxels of a block share what is found once for all of them, [`FetchVoxels`] where a cell or a row has
//! a faster way of its own. A [`StreamReader`] of such frames is a decoder. An encoder reads [`BlockRow`]s, codes them in parallel
//! with [`code_frame`], and counts its errors with [`Measured`]. A codec whose blocks are records of one length needs no more
//! than a [`BlockCodec`].

mod blocks;
mod frame;
mod grid;
mod measured;
mod parts;
mod range;
mod reader;
mod row;
mod slabs;
mod voxels;

pub use blocks::{BlockCodec, CodecOfBlocks};
pub use frame::BlockFrame;
pub use grid::BlockGrid;
pub use measured::Measured;
pub use parts::PartedTensor;
pub use range::value_range;
pub use reader::StreamReader;
pub use row::BlockRow;
pub use slabs::code_frame;
pub use voxels::{FetchVoxels, Voxel, fill_from_blocks};
