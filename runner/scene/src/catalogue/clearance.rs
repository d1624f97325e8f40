//! Radial internal clearance by class, ISO 5753-1.

use super::data::{BearingKind, Entry, number};
use std::sync::LazyLock;

/// Class of radial internal clearance before mounting.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum ClearanceClass {
    /// Below normal.
    C2,
    /// Normal: a designation without a class.
    #[default]
    Normal,
    /// Above normal.
    C3,
    /// Above C3.
    C4,
    /// Above C4.
    C5,
}

impl ClearanceClass {
    const NAMED: [(Self, &'static str); 5] =
        [(Self::C2, "C2"), (Self::Normal, "CN"), (Self::C3, "C3"), (Self::C4, "C4"), (Self::C5, "C5")];

    /// Returns the name; `CN` for the normal class.
    #[must_use]
    pub fn name(self) -> &'static str {
        Self::NAMED.iter().find(|(class, _)| *class == self).map_or("CN", |(_, name)| name)
    }

    /// Reads the class from the suffixes of a designation.
    pub(super) fn of_suffixes(suffixes: &str) -> Self {
        let found = Self::NAMED.into_iter().find(|(_, name)| suffixes.contains(name));
        found.map_or_else(Self::default, |(class, _)| class)
    }

    /// Returns true where the suffixes of a designation have a class of clearance that does not exist or has no values here, such as
    /// `C8`: the letter and one digit.
    pub(super) fn is_unknown(suffixes: &str) -> bool {
        let pieces = suffixes.split('C').skip(1).filter(|piece| piece.starts_with(|c: char| c.is_ascii_digit()));
        let is_class = |piece: &&str| piece.chars().take_while(char::is_ascii_digit).count() == 1;
        pieces.filter(is_class).any(|piece| !piece.starts_with(['2', '3', '4', '5']))
    }

    fn index(self) -> usize {
        Self::NAMED.iter().position(|(class, _)| *class == self).unwrap_or(1)
    }
}

/// Ranges of clearance of one range of bores.
struct Row {
    kind: BearingKind,
    /// Bore above the first and up to the second, mm.
    bores: [f64; 2],
    /// Least and greatest clearance of each class, um.
    classes: [[f64; 2]; 5],
}

static ROWS: LazyLock<Vec<Row>> = LazyLock::new(|| {
    include_str!("clearance.csv").lines().filter(|line| !line.starts_with('#')).skip(1).map(row).collect()
});

fn row(line: &str) -> Row {
    let mut cells = line.split(',');
    let kind = BearingKind::of_name(cells.next().unwrap_or_default());
    let mut next = || number(cells.next());
    Row { kind, bores: [next(), next()], classes: std::array::from_fn(|_| [next(), next()]) }
}

/// Returns the least and the greatest diametral clearance of an entry before mounting, m; `None` outside the table.
pub(super) fn range(entry: &Entry, class: ClearanceClass) -> Option<[f64; 2]> {
    let row =
        ROWS.iter().find(|row| row.kind == entry.kind && row.bores[0] < entry.bore && entry.bore <= row.bores[1])?;
    let range = row.classes.get(class.index())?.map(|um| um * 1e-6);
    range.iter().all(|um| um.is_finite()).then_some(range)
}
