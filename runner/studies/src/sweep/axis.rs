//! `--over KEY=FROM..TO:HOW`: a key of a scene with its values, and their insertion into a scene.

use ballrace_plant::error::{Error, Result, SweepError};
use ballrace_scene::units::{self, Dimension, Mismatch};
use toml_edit::Value;

/// Largest number of values of one key.
const MAX_VALUES: usize = 100_000;

/// Forms of `--over`.
const FORM: &str = "KEY=FROM..TO:COUNT (such as shaft.speed=500rpm..10000rpm:200), a step with its unit in place of the count, or KEY=A,B,C";

/// One key and its values.
#[derive(Debug, Clone, PartialEq)]
pub struct Axis {
    /// Key, such as `shaft.speed` or `bearing[0].radial_play`; a bearing also by its name, `bearing.DE.radial_play`.
    pub key: String,
    /// Values in `unit`.
    pub values: Vec<f64>,
    /// Unit of the ends; empty for plain numbers.
    pub unit: String,
}

impl Axis {
    /// Parses `KEY=FROM..TO:COUNT`, `KEY=FROM..TO:STEP` with the unit of the ends, or `KEY=A,B,C`.
    ///
    /// # Errors
    /// Returns an error with the expected forms if the text is invalid.
    pub fn parse(text: &str) -> Result<Self> {
        let invalid = |expected: String| Error::from(SweepError::Axis { found: text.to_owned(), expected });
        let form = || invalid(FORM.to_owned());
        let (key, range) = text.split_once('=').ok_or_else(form)?;
        let (numbers, unit) = match range.split_once("..") {
            Some((from, rest)) => {
                let (to, how) = rest.rsplit_once(':').ok_or_else(form)?;
                let ends = [quantity(from), quantity(to), quantity(how)];
                let [Some((from, a)), Some((to, b)), Some((how, c))] = ends else { return Err(form()) };
                if a != b {
                    return Err(invalid(format!("one unit for both ends, here {a:?} and {b:?}")));
                }
                if c.is_empty() && how.fract() == 0.0 {
                    (by_count(from, to, how).map_err(invalid)?, a)
                } else if c == a {
                    (by_step(from, to, how).map_err(invalid)?, a)
                } else {
                    return Err(invalid(format!("a whole count, or a step in {a:?}")));
                }
            }
            None => {
                let all: Option<Vec<(f64, String)>> = range.split(',').map(quantity).collect();
                let all = all.ok_or_else(form)?;
                let unit = all.first().map(|(_, unit)| unit.clone()).unwrap_or_default();
                if all.iter().any(|(_, other)| *other != unit) {
                    return Err(invalid("one unit for all values".to_owned()));
                }
                (all.into_iter().map(|(number, _)| number).collect(), unit)
            }
        };
        Ok(Self { key: key.trim().to_owned(), values: numbers, unit })
    }

    /// Returns the values in SI, of the dimension that they have. Numbers without a unit are SI where that is the usual unit.
    ///
    /// # Errors
    /// A unit of another dimension; no unit where the usual one is not that of SI.
    pub fn in_si(&self, dimension: Dimension) -> Result<Vec<f64>, Mismatch> {
        if let Some(expected) = self.likely(dimension) {
            return Err(Mismatch { found: format!("{:?} (has no unit)", self.range("")), expected });
        }
        let in_si = |value: &f64| match self.unit.as_str() {
            "" => Ok(*value),
            unit => units::parse(&format!("{value} {unit}"), dimension),
        };
        self.values.iter().map(in_si).collect()
    }

    /// Returns the two likely readings of numbers without a unit, none where they are not ambiguous.
    pub(super) fn likely(&self, dimension: Dimension) -> Option<String> {
        let largest = self.values.iter().fold(0.0, |largest: f64, value| largest.max(value.abs()));
        let [first, second] = dimension.likely_units(largest).filter(|_| self.unit.is_empty())?;
        Some(format!("{:?} or {:?}", self.range(first), self.range(second)))
    }

    /// Returns the values in `unit`, as the command line writes them.
    pub(super) fn range(&self, unit: &str) -> String {
        match self.values.as_slice() {
            [from, .., to] if self.values.len() > 2 && self.is_even() => {
                format!("{from}{unit}..{to}{unit}:{}", self.values.len())
            }
            all => all.iter().map(|value| format!("{value}{unit}")).collect::<Vec<_>>().join(","),
        }
    }

    /// Returns true where all steps between the values are the same.
    fn is_even(&self) -> bool {
        let steps: Vec<f64> = self.values.windows(2).map(|pair| pair[1] - pair[0]).collect();
        steps.iter().all(|step| (step - steps[0]).abs() <= 1e-9 * steps[0].abs())
    }

    /// Returns the value as a scene writes it.
    #[must_use]
    pub fn written(&self, value: f64) -> Value {
        if !self.unit.is_empty() {
            Value::from(format!("{value} {}", self.unit))
        } else if value.fract() == 0.0 && value.abs() < 1e15 {
            Value::from(value as i64)
        } else {
            Value::from(value)
        }
    }
}

/// Returns a number and its unit.
fn quantity(text: &str) -> Option<(f64, String)> {
    let text = text.trim();
    let number_end = |end: &usize| text.get(..*end).is_some_and(|head| head.trim().parse::<f64>().is_ok());
    let end = (1..=text.len()).rev().filter(|end| text.is_char_boundary(*end)).find(number_end)?;
    let number = text.get(..end)?.trim().parse::<f64>().ok().filter(|x| x.is_finite())?;
    Some((number, text.get(end..)?.trim().to_owned()))
}

fn by_count(from: f64, to: f64, count: f64) -> Result<Vec<f64>, String> {
    if !(2.0..=MAX_VALUES as f64).contains(&count) {
        return Err(format!("a count of 2 to {MAX_VALUES}"));
    }
    let last = count - 1.0;
    // The values are interpolated, so that rounding errors of the step do not accumulate.
    Ok((0..count as usize).map(|i| from + (to - from) * (i as f64 / last)).collect())
}

fn by_step(from: f64, to: f64, step: f64) -> Result<Vec<f64>, String> {
    let count = ((to - from) / step * (1.0 + 1e-12)).floor() + 1.0;
    if !(1.0..=MAX_VALUES as f64).contains(&count) {
        return Err(format!("a step that leads from the one end to the other in at most {MAX_VALUES}"));
    }
    Ok((0..count as usize).map(|i| from + step * i as f64).collect())
}

#[cfg(test)]
#[expect(clippy::unwrap_used, reason = "a test fails by panicking")]
mod tests {
    use super::*;

    #[test]
    fn ranges() {
        let speed = Axis::parse("shaft.speed=500rpm..10000rpm:3").unwrap();
        assert_eq!((speed.key.as_str(), speed.unit.as_str()), ("shaft.speed", "rpm"));
        assert_eq!(speed.values, [500.0, 5250.0, 10_000.0]);
        assert_eq!(Axis::parse("a=0 um..10 um:2.5um").unwrap().values, [0.0, 2.5, 5.0, 7.5, 10.0]);
        assert!(Axis::parse("a=10..-10:-5 ").unwrap_err().to_string().contains("a count of 2"));
        assert_eq!(Axis::parse("a=7,9,11").unwrap().values, [7.0, 9.0, 11.0]);
        assert_eq!(Axis::parse("a=7").unwrap().values, [7.0]);
        for bad in [
            "a",
            "a=",
            "a=1..2",
            "a=1um..2mm:3",
            "a=1um..2um:3mm",
            "a=1,2um",
            "a=x..2:3",
            "a=1..2:1",
            "a=1um..2um:-1um",
        ] {
            assert!(Axis::parse(bad).unwrap_err().to_string().contains("expected"), "{bad}");
        }
    }
}
