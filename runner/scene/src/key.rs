//! Description of the keys of a scene, from which the reader, the scene reference and the JSON schema come.

use crate::units::Dimension;
use std::ops::Bound::{self, Excluded, Included, Unbounded};

/// Keys of one table of a scene.
#[derive(Debug)]
pub(crate) struct Keys {
    /// Name of the table, of the schema's definition too.
    pub name: &'static str,
    /// Keys in the order of messages, with the heading of the scene reference that has them; without one where they stand with
    /// the table that this one is part of.
    pub sections: &'static [Section],
    /// Keys that belong together.
    pub choices: &'static [Choice],
}

/// Heading of the scene reference, and lists of its keys.
pub(crate) type Section = (&'static str, &'static [&'static [Key]]);

/// One key of a table.
#[derive(Debug)]
pub(crate) struct Key {
    /// Name.
    pub name: &'static str,
    /// Values that it takes.
    pub kind: Kind,
    /// Meaning, on one line, in Markdown.
    pub meaning: &'static str,
    /// Value where the key is absent; [`REQUIRED`] where there is none.
    pub default: &'static str,
    /// Conditions on its values beside those of `kind`, in Markdown.
    pub range: &'static str,
    /// Example in TOML.
    pub example: &'static str,
}

/// `default` of a key that a table must have.
pub(crate) const REQUIRED: &str = "required";

/// Sets of keys of a table.
#[derive(Debug)]
pub(crate) enum Choice {
    /// The table has exactly one of the sets, and no key of another.
    One(&'static [&'static [&'static str]]),
    /// The table has at least one of the sets.
    Any(&'static [&'static [&'static str]]),
    /// The table has none or one of the keys.
    AtMostOne(&'static [&'static str]),
}

/// Range of numbers.
pub(crate) type Bounds = (Bound<f64>, Bound<f64>);

pub(crate) const ANY: Bounds = (Unbounded, Unbounded);
pub(crate) const POSITIVE: Bounds = (Excluded(0.0), Unbounded);
pub(crate) const NOT_NEGATIVE: Bounds = (Included(0.0), Unbounded);
pub(crate) const BELOW_ONE: Bounds = (Included(0.0), Excluded(1.0));

/// Values that a key takes.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Kind {
    /// A text that is not empty: what it names.
    Text(&'static str),
    /// `true` or `false`.
    Boolean,
    /// A whole number from one to another.
    Integer(i64, i64),
    /// A number without unit.
    Number(Bounds),
    /// A number, bare or with this unit.
    NumberIn(&'static str, Bounds),
    /// A number in SI, or a text with number and unit.
    Quantity(Dimension, Bounds),
    /// A temperature with its unit.
    Temperature,
    /// One of several words.
    Words(fn() -> Vec<&'static str>),
    /// The unit of a column.
    Unit(Dimension),
    /// A table with these keys.
    Table(&'static Keys),
    /// A list of any length.
    List(&'static Self),
    /// A list of fixed length.
    Tuple(&'static [Self]),
    /// One of several kinds.
    Either(&'static [Self]),
}

impl Keys {
    pub fn all(&self) -> impl Iterator<Item = &'static Key> + use<> {
        self.sections.iter().flat_map(|(_, lists)| *lists).copied().flatten()
    }

    pub fn find(&self, name: &str) -> Option<&'static Key> {
        self.all().find(|key| key.name == name)
    }

    pub fn names(&self) -> Vec<&'static str> {
        self.all().map(|key| key.name).collect()
    }
}

impl Kind {
    /// Returns what `of` finds first in this kind or in one of several.
    fn first<T>(&self, of: &impl Fn(&Self) -> Option<T>) -> Option<T> {
        match self {
            Self::Either(kinds) => kinds.iter().find_map(|kind| kind.first(of)),
            kind => of(kind),
        }
    }

    /// Returns the keys of a table.
    pub fn keys(&self) -> Option<&'static Keys> {
        self.first(&|kind| if let Self::Table(keys) = kind { Some(*keys) } else { None })
    }

    /// Returns the kind of an entry of a list; one beyond the length of the list has the kind of the last.
    pub fn entry(&self, index: usize) -> Option<&'static Self> {
        self.first(&|kind| match kind {
            Self::List(entry) => Some(*entry),
            Self::Tuple(entries) => entries.get(index).or(entries.last()),
            _ => None,
        })
    }

    /// Returns dimension and range of a quantity.
    pub fn quantity(&self) -> Option<(Dimension, Bounds)> {
        self.first(&|kind| {
            if let Self::Quantity(dimension, bounds) = kind { Some((*dimension, *bounds)) } else { None }
        })
    }

    /// Returns the range of a number that is no quantity.
    pub fn number(&self) -> Option<Bounds> {
        self.first(&|kind| match kind {
            Self::Number(bounds) | Self::NumberIn(_, bounds) => Some(*bounds),
            _ => None,
        })
    }

    /// Returns the range of a whole number.
    pub fn integer(&self) -> Option<(i64, i64)> {
        self.first(&|kind| if let Self::Integer(least, most) = kind { Some((*least, *most)) } else { None })
    }
}

impl Key {
    pub fn is_required(&self) -> bool {
        self.default == REQUIRED
    }
}

/// Returns the key with this name, kind, meaning, default, further conditions and example.
pub(crate) const fn key(
    name: &'static str,
    kind: Kind,
    meaning: &'static str,
    default: &'static str,
    range: &'static str,
    example: &'static str,
) -> Key {
    Key { name, kind, meaning, default, range, example }
}

/// Returns a list of three values along X, Y, Z and two about X, Y.
pub(crate) const fn five(along: Dimension, about: Dimension, bounds: Bounds) -> [Kind; 5] {
    let [along, about] = [Kind::Quantity(along, bounds), Kind::Quantity(about, bounds)];
    [along, along, along, about, about]
}

/// Returns the words of a choice.
pub(crate) fn words<T>(choices: &[(&'static str, T)]) -> Vec<&'static str> {
    choices.iter().map(|(word, _)| *word).collect()
}
