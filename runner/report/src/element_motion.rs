//! Motion of balls and cage of a bearing: text for the terminal and HTML page.

use super::figures::{NamedCurve, Shape, cage_orbit, over_time};
use super::number::{alone, count, fixed};
use super::page::{self, Fact, Page, PageSection};
use anyhow::Result;
use ballrace_twin::multibody::{Balance, BallMotion, CageParams, ElementMotion, Steps};
use std::fmt::Write;

/// Balls whose curves a figure has.
const MAX_BALLS: usize = 3;

/// Motion of balls and cage of one bearing.
pub struct RecordedBearing {
    /// Name in the scene.
    pub name: String,
    /// The cage.
    pub cage: CageParams,
    /// Times, s, and the motion there.
    pub samples: Vec<(f64, ElementMotion)>,
    /// Errors of the balances.
    pub balance: Balance,
}

/// Range and mean of a number.
struct Range {
    low: f64,
    mean: f64,
    high: f64,
}

impl RecordedBearing {
    /// Returns the mean of a number over the samples.
    pub fn mean(&self, of: impl Fn(&ElementMotion) -> f64) -> f64 {
        self.range(of).mean
    }

    fn range(&self, of: impl Fn(&ElementMotion) -> f64) -> Range {
        let start = Range { low: f64::INFINITY, mean: 0.0, high: f64::NEG_INFINITY };
        let count = self.samples.len().max(1) as f64;
        self.samples.iter().map(|(_, motion)| of(motion)).fold(start, |r, x| Range {
            low: r.low.min(x),
            mean: r.mean + x / count,
            high: r.high.max(x),
        })
    }

    fn over_time(&self, of: impl Fn(&ElementMotion) -> f64) -> Vec<(f64, f64)> {
        self.samples.iter().map(|(time, motion)| (*time, of(motion))).collect()
    }

    /// Returns a curve of each of the first balls.
    fn of_balls(&self, of: impl Fn(&BallMotion) -> f64) -> Vec<NamedCurve> {
        let balls = self.samples.first().map_or(0, |(_, motion)| motion.balls.len().min(MAX_BALLS));
        let curve = |j: usize| self.over_time(|motion| motion.balls.get(j).map_or(0.0, &of));
        (0..balls).map(|j| (format!("ball {}", j + 1), curve(j))).collect()
    }
}

/// Returns the largest slip speed of a ball at the inner (0) or outer (1) race, m/s.
fn largest_slip(motion: &ElementMotion, race: usize) -> f64 {
    motion.balls.iter().map(|ball| ball.slip[race].abs()).fold(0.0, f64::max)
}

/// Returns the distance of the cage's centre from that of the ring that guides it, m.
fn eccentricity(motion: &ElementMotion) -> f64 {
    motion.cage.centre[0].hypot(motion.cage.centre[1])
}

/// Returns what guides the cage, and how far its centre can move to it, mm.
fn guidance(cage: &CageParams) -> (&'static str, f64) {
    let (word, clearance) = match cage.guide() {
        Some(0) => ("inner ring", cage.land_clearance[0]),
        Some(_) => ("outer ring", cage.land_clearance[1]),
        None => ("balls", Some(cage.pocket_clearance)),
    };
    (word, 500.0 * clearance.unwrap_or(0.0))
}

/// Returns the lines for the terminal; the bearings have one sample in `every`.
#[must_use]
pub fn text(bearings: &[RecordedBearing], steps: Steps, every: u64) -> String {
    let mut out = String::new();
    for bearing in bearings {
        let slip = bearing.range(|motion| 100.0 * motion.cage_slip());
        let travel = bearing.range(|motion| 1e3 * eccentricity(motion)).high;
        let (guided_by, clearance) = guidance(&bearing.cage);
        let loss = |i: usize| alone(bearing.range(|motion| motion.loss[i]).mean);
        let largest = |race| alone(bearing.range(|motion| largest_slip(motion, race)).high);
        let Balance { energy, momentum, angular_momentum } = bearing.balance;
        let energy = energy.map_or_else(|| "not counted on moving surfaces".to_owned(), |error| format!("{error:.1e}"));
        let _ = writeln!(
            out,
            "Bearing {}, balls and cage as bodies\n  \
             cage slip     {} %, from {} to {} %; its centre up to {} of {} mm, guided by the {guided_by}\n  \
             loss          traction {} W, cage {} W, drag {} W, damping {} W\n  \
             ball slip     up to {} m/s on the inner race, {} m/s on the outer race\n  \
             balances      energy {energy}, momentum {momentum:.1e}, angular momentum {angular_momentum:.1e}",
            bearing.name,
            fixed(slip.mean, 3),
            fixed(slip.low, 3),
            fixed(slip.high, 3),
            fixed(travel, 3),
            fixed(clearance, 3),
            loss(0),
            loss(2),
            loss(3),
            loss(1),
            largest(0),
            largest(1),
        );
    }
    if every > 1 {
        let _ = writeln!(out, "Means and extremes of one in {every} samples.");
    }
    let Steps { taken, rejected, events } = steps;
    let [taken, rejected, events] = [taken, rejected, events].map(count);
    let _ =
        writeln!(out, "{taken} steps, {rejected} repeated for their error, {events} where a contact opens or closes");
    out
}

/// Returns the HTML page, one file without external references: slip, orbit of the cage, loads, losses.
///
/// # Errors
/// Returns an error if the page cannot be rendered.
pub fn html(scene: &str, bearings: &[RecordedBearing]) -> Result<String> {
    let mut facts = vec![];
    let mut sections = vec![];
    for bearing in bearings {
        let slip = bearing.range(|motion| 100.0 * motion.cage_slip());
        facts
            .push(Fact::new(&format!("{}: mean slip of the cage", bearing.name), format!("{} %", fixed(slip.mean, 3))));
        let loss = bearing.range(|motion| motion.loss.iter().sum());
        facts.push(Fact::new(&format!("{}: mean loss", bearing.name), format!("{} W", alone(loss.mean))));
        let one = |name: &str, of: &dyn Fn(&ElementMotion) -> f64| vec![(name.to_owned(), bearing.over_time(of))];
        let races = [("inner race", 0), ("outer race", 1)];
        let slips = races.map(|(name, race)| (name.to_owned(), bearing.over_time(|m| largest_slip(m, race))));
        let losses = ["traction", "damping", "cage", "drag"].iter().enumerate();
        let losses = losses.map(|(i, name)| ((*name).to_owned(), bearing.over_time(|motion| motion.loss[i])));
        let (guided_by, clearance) = guidance(&bearing.cage);
        let centre =
            bearing.samples.iter().map(|(_, motion)| (1e3 * motion.cage.centre[0], 1e3 * motion.cage.centre[1]));
        sections.push(PageSection::figures(
            &format!("Bearing {}: slip", bearing.name),
            Shape::Wide,
            vec![
                over_time("Slip of the cage against pure rolling", "%", &one("cage", &|m| 100.0 * m.cage_slip())),
                over_time("Largest slip of a ball on the races", "m/s", &slips),
                over_time("Power lost", "W", &losses.collect::<Vec<_>>()),
            ],
        ));
        sections.push(PageSection::figures(
            &format!("Bearing {}: cage", bearing.name),
            Shape::Square,
            vec![cage_orbit(&centre.collect::<Vec<_>>(), clearance, guided_by)],
        ));
        sections.push(PageSection::figures(
            &format!("Bearing {}: balls", bearing.name),
            Shape::Wide,
            vec![
                over_time("Load on the inner race", "N", &bearing.of_balls(|ball| ball.load[0])),
                over_time("Load on the outer race", "N", &bearing.of_balls(|ball| ball.load[1])),
                over_time("Force of the cage along the orbit", "N", &bearing.of_balls(|ball| ball.pocket_force)),
            ],
        ));
    }
    page::render(Page {
        title: scene.to_owned(),
        subtitle: "Balls and cage as bodies".to_owned(),
        facts,
        sections,
        footer: "Slip of the cage: how much slower it turns than in pure rolling at the contact angles of that time."
            .to_owned(),
        ..Page::default()
    })
}
