//! What the tests share: golden files, comparison, element counts at run time.

pub mod bearings;
pub mod compare;
pub mod lumped;
pub mod rollers;
pub mod states;

/// Examples of the firmware guide, compiled and run as tests of this documentation.
#[cfg(doctest)]
#[doc = include_str!("../../docs/src/firmware.md")]
pub struct FirmwareGuide;

/// Calls `$body` with the constant `$n` equal to the run-time `$count` (3 to 24, what the golden files use).
#[macro_export]
macro_rules! with_elements {
    ($count:expr, $n:ident, $body:expr) => {
        $crate::with_elements!(@ $count, $n, $body,
            3 4 5 6 7 8 9 10 11 12 13 14 15 16 17 18 19 20 21 22 23 24)
    };
    (@ $count:expr, $n:ident, $body:expr, $($value:literal)*) => {
        match $count {
            $($value => { const $n: usize = $value; $body })*
            other => panic!("{other} elements: no golden case has that many"),
        }
    };
}

/// Whether tests that have a short and a full form run in full: `tests/run --all` sets the variable.
#[must_use]
pub fn runs_all() -> bool {
    std::env::var_os("BALLRACE_TEST_ALL").is_some()
}
