//! Status flags of evaluations and integration steps.

/// A set of flags of one evaluation or step; [`Status::OK`] is the empty set.
///
/// ```
/// use ballrace::Status;
///
/// let status = Status::CONTACT_LOST | Status::NOT_CONVERGED;
/// assert!(status.contains(Status::CONTACT_LOST) && status.intersects(Status::CONTACT_LOST | Status::OUT_OF_TABLE));
/// assert!(status.names().eq(["contact lost", "not converged"]));
/// ```
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Status(u8);

/// Name of each flag.
const NAMES: [(Status, &str); 8] = [
    (Status::INPUT_NOT_FINITE, "input not finite"),
    (Status::RESULT_NOT_FINITE, "result not finite"),
    (Status::CONTACT_LOST, "contact lost"),
    (Status::NOT_CONVERGED, "not converged"),
    (Status::GYROSCOPIC_SLIP, "gyroscopic slip"),
    (Status::OUT_OF_TABLE, "out of table"),
    (Status::INNOVATION_REJECTED, "innovation rejected"),
    (Status::INPUT_NOT_OK, "input not ok"),
];

impl core::ops::BitOr for Status {
    type Output = Self;
    #[inline]
    fn bitor(self, other: Self) -> Self {
        self.union(other)
    }
}

impl core::ops::BitOrAssign for Status {
    #[inline]
    fn bitor_assign(&mut self, other: Self) {
        *self = self.union(other);
    }
}

impl Status {
    /// No flag.
    pub const OK: Self = Self(0);
    /// An input is NaN or infinite; the result is the last valid value.
    pub const INPUT_NOT_FINITE: Self = Self(1);
    /// The inputs are finite and the result is not; the result is the last valid value.
    pub const RESULT_NOT_FINITE: Self = Self(2);
    /// No element carries load.
    pub const CONTACT_LOST: Self = Self(4);
    /// An element has not reached equilibrium after the given number of Newton steps; the force is inaccurate.
    pub const NOT_CONVERGED: Self = Self(8);
    /// The friction that balances the gyroscopic moment exceeds the traction limit of a contact: the ball slips.
    pub const GYROSCOPIC_SLIP: Self = Self(16);
    /// The state of an element is outside the domain of the table.
    pub const OUT_OF_TABLE: Self = Self(32);
    /// The normalised innovation squared exceeds the gate of the observer; the sample corrects nothing.
    pub const INNOVATION_REJECTED: Self = Self(64);
    /// A reading is outside the linear range of its transducer or does not change; the result is the last valid value.
    pub const INPUT_NOT_OK: Self = Self(128);

    /// Returns the flags as bits.
    #[must_use]
    #[inline]
    pub const fn bits(self) -> u8 {
        self.0
    }

    /// Creates the set from bits, such as those that [`Status::bits`] returned.
    #[must_use]
    #[inline]
    pub const fn from_bits(bits: u8) -> Self {
        Self(bits)
    }

    /// Returns the flags of both sets.
    #[must_use]
    #[inline]
    pub const fn union(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }

    /// Returns `self` if `condition`, else [`Status::OK`].
    #[must_use]
    #[inline]
    pub const fn when(self, condition: bool) -> Self {
        Self(self.0 * condition as u8)
    }

    /// Returns true if all flags of `other` are set.
    #[must_use]
    #[inline]
    pub const fn contains(self, other: Self) -> bool {
        self.0 & other.0 == other.0
    }

    /// Returns true if any flag of `other` is set.
    #[must_use]
    #[inline]
    pub const fn intersects(self, other: Self) -> bool {
        self.0 & other.0 != 0
    }

    /// Returns the names of the flags that are set, in the order of the bits.
    pub fn names(self) -> impl Iterator<Item = &'static str> {
        NAMES.into_iter().filter(move |(flag, _)| self.contains(*flag)).map(|(_, name)| name)
    }

    /// Returns true if the result is the last valid value instead of a new one.
    #[must_use]
    #[inline]
    pub const fn is_held(self) -> bool {
        self.intersects(Self(Self::INPUT_NOT_FINITE.0 | Self::RESULT_NOT_FINITE.0 | Self::INPUT_NOT_OK.0))
    }
}
