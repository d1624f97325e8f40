//! Scales of the pictures: ranges, linear and logarithmic, and their ticks.

/// Largest value drawn; differences of larger ones would overflow.
const LARGEST: f64 = 1e12;

/// Returns the smallest and the largest finite value; `None` without a finite value.
pub(super) fn extent(values: impl IntoIterator<Item = f64>) -> Option<(f64, f64)> {
    values.into_iter().filter(|value| value.is_finite()).map(|value| value.clamp(-LARGEST, LARGEST)).fold(
        None,
        |range, value| match range {
            None => Some((value, value)),
            Some((low, high)) => Some((low.min(value), high.max(value))),
        },
    )
}

/// One axis: range, title and ticks.
#[derive(Debug, Clone)]
pub(crate) struct Axis {
    low: f64,
    high: f64,
    is_logarithmic: bool,
    /// Quantity and unit.
    pub(crate) title: String,
    /// Values of the ticks with their labels.
    pub(crate) ticks: Vec<(f64, String)>,
    /// Values of fine grid lines without a label.
    pub(crate) minor: Vec<f64>,
}

impl Axis {
    /// Creates a linear axis exactly over `range`. A range without extent is widened; `None` becomes 0 to 1.
    pub(super) fn exact(range: Option<(f64, f64)>, most: usize, title: &str) -> Self {
        let (low, high) = widened(range.unwrap_or((0.0, 1.0)));
        let ticks = linear_ticks(low, high, most);
        Self { low, high, is_logarithmic: false, title: title.to_owned(), ticks, minor: Vec::new() }
    }

    /// Creates a linear axis with a margin of 6 % above and below the data.
    pub(super) fn padded(range: Option<(f64, f64)>, most: usize, title: &str) -> Self {
        let range = range.map(|range| {
            let (low, high) = widened(range);
            let air = 0.06 * (high - low);
            (low - air, high + air)
        });
        Self::exact(range, most, title)
    }

    /// Creates a linear axis from 0 to 1.08 times `high`, or to 1.0 where `high` is not above 0.
    pub(super) fn from_zero(high: Option<f64>, most: usize, title: &str) -> Self {
        let high = high.filter(|high| *high > 0.0).map_or(1.0, |high| 1.08 * high.min(LARGEST));
        Self::exact(Some((0.0, high)), most, title)
    }

    /// Creates a logarithmic axis from `low` to `high`, at least one decade long. An invalid range becomes 0.01 to 1.
    pub(super) fn decades(low: f64, high: f64, title: &str) -> Self {
        let sound = low > 0.0 && high >= low && high.is_finite();
        let (low, high) = if sound { (low, high.max(10.0 * low)) } else { (0.01, 1.0) };
        let first = low.log10().floor() as i32;
        let last = high.log10().ceil() as i32;
        let inside = |value: &f64| *value >= 0.999 * low && *value <= 1.001 * high;
        let decades = (first..=last).map(|power| 10f64.powi(power));
        let ticks = decades.clone().filter(inside).map(|value| (value, decade_label(value))).collect();
        let minor = decades.flat_map(|decade| (2..10).map(move |n| f64::from(n) * decade)).filter(inside).collect();
        Self { low, high, is_logarithmic: true, title: title.to_owned(), ticks, minor }
    }

    /// Returns the smallest value shown.
    pub(crate) const fn low(&self) -> f64 {
        self.low
    }

    /// Returns the largest value shown.
    pub(crate) const fn high(&self) -> f64 {
        self.high
    }

    /// Returns true for a logarithmic axis.
    pub(crate) const fn is_logarithmic(&self) -> bool {
        self.is_logarithmic
    }

    /// Returns the position of a value: 0 at the low end, 1 at the high end. A value outside is clamped to the edge.
    pub(super) fn place(&self, value: f64) -> f64 {
        let share = if self.is_logarithmic {
            (value.max(self.low) / self.low).log10() / (self.high / self.low).log10()
        } else {
            (value - self.low) / (self.high - self.low)
        };
        share.clamp(0.0, 1.0)
    }

    /// Returns true for a value inside the range.
    pub(super) fn holds(&self, value: f64) -> bool {
        value >= self.low && value <= self.high
    }
}

/// Widens a range whose extent is too small for the digits of its values.
fn widened((low, high): (f64, f64)) -> (f64, f64) {
    let size = low.abs().max(high.abs());
    if high - low > 1e-9 * size && high - low > 1e-12 {
        return (low, high);
    }
    let middle = 0.5 * (low + high);
    let half = if size > 1e-9 { 0.05 * size } else { 1.0 };
    (middle - half, middle + half)
}

/// Returns ticks at multiples of 1, 2 or 5 times a power of ten, at most `most` of them.
fn linear_ticks(low: f64, high: f64, most: usize) -> Vec<(f64, String)> {
    let most = most.max(2);
    let inside = |step: f64| (high / step + 1e-6).floor() - (low / step - 1e-6).ceil() + 1.0;
    let mut step = nice((high - low) / most as f64);
    if inside(step) > most as f64 {
        step = nice(1.01 * step);
    }
    let first = (low / step - 1e-6).ceil();
    (0..most)
        .map(|n| (first + n as f64) * step)
        .take_while(|value| *value <= high + 1e-6 * step)
        .map(|value| (value, tick_label(value, step)))
        .collect()
}

/// Returns the smallest of 1, 2, 5 times a power of ten that is not below `rough`.
fn nice(rough: f64) -> f64 {
    let power = 10f64.powf(rough.log10().floor());
    let lead = rough / power;
    let lead = [1.0, 2.0, 5.0].into_iter().find(|nice| lead <= nice * 1.0001).unwrap_or(10.0);
    lead * power
}

/// Formats the label of a tick with as many decimals as the step has.
fn tick_label(value: f64, step: f64) -> String {
    if value.abs() >= 1e6 || step < 1e-6 {
        return signed(&short_power(value));
    }
    let decimals = (-step.log10().floor()).max(0.0) as usize;
    let value = if value.abs() < 1e-6 * step { 0.0 } else { value };
    signed(&format!("{value:.decimals$}"))
}

/// Formats a value in scientific notation without trailing zeros.
fn short_power(value: f64) -> String {
    let text = format!("{value:.3e}");
    match text.split_once('e') {
        Some((lead, power)) => format!("{}e{power}", lead.trim_end_matches('0').trim_end_matches('.')),
        None => text,
    }
}

/// Returns the label of a power of ten.
fn decade_label(value: f64) -> String {
    let power = value.log10().round() as i32;
    match power {
        -4..=4 => format!("{value:.*}", (-power).max(0) as usize),
        _ => signed(&format!("1e{power}")),
    }
}

/// Replaces hyphens by minus signs.
pub(super) fn signed(text: &str) -> String {
    text.replace('-', "\u{2212}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn degenerate_ranges_have_an_extent() {
        for range in [None, Some((0.0, 0.0)), Some((5.0, 5.0)), Some((1e12, 1e12)), Some((-1e12, 1e12))] {
            let axis = Axis::padded(range, 5, "um");
            assert!(axis.high > axis.low);
            assert!(axis.ticks.len() >= 2 && axis.ticks.len() < 20, "{range:?}: {:?}", axis.ticks);
            assert!((0.0..=1.0).contains(&axis.place(range.map_or(0.5, |r| r.0))));
        }
        assert_eq!(extent([f64::NAN, f64::INFINITY]), None);
    }

    #[test]
    fn ticks_are_round() {
        let labels = |axis: &Axis| axis.ticks.iter().map(|tick| tick.1.clone()).collect::<Vec<_>>().join(" ");
        assert_eq!(labels(&Axis::exact(Some((-1.2, 1.3)), 5, "")), "\u{2212}1.0 \u{2212}0.5 0.0 0.5 1.0");
        assert_eq!(labels(&Axis::exact(Some((0.0, 813.0)), 8, "")), "0 200 400 600 800");
        assert_eq!(labels(&Axis::decades(0.002, 20.0, "")), "0.01 0.1 1 10");
    }

    #[test]
    fn logarithms_survive_zero() {
        for (low, high) in [(0.0, 0.0), (f64::NAN, 1.0), (1.0, 0.0), (1e-300, 1e-300)] {
            let axis = Axis::decades(low, high, "um");
            assert!(axis.place(0.0) == 0.0 && axis.place(f64::MAX) == 1.0);
        }
    }
}
