//! The Campbell diagram: natural frequencies over speed, with the lines of one and two per turn.

use super::Picture;
use super::axis::{Axis, extent};
use super::canvas::{Dashes, FAINT, Frame, Key, MARK, MEASURED, Stroke, TWIN, gutter, picture};
use super::line::Point;
use anyhow::Result;
use ballrace_twin::campbell::{AtSpeed, Whirl};

const WIDTH: f64 = 760.0;

/// The diagram of all modes.
pub(crate) fn diagram(all: &[AtSpeed]) -> Result<Picture> {
    let x = Axis::exact(extent(all.iter().map(|at| at.speed_rpm)), 8, "Speed, rpm");
    let frequencies = all.iter().flat_map(|at| at.modes.iter().map(|m| m.frequency_hz));
    let y = Axis::from_zero(extent(frequencies).map(|range| range.1), 8, "Frequency, Hz");
    let left = gutter(&[&y]);
    let highest = all.iter().flat_map(|at| &at.modes).fold(0.0_f64, |most, m| most.max(m.frequency_hz)) * 1.08;
    let frame = Frame { start: 0.0, left, top: 34.0, right: WIDTH - 18.0, bottom: 394.0, x, y };
    let svg = picture((WIDTH, frame.bottom + 36.0), Dashes::None, |canvas| {
        let keys = [
            (Key::Dot(MEASURED), "forward"),
            (Key::Dot(TWIN), "backward"),
            (Key::Dot(MARK), "straight"),
            (Key::Line(Stroke(FAINT, 1.0)), "1X and 2X"),
        ];
        canvas.legend(left, 0.0, &keys)?;
        frame.axes(canvas, true)?;
        for order in [1.0, 2.0] {
            let line: Vec<Point> = all
                .iter()
                .map(|at| (at.speed_rpm, order * at.speed_rpm.abs() / 60.0))
                .filter(|point| point.1 <= highest)
                .collect();
            frame.curve(canvas, &line, Stroke(FAINT, 1.0))?;
        }
        for at in all {
            for mode in &at.modes {
                let (px, py) = frame.at(&(at.speed_rpm, mode.frequency_hz));
                let colour = match mode.whirl {
                    Whirl::Forward => MEASURED,
                    Whirl::Backward => TWIN,
                    Whirl::Straight => MARK,
                };
                canvas.dot(px, py, 2.0, colour)?;
            }
        }
        Ok(())
    })?;
    Ok(Picture {
        title: "Campbell diagram".to_owned(),
        note: "Linearised at rest at each speed. Where a mode crosses a line of the shaft, that speed is critical."
            .to_owned(),
        svg,
    })
}
