//! Checks that every decoder makes before it trusts a stream or a key.

use super::{CodecInfo, DecodeError};
use crate::container::EncodedVolume;
use crate::volume::{BrickKey, VolumeLayout};

/// Checks that a stream belongs to this codec and is not of a later version. Every decoder calls it first.
///
/// # Errors
/// [`DecodeError::Version`] for a later version, [`DecodeError::Corrupt`] for another codec's stream.
pub fn check_stream(volume: &EncodedVolume, info: &CodecInfo) -> Result<(), DecodeError> {
    let spec = volume.spec();
    if spec.codec != info.id {
        let problem = format!("it was written by codec `{}`, not by `{}`", spec.codec, info.id);
        return Err(DecodeError::Corrupt(problem));
    }
    if spec.stream_version > info.stream_version {
        let (known, found) = (info.stream_version, spec.stream_version);
        return Err(DecodeError::Version { codec: info.id.to_owned(), known, found });
    }
    Ok(())
}

/// Checks a key for a codec with one resolution: the frame exists, the region lies inside, the resolution is 0, and at
/// least one stage is asked for. A number above the stream's stages means all stages. Allocates memory only for the
/// error.
///
/// # Errors
/// [`DecodeError::NoSuchBrick`] otherwise.
pub fn check_key(layout: &VolumeLayout, key: BrickKey) -> Result<(), DecodeError> {
    check_key_at(layout, 1, key)
}

/// As [`check_key`], for a codec with this many resolutions, the full one included. The region must lie inside the
/// volume at the key's resolution.
///
/// # Errors
/// As [`check_key`].
pub fn check_key_at(layout: &VolumeLayout, resolutions: u8, key: BrickKey) -> Result<(), DecodeError> {
    let BrickKey { frame, level, region } = key;
    let known = frame.0 < layout.frames && level.resolution < resolutions && level.stages > 0;
    if known && region.fits(layout.extent.at_resolution(level.resolution)) {
        return Ok(());
    }
    Err(DecodeError::NoSuchBrick(format!(
        "{} voxels at {:?}, frame {}, resolution {}, stages {} of a volume of {} voxels and {} frame(s)",
        region.extent, region.origin, frame.0, level.resolution, level.stages, layout.extent, layout.frames
    )))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::volume::{Extent, FrameIndex, Level, Region, SampleType};

    #[test]
    fn a_key_must_lie_inside() {
        let layout = VolumeLayout::scalar(Extent::cube(4).unwrap(), SampleType::U8);
        let inside = BrickKey::full(FrameIndex::FIRST, Region::whole(layout.extent));
        assert!(check_key(&layout, inside).is_ok());
        assert!(check_key(&layout, BrickKey { frame: FrameIndex(1), ..inside }).is_err());
        assert!(check_key(&layout, BrickKey { region: Region::voxel([0, 0, 4]), ..inside }).is_err());
        let level = |resolution, stages| BrickKey { level: Level { resolution, stages }, ..inside };
        assert!(check_key(&layout, level(0, 1)).is_ok());
        assert!(check_key(&layout, level(1, 1)).is_err());
        assert!(check_key(&layout, level(0, 0)).is_err());
    }

    #[test]
    fn a_region_counts_voxels_of_its_resolution() {
        let layout = VolumeLayout::scalar(Extent::new(5, 4, 1).unwrap(), SampleType::U8);
        let at = |resolution, origin| BrickKey {
            frame: FrameIndex::FIRST,
            level: Level { resolution, ..Level::FULL },
            region: Region::voxel(origin),
        };
        for (resolution, origin, held) in [
            (0, [4, 3, 0], true),
            (1, [2, 1, 0], true),
            (1, [3, 1, 0], false),
            (1, [2, 2, 0], false),
            (2, [1, 0, 0], true),
            (3, [0, 0, 0], false),
        ] {
            assert_eq!(
                check_key_at(&layout, 3, at(resolution, origin)).is_ok(),
                held,
                "{resolution} {origin:?}"
            );
        }
    }
}
