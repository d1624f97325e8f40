//! Figures of a fit: changes of the parameters with their intervals, and the residual at each probe before and after it.

use super::Picture;
use super::axis::{Axis, extent};
use super::canvas::{
    Anchor, BELOW, FAINT, Frame, INK, Key, MARK, MEASURED, Marker, RESIDUAL, SMALL, Stroke, TWIN, WIDE, WIDE_RIGHT,
    gutter, picture, text_width,
};
use super::line::Point;
use crate::number::shortened;
use ballrace_twin::fit::{Estimate, Fitted};

/// Height of a parameter's row, and least height of all rows.
const ROW: f64 = 17.0;
const ROWS: f64 = 90.0;
/// Longest name of a parameter or probe.
const LONGEST: usize = 28;
/// Residuals that differ by more than this are drawn on a logarithmic scale.
const WIDE_RANGE: f64 = 20.0;
const INTERVAL: Stroke = Stroke(MEASURED, 3.0);

/// Draws the change of each identifiable parameter from the scene's value in per cent, with its interval; none where every parameter
/// of the scene is 0 or not identifiable.
pub(crate) fn changes(found: &Fitted) -> Option<Picture> {
    let percent = |p: &Estimate, value: f64| 100.0 * (value - p.given) / p.given.abs();
    let is_shown = |p: &&Estimate| p.identified && p.given != 0.0 && percent(p, p.value).is_finite();
    let shown: Vec<&Estimate> = found.parameters.iter().filter(is_shown).collect();
    if shown.is_empty() {
        return None;
    }
    let ends = |p: &Estimate| [p.low, Some(p.value), p.high].map(|x| percent(p, x.unwrap_or(p.value)));
    let x = Axis::padded(extent(shown.iter().flat_map(|p| ends(p)).chain([0.0])), 7, "Change from the scene, %");
    let names: Vec<String> = shown.iter().map(|p| shortened(&p.name, LONGEST)).collect();
    let left = names.iter().map(|name| text_width(name, SMALL)).fold(60.0, f64::max) + 12.0;
    let mut y = Axis::exact(Some((0.0, shown.len() as f64)), 2, "");
    y.ticks.clear();
    let top = 28.0;
    let frame =
        Frame { start: 0.0, left, top, right: WIDE_RIGHT, bottom: top + (ROW * shown.len() as f64).max(ROWS), x, y };
    let drawing = picture((WIDE, frame.bottom + BELOW), |canvas| {
        let interval = if found.consistent { "fitted, 95 % interval" } else { "fitted" };
        canvas.legend(left, 0.0, &[(Key::Line(INTERVAL), interval)]);
        frame.axes(canvas, true);
        frame.uprights(canvas, [0.0], Stroke(MARK, 1.0));
        for (i, (p, name)) in shown.iter().zip(&names).enumerate() {
            let row = shown.len() as f64 - 0.5 - i as f64;
            canvas.text(name, (left - 6.0, frame.at(&(0.0, row)).1), Anchor::End, INK);
            let [low, value, high] = ends(p);
            frame.curve(canvas, &[(low, row), (high, row)], INTERVAL);
            frame.scatter(canvas, (name, &[(value, row)]), Marker::Dot(4.0, MEASURED));
        }
    });
    Some(Picture {
        title: "Change of the parameters".to_owned(),
        note: "Fitted value less the scene's value, over the scene's value. Parameters that are 0 in the scene or not identifiable are in \
               the table alone."
            .to_owned(),
        drawing,
        ..Picture::default()
    })
}

/// Draws the residual at each probe with the scene, after the fit, and the noise of the probe.
pub(crate) fn residuals(found: &Fitted) -> Picture {
    let all = found.residuals.iter().flat_map(|r| [r.before_um, r.after_um, r.noise_um]).filter(|x| *x > 0.0);
    let (low, high) = extent(all).unwrap_or((0.01, 1.0));
    let title = "Residual, um rms";
    let y = if high > WIDE_RANGE * low {
        Axis::decades(0.6 * low, 1.6 * high, title)
    } else {
        Axis::from_zero(Some(high), 6, title)
    };
    let left = gutter(&[&y]);
    let count = found.residuals.len().max(1) as f64;
    let mut x = Axis::exact(Some((0.0, count)), 2, "Probe");
    let room = (WIDE_RIGHT - left) / count;
    let longest = ((room / text_width("m", SMALL)) as usize).clamp(3, LONGEST);
    let name = |(i, r): (usize, &ballrace_twin::fit::Residual)| (i as f64 + 0.5, shortened(&r.probe, longest));
    x.ticks = found.residuals.iter().enumerate().map(name).collect();
    let frame = Frame { start: 0.0, left, top: 28.0, right: WIDE_RIGHT, bottom: 228.0, x, y };
    let drawing = picture((WIDE, frame.bottom + BELOW), |canvas| {
        let keys = [
            (Key::Ring(TWIN), "scene"),
            (Key::Dot(MEASURED), "fitted"),
            (Key::Line(Stroke(RESIDUAL, 1.4)), "noise of the probe"),
        ];
        canvas.legend(left, 0.0, &keys);
        frame.axes(canvas, true);
        for (i, r) in found.residuals.iter().enumerate() {
            let place = i as f64 + 0.5;
            let ends: [Point; 2] = [(place - 0.3, r.noise_um), (place + 0.3, r.noise_um)];
            frame.curve(canvas, &ends, Stroke(RESIDUAL, 1.4));
            frame.curve(canvas, &[(place, r.before_um), (place, r.after_um)], Stroke(FAINT, 1.0));
            frame.scatter(canvas, ("scene", &[(place, r.before_um)]), Marker::Ring(TWIN));
            frame.scatter(canvas, ("fitted", &[(place, r.after_um)]), Marker::Dot(3.6, MEASURED));
        }
    });
    Picture {
        title: "Residual at each probe".to_owned(),
        note: if found.errors.is_empty() {
            "Where the scene describes the machine, the fitted residual is the noise."
        } else {
            "Where the scene describes the machine, the fitted residual is the noise and what waves and unequal elements of sound bearings do."
        }
        .to_owned(),
        drawing,
        ..Picture::default()
    }
}
