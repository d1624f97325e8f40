//! Reduction of curves to few points, and lines that are interrupted at missing readings.

/// A point in the data's units.
pub(super) type Point = (f64, f64);

/// Reduction of a curve, with the largest numbers of points that are drawn and that are stored for the script.
#[derive(Debug, Clone, Copy)]
pub(super) enum Thinning {
    /// Lowest and highest of each run of neighbours, for curves over time.
    Extremes([usize; 2]),
    /// Highest of each run, for spectra, in which only peaks count.
    Peaks([usize; 2]),
    /// Evenly spaced points, for curves in a plane; the same points are drawn and stored.
    Path(usize),
    /// All points.
    None,
}

impl Thinning {
    /// Returns the points to draw.
    pub(super) fn drawn(self, points: &[Point]) -> Vec<Point> {
        match self {
            Self::Extremes([limit, _]) => decimated(points, limit),
            Self::Peaks([limit, _]) => peaks(points, limit),
            Self::Path(limit) => thinned(points, limit),
            Self::None => points.to_vec(),
        }
    }

    /// Returns the points to store for the script.
    pub(super) fn kept(self, points: &[Point]) -> Vec<Point> {
        match self {
            Self::Extremes([_, limit]) => Self::Extremes([limit, limit]).drawn(points),
            Self::Peaks([_, limit]) if limit < points.len() => peaks(points, limit),
            Self::Path(limit) => thinned(points, limit),
            Self::Peaks(_) | Self::None => points.to_vec(),
        }
    }
}

/// Returns at most about `limit` points: the lowest and the highest of each run of neighbours, in their order.
/// The first missing value of a run remains, so that the line is interrupted there.
fn decimated(points: &[Point], limit: usize) -> Vec<Point> {
    if points.len() <= limit {
        return points.to_vec();
    }
    let run = points.len().div_ceil((limit / 2).max(1));
    points.chunks(run).flat_map(extremes).collect()
}

/// Returns the lowest, the highest and the first missing point of a run, in their order.
fn extremes(run: &[Point]) -> Vec<Point> {
    let finite = |i: &usize| run[*i].1.is_finite();
    let lowest = (0..run.len()).filter(finite).min_by(|a, b| run[*a].1.total_cmp(&run[*b].1));
    let highest = (0..run.len()).filter(finite).max_by(|a, b| run[*a].1.total_cmp(&run[*b].1));
    let missing = run.iter().position(|point| !point.1.is_finite());
    let mut kept: Vec<usize> = [lowest, highest, missing].into_iter().flatten().collect();
    kept.sort_unstable();
    kept.dedup();
    kept.into_iter().map(|i| run[i]).collect()
}

/// Returns at most `limit` points: the highest of each run. For spectra, in which only peaks count.
fn peaks(points: &[Point], limit: usize) -> Vec<Point> {
    let run = points.len().div_ceil(limit.max(1)).max(1);
    points
        .chunks(run)
        .filter_map(|run| run.iter().filter(|point| point.1.is_finite()).max_by(|a, b| a.1.total_cmp(&b.1)))
        .copied()
        .collect()
}

/// Returns about `limit` evenly spaced points with the ends of each piece. For curves in a plane.
fn thinned(points: &[Point], limit: usize) -> Vec<Point> {
    let step = points.len().div_ceil(limit.max(1)).max(1);
    let is_missing = |i: usize| points.get(i).is_none_or(|point| !point.0.is_finite() || !point.1.is_finite());
    let is_end = |i: usize| is_missing(i) != is_missing(i + 1) && i + 1 < points.len();
    let kept = (0..points.len()).filter(|&i| i.is_multiple_of(step) || is_end(i));
    kept.map(|i| points[i]).collect()
}

/// Returns the pieces between missing points.
pub(super) fn pieces(points: &[Point]) -> impl Iterator<Item = &[Point]> {
    points.split(|point| !point.0.is_finite() || !point.1.is_finite()).filter(|piece| !piece.is_empty())
}

/// Returns two columns as points; the longer one is truncated.
pub(super) fn zipped(x: &[f64], y: &[f64]) -> Vec<Point> {
    x.iter().copied().zip(y.iter().copied()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn extremes_survive() {
        let mut points: Vec<Point> = (0..10_000).map(|i| (f64::from(i), 0.0)).collect();
        points[5_001].1 = 7.0;
        points[5_002].1 = -7.0;
        let few = decimated(&points, 100);
        assert!(few.len() <= 100);
        assert!(few.contains(&(5_001.0, 7.0)) && few.contains(&(5_002.0, -7.0)));
        assert!(peaks(&points, 100).contains(&(5_001.0, 7.0)));
        assert_eq!(thinned(&points, 100).len(), 100);
    }

    #[test]
    fn missing_values_break_the_line() {
        let mut points: Vec<Point> = (0..1000).map(|i| (f64::from(i), 1.0)).collect();
        points[500].1 = f64::NAN;
        assert_eq!(pieces(&decimated(&points, 10)).count(), 2);
        let turns: Vec<Point> =
            points.iter().enumerate().map(|(i, p)| if i % 97 == 0 { (f64::NAN, f64::NAN) } else { *p }).collect();
        // Eleven pieces, of which the missing value at 500 divides one.
        assert_eq!(pieces(&Thinning::Path(50).drawn(&turns)).count(), 12);
        assert_eq!(pieces(&[]).count(), 0);
        assert!(decimated(&[], 0).is_empty() && peaks(&[], 0).is_empty() && thinned(&[], 0).is_empty());
    }
}
