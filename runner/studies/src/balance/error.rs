//! Errors of a balance.

/// Error of an estimate from vectors.
#[derive(Debug, thiserror::Error)]
pub enum BalanceError {
    /// There are too few runs with known masses.
    #[error(
        "{found} conditions with known masses, expected at least {least}: a baseline and one trial for each of the {planes} planes"
    )]
    Few {
        /// Conditions found.
        found: usize,
        /// Least number.
        least: usize,
        /// Planes.
        planes: usize,
    },
    /// The trials do not tell the planes apart.
    #[error(
        "the trial masses do not tell the planes apart at {speed:.0} rpm, expected trials on each plane alone or in different proportions"
    )]
    Dependent {
        /// Speed, rpm.
        speed: f64,
    },
    /// No trial moves the probes by more than the errors of the vectors.
    #[error(
        "the trial masses change no probe by more than its scatter, expected larger masses, or planes and probes of this rotor"
    )]
    NoResponse,
    /// The response turns against the masses.
    #[error(
        "the vectors turn against the masses: with the angles of all masses counted the other way, the trials fit far better, expected angles of masses and vectors in one direction (a phase lag grows with the angle of the mass against rotation)"
    )]
    Mirrored,
    /// A blind run has a speed without trials.
    #[error("condition {condition}: no trial at {speed:.0} rpm, expected trials at the speeds of the blind runs")]
    Speed {
        /// Condition.
        condition: String,
        /// Speed, rpm.
        speed: f64,
    },
    /// Trials and twin do not agree, and there are too few trials without it.
    #[error(
        "the vectors are {misfit:.1} times as far from the coefficients of the twin as its errors and those of the vectors allow, expected a scene of \
         this machine, the right masses and angles, or a trial for each plane"
    )]
    Twin {
        /// Chi-squared over its largest value.
        misfit: f64,
    },
    /// Two planes are exchanged.
    #[error(
        "planes {first} and {second} look exchanged: with the masses of each in the other the vectors agree with the twin, expected the planes in which the masses were"
    )]
    Planes {
        /// A plane.
        first: String,
        /// The other.
        second: String,
    },
    /// The vectors of a run are not those that the twin expects of its masses.
    #[error(
        "{condition}: the vectors agree with the twin only with {likely}, expected {expected}, or a scene of this machine"
    )]
    AgainstTwin {
        /// Condition.
        condition: String,
        /// Masses, probes or unit that explain the vectors.
        likely: String,
        /// What is expected of the table or of the machine.
        expected: &'static str,
    },
    /// The vectors of a run are not those that the others expect of its masses.
    #[error("{condition}: the vectors agree with the other runs only with {likely}, expected {expected}")]
    Mounted {
        /// Condition.
        condition: String,
        /// Masses, probes or unit that explain the vectors.
        likely: String,
        /// What is expected of the table or of the machine.
        expected: &'static str,
    },
    /// There are no mounted masses to take off.
    #[error("no trim run, expected one whose masses are taken off")]
    NoTrim,
    /// A stock has too many choices of weights.
    #[error(
        "the stock has more than {most} choices of weights in the holes of a plane, expected fewer kinds of weights, holes or weights in a plane"
    )]
    Choices {
        /// Most choices.
        most: usize,
    },
    /// Two probes are exchanged in all runs.
    #[error(
        "all runs: probes {first} and {second} look exchanged: with each in the place of the other the vectors agree with the twin, expected the columns of the scene"
    )]
    Exchanged {
        /// A probe.
        first: String,
        /// The other.
        second: String,
    },
}
