//! Holes and weights of the planes from the options of a user.
//!
//! Each entry of an option has the name of its plane in front, such as `fan 30 mm`; an entry without one holds for the planes that no entry of
//! that option names.

use super::holes::{HoleCircle, Holes, Weight};
use ballrace_base::printable::name as printable;
use ballrace_scene::units::{Dimension, parse};

/// Least number of holes of a plane.
const LEAST_HOLES: u16 = 3;

/// Holes and weights as a user writes them.
#[derive(Debug, Clone, Default)]
pub struct HoleOptions {
    /// Number of holes: `16`, `fan 12`, or `fan 12 from 15 deg` where the first one is not at 0.
    pub holes: Vec<String>,
    /// Radius of the circle of holes: `30 mm`, `fan 100 mm`.
    pub radius: Vec<String>,
    /// Largest mass of a hole: `5 g`, `fan 20 g`.
    pub hole_limit: Vec<String>,
    /// Weights in stock: `2 g`, `fan 3 x 2 g`.
    pub stock: Vec<String>,
    /// Holes that take no mass: `fan 3`.
    pub taken: Vec<String>,
    /// Most weights of the stock in a plane.
    pub weights: usize,
}

/// Error of an option of holes and weights.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{option}: {found}, expected {expected}")]
pub struct OptionError {
    /// Option: `holes`, `radius`, `hole-limit`, `stock` or `taken`.
    pub option: &'static str,
    /// What was found.
    pub found: String,
    /// What is expected.
    pub expected: String,
}

/// An option with the names of the planes.
struct Entries<'a> {
    option: &'static str,
    texts: &'a [String],
    planes: &'a [String],
    /// A value as an example.
    example: &'static str,
}

impl Entries<'_> {
    fn error(&self, found: String, expected: String) -> OptionError {
        OptionError { option: self.option, found, expected }
    }

    /// Returns the error of a plane without an entry.
    fn missing(&self, plane: usize) -> OptionError {
        let (example, name) = (self.example, &self.planes[plane]);
        let found = if self.texts.is_empty() { "missing".to_owned() } else { format!("none for plane {name}") };
        self.error(found, format!("\"{example}\" for all planes, or \"{name} {example}\""))
    }

    /// Returns plane and value of each entry; no plane where it holds for those that are not named. `value` returns what is found and expected
    /// instead of a value.
    fn read<T>(&self, value: impl Fn(&str) -> Result<T, [String; 2]>) -> Result<Vec<(Option<usize>, T)>, OptionError> {
        let one = |text: &String| {
            let text = text.trim();
            // A plane may have a number for a name.
            let of_all = match value(text) {
                Ok(value) => return Ok((None, value)),
                Err(error) => error,
            };
            let rest = |name: &String| text.strip_prefix(name.as_str()).filter(|rest| rest.starts_with(' '));
            let named = self.planes.iter().enumerate().filter_map(|(plane, name)| Some((plane, rest(name)?)));
            let [found, expected] = match named.min_by_key(|(_, rest)| rest.len()) {
                None => {
                    let [found, expected] = of_all;
                    let planes = self.planes.join(", ");
                    [found, format!("{expected}, with a plane ({planes}) in front where it is not for all planes")]
                }
                Some((plane, rest)) => match value(rest.trim()) {
                    Ok(value) => return Ok((Some(plane), value)),
                    Err([found, expected]) => [format!("plane {}: {found}", self.planes[plane]), expected],
                },
            };
            Err(self.error(found, expected))
        };
        self.texts.iter().map(one).collect()
    }

    /// Returns the value of each plane, at most one.
    fn single<T: Clone>(&self, value: impl Fn(&str) -> Result<T, [String; 2]>) -> Result<Vec<Option<T>>, OptionError> {
        let mut of_all = None;
        let mut own = vec![None; self.planes.len()];
        for (plane, value) in self.read(value)? {
            let before = plane.map_or(&mut of_all, |plane| &mut own[plane]).replace(value);
            if before.is_some() {
                let of = plane.map_or("all planes".to_owned(), |plane| format!("plane {}", self.planes[plane]));
                return Err(self.error(format!("two values for {of}"), "one".to_owned()));
            }
        }
        Ok(own.into_iter().map(|own| own.or_else(|| of_all.clone())).collect())
    }

    /// Returns the value of each plane.
    fn of_each<T: Clone>(&self, value: impl Fn(&str) -> Result<T, [String; 2]>) -> Result<Vec<T>, OptionError> {
        let found = self.single(value)?.into_iter().enumerate();
        found.map(|(plane, value)| value.ok_or_else(|| self.missing(plane))).collect()
    }
}

/// Reads a quantity above 0.
fn positive(text: &str, dimension: Dimension) -> Result<f64, [String; 2]> {
    let value = parse(text, dimension).map_err(|mismatch| [mismatch.found, mismatch.expected])?;
    if value > 0.0 {
        return Ok(value);
    }
    Err([format!("out of range: \"{}\"", printable(text)), dimension.expected("above 0")])
}

/// Reads a number of holes, and the angle of the first one in rad.
fn holes(text: &str) -> Result<(usize, f64), [String; 2]> {
    let (count, first) = text.split_once(" from ").map_or((text, None), |(count, first)| (count, Some(first)));
    let Some(count) = count.trim().parse().ok().filter(|count: &u16| *count >= LEAST_HOLES) else {
        let expected = format!("{LEAST_HOLES} holes or more, such as \"16\" or \"16 from 15 deg\"");
        return Err([format!("\"{}\"", printable(text)), expected]);
    };
    let first = first.map_or(Ok(0.0), |first| parse(first.trim(), Dimension::Angle));
    Ok((count.into(), first.map_err(|mismatch| [mismatch.found, mismatch.expected])?))
}

/// Reads a weight such as `0.8 g`, or `3 x 0.8 g` of which there are three.
fn weight(text: &str) -> Result<Weight, [String; 2]> {
    let expected = || format!("{}, or with a number as \"3 x 0.8 g\"", Dimension::Mass.expected("above 0"));
    let (count, mass) = text.split_once(" x ").map_or((None, text), |(count, mass)| (Some(count), mass));
    let count = match count.map(|count| count.trim().parse::<usize>().ok().filter(|count| *count > 0)) {
        Some(None) => {
            let expected = "a number of weights above 0, such as \"3 x 0.8 g\"".to_owned();
            return Err([format!("\"{}\"", printable(text)), expected]);
        }
        count => count.flatten(),
    };
    let mass = positive(mass.trim(), Dimension::Mass).map_err(|[found, _]| [found, expected()])?;
    Ok(Weight { mass, count })
}

impl HoleOptions {
    /// Returns holes and weights of these planes; `None` where no option is given.
    ///
    /// # Errors
    /// Returns an error for a plane or hole that is not there, an invalid value, two values for a plane, and a plane without one.
    pub fn read(&self, planes: &[String]) -> Result<Option<Holes>, OptionError> {
        let entries = |option, texts, example| Entries { option, texts, planes, example };
        let all = [&self.holes, &self.radius, &self.hole_limit, &self.stock, &self.taken];
        if all.iter().all(|texts| texts.is_empty()) {
            return Ok(None);
        }
        let counts = entries("holes", &self.holes, "16").of_each(holes)?;
        let length = |text: &str| positive(text, Dimension::Length);
        let radii = entries("radius", &self.radius, "30 mm").of_each(length)?;
        let mass = |text: &str| positive(text, Dimension::Mass);
        let limits = entries("hole-limit", &self.hole_limit, "5 g").single(mass)?;
        let (stock, kinds) = entries("stock", &self.stock, "2 g").stock()?;
        let circle = |plane: usize| {
            let (count, first) = counts[plane];
            let (radius, limit, weights) = (radii[plane], limits[plane], kinds[plane].clone());
            HoleCircle { count, radius, first, limit, taken: vec![], weights }
        };
        let mut circles: Vec<HoleCircle> = (0..planes.len()).map(circle).collect();
        for text in &self.taken {
            let [plane, hole] = taken(planes, &circles, text)?;
            circles[plane].taken.push(hole);
        }
        Ok(Some(Holes { circles, stock, most: self.weights }))
    }
}

impl Entries<'_> {
    /// Returns the weights in stock, and those that fit the holes of each plane.
    fn stock(&self) -> Result<(Vec<Weight>, Vec<Vec<usize>>), OptionError> {
        let read = self.read(weight)?;
        let of =
            |wanted: Option<usize>| -> Vec<usize> { (0..read.len()).filter(|kind| read[*kind].0 == wanted).collect() };
        let of_plane = |plane: usize| {
            let own = of(Some(plane));
            let kinds = if own.is_empty() { of(None) } else { own };
            if kinds.is_empty() && !read.is_empty() { Err(self.missing(plane)) } else { Ok(kinds) }
        };
        let kinds = (0..self.planes.len()).map(of_plane).collect::<Result<_, _>>()?;
        Ok((read.into_iter().map(|(_, weight)| weight).collect(), kinds))
    }
}

/// Reads a hole of a plane such as `fan 3`: plane and hole from 0.
fn taken(planes: &[String], circles: &[HoleCircle], text: &str) -> Result<[usize; 2], OptionError> {
    let (name, number) = text.trim().rsplit_once(' ').unwrap_or_default();
    let plane = planes.iter().position(|plane| plane == name.trim());
    let count = |plane: usize| circles[plane].count;
    let hole = number.parse().ok().zip(plane).filter(|(hole, plane)| (1..=count(*plane)).contains(hole));
    if let Some((hole, plane)) = hole {
        return Ok([plane, hole - 1]);
    }
    let (example, named) = plane.map_or((planes.first(), planes.join(", ")), |at| (planes.get(at), planes[at].clone()));
    let most = plane.map_or_else(|| circles.iter().map(|circle| circle.count).max().unwrap_or_default(), count);
    Err(OptionError {
        option: "taken",
        found: format!("unknown hole: \"{}\"", printable(text)),
        expected: format!(
            "a plane ({named}) and a hole from 1 to {most}, such as \"{} 3\"",
            example.map_or("DE", String::as_str)
        ),
    })
}

#[cfg(test)]
#[expect(clippy::unwrap_used, reason = "a test fails by panicking")]
mod tests {
    use super::*;

    fn texts(of: &[&str]) -> Vec<String> {
        of.iter().map(|text| (*text).to_owned()).collect()
    }

    fn read(holes: &[&str], radius: &[&str], others: [&[&str]; 3]) -> Result<Option<Holes>, OptionError> {
        let [hole_limit, stock, taken] = others.map(texts);
        let options = HoleOptions { holes: texts(holes), radius: texts(radius), hole_limit, stock, taken, weights: 2 };
        // Names that are the beginning of others, and of values.
        options.read(&texts(&["16", "fan", "fan B", "20 mm"]))
    }

    /// An entry with a plane holds for that plane, one without for all others; a whole value has no plane in front.
    #[test]
    fn entries_of_planes() {
        let found = read(
            &["16", "fan B 8 from 22.5 deg", "20 mm 12"],
            &["30 mm", "20 mm 40 mm", "16 0.1 m", "fan B 60 mm"],
            [&["fan 5 g"], &["2 g", "fan B 3 x 1 g", "3 x 4 g", "fan B 5 g"], &["fan B 8", "20 mm 12"]],
        );
        let found = found.unwrap().unwrap();
        let count: Vec<usize> = found.circles.iter().map(|circle| circle.count).collect();
        assert_eq!(count, [16, 16, 8, 12]);
        let radius: Vec<f64> = found.circles.iter().map(|circle| circle.radius).collect();
        assert_eq!(radius, [0.1, 0.03, 0.06, 0.04]);
        assert_eq!(found.circles[2].first, 22.5_f64.to_radians());
        assert_eq!(found.circles.iter().map(|circle| circle.limit).collect::<Vec<_>>(), [None, Some(5e-3), None, None]);
        let weights: Vec<&[usize]> = found.circles.iter().map(|circle| circle.weights.as_slice()).collect();
        assert_eq!(weights, [&[0, 2], &[0, 2], &[1, 3], &[0, 2]]);
        assert_eq!(found.stock[1], Weight { mass: 1e-3, count: Some(3) });
        assert_eq!((found.circles[2].taken.as_slice(), found.circles[3].taken.as_slice()), (&[7][..], &[11][..]));
    }

    /// Holes, radius, the other options, and words of the error.
    type Case = (&'static [&'static str], &'static [&'static str], [&'static [&'static str]; 3], &'static str);

    #[test]
    fn wrong_entries_have_one_clear_error() {
        let (holes, radius, none): (&'static [&'static str], &'static [&'static str], &'static [&'static str]) =
            (&["16"], &["30 mm"], &[]);
        let cases: [Case; 14] = [
            (&["2"], radius, [none; 3], "holes: \"2\", expected 3 holes or more"),
            (&["fan 2"], radius, [none; 3], "holes: plane fan: \"2\", expected 3 holes or more"),
            (
                &["fna 12", "16"],
                radius,
                [none; 3],
                "holes: \"fna 12\", expected 3 holes or more, such as \"16\" or \"16 from 15 deg\", with a plane (16, fan, fan B, 20 mm) in front",
            ),
            (&["fan 12"], radius, [none; 3], "holes: none for plane 16, expected \"16\" for all planes, or \"16 16\""),
            (&["16", "fan 12", "fan 8"], radius, [none; 3], "holes: two values for plane fan, expected one"),
            (&["16", "12"], radius, [none; 3], "holes: two values for all planes"),
            (&["12 from 15"], radius, [none; 3], "has no unit"),
            (holes, none, [none; 3], "radius: missing, expected \"30 mm\" for all planes"),
            (none, radius, [none; 3], "holes: missing, expected \"16\""),
            (holes, &["30 mm", "fan 3 kg"], [none; 3], "radius: plane fan: "),
            (holes, &["-30 mm"], [none; 3], "radius: out of range: \"-30 mm\", expected a length above 0"),
            (
                holes,
                radius,
                [none, &["fan 0 x 1 g"], none],
                "stock: plane fan: \"0 x 1 g\", expected a number of weights above 0",
            ),
            (holes, radius, [none, &["fan 1 g"], none], "stock: none for plane 16"),
            (
                &["16", "fan 8"],
                radius,
                [none, none, &["fan 9"]],
                "taken: unknown hole: \"fan 9\", expected a plane (fan) and a hole from 1 to 8",
            ),
        ];
        for (holes, radius, others, message) in cases {
            let error = read(holes, radius, others).unwrap_err().to_string();
            assert!(error.contains(message), "{message}: {error}");
        }
        assert_eq!(read(none, none, [none; 3]), Ok(None));
    }
}
