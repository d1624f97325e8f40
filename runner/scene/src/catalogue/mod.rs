//! Catalogue of rolling bearings: designation such as `6309` or `NU205 C3` to geometry, with the source of every entry.
//!
//! The numbers of an entry are published, confirmed by published frequencies, solved from load ratings, or estimated from the boundary
//! dimensions; [`Provenance`] states which.
//! Conformities and lengths of rollers are estimated for all entries, because makers do not publish them. Makers differ: an entry is
//! one design.

mod clearance;
mod data;
mod defaults;
#[cfg(test)]
#[expect(clippy::unwrap_used, reason = "a test fails by panicking")]
mod tests;

pub use clearance::ClearanceClass;
pub use data::{BearingKind, Entry, Provenance, PublishedFactors, all};
pub(crate) use defaults::line_contact_keys;
pub use defaults::{SceneKey, clearance_range, scene_keys};

use ballrace_base::printable;

/// Makers whose names may stand before a designation.
const MAKERS: [&str; 12] =
    ["SKF", "FAG", "INA", "NSK", "NTN", "SNR", "KOYO", "JTEKT", "NACHI", "TIMKEN", "FAFNIR", "MRC"];
/// Longest list of similar designations in an error.
const SIMILAR: usize = 6;

/// A bearing of the catalogue with the class of its clearance.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Listed {
    /// The entry.
    pub entry: &'static Entry,
    /// Class of radial internal clearance.
    pub class: ClearanceClass,
}

/// Error returned for a designation that is not in the catalogue.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct UnknownBearing {
    /// The designation.
    pub found: String,
    /// Similar designations.
    pub similar: Vec<&'static str>,
}

impl UnknownBearing {
    /// Returns the values expected, in words.
    #[must_use]
    pub fn expected(&self) -> String {
        let similar = if self.similar.is_empty() { "6205, 7206B, NU205".to_owned() } else { self.similar.join(", ") };
        let class = if ClearanceClass::is_unknown(&self.found.to_ascii_uppercase()) {
            ", with C2, CN, C3, C4 or C5"
        } else {
            ""
        };
        format!(
            "a bearing of the catalogue, such as {similar}{class} (ballrace new --list prints all), or the keys of its geometry in place of bearing"
        )
    }
}

impl std::fmt::Display for UnknownBearing {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "not in the catalogue: {:?}, expected {}", printable::name(&self.found), self.expected())
    }
}

impl std::error::Error for UnknownBearing {}

/// Finds a bearing by its designation: maker, spaces and suffixes of seals and cages are ignored, `C2` to `C5` select the class
/// of clearance.
///
/// ```
/// use ballrace_scene::catalogue::{ClearanceClass, find};
///
/// let listed = find("SKF 6205-2RS1/C3").unwrap();
/// assert_eq!(listed.entry.designation, "6205");
/// assert_eq!(listed.class, ClearanceClass::C3);
/// assert!((listed.entry.orders().outer_race - 3.585).abs() < 0.002);
/// ```
///
/// # Errors
/// Returns an error if the designation is not in the catalogue, or its class of clearance does not exist.
pub fn find(designation: &str) -> Result<Listed, UnknownBearing> {
    let upper = designation.to_ascii_uppercase();
    let maker = MAKERS.iter().find(|maker| upper.trim_start().starts_with(**maker));
    let without_maker = maker.map_or(upper.as_str(), |maker| upper.trim_start().strip_prefix(maker).unwrap_or(&upper));
    let compact = standard(without_maker);
    let entry = all()
        .iter()
        .filter(|entry| is_designation(&compact, entry.designation))
        .max_by_key(|entry| entry.designation.len());
    match entry {
        Some(entry) => {
            let suffixes = compact.get(entry.designation.len()..).unwrap_or_default();
            if ClearanceClass::is_unknown(suffixes) {
                return Err(UnknownBearing { found: designation.to_owned(), similar: vec![entry.designation] });
            }
            Ok(Listed { entry, class: ClearanceClass::of_suffixes(suffixes) })
        }
        None => Err(UnknownBearing { found: designation.to_owned(), similar: similar(&compact) }),
    }
}

/// Returns a designation in the notation of the catalogue: `6805` as `61805`, `NJ206` and `NUP206` as `NU206`, which has the same
/// rollers, `7206-B` as `7206B`, `AC` of angular-contact bearings as `A5` (25 degrees).
fn standard(text: &str) -> String {
    let mut compact = String::new();
    for word in text.split_whitespace() {
        // "6205 2Z" is a bearing and a seal.
        let is_digit = |c: char| c.is_ascii_digit();
        compact.push_str(if compact.ends_with(is_digit) && word.starts_with(is_digit) { "-" } else { "" });
        compact.push_str(word);
    }
    for prefix in ["NUP", "NJ", "N"] {
        if let Some(rest) = compact.strip_prefix(prefix).filter(|rest| rest.starts_with(|c: char| c.is_ascii_digit())) {
            compact = format!("NU{rest}");
        }
    }
    let digits = compact.chars().take_while(char::is_ascii_digit).count();
    for (thin, iso) in [("68", "618"), ("69", "619")] {
        if let Some(rest) = compact.strip_prefix(thin).filter(|_| digits == 4) {
            return format!("{iso}{rest}");
        }
    }
    let (number, suffix) = compact.split_at(digits);
    let suffix =
        suffix.strip_prefix('-').filter(|rest| rest.starts_with(|c: char| c.is_ascii_alphabetic())).unwrap_or(suffix);
    match suffix.strip_prefix("AC") {
        Some(rest) if number.starts_with('7') => format!("{number}A5{rest}"),
        _ => format!("{number}{suffix}"),
    }
}

/// Returns true where `text` is the designation `of`, with or without suffixes.
fn is_designation(text: &str, of: &str) -> bool {
    text.strip_prefix(of).is_some_and(|rest| !rest.starts_with(|c: char| c.is_ascii_digit()))
}

/// Returns the designations with the longest common start.
fn similar(text: &str) -> Vec<&'static str> {
    let common = |entry: &Entry| entry.designation.bytes().zip(text.bytes()).take_while(|(a, b)| a == b).count();
    let longest = all().iter().map(common).max().unwrap_or(0);
    if longest < 2 {
        return vec![];
    }
    all().iter().filter(|entry| common(entry) == longest).map(|entry| entry.designation).take(SIMILAR).collect()
}
