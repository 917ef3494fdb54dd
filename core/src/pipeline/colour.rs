//! Colours as configurations and command lines write them.

/// RGB of `#rrggbb`, or RGB and opacity of `#rrggbbaa`, each `0.0..=1.0`. `None` for any other text.
#[must_use]
pub fn parse_colour(text: &str) -> Option<([f32; 3], Option<f32>)> {
    let digits = text.strip_prefix('#').filter(|d| d.bytes().all(|b| b.is_ascii_hexdigit()))?;
    let channel = |i: usize| {
        let pair = digits.get(2 * i..2 * i + 2)?;
        Some(f32::from(u8::from_str_radix(pair, 16).ok()?) / 255.0)
    };
    matches!(digits.len(), 6 | 8).then(|| Some(([channel(0)?, channel(1)?, channel(2)?], channel(3))))?
}
