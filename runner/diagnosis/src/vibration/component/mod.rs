//! Components of a bearing whose damage has a pattern of lines in the envelope: one file a component.

mod cage;
mod element;
mod inner_race;
mod outer_race;

use super::suspect::Suspect;
use ballrace_outcome::FaultKind;

/// Lines that damage of a component causes: harmonics of a carrier, with side bands where the impacts swell and fade.
#[derive(Debug, Clone)]
pub(crate) struct Pattern {
    /// Component.
    pub kind: FaultKind,
    /// Name at the beginning of a sentence.
    pub name: &'static str,
    /// Order of the carrier in pure rolling, per revolution of the shaft.
    pub order: f64,
    /// Least and greatest deviation of the order from pure rolling: slip, and the contact angle under load.
    pub slip: [f64; 2],
    /// Distances of the side bands from each harmonic, orders.
    pub side_bands: Vec<f64>,
}

/// Components, in the order of their patterns.
pub(crate) const KINDS: [FaultKind; 4] =
    [FaultKind::OuterRace, FaultKind::InnerRace, FaultKind::Element, FaultKind::Cage];

/// Returns the patterns of the components of a bearing.
pub(crate) fn patterns(suspect: &Suspect) -> [Pattern; KINDS.len()] {
    [outer_race::pattern(suspect), inner_race::pattern(suspect), element::pattern(suspect), cage::pattern(suspect)]
}

/// Returns the name of a component in a sentence.
pub(crate) const fn in_words(kind: FaultKind) -> &'static str {
    match kind {
        FaultKind::OuterRace => "outer race",
        FaultKind::InnerRace => "inner race",
        FaultKind::Element => "rolling element",
        _ => "cage",
    }
}
