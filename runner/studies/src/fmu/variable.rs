//! Variables of a unit.

/// Direction of a variable.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Causality {
    /// Time.
    Independent,
    /// Set by the host.
    Input,
    /// Computed by the unit.
    Output,
}

impl Causality {
    /// Returns the name in FMI.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Independent => "independent",
            Self::Input => "input",
            Self::Output => "output",
        }
    }
}

/// One variable.
#[derive(Debug, Clone, PartialEq)]
pub struct Variable {
    /// Name by the structured naming convention of FMI.
    pub name: String,
    /// Direction.
    pub causality: Causality,
    /// SI unit; none of a generalised coordinate.
    pub unit: Option<&'static str>,
    /// Meaning.
    pub description: String,
    /// Value of an input at the start.
    pub start: f64,
    /// Value reference of the variable whose rate it is.
    pub rate_of: Option<usize>,
    /// True for a whole number: the status.
    pub is_whole: bool,
}

impl Variable {
    /// Returns an input that starts at 0, or an output.
    pub(super) fn new(
        causality: Causality,
        name: impl Into<String>,
        unit: Option<&'static str>,
        description: impl Into<String>,
    ) -> Self {
        let (name, description) = (name.into(), description.into());
        Self { name, causality, unit, description, start: 0.0, rate_of: None, is_whole: false }
    }

    /// Returns the time.
    pub(super) fn time() -> Self {
        Self::new(Causality::Independent, "time", Some("s"), "Time")
    }

    /// Returns the flags of the last evaluation.
    pub(super) fn status() -> Self {
        let meaning = "Sum of 1 input not finite, 2 result not finite, 4 contact lost, 8 not converged, 16 gyroscopic slip, \
                       32 outside the table; 0 for a valid value";
        Self { is_whole: true, ..Self::new(Causality::Output, "status", None, meaning) }
    }
}

/// The five directions of displacement and force, with the units of both.
pub(super) const DIRECTIONS: [(&str, &str, &str, &str, &str); 5] = [
    ("u", "FX", "along X", "m", "N"),
    ("v", "FY", "along Y", "m", "N"),
    ("w", "FZ", "along Z", "m", "N"),
    ("thu", "MX", "about X", "rad", "N.m"),
    ("thv", "MY", "about Y", "rad", "N.m"),
];

/// Returns the forces of a bearing after `prefix`.
pub(super) fn forces(prefix: &str, bearing: &str) -> Vec<Variable> {
    let force = |(_, name, along, _, unit): (&str, &str, &str, &str, &'static str)| {
        let kind = if unit == "N" { "Force" } else { "Moment" };
        let meaning = format!("{kind} {along} of bearing {bearing} on its inner ring");
        Variable::new(Causality::Output, format!("{prefix}{name}"), Some(unit), meaning)
    };
    DIRECTIONS.map(force).into()
}

/// Returns a name as an identifier of the structured naming convention: in single quotation marks where it is not of letters, digits
/// and `_`. A character that the convention does not have becomes its code.
pub(super) fn identifier(name: &str) -> String {
    let is_word = |c: char| c.is_ascii_alphanumeric() || c == '_';
    if name.chars().all(is_word) && !name.starts_with(|c: char| c.is_ascii_digit()) && !name.is_empty() {
        return name.to_owned();
    }
    let mut quoted = String::from("'");
    for c in name.chars() {
        match c {
            '\'' | '\\' | '"' => quoted.extend(['\\', c]),
            c if is_word(c) || "!#$%&()*+,-./:;<>=?@[]^{}|~ ".contains(c) => quoted.push(c),
            c => quoted += &format!("U+{:04X}", u32::from(c)),
        }
    }
    quoted + "'"
}

#[cfg(test)]
mod tests {
    use super::identifier;

    #[test]
    fn names_are_identifiers() {
        assert_eq!(identifier("DE"), "DE");
        assert_eq!(identifier("drive end"), "'drive end'");
        assert_eq!(identifier("2"), "'2'");
        assert_eq!(identifier("a'b"), "'a\\'b'");
        assert_eq!(identifier("Geh\u{e4}use"), "'GehU+00E4use'");
    }
}
