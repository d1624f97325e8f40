//! Masses from vibration vectors: text for the terminal, and the table of blind conditions.

use super::figures::{self, Picture, Shape};
use super::number::fixed;
use super::page::{self, Column, Page, PageSection, Row, Table};
use anyhow::Result;
use ballrace_twin::balance::{
    Agreement, Balance, Departure, HoleMass, Influence, MomentEstimate, Outlier, PlaneCorrection, Proof, Quality,
    StockChoice, Trim, TrimVector,
};
use ballrace_twin::output::cell_text;
use std::fmt::Write;

/// Condition number from which single planes are told to be known less than their sum.
const ILL_CONDITIONED: f64 = 10.0;

/// Returns the estimate as text for the terminal.
///
/// # Errors
/// Returns an error if the text cannot be formatted.
pub fn text(of: &Balance) -> Result<String> {
    let mut out = String::new();
    let unit = &of.unit;
    writeln!(out, "INFLUENCE COEFFICIENTS, {unit} per g mm; angles in degrees")?;
    write!(out, "{:<12} {:>8} {:>18}", "probe", "rpm", "no added mass")?;
    for plane in &of.planes {
        write!(out, " {plane:>26}")?;
    }
    writeln!(out, " {:>10} {:>10}", "drift", "error")?;
    for Influence { probe, speed_rpm, baseline: [size, angle], coefficients, drift, error, .. } in &of.influence {
        write!(out, "{probe:<12} {speed_rpm:>8.1} {size:>10.4} at {angle:>4.0}")?;
        for [size, angle, deviation] in coefficients {
            write!(out, " {size:>9.6} +-{deviation:<8.6} {angle:>4.0}")?;
        }
        writeln!(out, " {drift:>10.4} {error:>10.4}")?;
    }
    match of.drift_time_s {
        Some(time) => writeln!(out, "The vectors drift; a drift is lost within {}.", duration(time))?,
        // A recording has no time of day.
        None if of.twin.is_some() => {}
        None => writeln!(
            out,
            "The runs have no times: each condition is taken to have drifted on its own. Times narrow the intervals where the drift is slow."
        )?,
    }
    if let Some(twin) = &of.twin {
        writeln!(out, "{}", agreement(twin))?;
    }
    writeln!(out, "{}", proof(&of.proof))?;
    if !of.conditions.is_empty() {
        writeln!(out, "\nMASSES OF THE BLIND CONDITIONS, with 95 % intervals")?;
        for condition in &of.conditions {
            for (plane, moment) in of.planes.iter().zip(&condition.planes) {
                writeln!(out, "{:<12} {plane:<8} {}", condition.condition, described(moment))?;
            }
            if condition.misfit > MISFIT {
                writeln!(
                    out,
                    "{:<12} no masses on these planes explain its vectors: {:.1} times what drift and errors leave",
                    condition.condition, condition.misfit
                )?;
            }
        }
    }
    if let Some(trim) = &of.trim {
        of_trim(&mut out, of, trim)?;
    }
    correction(&mut out, of)?;
    if let Some(quality) = &of.quality {
        of_quality(&mut out, quality)?;
    }
    Ok(out)
}

/// Returns how well known conditions are estimated.
fn proof(of: &Proof) -> String {
    if of.moments == 0 {
        return "No proof: with one known condition less, the others do not tell coefficients and errors. Repeat the baseline or add a trial."
            .to_owned();
    }
    format!(
        "Proof: each known condition estimated from the others: mean error {:.2} g mm (largest {:.2}) and {:.1} deg; {} of {} intervals hold \
         the true moment.",
        of.mean_error_g_mm, of.largest_error_g_mm, of.mean_angle_error_deg, of.inside, of.moments
    )
}

/// Returns what the twin adds to the estimate.
fn agreement(of: &Agreement) -> String {
    let far =
        of.misfit.map_or_else(String::new, |misfit| format!(" ({misfit:.1} times what its errors and theirs allow)"));
    match (of.used, of.has_trials, of.misfit) {
        (false, ..) => format!(
            "The trials disagree with the twin of the scene{far}: its coefficients are not used. Check masses, angles and planes of the trials, or \
             the scene."
        ),
        (true, true, _) => "The coefficients are those of the twin of the scene and of the trials together.".to_owned(),
        (true, false, Some(misfit)) if misfit > 1.0 => format!(
            "The coefficients are those of the twin of the scene. Its unbalance on these planes does not explain the vectors{far}: a bow, a \
             coupling, run-out, other planes, or a scene that is not this machine. A trial tells."
        ),
        (true, false, _) => "The coefficients are those of the twin of the scene alone, with the uncertainty of its parameters. A trial narrows the intervals."
            .to_owned(),
    }
}

/// Returns the grades before and after the correction.
fn grades(of: &Quality) -> String {
    let verdict = if of.after_high <= of.grade {
        "within"
    } else if of.after <= of.grade {
        "expected to be within"
    } else {
        "not within"
    };
    format!(
        "Before G {:.2}, with the correction G {:.2}, at most G {:.2} (95 %): {verdict} G {}.",
        of.before, of.after, of.after_high, of.grade
    )
}

fn of_quality(out: &mut String, of: &Quality) -> Result<()> {
    writeln!(
        out,
        "\nBALANCE QUALITY by ISO 21940-11: G {} of {:.2} kg at {:.0} rpm permits {:.1} g mm",
        of.grade, of.mass_kg, of.speed_rpm, of.permissible_g_mm
    )?;
    writeln!(out, "{:<12} {:>10} {:>10} {:>10} {:>10}   g mm", "plane", "permitted", "before", "after", "at most")?;
    for plane in &of.planes {
        writeln!(
            out,
            "{:<12} {:>10.1} {:>10.1} {:>10.1} {:>10.1}",
            plane.plane, plane.permissible_g_mm, plane.before_g_mm, plane.after_g_mm, plane.after_high_g_mm
        )?;
    }
    writeln!(out, "{}", grades(of))?;
    Ok(())
}

/// Share of a moment that masses in holes leave, from which other weights are needed.
const LEFT: f64 = 0.1;
/// Ratio of what moments leave to what is expected, from which they do not explain the vectors.
const MISFIT: f64 = 3.0;

fn described(of: &MomentEstimate) -> String {
    if of.moment_low > 0.0 {
        format!(
            "{:>6.1} g mm ({:.1} to {:.1}) at {:>5.1} deg ({:.1} to {:.1})",
            of.moment_g_mm, of.moment_low, of.moment_high, of.angle_deg, of.angle_low, of.angle_high
        )
    } else if of.loaded < 0.5 {
        format!(" empty, or at most {:.1} g mm", of.moment_high)
    } else {
        format!("{:>6.1} g mm (0 to {:.1}) about {:.0} deg, or empty", of.moment_g_mm, of.moment_high, of.angle_deg)
    }
}

/// Returns the half of the 95 % interval of the angle of a correction, deg; none where the moment may have any angle.
fn angle_error(of: &PlaneCorrection) -> Option<f64> {
    let share = 2.0 * of.deviation_g_mm / of.moment_g_mm;
    (share < 1.0).then(|| share.asin().to_degrees())
}

/// Share of a moment beyond which its interval leaves more of the unbalance than a first balancing should.
const KNOWN: f64 = 0.5;

/// Returns a sentence where a correction is hardly known.
fn hardly_known(of: &Balance) -> Option<String> {
    if of.trim.is_some() {
        let is_shown = |one: &PlaneCorrection| one.moment_g_mm > 2.0 * one.deviation_g_mm;
        let is_done = !of.correction.replaces && !of.correction.planes.iter().any(is_shown);
        return is_done.then(|| {
            "The next moments lie within their intervals: these runs do not show that further masses lower the vibration."
                .to_owned()
        });
    }
    let is_vague = |one: &&PlaneCorrection| one.moment_g_mm > 0.0 && 2.0 * one.deviation_g_mm > KNOWN * one.moment_g_mm;
    let planes: Vec<&str> = of.correction.planes.iter().filter(is_vague).map(|one| one.plane.as_str()).collect();
    (!planes.is_empty()).then(|| {
        format!(
            "The moment of {} is known to no better than half of itself: make a trial with a mass of this size before you rely on it.",
            planes.join(", ")
        )
    })
}

/// Returns the moments that stay mounted as text.
fn mounted(of: &Balance, trim: &Trim) -> String {
    let is_loaded = |(_, [moment, _]): &(&String, &[f64; 2])| *moment > 0.0;
    let loaded = of.planes.iter().zip(&trim.mounted).filter(is_loaded);
    let texts: Vec<String> =
        loaded.map(|(plane, [moment, angle])| format!("{plane} {moment:.1} g mm at {angle:.1} deg")).collect();
    if texts.is_empty() { "no masses".to_owned() } else { texts.join(", ") }
}

/// Returns whether the vectors of a trim run are those that the other runs expect.
fn trim_agreement(of: &Trim) -> String {
    match of.misfit {
        None => "The other runs do not tell what to expect of the mounted masses.".to_owned(),
        Some(misfit) if misfit > 1.0 => format!(
            "The vectors of {} are {misfit:.1} times as far from the expected ones as errors allow: other masses or angles than stated, or a machine \
             that has changed. Its vectors count; check the masses, or repeat the trials.",
            of.condition
        ),
        Some(_) => {
            format!(
                "The vectors of {} are those that the other runs expect. They improve the coefficients.",
                of.condition
            )
        }
    }
}

fn of_trim(out: &mut String, of: &Balance, trim: &Trim) -> Result<()> {
    writeln!(out, "\nTRIM RUN {}, mounted: {}", trim.condition, mounted(of, trim))?;
    writeln!(out, "{:<12} {:>8} {:>10} {:>21} {:>10}", "probe", "rpm", "no masses", "expected", "measured")?;
    for one in &trim.vectors {
        let expected =
            one.expected.map_or_else(String::new, |[size, _, deviation]| format!("{size:.4} +-{:.4}", 2.0 * deviation));
        let without = without_masses(of, one).map_or(f64::NAN, |influence| influence.baseline[0]);
        writeln!(
            out,
            "{:<12} {:>8.1} {without:>10.4} {expected:>21} {:>10.4} {}",
            one.probe, one.speed_rpm, one.measured[0], of.unit
        )?;
    }
    writeln!(out, "{}", trim_agreement(trim))?;
    Ok(())
}

/// Returns the channel of a vector of a trim run.
fn without_masses<'a>(of: &'a Balance, vector: &TrimVector) -> Option<&'a Influence> {
    of.influence.iter().find(|one| one.probe == vector.probe && one.speed_rpm == vector.speed_rpm)
}

/// Returns of which rotor the correction is.
fn state(of: &Balance) -> String {
    match &of.trim {
        None => "of the rotor without added masses".to_owned(),
        Some(trim) if of.correction.replaces => {
            format!("instead of the masses of {}, which are taken off", trim.condition)
        }
        Some(trim) => format!("beside the masses of {}, which stay", trim.condition),
    }
}

/// Returns what a choice of weights of the stock adds.
fn stock(of: &StockChoice, unit: &str) -> String {
    let StockChoice { choices, added, bound } = of;
    let best = if bound < added {
        format!("no choice adds less than {bound:.4}")
    } else {
        "no other choice adds less".to_owned()
    };
    format!(
        "The weights of the stock add {added:.4} {unit} (rms of all vectors) to what the exact moments would leave; of up to {choices} choices a plane, {best}."
    )
}

fn correction(out: &mut String, of: &Balance) -> Result<()> {
    writeln!(out, "\nCORRECTION {}", state(of))?;
    let removes = of.correction.removes;
    for one in &of.correction.planes {
        let PlaneCorrection { plane, moment_g_mm, deviation_g_mm, left_g_mm, .. } = one;
        let error = 2.0 * deviation_g_mm;
        let verb = if removes { "remove" } else { "add" };
        write!(out, "{plane:<12} {verb} {moment_g_mm:.1} +-{error:.1} g mm at {:.1}", placed_angle(one, removes))?;
        if let Some(error) = angle_error(one) {
            write!(out, " +-{error:.1}")?;
        }
        let masses = in_holes(one, removes);
        writeln!(out, " deg{}{masses}", if masses.is_empty() { "" } else { ": " })?;
        if *left_g_mm > LEFT * moment_g_mm && left_g_mm > deviation_g_mm {
            writeln!(out, "{:<12} these masses leave {left_g_mm:.1} g mm: others are needed", "")?;
        }
    }
    for sentence in sentences(of) {
        writeln!(out, "{sentence}")?;
    }
    writeln!(out, "{:<12} {:>8} {:>10} {:>18}", "probe", "rpm", "before", "after, expected")?;
    for one in &of.correction.predicted {
        writeln!(
            out,
            "{:<12} {:>8.1} {:>10.4} {:>9.4} +-{:.4} {}",
            one.probe,
            one.speed_rpm,
            one.before,
            one.after,
            2.0 * one.deviation,
            of.unit
        )?;
    }
    Ok(())
}

/// Returns what is to be known of the correction beside its masses.
fn sentences(of: &Balance) -> Vec<String> {
    let not_observed = (of.correction.not_observed > 0).then(|| {
        format!(
            "{} of {} combinations of the planes move the probes less than drift and errors do: they stay 0.",
            of.correction.not_observed,
            of.planes.len()
        )
    });
    let stock = of.correction.stock.as_ref().map(|choice| stock(choice, &of.unit));
    let holes = circles(&of.correction.planes);
    let outliers = of.outliers.iter().map(|one| outlier(one, &of.unit));
    holes
        .into_iter()
        .chain(outliers)
        .chain(of.departure.as_ref().map(departure))
        .chain(not_shown(&of.correction.planes))
        .chain(hardly_known(of))
        .chain(stock)
        .chain(not_observed)
        .chain(ill_conditioned(of))
        .collect()
}

/// Returns a sentence with the holes of each plane; none where masses are placed at any angle.
fn circles(planes: &[PlaneCorrection]) -> Option<String> {
    let one =
        |one: &PlaneCorrection| one.circle.as_ref().map(|circle| format!("{} {}", one.plane, figures::circle(circle)));
    let all: Vec<String> = planes.iter().filter_map(one).collect();
    (!all.is_empty()).then(|| format!("Holes: {}.", all.join("; ")))
}

/// Returns a sentence on a record that is not used.
fn outlier(of: &Outlier, unit: &str) -> String {
    format!(
        "Record {} of {} is not used: at {} and {:.0} rpm it is {:.3} {unit} from the mean of the others, {:.1} of its deviations; record it again.",
        of.record,
        of.condition,
        of.probe,
        of.speed_rpm,
        of.distance,
        of.distance / of.deviation
    )
}

/// Returns a sentence on planes whose masses no probe shows.
fn not_shown(planes: &[PlaneCorrection]) -> Option<String> {
    let not_shown: Vec<&str> = planes.iter().filter(|one| !one.observed).map(|one| one.plane.as_str()).collect();
    (!not_shown.is_empty()).then(|| {
        format!(
            "The probes do not show the masses of {} above drift and errors: make a trial with a larger mass there, and check that it was mounted.",
            not_shown.join(", ")
        )
    })
}

/// Returns a sentence on a condition that departs from the others.
fn departure(of: &Departure) -> String {
    format!(
        "The vectors of {} are {:.1} times as far from those that the other runs expect as errors allow: check its masses, angles and probes, or \
         repeat it.",
        of.condition, of.misfit
    )
}

/// Returns a sentence where the planes act alike.
fn ill_conditioned(of: &Balance) -> Option<String> {
    (of.condition_number > ILL_CONDITIONED).then(|| {
        format!(
            "The planes act alike on these probes (condition number {:.0}): the sum of their moments is known better than each.",
            of.condition_number
        )
    })
}

fn duration(seconds: f64) -> String {
    if seconds < 120.0 {
        format!("{seconds:.0} s")
    } else if seconds < 7200.0 {
        format!("{:.0} min", seconds / 60.0)
    } else {
        format!("{:.1} h", seconds / 3600.0)
    }
}

/// Returns the masses in holes as text.
fn in_holes(of: &PlaneCorrection, removes: bool) -> String {
    let side = if removes { "from" } else { "in" };
    let one = |one: &HoleMass| format!("{:.2} g {side} hole {} ({:.1} deg)", one.mass_g, one.hole, one.angle_deg);
    of.holes.iter().map(one).collect::<Vec<_>>().join(", ")
}

/// Returns the HTML page, one file without external references, for the shop: the masses to place with a drawing of each plane, the trim run,
/// polar plots of the vectors, the balance quality.
///
/// # Errors
/// Returns an error if the page cannot be rendered.
pub fn html(name: &str, of: &Balance) -> Result<String> {
    let removes = of.correction.removes;
    let mut corrections = Table {
        columns: vec![
            Column::name("Plane"),
            Column::number(if removes { "Moment to remove" } else { "Moment to add" }, "g mm"),
            Column::number("Plus or minus", "g mm"),
            Column::number("Angle", "deg"),
            Column::number("Plus or minus", "deg"),
            Column::words("Holes"),
        ],
        ..Table::default()
    };
    for plane in &of.correction.planes {
        corrections.push(Row::new([
            plane.plane.clone(),
            fixed(plane.moment_g_mm, 1),
            fixed(2.0 * plane.deviation_g_mm, 1),
            fixed(placed_angle(plane, removes), 1),
            fixed(angle_error(plane).unwrap_or(f64::NAN), 1),
            in_holes(plane, removes),
        ]));
    }
    let plane = |one: &PlaneCorrection| figures::plane(one, placed_angle(one, removes));
    let planes: Vec<Picture> = of.correction.planes.iter().map(plane).collect();
    let predicted = of.correction.predicted.iter().map(|one| figures::correction(one, &of.unit)).collect();
    let mut sections = vec![
        PageSection { note: format!("Correction {}.", state(of)), ..PageSection::table("Correction", corrections) },
        PageSection::figures(if removes { "Masses to remove" } else { "Masses to add" }, Shape::Square, planes),
    ];
    if let Some(trim) = &of.trim {
        let one = |one: &TrimVector| Some(figures::trim(one, without_masses(of, one)?, &of.unit));
        let vectors = trim.vectors.iter().filter_map(one).collect();
        let figures = PageSection::figures(&format!("Trim run {}", trim.condition), Shape::Square, vectors);
        sections.push(PageSection { note: format!("Mounted: {}. {}", mounted(of, trim), figures.note), ..figures });
    }
    sections.push(PageSection::figures("Vectors before and after", Shape::Square, predicted));
    if let Some(quality) = &of.quality {
        let mut planes = Table {
            columns: vec![
                Column::name("Plane"),
                Column::number("Permitted", "g mm"),
                Column::number("Before", "g mm"),
                Column::number("After", "g mm"),
                Column::number("At most", "g mm"),
            ],
            ..Table::default()
        };
        for one in &quality.planes {
            let figures = [one.permissible_g_mm, one.before_g_mm, one.after_g_mm, one.after_high_g_mm];
            let figures = figures.map(|x| fixed(x, 1));
            planes.push(Row::new(std::iter::once(one.plane.clone()).chain(figures)));
        }
        sections.push(PageSection::table("Balance quality by ISO 21940-11", planes));
    }
    let notes =
        sentences(of).into_iter().chain(of.trim.iter().map(trim_agreement)).chain(of.twin.iter().map(agreement));
    let notes = notes.chain([proof(&of.proof)]).chain(of.quality.iter().map(grades));
    sections.push(PageSection::list("Notes", notes.collect()));
    page::render(Page {
        title: name.to_owned(),
        subtitle: "Balancing".to_owned(),
        sections,
        footer: "Angles from the keyphasor mark in the direction of positive rotation. Intervals of 95 %.".to_owned(),
        ..Page::default()
    })
}

/// Returns the angle at which a moment is added or removed, degrees.
fn placed_angle(of: &PlaneCorrection, removes: bool) -> f64 {
    if removes { (of.angle_deg + 180.0) % 360.0 } else { of.angle_deg }
}

/// Returns the moments of the blind conditions as CSV, a row a condition and plane.
#[must_use]
pub fn csv(of: &Balance) -> String {
    let mut out = "condition,plane,moment_g_mm,moment_low,moment_high,angle_deg,angle_low,angle_high\n".to_owned();
    for condition in &of.conditions {
        for (plane, moment) in condition.planes.iter().enumerate() {
            let figures = [
                moment.moment_g_mm,
                moment.moment_low,
                moment.moment_high,
                moment.angle_deg,
                moment.angle_low,
                moment.angle_high,
            ];
            let figures: Vec<String> = figures.iter().map(|x| format!("{x:.3}")).collect();
            out += &format!("{},{},{}\n", cell_text(&condition.condition), plane + 1, figures.join(","));
        }
    }
    out
}

/// Returns the correction as CSV, a row a plane.
#[must_use]
pub fn correction_csv(of: &Balance) -> String {
    let mut out = "plane,moment_g_mm,deviation_g_mm,angle_deg\n".to_owned();
    for plane in &of.correction.planes {
        let figures = [plane.moment_g_mm, plane.deviation_g_mm, plane.angle_deg].map(|x| format!("{x:.3}"));
        out += &format!("{},{}\n", cell_text(&plane.plane), figures.join(","));
    }
    out
}
