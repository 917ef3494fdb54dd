//! The code that codecs of blocks share.
//!
//! The kit is part of `core`: it uses only core's types, and every codec already depends on `core`. A decoder needs a
//! [`BlockGrid`], its tensors as [`PartedTensor`]s, and one of two traits for its frames: [`BlockFrame`] if the voxels
//! of a block share data that is found once per block, or [`FetchVoxels`] if a cell or a row has a faster path of its
//! own. A [`StreamReader`] of such frames is a decoder. An encoder reads [`BlockRow`]s, codes them in parallel with
//! [`code_frame`], and measures its errors with [`Measured`]. A codec whose blocks are records of one length needs only
//! a [`BlockCodec`].

mod bits;
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

pub use bits::number;
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
