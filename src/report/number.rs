//! Numbers as the report writes them.

/// Shown for a value that was not measured.
pub(super) const NONE: &str = "–";

/// A fixed number of decimals; `∞` for infinity.
pub(super) fn fixed(value: Option<f64>, decimals: usize) -> String {
    match value {
        None => NONE.to_owned(),
        Some(v) if v.is_nan() => "not a number".to_owned(),
        Some(v) if v.is_infinite() => if v > 0.0 { "∞" } else { "−∞" }.to_owned(),
        Some(v) => format!("{v:.decimals$}").replace('-', "−"),
    }
}

/// Three significant digits.
pub(super) fn short(value: Option<f64>) -> String {
    match value {
        Some(v) if v.is_finite() && v != 0.0 => {
            let magnitude = v.abs().log10().floor();
            if (-4.0..6.0).contains(&magnitude) {
                fixed(value, (2.0 - magnitude).max(0.0) as usize)
            } else {
                format!("{v:.2e}").replace('-', "−")
            }
        }
        other => fixed(other, 0),
    }
}

/// Decibels.
pub(super) fn decibels(value: Option<f64>) -> String {
    let unit = if value.is_some_and(f64::is_finite) { " dB" } else { "" };
    fixed(value, 1) + unit
}

/// Bytes in binary units.
pub(super) fn bytes(value: Option<u64>) -> String {
    let Some(bytes) = value else { return NONE.to_owned() };
    let mut scaled = bytes as f64;
    for unit in ["B", "KiB", "MiB"] {
        if scaled < 1000.0 {
            let number = if unit == "B" { bytes.to_string() } else { short(Some(scaled)) };
            return format!("{number} {unit}");
        }
        scaled /= 1024.0;
    }
    format!("{} GiB", short(Some(scaled)))
}

/// Middle value; the mean of the middle two of an even number.
pub(super) fn median(mut values: Vec<f64>) -> Option<f64> {
    values.sort_by(f64::total_cmp);
    let n = values.len();
    (n > 0).then(|| f64::midpoint(values[(n - 1) / 2], values[n / 2]))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_keep_three_digits_and_infinity_its_sign() {
        assert_eq!(short(Some(0.0123456)), "0.0123");
        assert_eq!(short(Some(1234.5)), "1234");
        assert_eq!(short(Some(2.0)), "2.00");
        assert_eq!(short(Some(1e9)), "1.00e9");
        assert_eq!(short(None), "–");
        assert_eq!(decibels(Some(f64::INFINITY)), "∞");
        assert_eq!(decibels(Some(41.26)), "41.3 dB");
        assert_eq!(fixed(Some(-1.25), 1), "−1.2");
        assert_eq!(bytes(Some(999)), "999 B");
        assert_eq!(bytes(Some(16 << 20)), "16.0 MiB");
        assert_eq!(median(vec![3.0, 1.0, 2.0, 9.0]), Some(2.5));
        assert_eq!(median(Vec::new()), None);
    }
}
