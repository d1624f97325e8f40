//! Strongest lines of a residual that no hypothesis explains: order, bearing, precession and frame of reference.

use super::fault_figures::at_bearing;
use super::fit::Fitted;
use super::motion::C;
use super::residual::Evidence;
use ballrace_outcome::{Precession, ReferenceFrame, UnexplainedLine};
use std::f64::consts::TAU;

/// Largest number of listed lines.
const LISTED: usize = 5;
/// Lines closer than this, in orders, are one.
const APART: f64 = 0.1;
/// Distance from a harmonic, in orders, within which a line is one: the slip of a cage that is not observable moves it.
const NEAR: f64 = 0.05;

/// Returns the lines with the largest squared residual, strongest first.
pub(super) fn unexplained_lines(e: &Evidence, of: &Fitted) -> Vec<UnexplainedLine> {
    let speed = e.motion.mean_speed();
    let square = |values: &[f64]| values.iter().map(|x| x * x).sum::<f64>();
    let mut lines: Vec<(f64, usize)> =
        of.residual.chunks(2 * e.rows).enumerate().map(|(k, values)| (square(values), k)).collect();
    lines.sort_by(|a, b| b.0.total_cmp(&a.0));
    let order = |k: usize| e.transform.lines[k] / speed.abs();
    let mut strongest: Vec<usize> = vec![];
    for (_, k) in lines {
        if strongest.iter().all(|other| (order(*other) - order(k)).abs() > APART) {
            strongest.push(k);
        }
        if strongest.len() == LISTED {
            break;
        }
    }
    // The force that is missing has the opposite sign of the force that is left over; here only its size counts.
    let force = e.force(&of.spectra);
    let bearings = &e.plant.bearings;
    let is_divided = bearings.len() == 2 && bearings[0].station != bearings[1].station;
    let planes: Vec<[Vec<C>; 2]> =
        (0..if is_divided { 2 } else { 1 }).map(|b| at_bearing(e, is_divided.then_some(b), &force)).collect();
    let line = |k: usize| {
        let forces = planes.iter().enumerate().flat_map(|(b, [x, y])| {
            // The parts of F_X + i F_Y that turn in the sense of +X to +Y, and against it.
            let (counterclockwise, clockwise) = ((x[k] + C::i() * y[k]).norm(), (x[k] - C::i() * y[k]).norm());
            let [forward, backward] =
                if speed >= 0.0 { [counterclockwise, clockwise] } else { [clockwise, counterclockwise] };
            [(b, Precession::Forward, forward), (b, Precession::Backward, backward)]
        });
        let (b, precession, amplitude) = forces.max_by(|a, b| a.2.total_cmp(&b.2)).unwrap_or_default();
        let (mounted, cage) = (&bearings[b], &of.machine.bearings[b].cage);
        let (n, cage_ratio) = (mounted.elements as f64, mounted.kinematics.cage_ratio * (1.0 - cage.slip));
        let spin = mounted.kinematics.ball_ratio() * (1.0 - cage.spin_slip);
        UnexplainedLine {
            order: order(k),
            line_hz: e.transform.lines[k] / TAU,
            bearing: is_divided.then(|| bearings[b].name.clone()),
            precession,
            frame: frame(if precession == Precession::Forward { order(k) } else { -order(k) }, n, cage_ratio, spin),
            force_n: amplitude / e.transform.sum(),
        }
    };
    strongest.into_iter().map(line).collect()
}

/// Returns the frame of reference in which a line is a harmonic: of the passing of the elements over the ring that is stationary in it,
/// of their spin, or of the shaft; the nearest one decides. A line that is a harmonic in none belongs to the fixed frame.
fn frame(order: f64, n: f64, cage_ratio: f64, spin: f64) -> ReferenceFrame {
    let distance = |order: f64, first: f64| {
        let harmonic = (order / first).round();
        if harmonic == 0.0 { f64::INFINITY } else { (order - harmonic * first).abs() }
    };
    let frames = [
        (ReferenceFrame::Fixed, distance(order, n * cage_ratio)),
        (ReferenceFrame::Shaft, distance(order - 1.0, n * (1.0 - cage_ratio)).min(distance(order, 1.0))),
        (ReferenceFrame::Cage, distance(order - cage_ratio, 2.0 * spin)),
    ];
    let nearest = frames.into_iter().filter(|(_, distance)| *distance < NEAR).min_by(|a, b| a.1.total_cmp(&b.1));
    nearest.map_or(ReferenceFrame::Fixed, |(frame, _)| frame)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Nine elements, the cage at 0.4 and the elements' spin at 2.33 of the shaft speed; backward precession has negative orders.
    #[test]
    fn a_line_belongs_to_the_frame_in_which_it_is_a_harmonic() {
        let of = |order: f64| frame(order, 9.0, 0.4, 2.33);
        for harmonic in [-2.0, -1.0, 1.0, 3.0] {
            assert_eq!(of(harmonic * 3.6), ReferenceFrame::Fixed);
            assert_eq!(of(harmonic * 5.4 + 1.0), ReferenceFrame::Shaft);
            assert_eq!(of(harmonic * 4.66 + 0.4), ReferenceFrame::Cage);
        }
        assert_eq!(
            [of(1.0), of(-2.0), of(2.37)],
            [ReferenceFrame::Shaft, ReferenceFrame::Shaft, ReferenceFrame::Fixed]
        );
    }
}
