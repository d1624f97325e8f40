//! Status flags of one sample, for files and for the replay.

use ballrace::Status;

/// Flags of one sample: the kernel's in the low byte, those of recording and replay above. 0 where there is nothing to
/// report.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct SampleStatus(u16);

impl SampleStatus {
    /// The force of every bearing comes from the measured displacement instead of the observer.
    pub const FROM_DISPLACEMENT: Self = Self(128);
    /// A reading was outside the range that the bearings allow.
    pub const READING_OUT_OF_RANGE: Self = Self(256);
    /// The observer or the twin restarted at this sample.
    pub const RESTARTED: Self = Self(512);
    /// The shaft angle was extrapolated: no keyphasor pulse, no speed or a speed outside its range.
    pub const ANGLE_NOT_MEASURED: Self = Self(1024);
    /// The motion of the twin was not finite: its last state is held.
    pub const TWIN_HELD: Self = Self(2048);

    /// Returns the flags as a number, for files.
    #[must_use]
    pub const fn bits(self) -> u16 {
        self.0
    }

    /// Returns the flags of both.
    #[must_use]
    pub const fn and(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }

    /// Returns the flags of `self` that `other` does not have.
    #[must_use]
    pub const fn without(self, other: Self) -> Self {
        Self(self.0 & !other.0)
    }

    /// Returns `self` where `condition` holds, else no flag.
    #[must_use]
    pub const fn when(self, condition: bool) -> Self {
        if condition { self } else { Self(0) }
    }

    /// Returns true where all flags of `other` are set.
    #[must_use]
    pub const fn has(self, other: Self) -> bool {
        self.0 & other.0 == other.0
    }
}

impl From<Status> for SampleStatus {
    fn from(status: Status) -> Self {
        Self(u16::from(status.bits()))
    }
}
