//! Values of a draft that are still unknown.

use crate::draft::UNKNOWN;
use serde::Serialize;

/// A value `"?"` of a scene.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct UnknownValue {
    /// Line of the scene, from 1.
    pub line: usize,
    /// The line without its comment.
    pub text: String,
    /// Its comment.
    pub hint: String,
}

/// Returns the lines of a scene with a value `"?"`.
#[must_use]
pub fn unknown_values(text: &str) -> Vec<UnknownValue> {
    let mark = format!("\"{UNKNOWN}\"");
    let lines = text.lines().zip(1..).filter(|(line, _)| !line.trim_start().starts_with('#'));
    let unknown = lines.filter_map(|(line, number)| {
        let (value, hint) = line.split_once(" # ").unwrap_or((line, ""));
        value.contains(&mark).then(|| UnknownValue {
            line: number,
            text: value.trim().trim_end_matches(',').to_owned(),
            hint: hint.trim().to_owned(),
        })
    });
    unknown.collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_values_count() {
        let text = "# \"?\" is unknown\n[rotor]\nmass = \"?\"   # such as \"6 kg\"\nname = \"a?\"\n";
        let found = unknown_values(text);
        let expected = UnknownValue { line: 3, text: "mass = \"?\"".to_owned(), hint: "such as \"6 kg\"".to_owned() };
        assert_eq!(found, [expected]);
    }
}
