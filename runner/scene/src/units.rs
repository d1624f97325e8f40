//! Quantities with units, as scenes and recordings name them.
//!
//! A unit is a product of names with optional powers and at most one `/`; everything after the `/` divides:
//! `N s/m`, `1/Pa`, `kg m^2`, `N/mm^1.5`, `g·mm`. The dimension is checked, with the angle and the voltage as
//! dimensions of their own: `Hz` cannot pass for a speed of rotation.

use std::f64::consts::{PI, TAU};

/// Powers of length, mass, time, angle and voltage.
type Powers = [f64; 5];

const LENGTH: Powers = [1.0, 0.0, 0.0, 0.0, 0.0];
const MASS: Powers = [0.0, 1.0, 0.0, 0.0, 0.0];
const TIME: Powers = [0.0, 0.0, 1.0, 0.0, 0.0];
const ANGLE: Powers = [0.0, 0.0, 0.0, 1.0, 0.0];
const FREQUENCY: Powers = [0.0, 0.0, -1.0, 0.0, 0.0];
const SPEED: Powers = [0.0, 0.0, -1.0, 1.0, 0.0];
const FORCE: Powers = [1.0, 1.0, -2.0, 0.0, 0.0];
const MOMENT: Powers = [2.0, 1.0, -2.0, 0.0, 0.0];
/// The one of kinematic viscosities.
const KINEMATIC_VISCOSITY: Powers = [2.0, 0.0, -1.0, 0.0, 0.0];
const UNBALANCE: Powers = [1.0, 1.0, 0.0, 0.0, 0.0];
const VOLTAGE: Powers = [0.0, 0.0, 0.0, 0.0, 1.0];
const PRESSURE: Powers = [-1.0, 1.0, -2.0, 0.0, 0.0];

/// Largest relative difference between the written power of a contact stiffness and the law's exponent:
/// 10/9 may be written 1.111.
const EXPONENT_TOLERANCE: f64 = 1e-3;

/// Largest difference of every other power.
const POWER_TOLERANCE: f64 = 1e-9;

/// Longest piece of the user's text that an error repeats, in characters.
const LONGEST_QUOTE: usize = 60;

/// Physical dimension of a number in the scene.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Dimension {
    /// m
    Length,
    /// kg
    Mass,
    /// s
    Time,
    /// rad
    Angle,
    /// Hz
    Frequency,
    /// 1/s, of a decay
    Rate,
    /// rad/s, of a shaft or ring
    Speed,
    /// m/s
    Velocity,
    /// m/s^2
    Acceleration,
    /// N
    Force,
    /// N m
    Moment,
    /// kg m^2
    Inertia,
    /// kg m, mass times radius
    Unbalance,
    /// N s/m
    Damping,
    /// N m s/rad, also written N m s
    AngularDamping,
    /// N/m
    Stiffness,
    /// N/rad, also written N: the coupling terms of a stiffness matrix
    CrossStiffness,
    /// N m/rad, also written N m
    AngularStiffness,
    /// Pa
    Pressure,
    /// kg/m^3
    Density,
    /// Pa s
    Viscosity,
    /// m^2/s
    KinematicViscosity,
    /// 1/Pa
    PressureViscosity,
    /// V
    Voltage,
    /// V/m, of a displacement probe
    Sensitivity,
    /// N/m^n of the law F = stiffness * deflection^n
    ContactStiffness(
        /// n
        f64,
    ),
}

/// Properties of one [`Dimension`].
struct Row {
    words: &'static str,
    example: &'static str,
    si: &'static str,
    powers: Powers,
    /// The unit may also be given per radian.
    per_radian: bool,
}

/// Error returned for a unit or a number that does not fit.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("invalid value: {found}, expected {expected}")]
pub struct Mismatch {
    /// Text found, with the reason in parentheses.
    pub found: String,
    /// Values expected, with an example.
    pub expected: String,
}

/// Every dimension that has a fixed form, the more usual name first where two share their powers.
const FIXED: [Dimension; 25] = [
    Dimension::Length,
    Dimension::Mass,
    Dimension::Time,
    Dimension::Angle,
    Dimension::Frequency,
    Dimension::Speed,
    Dimension::Velocity,
    Dimension::Acceleration,
    Dimension::Force,
    Dimension::Moment,
    Dimension::Inertia,
    Dimension::Unbalance,
    Dimension::Damping,
    Dimension::AngularDamping,
    Dimension::Stiffness,
    Dimension::CrossStiffness,
    Dimension::AngularStiffness,
    Dimension::Pressure,
    Dimension::Density,
    Dimension::Viscosity,
    Dimension::KinematicViscosity,
    Dimension::PressureViscosity,
    Dimension::Rate,
    Dimension::Voltage,
    Dimension::Sensitivity,
];

impl Dimension {
    #[rustfmt::skip] // a table
    fn row(self) -> Row {
        let row = |words, example, si, powers| Row { words, example, si, powers, per_radian: false };
        let per_radian = |row| Row { per_radian: true, ..row };
        match self {
            Self::Length => row("a length", "12.7 mm", "m", LENGTH),
            Self::Mass => row("a mass", "6 kg", "kg", MASS),
            Self::Time => row("a time", "2 s", "s", TIME),
            Self::Angle => row("an angle", "40 deg", "rad", ANGLE),
            Self::Frequency => row("a frequency", "25.6 kHz", "Hz", FREQUENCY),
            Self::Rate => row("a rate of decay", "60 1/s", "1/s", [0.0, 0.0, -1.0, 0.0, 0.0]),
            Self::Speed => row("a speed of rotation", "3000 rpm", "rad/s", SPEED),
            Self::Velocity => row("a velocity", "4.5 mm/s", "m/s", [1.0, 0.0, -1.0, 0.0, 0.0]),
            Self::Acceleration => row("an acceleration", "9.81 m/s^2", "m/s^2", [1.0, 0.0, -2.0, 0.0, 0.0]),
            Self::Force => row("a force", "500 N", "N", FORCE),
            Self::Moment => row("a moment", "2 N m", "N m", MOMENT),
            Self::Inertia => row("a moment of inertia", "0.030 kg m^2", "kg m^2", [2.0, 1.0, 0.0, 0.0, 0.0]),
            Self::Unbalance => row("an unbalance, mass times radius", "30 g mm", "kg m", UNBALANCE),
            Self::Damping => row("a damping", "400 N s/m", "N s/m", [0.0, 1.0, -1.0, 0.0, 0.0]),
            Self::AngularDamping => {
                per_radian(row("a damping of rotation", "0.4 N m s/rad", "N m s/rad", [2.0, 1.0, -1.0, 0.0, 0.0]))
            }
            Self::Stiffness => row("a stiffness", "1e8 N/m", "N/m", [0.0, 1.0, -2.0, 0.0, 0.0]),
            Self::CrossStiffness => per_radian(row("a force per angle", "1e5 N/rad", "N/rad", FORCE)),
            Self::AngularStiffness => per_radian(row("a stiffness of rotation", "1e4 N m/rad", "N m/rad", MOMENT)),
            Self::Pressure => row("a pressure", "206 GPa", "Pa", PRESSURE),
            Self::Density => row("a density", "7800 kg/m^3", "kg/m^3", [-3.0, 1.0, 0.0, 0.0, 0.0]),
            Self::Viscosity => row("a viscosity", "0.04 Pa s", "Pa s", [-1.0, 1.0, -1.0, 0.0, 0.0]),
            Self::KinematicViscosity => {
                row("a kinematic viscosity", "32 mm^2/s", "m^2/s", KINEMATIC_VISCOSITY)
            }
            Self::PressureViscosity => {
                row("a compliance to pressure", "2.2e-8 1/Pa", "1/Pa", [1.0, -1.0, 2.0, 0.0, 0.0])
            }
            Self::Voltage => row("a voltage", "-9.5 V", "V", VOLTAGE),
            Self::Sensitivity => {
                row("a voltage per length", "7.87 mV/um", "V/m", [-1.0, 0.0, 0.0, 0.0, 1.0])
            }
            Self::ContactStiffness(n) => {
                row("a contact stiffness", "1.2e10 N/m^1.5", "N/m^n", [1.0 - n, 1.0, -2.0, 0.0, 0.0])
            }
        }
    }

    /// Returns the SI unit of a bare number.
    pub(crate) fn si_unit(self) -> String {
        match self {
            Self::ContactStiffness(n) => format!("N/m^{}", short(n)),
            _ => self.row().si.to_owned(),
        }
    }

    /// Describes the values expected, with an example; `range` such as `above 0`, or empty.
    pub fn expected(self, range: &str) -> String {
        let row = self.row();
        let range = if range.is_empty() { String::new() } else { format!(" {range}") };
        match self {
            Self::ContactStiffness(n) => {
                let unit = self.si_unit();
                format!(
                    "a contact stiffness{range} in {unit} (the exponent is {}), such as \"1.2e10 {unit}\"",
                    short(n)
                )
            }
            Self::Length => format!("{}{range}, such as \"{}\" or \"5 um\"", row.words, row.example),
            Self::Speed => {
                format!("{}{range}, such as \"{}\" (rpm, rev/s or rad/s; Hz is not taken)", row.words, row.example)
            }
            _ => format!("{}{range}, such as \"{}\"", row.words, row.example),
        }
    }

    /// Returns the largest magnitude that a bare number may have, and the unit that a larger one most likely has: lengths of
    /// machines are in millimetres and angles in degrees. A text with its unit may have any value.
    pub(crate) const fn bare_limit(self) -> Option<(f64, &'static str)> {
        match self {
            Self::Length => Some((5.0, "mm")),
            Self::Angle => Some((TAU * (1.0 + 1e-12), "deg")),
            _ => None,
        }
    }

    /// Returns the two units that a bare number on a command line most likely has, the more likely one first; none where the usual
    /// unit is that of SI, and for 0, which is the same in both.
    #[must_use]
    pub fn likely_units(self, number: f64) -> Option<[&'static str; 2]> {
        match self {
            _ if number == 0.0 => None,
            Self::Speed => Some(["rpm", "rad/s"]),
            Self::Angle => Some(["deg", "rad"]),
            Self::Length if number.abs() < 1.0 => Some(["mm", "m"]),
            Self::Length => Some(["um", "mm"]),
            Self::Pressure => Some(["GPa", "Pa"]),
            Self::Unbalance => Some(["g mm", "kg m"]),
            Self::Sensitivity => Some(["mV/um", "V/m"]),
            _ => None,
        }
    }

    /// Returns an example of a quantity.
    pub(super) fn example(self) -> &'static str {
        self.row().example
    }

    /// Returns the dimension that an error about a unit expects.
    pub(super) fn of_expected(expected: &str) -> Option<Self> {
        FIXED.into_iter().find(|dimension| dimension.expected("") == expected)
    }

    /// Returns the dimension in words without article, such as `length`.
    pub(crate) fn name(self) -> &'static str {
        let words = self.row().words.split(',').next().unwrap_or_default();
        words.strip_prefix("an ").or(words.strip_prefix("a ")).unwrap_or(words)
    }

    /// Returns a regular expression of the units of this dimension. A single unit has the dimension; of an expression of several only
    /// the form is matched.
    pub(crate) fn unit_pattern(self) -> String {
        let single: Vec<String> = UNITS
            .iter()
            .filter(|(_, _, powers)| self.fits(*powers))
            .map(|(name, ..)| match name.strip_prefix('u') {
                Some(rest) => format!("[u\u{b5}\u{3bc}]{rest}"),
                None if *name == "deg" => "deg|\u{b0}".to_owned(),
                None => (*name).to_owned(),
            })
            .collect();
        const NAME: &str = "[A-Za-z\u{b5}\u{3bc}\u{b0}]+";
        const POWER: &str = "(\\^[+-]?[0-9.]+|[\u{b2}\u{b3}])";
        let term = format!("{NAME}{POWER}?");
        let product = format!("{term}([\\s*\u{b7}\u{22c5}]+{term})*");
        let several = format!("{term}([\\s*\u{b7}\u{22c5}]+{term})+");
        let expressions = format!("{NAME}{POWER}|{several}|(1|{product})\\s*/\\s*{product}");
        let single = single.iter().fold(String::new(), |all, one| all + one + "|");
        format!("({single}{expressions})")
    }

    fn fits(self, powers: Powers) -> bool {
        let row = self.row();
        let near = |a: f64, b: f64, tolerance: f64| (a - b).abs() <= tolerance;
        let length_tolerance = match self {
            Self::ContactStiffness(n) => EXPONENT_TOLERANCE * n.abs(),
            _ => POWER_TOLERANCE,
        };
        near(powers[0], row.powers[0], length_tolerance)
            && near(powers[1], row.powers[1], POWER_TOLERANCE)
            && near(powers[2], row.powers[2], POWER_TOLERANCE)
            && near(powers[4], row.powers[4], POWER_TOLERANCE)
            && (near(powers[3], row.powers[3], POWER_TOLERANCE)
                || row.per_radian && near(powers[3], -1.0, POWER_TOLERANCE))
    }
}

/// Returns the SI value of `"<number> <unit>"` of the dimension `dimension`.
pub fn parse(text: &str, dimension: Dimension) -> Result<f64, Mismatch> {
    let mismatch = |why: &str| Mismatch { found: format!("{} ({why})", quote(text)), expected: dimension.expected("") };
    let (number, unit) = split_number(text).ok_or_else(|| mismatch("does not start with a number and a unit"))?;
    if unit.is_empty() {
        return Err(mismatch("has no unit"));
    }
    if unit.starts_with(',') {
        return Err(mismatch("has a comma; a decimal point is written as a point"));
    }
    let (factor, powers) = unit_of(unit, dimension).map_err(|why| mismatch(&why))?;
    if !dimension.fits(powers) {
        return Err(mismatch(&describe(powers)));
    }
    let value = number * factor;
    if value.is_finite() { Ok(value) } else { Err(mismatch("is too large a number")) }
}

/// Returns the metres in one unit of a recording's column, such as `um`, `mil`, `mm` or `m`.
///
/// # Errors
/// A text that is no unit of length.
pub fn length_column(unit: &str) -> Result<f64, Mismatch> {
    column(unit, Dimension::Length, "a unit of length: um, mil, mm or m")
}

/// Returns the radians per second in one unit of a recording's column, such as `rpm` or `rad/s`.
///
/// # Errors
/// A text that is no unit of speed. `Hz` is one: revolutions and radians per second differ by 2 pi, and it does not distinguish them.
pub fn speed_column(unit: &str) -> Result<f64, Mismatch> {
    column(unit, Dimension::Speed, "a unit of speed of rotation: rpm, rev/s or rad/s")
}

/// Returns the volts in one unit of a recording's column, `V` or `mV`.
///
/// # Errors
/// A text that is no unit of voltage.
pub fn voltage_column(unit: &str) -> Result<f64, Mismatch> {
    column(unit, Dimension::Voltage, "a unit of voltage: V or mV")
}

/// Returns the hertz in one unit of a sampling rate in a recording.
///
/// # Errors
/// A text that is no unit of frequency.
pub(crate) fn frequency_column(unit: &str) -> Result<f64, Mismatch> {
    column(unit, Dimension::Frequency, "a unit of frequency: Hz or kHz")
}

/// Returns true where the unit of a column in the file differs from the scene's. A text that is no unit here, such as that of
/// a sensor, contradicts nothing, nor does a voltage where the scene has none: recorders write `V` beside scaled values.
pub fn contradict(found: &str, meant: &str) -> bool {
    let known = |text: &str| unit_of(text, Dimension::Length).ok();
    let same = |(a, one): (f64, Powers), (b, other): (f64, Powers)| (a / b - 1.0).abs() < 1e-9 && one == other;
    match (known(found.trim()), known(meant)) {
        _ if found.trim() == meant => false,
        (Some((_, found)), meant) if found == VOLTAGE && meant.is_none_or(|(_, meant)| meant != VOLTAGE) => false,
        (Some(found), Some(meant)) => !same(found, meant),
        (found, _) => found.is_some(),
    }
}

/// The unit of a column of lengths, by its factor.
pub(crate) fn length_name(metres: f64) -> Option<&'static str> {
    ["um", "mil", "mm", "m", "nm", "cm", "in", "ft"].into_iter().find(|unit| near(length_column(unit), metres))
}

/// The unit of a column of voltages, by its factor.
pub(crate) fn voltage_name(volts: f64) -> Option<&'static str> {
    ["V", "mV"].into_iter().find(|unit| near(voltage_column(unit), volts))
}

/// Units of a column of time with their seconds; Excel counts days.
pub(crate) const TIME_COLUMN: [(&str, f64); 7] =
    [("s", 1.0), ("ms", 1e-3), ("us", 1e-6), ("ns", 1e-9), ("min", 60.0), ("h", 3600.0), ("d", 86_400.0)];

/// Names of the units of a column of time.
pub(crate) const TIME_UNITS: &str = "s, ms, us, ns, min, h or d";

/// Returns the seconds in one unit of a recording's column.
///
/// # Errors
/// A text that is no unit of time.
pub(crate) fn time_column(unit: &str) -> Result<f64, Mismatch> {
    let plain = plain_signs(unit.trim());
    let found = TIME_COLUMN.iter().find(|(name, _)| *name == plain);
    found
        .map(|(_, seconds)| *seconds)
        .ok_or_else(|| Mismatch { found: quote(unit), expected: format!("a unit of time: {TIME_UNITS}") })
}

/// The unit of a column of time, by its factor.
#[must_use]
pub fn time_name(seconds: f64) -> Option<&'static str> {
    TIME_COLUMN.iter().find(|(_, own)| near(Ok(*own), seconds)).map(|(name, _)| *name)
}

/// Returns the units of time of which one makes a rate of time stamps in seconds (Hz) one that `fits`.
pub fn time_units_with(rate: f64, fits: impl Fn(f64) -> bool) -> Vec<&'static str> {
    TIME_COLUMN.iter().filter(|(_, seconds)| fits(rate / seconds)).map(|(name, _)| *name).collect()
}

/// Returns the unit of time at the end of the name of a column, such as `ms` of `t_ms` or `time [ms]`.
#[must_use]
pub fn unit_in_name(column: &str) -> Option<&str> {
    let word = column.trim_end_matches([')', ']', ' ']).rsplit(|c: char| !c.is_alphanumeric()).next()?;
    time_column(word).is_ok().then_some(word)
}

/// Returns true for the text of a unit of a recording.
#[must_use]
pub fn is_unit(text: &str) -> bool {
    let text = text.trim().trim_matches(['(', ')', '[', ']']).trim();
    time_column(text).is_ok() || unit_of(text, Dimension::Length).is_ok()
}

/// The unit of a column of speeds, by its factor.
pub(crate) fn speed_name(radians_per_second: f64) -> Option<&'static str> {
    ["rpm", "rev/s", "rad/s"].into_iter().find(|unit| near(speed_column(unit), radians_per_second))
}

fn near(unit: Result<f64, Mismatch>, factor: f64) -> bool {
    unit.is_ok_and(|unit| (unit / factor - 1.0).abs() < 1e-9)
}

fn column(unit: &str, dimension: Dimension, expected: &str) -> Result<f64, Mismatch> {
    let mismatch = |why: String| Mismatch { found: format!("{} ({why})", quote(unit)), expected: expected.to_owned() };
    let (factor, powers) = unit_of(unit, dimension).map_err(&mismatch)?;
    if !dimension.fits(powers) {
        return Err(mismatch(describe(powers)));
    }
    if factor.is_finite() && factor > 0.0 { Ok(factor) } else { Err(mismatch("is too large or too small".to_owned())) }
}

/// Splits `text` into the number at its start and the rest.
fn split_number(text: &str) -> Option<(f64, &str)> {
    let text = text.trim();
    let (number, unit) = text.split_at_checked(number_length(text.as_bytes()))?;
    let number = number.parse().ok()?;
    Some((number, unit.trim()))
}

/// Bytes of the decimal number at the start; an `e` counts only with digits after it.
fn number_length(text: &[u8]) -> usize {
    let digits = |from: usize| text.iter().skip(from).take_while(|b| b.is_ascii_digit()).count();
    let is = |at: usize, set: &[u8]| text.get(at).is_some_and(|b| set.contains(b));
    let mut end = usize::from(is(0, b"+-"));
    end += digits(end);
    if is(end, b".") {
        end += 1 + digits(end + 1);
    }
    if is(end, b"eE") {
        let sign = usize::from(is(end + 1, b"+-"));
        let power = digits(end + 1 + sign);
        if power > 0 {
            end += 1 + sign + power;
        }
    }
    end
}

/// Returns factor to SI and dimension of a unit expression, or the reason for which it is none.
fn unit_of(text: &str, wanted: Dimension) -> Result<(f64, Powers), String> {
    let plain = plain_signs(text);
    let mut sides = plain.split('/');
    let above = sides.next().unwrap_or_default();
    let below = sides.next();
    if sides.next().is_some() {
        return Err("more than one \"/\" is ambiguous; one divides by all that follows it".into());
    }
    let mut product = (1.0, [0.0; 5]);
    if above.trim() != "1" {
        multiply(&mut product, above, 1.0, wanted)?;
    }
    match below {
        Some(below) if below.trim().is_empty() => Err("nothing follows the \"/\"".into()),
        Some(below) => multiply(&mut product, below, -1.0, wanted).map(|()| product),
        None if above.trim().is_empty() => Err("there is no unit".into()),
        None => Ok(product),
    }
}

/// Returns the unit in the letters and signs of the table: micro as `u`, the degree sign as `deg`, a space for a product.
fn plain_signs(text: &str) -> String {
    let mut plain = String::with_capacity(text.len());
    for sign in text.chars() {
        match sign {
            '\u{b5}' | '\u{3bc}' => plain.push('u'),
            '\u{b0}' => plain.push_str("deg"),
            '*' | '\u{b7}' | '\u{22c5}' => plain.push(' '),
            '\u{b2}' => plain.push_str("^2"),
            '\u{b3}' => plain.push_str("^3"),
            other => plain.push(other),
        }
    }
    plain
}

/// Multiplies `product` by every name of one side of the `/`.
fn multiply(product: &mut (f64, Powers), side: &str, sign: f64, wanted: Dimension) -> Result<(), String> {
    for term in side.split_whitespace() {
        let (name, power) = match term.split_once('^') {
            Some((name, power)) => (name, power_of(power, wanted)?),
            None => (term, 1.0),
        };
        let (factor, powers) = atom(name)?;
        product.0 *= factor.powf(sign * power);
        for (total, own) in product.1.iter_mut().zip(powers) {
            *total += sign * power * own;
        }
    }
    Ok(())
}

/// Parses a power. One near the law's exponent is replaced by it: with `exponent = 1.1111`, `N/mm^1.111`
/// must not be off by `1000^0.0001`.
fn power_of(text: &str, wanted: Dimension) -> Result<f64, String> {
    let power: f64 = text
        .parse()
        .ok()
        .filter(|p: &f64| p.abs() <= 10.0)
        .ok_or_else(|| format!("\"^\" is followed by {} and not by a power", quote(text)))?;
    match wanted {
        Dimension::ContactStiffness(n) if (power.abs() - n).abs() <= EXPONENT_TOLERANCE * n => Ok(n.copysign(power)),
        _ => Ok(power),
    }
}

/// Factor to SI and dimension of one unit name.
fn atom(name: &str) -> Result<(f64, Powers), String> {
    if let Some((_, factor, powers)) = UNITS.iter().find(|(known, ..)| *known == name) {
        return Ok((*factor, *powers));
    }
    let other_case = UNITS.iter().find(|(known, ..)| known.eq_ignore_ascii_case(name));
    let hint = other_case.map_or(String::new(), |(known, ..)| format!("; did you mean \"{known}\"?"));
    Err(format!("{} is no known unit{hint}", quote(name)))
}

/// Units by name with their factor to SI: decimal multiples, the definitions of the international yard and pound agreement
/// of 1959 (inch, foot, pound, ounce) and what follows from them with standard gravity, 9.80665 m/s^2 (lbf, kgf, psi).
#[rustfmt::skip] // a table
const UNITS: [(&str, f64, Powers); 55] = [
    ("m", 1.0, LENGTH),
    ("cm", 1e-2, LENGTH),
    ("mm", 1e-3, LENGTH),
    ("um", 1e-6, LENGTH),
    ("nm", 1e-9, LENGTH),
    ("in", 0.0254, LENGTH),
    ("ft", 0.3048, LENGTH),
    ("mil", 2.54e-5, LENGTH),
    ("mils", 2.54e-5, LENGTH),
    ("kg", 1.0, MASS),
    ("g", 1e-3, MASS),
    ("mg", 1e-6, MASS),
    ("lb", 0.453_592_37, MASS),
    ("oz", 0.028_349_523_125, MASS),
    ("s", 1.0, TIME),
    ("ms", 1e-3, TIME),
    ("us", 1e-6, TIME),
    ("min", 60.0, TIME),
    ("h", 3600.0, TIME),
    ("rad", 1.0, ANGLE),
    ("mrad", 1e-3, ANGLE),
    ("urad", 1e-6, ANGLE),
    ("deg", PI / 180.0, ANGLE),
    ("arcmin", PI / 10_800.0, ANGLE),
    ("arcsec", PI / 648_000.0, ANGLE),
    ("rev", TAU, ANGLE),
    ("r", TAU, ANGLE),
    ("turn", TAU, ANGLE),
    ("rpm", TAU / 60.0, SPEED),
    ("rps", TAU, SPEED),
    ("Hz", 1.0, FREQUENCY),
    ("kHz", 1e3, FREQUENCY),
    ("MHz", 1e6, FREQUENCY),
    ("N", 1.0, FORCE),
    ("mN", 1e-3, FORCE),
    ("kN", 1e3, FORCE),
    ("MN", 1e6, FORCE),
    ("lbf", 4.448_221_615_260_5, FORCE),
    ("kip", 4_448.221_615_260_5, FORCE),
    ("kgf", 9.806_65, FORCE),
    ("Nm", 1.0, MOMENT),
    ("kNm", 1e3, MOMENT),
    ("Pa", 1.0, PRESSURE),
    ("mPa", 1e-3, PRESSURE),
    ("kPa", 1e3, PRESSURE),
    ("MPa", 1e6, PRESSURE),
    ("GPa", 1e9, PRESSURE),
    ("bar", 1e5, PRESSURE),
    ("psi", 6_894.757_293_168_361, PRESSURE),
    ("cSt", 1e-6, KINEMATIC_VISCOSITY),
    ("V", 1.0, VOLTAGE),
    ("mV", 1e-3, VOLTAGE),
    // Balancing sheets print these without a space.
    ("gmm", 1e-6, UNBALANCE),
    ("kgmm", 1e-3, UNBALANCE),
    ("kgm", 1.0, UNBALANCE),
];

/// A dimension in words: a known one by its name, any other by its SI units.
fn describe(powers: Powers) -> String {
    if let Some(known) = FIXED.into_iter().find(|d| d.fits(powers)) {
        return known.row().words.to_owned();
    }
    let exponent = 1.0 - powers[0];
    if exponent > 0.0 && Dimension::ContactStiffness(exponent).fits(powers) {
        return format!("a contact stiffness in N/m^{}", short(exponent));
    }
    let named = powers.into_iter().zip(["m", "kg", "s", "rad", "V"]);
    let units: Vec<String> = named
        .filter(|(power, _)| power.abs() > POWER_TOLERANCE)
        .map(|(power, name)| if power == 1.0 { name.to_owned() } else { format!("{name}^{}", short(power)) })
        .collect();
    if units.is_empty() {
        "a number without dimension".to_owned()
    } else {
        format!("a quantity in {}", units.join(" "))
    }
}

/// A power with at most four decimals.
fn short(power: f64) -> String {
    let text = format!("{power:.4}");
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}

/// The user's text in quotes on one line, cut where it is long.
pub(super) fn quote(text: &str) -> String {
    let mut shown: String = text.chars().take(LONGEST_QUOTE).collect();
    if shown.len() < text.len() {
        shown.push_str("...");
    }
    format!("{shown:?}")
}

#[cfg(test)]
#[expect(clippy::unwrap_used, reason = "a test fails by panicking")]
mod tests;
