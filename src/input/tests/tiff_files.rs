//! TIFF files by hand: pages of strips, with descriptions.

use std::ops::Range;

/// A page of gray samples.
#[derive(Clone, Debug)]
pub struct Page {
    pub size: [u32; 2],
    pub bits: u32,
    pub compression: u32,
    pub rows_per_strip: u32,
    /// As they are stored.
    pub strips: Vec<Vec<u8>>,
    pub description: Option<Vec<u8>>,
    /// Pixels per unit of length along x and y, as fractions.
    pub resolution: Option<[[u32; 2]; 2]>,
    /// Further tags of one long each.
    pub more: Vec<(u16, u32)>,
}

impl Page {
    /// A page of 3×2 pixels of 8 bits that begin with `first`.
    pub fn small(first: u8) -> Self {
        Self::gray([3, 2], (first..first + 6).collect())
    }

    /// A page of 8 bits in one strip that is not packed.
    pub fn gray(size: [u32; 2], pixels: Vec<u8>) -> Self {
        Self {
            size,
            bits: 8,
            compression: 1,
            rows_per_strip: size[1],
            strips: vec![pixels],
            description: None,
            resolution: None,
            more: Vec::new(),
        }
    }

    pub fn described(self, description: &str) -> Self {
        Self { description: Some(description.as_bytes().to_vec()), ..self }
    }
}

/// The file of these pages, and where its strips lie.
pub fn tiff(pages: &[Page]) -> (Vec<u8>, Vec<Range<usize>>) {
    let mut bytes = b"II*\0\0\0\0\0".to_vec();
    let mut link = 4;
    let mut strips = Vec::new();
    for page in pages {
        let mut offsets = Vec::new();
        for strip in &page.strips {
            offsets.push(bytes.len() as u32);
            strips.push(bytes.len()..bytes.len() + strip.len());
            bytes.extend(strip);
        }
        // Number, type, count, and the value's bytes.
        let long = |tag: u16, values: &[u32]| {
            (tag, 4_u16, values.len(), values.iter().flat_map(|v| v.to_le_bytes()).collect::<Vec<u8>>())
        };
        let counts: Vec<u32> = page.strips.iter().map(|s| s.len() as u32).collect();
        let mut tags = vec![
            long(256, &[page.size[0]]),
            long(257, &[page.size[1]]),
            long(258, &[page.bits]),
            long(259, &[page.compression]),
            long(262, &[1]),
            long(273, &offsets),
            long(277, &[1]),
            long(278, &[page.rows_per_strip]),
            long(279, &counts),
        ];
        if let Some(text) = &page.description {
            let text = [&text[..], b"\0"].concat();
            tags.push((270, 2, text.len(), text));
        }
        for (tag, fraction) in [282, 283].into_iter().zip(page.resolution.into_iter().flatten()) {
            tags.push((tag, 5, 1, fraction.iter().flat_map(|v| v.to_le_bytes()).collect()));
        }
        tags.extend(page.more.iter().map(|(tag, value)| long(*tag, &[*value])));
        tags.sort_by_key(|tag| tag.0);
        let mut directory = (tags.len() as u16).to_le_bytes().to_vec();
        for (tag, kind, count, value) in tags {
            directory.extend(tag.to_le_bytes());
            directory.extend(kind.to_le_bytes());
            directory.extend((count as u32).to_le_bytes());
            if value.len() <= 4 {
                directory.extend([&value[..], &[0; 4]].concat()[..4].to_vec());
            } else {
                directory.extend((bytes.len() as u32).to_le_bytes());
                bytes.extend(value);
            }
        }
        let at = bytes.len() as u32;
        bytes[link..link + 4].copy_from_slice(&at.to_le_bytes());
        bytes.extend(directory);
        link = bytes.len();
        bytes.extend([0; 4]);
    }
    (bytes, strips)
}
