//! What a step has to say besides its value: a few flags, returned by value.

/// Flags of one evaluation or step; [`Status::OK`] when there is nothing to say.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Status(u8);

impl Status {
    /// Nothing to report.
    pub const OK: Self = Self(0);
    /// An input was NaN or infinite: the last good value is held.
    pub const INPUT_NOT_FINITE: Self = Self(1);
    /// The inputs were finite and the result was not (overflow): the last good value is held.
    pub const RESULT_NOT_FINITE: Self = Self(2);
    /// No element carries load.
    pub const CONTACT_LOST: Self = Self(4);
    /// An element did not reach its equilibrium in the steps given: the force is not to be trusted.
    pub const NOT_CONVERGED: Self = Self(8);
    /// The friction that would balance a gyroscopic moment is more than the contacts can give: the ball would slip.
    pub const GYROSCOPIC_SLIP: Self = Self(16);
    /// Outside of what was declared when the bearing's table was made.
    pub const OUT_OF_TABLE: Self = Self(32);
    /// The normalised innovation squared is above the observer's gate: the sample corrects nothing.
    pub const INNOVATION_REJECTED: Self = Self(64);

    /// The flags as bits, for logs and tables.
    #[must_use]
    #[inline]
    pub const fn bits(self) -> u8 {
        self.0
    }

    /// Both sets of flags.
    #[must_use]
    #[inline]
    pub const fn union(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }

    /// `self` when `condition` holds, else OK.
    #[must_use]
    #[inline]
    pub const fn when(self, condition: bool) -> Self {
        Self(self.0 * condition as u8)
    }

    /// All flags of `other` are set.
    #[must_use]
    #[inline]
    pub const fn contains(self, other: Self) -> bool {
        self.0 & other.0 == other.0
    }

    /// The last good value is returned instead of a fresh one.
    #[must_use]
    #[inline]
    pub const fn is_held(self) -> bool {
        self.0 & (Self::INPUT_NOT_FINITE.0 | Self::RESULT_NOT_FINITE.0) != 0
    }
}
