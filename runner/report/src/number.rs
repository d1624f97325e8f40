//! Numbers in tables: few digits, the same number of decimals in a column, no NaN.

use ballrace_twin::replay::outcome::NumericField;

/// Text of a missing number.
pub(super) const NONE: &str = "-";

/// Returns the number of decimals that shows the largest number of a column with about four digits.
pub(super) fn decimals(values: impl IntoIterator<Item = f64>) -> usize {
    let largest = values.into_iter().filter(|value| value.is_finite()).map(f64::abs).fold(0.0, f64::max);
    match largest {
        0.0 => 2,
        v if v >= 1000.0 => 0,
        v if v >= 100.0 => 1,
        v if v >= 10.0 => 2,
        v if v >= 0.1 => 3,
        v if v >= 0.01 => 4,
        _ => 5,
    }
}

/// Formats a number with this number of decimals; from 1e7 in scientific notation, and as `-` where it is not finite.
pub fn fixed(value: f64, decimals: usize) -> String {
    if !value.is_finite() {
        return NONE.to_owned();
    }
    if value.abs() >= 1e7 {
        return format!("{value:.2e}");
    }
    let text = format!("{value:.decimals$}");
    // "-0.00" has a sign without a significant digit.
    match text.strip_prefix('-') {
        Some(rest) if rest.chars().all(|c| c == '0' || c == '.') => rest.to_owned(),
        _ => text,
    }
}

/// Formats a field of each object, with the same number of decimals.
pub(super) fn field_column<'a, T: 'a>(
    field: &NumericField<T>,
    objects: impl IntoIterator<Item = &'a T>,
) -> Vec<String> {
    let values: Vec<f64> = objects.into_iter().map(field.value).collect();
    let decimals = field.decimals.unwrap_or_else(|| decimals(values.iter().copied()));
    values.into_iter().map(|value| fixed(value, decimals)).collect()
}

/// Formats the fields of an object; those without a number of decimals have `decimals`.
pub(super) fn field_row<T>(fields: &[NumericField<T>], of: &T, decimals: usize) -> Vec<String> {
    fields.iter().map(|field| fixed((field.value)(of), field.decimals.unwrap_or(decimals))).collect()
}

/// Returns [`decimals`] of the fields without a number of decimals.
pub(super) fn common_decimals<'a, T: 'a>(
    fields: &[NumericField<T>],
    objects: impl IntoIterator<Item = &'a T>,
) -> usize {
    let free = || fields.iter().filter(|field| field.decimals.is_none());
    decimals(objects.into_iter().flat_map(|of| free().map(move |field| (field.value)(of))))
}

/// Formats a number in scientific notation with six digits; 0 as `0`.
pub(super) fn in_tens(value: f64) -> String {
    if value == 0.0 { "0".to_owned() } else { format!("{value:.5e}") }
}

/// Formats a single number with three digits.
pub(super) fn alone(value: f64) -> String {
    let power = value.abs().log10().floor();
    let decimals = if power.is_finite() { (2.0 - power).clamp(0.0, 6.0) as usize } else { 2 };
    fixed(value, decimals)
}

/// Formats a station as ` at 12.3 mm`; empty where a scene has no stations.
pub(super) fn at_station(station_mm: f64, decimals: usize) -> String {
    if station_mm.is_finite() { format!(" at {} mm", fixed(station_mm, decimals)) } else { String::new() }
}

/// Formats an optional number as [`alone`].
pub(super) fn maybe(value: Option<f64>) -> String {
    value.map_or_else(|| NONE.to_owned(), alone)
}

/// Formats a change as [`fixed`], with its sign unless it is 0 in these decimals.
pub fn with_sign(value: f64, decimals: usize) -> String {
    let text = fixed(value, decimals);
    if value > 0.0 && text.chars().any(|c| ('1'..='9').contains(&c)) { format!("+{text}") } else { text }
}

/// Formats a count with a space between groups of three digits.
pub fn count(value: u64) -> String {
    let digits = value.to_string();
    let mut text = String::new();
    for (place, digit) in digits.chars().enumerate() {
        if place > 0 && (digits.len() - place).is_multiple_of(3) {
            text.push(' ');
        }
        text.push(digit);
    }
    text
}

/// Formats a count with its noun, such as "1 sample" or "2 samples".
pub fn counted(value: u64, noun: &str) -> String {
    let plural = if value == 1 { "" } else { "s" };
    format!("{} {noun}{plural}", count(value))
}

/// Converts nanoseconds to microseconds.
pub(super) fn microseconds(nanoseconds: u64) -> f64 {
    nanoseconds as f64 / 1000.0
}

/// Returns at most `limit` characters, the last one an ellipsis where the text is longer.
pub(super) fn shortened(text: &str, limit: usize) -> String {
    if text.chars().count() <= limit {
        return text.to_owned();
    }
    let mut short: String = text.chars().take(limit.saturating_sub(1)).collect();
    short.push('…');
    short
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn digits_follow_the_size() {
        assert_eq!(alone(0.0), "0.00");
        assert_eq!(alone(12.345), "12.3");
        assert_eq!(alone(-0.012_34), "-0.0123");
        assert_eq!(alone(12_345.6), "12346");
        assert_eq!(alone(3.2e9), "3.20e9");
        assert_eq!(fixed(-0.001, 2), "0.00");
        assert_eq!(fixed(f64::NAN, 2), NONE);
        assert_eq!(maybe(None), NONE);
        assert_eq!(
            [decimals([]), decimals([0.08, -1.57]), decimals([62.9, 0.4]), decimals([f64::NAN, 1e-9])],
            [2, 3, 2, 5]
        );
    }

    #[test]
    fn counts_are_grouped() {
        assert_eq!(count(0), "0");
        assert_eq!(count(999), "999");
        assert_eq!(count(1_234_567), "1 234 567");
        assert_eq!(counted(1, "sample"), "1 sample");
    }

    #[test]
    fn long_names_are_cut_by_characters() {
        assert_eq!(shortened("größer", 6), "größer");
        assert_eq!(shortened("größeres", 6), "größe…");
    }
}
