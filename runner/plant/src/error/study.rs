//! Errors of questions about a scene.

use ballrace_scene::edit::UnknownKey;
use std::path::PathBuf;

/// Error returned for a single bearing without a load.
#[derive(Debug, thiserror::Error)]
#[error(
    "{}: bearing {bearing}: neither a rotor, a preload nor --load, expected one of them as a load for the equilibrium",
    file.display()
)]
pub struct NoLoad {
    /// Scene file.
    pub file: PathBuf,
    /// Name of the bearing.
    pub bearing: String,
}

/// Error returned when the temperatures of bearings cannot be found.
#[derive(Debug, thiserror::Error)]
pub enum ThermalError {
    /// No bearing has a way for its heat.
    #[error("{}: no bearing with cooling, expected `cooling`, `lubrication` and `temperatures` in a bearing", file.display())]
    NoCooling {
        /// Scene file.
        file: PathBuf,
    },
    /// The friction of a bearing is not known.
    #[error(
        "{}: bearing {bearing}: no friction: its ratings are not known, expected its geometry or a bearing of the catalogue",
        file.display()
    )]
    NoFriction {
        /// Scene file.
        file: PathBuf,
        /// Name of the bearing.
        bearing: String,
    },
    /// The heat has no steady temperature in the range of bearing steel.
    #[error(
        "{}: bearing {bearing}: no steady temperature: {celsius:.0} degC with {watts:.0} W of friction, expected one below 250 degC; \
         more cooling, less preload or less viscosity",
        file.display()
    )]
    TooHot {
        /// Scene file.
        file: PathBuf,
        /// Name of the bearing.
        bearing: String,
        /// Temperature reached, degrees Celsius.
        celsius: f64,
        /// Power of the friction, W.
        watts: f64,
    },
    /// The rings use up the clearance, below which models with a contact angle do not hold.
    #[error(
        "{}: bearing {bearing}: no steady temperature: with the inner ring at {:.0} degC and the outer ring at {:.0} degC the operating \
         clearance is {micrometres:.1} um, and the preload runs away, expected a clearance of 0 or more; more cooling, less preload or interference",
        file.display(), rings[0], rings[1]
    )]
    NoClearance {
        /// Scene file.
        file: PathBuf,
        /// Name of the bearing.
        bearing: String,
        /// Temperatures of inner and outer ring, degrees Celsius.
        rings: [f64; 2],
        /// Operating clearance, um.
        micrometres: f64,
    },
    /// The temperatures do not settle.
    #[error("{}: no steady temperatures within {rounds} equilibria", file.display())]
    NotSteady {
        /// Scene file.
        file: PathBuf,
        /// Number of equilibria.
        rounds: usize,
    },
}

/// Error returned when a sweep cannot be run or continued.
#[derive(Debug, thiserror::Error)]
pub enum SweepError {
    /// A range that cannot be read.
    #[error("--over: invalid range: {found:?}, expected {expected}")]
    Axis {
        /// Text of the option.
        found: String,
        /// Form expected.
        expected: String,
    },
    /// Numbers without a unit of a quantity whose usual unit is not that of SI.
    #[error("--over: no unit: {found:?}, expected {expected}")]
    NoUnit {
        /// Text of the option.
        found: String,
        /// The two likely readings.
        expected: String,
    },
    /// A key that the scene does not have.
    #[error("--over: {0}")]
    Key(UnknownKey),
    /// There are too many points.
    #[error("--over: too many points: {found}, expected at most {most} with {periods} section periods at each")]
    Points {
        /// Number of values of each axis.
        found: String,
        /// Largest number of points.
        most: usize,
        /// Number of section periods of each point.
        periods: usize,
    },
    /// There are too many equilibria.
    #[error("--over: too many points: {found}, expected at most {most}")]
    Equilibria {
        /// Number of values of each axis.
        found: String,
        /// Largest number of points.
        most: usize,
    },
    /// The transient at a point has too many samples.
    #[error("--settle: too many samples: {found:.3e} at {rate:.3e} Hz, expected at most {most:.0e}")]
    Samples {
        /// Number of samples.
        found: f64,
        /// Sampling rate, Hz.
        rate: f64,
        /// Largest number of samples.
        most: f64,
    },
    /// The shaft is at standstill.
    #[error("{}: shaft.speed: shaft at standstill, expected a rotating shaft in a sweep", file.display())]
    Standstill {
        /// Scene file.
        file: PathBuf,
    },
    /// The text of the scene is no TOML.
    #[error("{}: invalid TOML", file.display())]
    Syntax {
        /// Scene file.
        file: PathBuf,
        /// First error in the text.
        source: toml_edit::TomlError,
    },
    /// A journal cannot be read.
    #[error("{}: this file cannot be read", file.display())]
    Read {
        /// The journal.
        file: PathBuf,
        /// The system's error.
        source: std::io::Error,
    },
    /// A file is no journal.
    #[error("{}: no results of a sweep, expected a file that sweep has written", file.display())]
    NoJournal {
        /// The file.
        file: PathBuf,
    },
    /// A journal belongs to another sweep.
    #[error(
        "{}: results of another scene, range or measure, expected those of this sweep; remove the file or choose another -o",
        file.display()
    )]
    OtherSweep {
        /// The journal.
        file: PathBuf,
    },
    /// A line of a journal is invalid.
    #[error("{}:{line}: no result of a sweep", file.display())]
    Line {
        /// The journal.
        file: PathBuf,
        /// Number of the line, from 1.
        line: usize,
        /// First error in the line.
        source: serde_json::Error,
    },
    /// A journal cannot be written.
    #[error("{}: this file cannot be written", file.display())]
    Write {
        /// The journal.
        file: PathBuf,
        /// The system's error.
        source: std::io::Error,
    },
    /// A result is not a finite number.
    #[error("result of a point that is not finite")]
    NotFinite(#[source] serde_json::Error),
    /// Options or results cannot be written as JSON.
    #[error(transparent)]
    Json(#[from] serde_json::Error),
}

impl SweepError {
    /// Returns true where the options of the command are wrong.
    #[must_use]
    pub const fn is_usage_error(&self) -> bool {
        matches!(
            self,
            Self::Axis { .. } | Self::NoUnit { .. } | Self::Key(_) | Self::Points { .. } | Self::Samples { .. }
        )
    }
}

/// Error returned when a scene cannot be fitted to a recording.
#[derive(Debug, thiserror::Error)]
pub enum FitError {
    /// The scene has no recording.
    #[error("{}: missing table [recording], expected the recording to fit to", file.display())]
    NoRecording {
        /// Scene file.
        file: PathBuf,
    },
    /// The recording has no sample.
    #[error("{recording}: no sample, expected some turns of the shaft")]
    NoSample {
        /// Name of the recording.
        recording: String,
    },
    /// The search ended at its largest number of iterations.
    #[error(
        "{recording}: the fit does not converge because the scene does not describe the recording: after {iterations} iterations \
         over all samples chi-squared still falls by {:.1e} % an iteration, and probe {probe} leaves {left_um:.3} um rms where its \
         noise is {noise_um:.3} um, expected a recording of this machine without drift of a probe; --only or --turns fits less",
        100.0 * still_falls
    )]
    NotConverged {
        /// Name of the recording.
        recording: String,
        /// Number of iterations over all samples.
        iterations: usize,
        /// Relative decrease of chi-squared in the last iteration.
        still_falls: f64,
        /// Column of the probe with the largest residual over its noise.
        probe: String,
        /// Residual of that probe, um rms.
        left_um: f64,
        /// Noise of that probe, um rms.
        noise_um: f64,
    },
    /// The time of the search has ended.
    #[error(
        "{recording}: the fit does not converge because its time has ended: {limit_s} s, over {turns:.1} of {all_turns:.1} \
         revolutions, expected fewer revolutions (--turns), fewer parameters (--only) or more time (--time-limit)"
    )]
    TooLong {
        /// Name of the recording.
        recording: String,
        /// Time of the fit, s.
        limit_s: f64,
        /// Number of revolutions over which the search was under way.
        turns: f64,
        /// Number of revolutions in all samples.
        all_turns: f64,
    },
    /// The recording has no probes.
    #[error("{}: [recording]: no probes, expected probes in fit", file.display())]
    NoProbes {
        /// Scene file.
        file: PathBuf,
    },
    /// The scene has no parameter that can be fitted.
    #[error("{}: nothing to fit, expected a [rotor] on bearings", file.display())]
    NothingToFit {
        /// Scene file.
        file: PathBuf,
    },
    /// The text of the scene is no TOML.
    #[error("{}: invalid TOML", file.display())]
    Syntax {
        /// Scene file.
        file: PathBuf,
        /// First error in the text.
        source: toml_edit::TomlError,
    },
    /// The tables of the scene have another form than the fitted values need.
    #[error("{}: the fitted values cannot be written into this scene, expected {expected}", file.display())]
    Form {
        /// Scene file.
        file: PathBuf,
        /// Form that takes the values.
        expected: &'static str,
    },
}

/// Error returned when the models of a scene cannot be compared.
#[derive(Debug, thiserror::Error)]
pub enum TradeError {
    /// No model can be built from the scene.
    #[error("no model that this scene allows")]
    NoModel,
    /// The scene has no level of this name.
    #[error("no such model: {found:?}, expected one of this scene")]
    UnknownLevel {
        /// Name of the level.
        found: String,
    },
    /// The text of the scene is no TOML.
    #[error("{}: invalid TOML", file.display())]
    Syntax {
        /// Scene file.
        file: PathBuf,
        /// First error in the text.
        source: toml_edit::TomlError,
    },
    /// The text of the scene has no bearing.
    #[error("{}: missing table [[bearing]]", file.display())]
    NoBearing {
        /// Scene file.
        file: PathBuf,
    },
    /// The recording has no complete sample.
    #[error("{}: no sample with all probes, expected at least one turn of the shaft", file.display())]
    NoSample {
        /// The recording.
        file: PathBuf,
    },
    /// No bearing carries a load.
    #[error("{}: bearings without load over the whole motion, expected a motion under load", file.display())]
    NoLoad {
        /// Scene file.
        file: PathBuf,
    },
    /// No candidate has a cost on the target.
    #[error(
        "--error, --deadline: no model of this scene is among those counted on the Cortex-M4F (waviness, damage and a \
         displaced housing are not counted), expected --error with --on desktop"
    )]
    NotCounted,
    /// The motion of the reference overflows.
    #[error("no motion to compare with: the most accurate model at a fine step: {reason}")]
    Reference {
        /// Its error.
        reason: String,
    },
    /// The motion of every candidate with a cost overflows.
    #[error("no model to recommend: the motion overflows with every model that has a cost. {reason}")]
    Overflow {
        /// Error of the first.
        reason: String,
    },
    /// No candidate is accurate enough.
    #[error(
        "--error: no model is so accurate: {:.3e} %, expected {:.3e} % or more, the least error of a model with a cost", found * 100.0, least * 100.0
    )]
    Error {
        /// Error that is required, relative.
        found: f64,
        /// Error of the most accurate candidate with a cost.
        least: f64,
    },
    /// No candidate is fast enough.
    #[error(
        "--deadline: no model is so fast: {:.3} us at {:.0} MHz, expected {:.3} us or more, the cheapest model with a count",
        found * 1e6, clock / 1e6, least * 1e6
    )]
    Deadline {
        /// Deadline that is required, s.
        found: f64,
        /// Clock of the target, Hz.
        clock: f64,
        /// Time of the cheapest candidate with a cost, s.
        least: f64,
    },
}

impl TradeError {
    /// Returns true where the command or the scene is wrong.
    #[must_use]
    pub const fn is_usage_error(&self) -> bool {
        matches!(self, Self::NotCounted | Self::Error { .. } | Self::Deadline { .. })
    }
}

/// Speed of sound in steel, m/s: a motion that is faster has no physical meaning, and is that of an unstable system or step.
pub const LARGEST_SPEED: f64 = 5000.0;

/// Error returned when a computed motion overflows.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("the motion overflows: {found}, expected at most {LARGEST_SPEED} m/s. {advice}")]
pub struct MotionOverflow {
    /// Speed and time.
    pub found: String,
    /// Probable cause.
    pub advice: String,
}

/// Error returned when a scene cannot be written as constants.
#[derive(Debug, thiserror::Error)]
pub enum BakeError {
    /// A model without constants.
    #[error(
        "{}: bearing {bearing}: model with a displaced housing, a bending outer ring, balls that move or two rows: {found}, expected any other in bake",
        file.display()
    )]
    Model {
        /// Scene file.
        file: PathBuf,
        /// Name of the bearing.
        bearing: String,
        /// Its model.
        found: &'static str,
    },
    /// Content of a scene for which the library of C has no struct and a blob no constants.
    #[error("{}: {place}: {found} with --language {language}, expected {expected}", file.display())]
    NotInC {
        /// Scene file.
        file: PathBuf,
        /// Language of the constants.
        language: &'static str,
        /// Part of the scene.
        place: String,
        /// Its content.
        found: String,
        /// Content that C has.
        expected: &'static str,
    },
    /// Two bearings whose names give one module.
    #[error(
        "{}: bearings {} and {}: both become the module {module}, expected names that differ in letters or digits",
        file.display(), bearings[0], bearings[1]
    )]
    SameModule {
        /// Scene file.
        file: PathBuf,
        /// Name of the module.
        module: String,
        /// Names of the bearings.
        bearings: [String; 2],
    },
    /// A rotor that its bearings do not support.
    #[error(
        "{}: no equilibrium: {residual:.2e} of the load is not balanced, expected at most {most:.0e} in bake",
        file.display()
    )]
    NoEquilibrium {
        /// Scene file.
        file: PathBuf,
        /// Residual of the equilibrium over the load.
        residual: f64,
        /// Largest residual.
        most: f64,
    },
    /// A displacement or force that is no number.
    #[error("{}: bearing {bearing}: {figure} out of the range of numbers, expected finite values in bake", file.display())]
    NotFinite {
        /// Scene file.
        file: PathBuf,
        /// Name of the bearing.
        bearing: String,
        /// Name of the value.
        figure: &'static str,
    },
    /// A motion with loads beyond the static rating.
    #[error(
        "{}: bearing {bearing}: load of {found:.2e} N on an element, expected at most {most:.2e} N, the static limit of ISO 76",
        file.display()
    )]
    Overload {
        /// Scene or recording.
        file: PathBuf,
        /// Name of the bearing.
        bearing: String,
        /// Largest load on an element, N.
        found: f64,
        /// Load on an element at the permissible static contact pressure, N.
        most: f64,
    },
    /// A recording whose position is not that of the shaft in its bearings.
    #[error(
        "{}: bearing {bearing}: median force of {found:.2e} N at the recorded position, expected at most {most:.2e} N, the static force and \
         {factor} times the loads on the rotor: the gap of the probes is in the readings (offset)",
        file.display()
    )]
    Position {
        /// The recording.
        file: PathBuf,
        /// Name of the bearing.
        bearing: String,
        /// Median of the magnitude of the force, N.
        found: f64,
        /// Largest force, N.
        most: f64,
        /// Largest force over the loads on the rotor.
        factor: f64,
    },
    /// An observer whose gains the scene does not determine.
    #[error("{}: [observer]: {found} in bake, expected {expected}", file.display())]
    Observer {
        /// Scene file.
        file: PathBuf,
        /// Content of the scene.
        found: &'static str,
        /// Content that determines the gains.
        expected: &'static str,
    },
}

/// Error returned when a file of baked constants cannot be verified.
#[derive(Debug, thiserror::Error)]
pub enum VerifyError {
    /// A file cannot be read.
    #[error("{}: this file cannot be read", file.display())]
    Read {
        /// The file.
        file: PathBuf,
        /// The system's error.
        source: std::io::Error,
    },
    /// A file without a block of comments.
    #[error("{}: no complete {what} in the comments, expected a file that bake has written", file.display())]
    NoBlock {
        /// The file.
        file: PathBuf,
        /// Name of the block.
        what: &'static str,
    },
    /// A certificate without a field.
    #[error("{}: missing field {name:?} of the certificate, expected a file that bake has written", file.display())]
    NoField {
        /// The file.
        file: PathBuf,
        /// Name of the field.
        name: &'static str,
    },
    /// A field of a certificate is invalid.
    #[error("{}: field {name:?} of the certificate: invalid value: {found:?}, expected {expected}", file.display())]
    Field {
        /// The file.
        file: PathBuf,
        /// Name of the field.
        name: &'static str,
        /// Its value.
        found: String,
        /// Values expected.
        expected: String,
    },
}

/// Error returned when a co-simulation unit cannot be opened or used.
#[derive(Debug, thiserror::Error)]
pub enum UnitError {
    /// A file of the unit cannot be read.
    #[error("{}: this file cannot be read", file.display())]
    Read {
        /// The file.
        file: PathBuf,
        /// The system's error.
        source: std::io::Error,
    },
    /// The file with the content of the unit is none.
    #[error("{}: invalid content of a unit, expected bearing = \"NAME\" or rate = a number above 0, Hz", file.display())]
    Content {
        /// The file.
        file: PathBuf,
    },
    /// The token is not that of the unit's files and this version.
    #[error("instantiationToken: {found:?}, expected {expected:?}, that of these resources and of ballrace {version}")]
    Token {
        /// Token of the host.
        found: String,
        /// Token of the unit.
        expected: String,
        /// Version of this library.
        version: &'static str,
    },
    /// No variable has this value reference.
    #[error("value reference {found}: no such variable, expected 0 to {most}")]
    Reference {
        /// The value reference.
        found: u32,
        /// Largest value reference.
        most: usize,
    },
    /// A variable that is no input is set.
    #[error("{name}: this variable is no input")]
    NotAnInput {
        /// Name of the variable.
        name: String,
    },
    /// A communication point is not the time of the unit.
    #[error("communication point {found} s, expected {expected} s, the end of the last step")]
    Point {
        /// Time of the host, s.
        found: f64,
        /// Time of the unit, s.
        expected: f64,
    },
    /// A step beyond the end of the simulation.
    #[error("end of the communication step {found} s, expected at most the stop time of {stop} s")]
    Beyond {
        /// End of the step, s.
        found: f64,
        /// Stop time, s.
        stop: f64,
    },
    /// A step without length.
    #[error("communication step {found} s, expected a step above 0 s")]
    NoLength {
        /// Length of the step, s.
        found: f64,
    },
    /// A communication step is no whole number of internal steps.
    #[error("communication step {found} s, expected a multiple of the internal step of {internal} s, such as {near} s")]
    Step {
        /// Length of the step, s.
        found: f64,
        /// Internal step, s.
        internal: f64,
        /// Nearest multiple, s.
        near: f64,
    },
}

/// Error returned when recordings of a scene give no vectors for balancing.
#[derive(Debug, thiserror::Error)]
pub enum VectorError {
    /// The scene has no recording.
    #[error("{}: missing table [recording], expected probes and keyphasor of the recordings", file.display())]
    NoRecording {
        /// Scene.
        file: PathBuf,
    },
    /// The scene has no radial probe.
    #[error("{}: recording.probes: no radial probe, expected at least one displacement probe with an angle", file.display())]
    NoProbe {
        /// Scene.
        file: PathBuf,
    },
    /// The recordings have no mark on the shaft.
    #[error("{}: recording: no mark on the shaft, by which angles of runs compare, expected a keyphasor with one pulse per turn, or one on a wheel with a gap", file.display())]
    NoMark {
        /// Scene.
        file: PathBuf,
    },
    /// A recording is shorter than a block.
    #[error("{}: no 1X vector, expected at least {turns} turns with a reading of every probe", file.display())]
    Short {
        /// Recording.
        file: PathBuf,
        /// Least number of turns.
        turns: i64,
    },
    /// The speed of a recording changes.
    #[error("{}: speed from {low:.1} to {high:.1} rpm, expected one speed, within {percent} %", file.display())]
    SpeedChanges {
        /// Recording.
        file: PathBuf,
        /// Slowest block, rpm.
        low: f64,
        /// Fastest block, rpm.
        high: f64,
        /// Largest difference, %.
        percent: f64,
    },
    /// A trial has another speed than the runs without masses.
    #[error("{}: {found:.1} rpm, expected a speed of the runs without masses: {}", file.display(), list(expected))]
    OtherSpeed {
        /// Recording of the trial.
        file: PathBuf,
        /// Its speed, rpm.
        found: f64,
        /// Speeds of the runs without masses, rpm.
        expected: Vec<f64>,
    },
}

fn list(speeds: &[f64]) -> String {
    let speeds: Vec<String> = speeds.iter().map(|speed| format!("{speed:.1} rpm")).collect();
    speeds.join(", ")
}
