//! Report of a static equilibrium: text for the terminal and HTML page.

use super::figures::{Picture, balance, mode_shapes, rotor};
use super::number::{alone, fixed, with_sign};
use super::text::broken;
use super::words;
use anyhow::Result;
use ballrace_twin::equilibrium::{BearingEquilibrium, EffectShare, Element, StaticEquilibrium};
use ballrace_twin::plant::PRESSURE_LIMIT;
use ballrace_twin::replay::outcome::BearingOrders;
use minijinja::{Environment, context};
use std::fmt::Write;

/// Template of the page, filled by [`html`].
const PAGE: &str = include_str!("page.html");
/// Number of characters of a bar.
const BAR: usize = 24;
/// Width at which the description of the rotor is broken.
const WIDTH: usize = 80;

/// Returns the equilibrium as text for the terminal, 100 columns wide.
#[must_use]
pub fn text(settled: &StaticEquilibrium) -> String {
    let mut out = String::new();
    let rpm = settled.speed * 60.0 / std::f64::consts::TAU;
    line(&mut out, &format!("{}: equilibrium at {} rpm", settled.scene, alone(rpm)));
    if !settled.is_in_equilibrium() {
        let part = settled.residual * 100.0;
        line(
            &mut out,
            &format!(
                "NOT IN EQUILIBRIUM: {part:.2e} % of the load is unbalanced; the rotor is unsupported in some direction."
            ),
        );
    }
    for b in &settled.bearings {
        let [u, v, w, thu, thv] = b.displacement;
        let [fx, fy, fz, mx, my] = b.force;
        line(&mut out, "");
        line(&mut out, &format!("Bearing {}", b.name));
        let [u, v, w] = [u, v, w].map(|x| fixed(x * 1e6, 4));
        let [thu, thv] = [thu, thv].map(|x| fixed(x * 1e3, 4));
        line(&mut out, &format!("  displacement  {u} {v} {w} um, tilt {thu} {thv} mrad"));
        let [fx, fy, fz] = [fx, fy, fz].map(|x| fixed(x, 3));
        let [mx, my] = [mx, my].map(|x| fixed(x, 4));
        line(&mut out, &format!("  force         {fx} {fy} {fz} N, moment {mx} {my} N m"));
        let k: Vec<String> = (0..5).map(|i| format!("{:.5e}", b.stiffness[i][i])).collect();
        line(&mut out, &format!("  stiffness     {} N/m, {} N m/rad", k[..3].join(" "), k[3..].join(" ")));
        if let Some(clearance) = &b.operating_clearance {
            line(&mut out, &format!("  clearance     {clearance}"));
        }
        kinematics(&mut out, b);
        element_table(&mut out, settled, &b.name);
    }
    let pressed =
        settled.elements.iter().flat_map(|e| [e.inner_pressure, e.outer_pressure]).flatten().fold(0.0, f64::max);
    if pressed > PRESSURE_LIMIT {
        let (found, limit) = (pressed / 1e9, PRESSURE_LIMIT / 1e9);
        line(
            &mut out,
            &format!("BEYOND YIELD: {found:.2} GPa of peak pressure, the static limit of ISO 76 is {limit:.1} GPa."),
        );
    }
    if let Some(rotor) = &settled.rotor {
        line(&mut out, "");
        for (name, value) in words::rotor(rotor) {
            for (i, part) in broken(&value, WIDTH).iter().enumerate() {
                let lead = if i == 0 { format!("{name}:") } else { String::new() };
                line(&mut out, &format!("{lead:<15}{part}"));
            }
        }
    }
    if !settled.natural_frequencies_hz.is_empty() {
        line(&mut out, "");
        let list: Vec<String> = settled.natural_frequencies_hz.iter().map(|f| format!("{f:.2}")).collect();
        line(&mut out, &format!("Natural frequencies, Hz: {}", list.join(", ")));
    }
    effect_table(&mut out, &settled.effects);
    line(&mut out, "");
    line(&mut out, &format!("Solved in {:.3} ms.", settled.solving_seconds * 1e3));
    out
}

fn line(out: &mut String, text: &str) {
    out.push_str(text);
    out.push('\n');
}

/// Prints the contact angle used for cage speed and orders, and the mean angle under load.
fn kinematics(out: &mut String, b: &BearingEquilibrium) {
    let per_turn = |o: &BearingOrders| {
        format!("cage {:.3}, outer race {:.3}, inner race {:.3} per turn", o.cage, o.outer_race, o.inner_race)
    };
    let Some(orders) = &b.orders else { return };
    let source = match (b.cage_ratio, b.contact_angle) {
        (Some(ratio), _) => format!("cage_ratio {ratio} of the scene"),
        (None, Some(angle)) => format!("free contact angle {:.2} deg", angle.free.to_degrees()),
        (None, None) => return,
    };
    line(out, &format!("  kinematics    {source}, used for cage speed and orders"));
    line(out, &format!("                {}", per_turn(orders)));
    let loaded = b.contact_angle.and_then(|angle| angle.loaded);
    if let Some((angle, orders)) = loaded.zip(b.orders_under_load.as_ref()) {
        line(
            out,
            &format!(
                "                mean angle under load {:.2} deg, pure rolling at this angle:",
                angle.to_degrees()
            ),
        );
        line(out, &format!("                {}", per_turn(orders)));
    }
}

fn of<'a>(settled: &'a StaticEquilibrium, name: &str) -> Vec<&'a Element> {
    settled.elements.iter().filter(|e| e.bearing == name).collect()
}

fn element_table(out: &mut String, settled: &StaticEquilibrium, name: &str) {
    let elements = of(settled, name);
    let most = elements.iter().map(|e| e.inner_load.max(e.outer_load)).fold(0.0, f64::max);
    let has_film = elements.iter().any(|e| e.outer_film > 0.0);
    let film = if has_film { "  film, um" } else { "" };
    line(out, &format!("   no azimuth       load, N     contact angle  pressure, MPa{film}"));
    line(
        out,
        &format!(
            "          deg  inner  outer    inner  outer    inner  outer{}",
            if has_film { "  in  out" } else { "" }
        ),
    );
    for e in elements {
        let degrees = |a: Option<f64>| a.map_or("-".to_owned(), |a| format!("{:.2}", a.to_degrees()));
        let mpa = |p: Option<f64>| p.map_or("-".to_owned(), |p| format!("{:.0}", p / 1e6));
        let film = if has_film {
            let ratio = e.film_ratio.map_or(String::new(), |r| format!(" ratio {r:.1}"));
            format!(" {:.2} {:.2}{ratio}", e.inner_film * 1e6, e.outer_film * 1e6)
        } else {
            String::new()
        };
        let filled = if most > 0.0 { (e.inner_load / most * BAR as f64).round() as usize } else { 0 };
        let text = format!(
            "  {:>3} {:>8.2} {:>7} {:>7} {:>7} {:>6} {:>6} {:>6}{film} {}",
            e.number,
            e.azimuth.to_degrees(),
            alone(e.inner_load),
            alone(e.outer_load),
            degrees(e.inner_angle),
            degrees(e.outer_angle),
            mpa(e.inner_pressure),
            mpa(e.outer_pressure),
            "#".repeat(filled.min(BAR))
        );
        line(out, text.trim_end());
    }
}

fn effect_table(out: &mut String, effects: &[EffectShare]) {
    if effects.is_empty() {
        return;
    }
    line(out, "");
    line(out, "Change of this equilibrium when one effect is switched off:");
    line(out, "  effect          u, v, w, um                stiffness X, Y, Z, %       largest load, %");
    for e in effects {
        let [u, v, w, ..] = e.displacement.map(|x| x * 1e6);
        let [kx, ky, kz, ..] = e.stiffness.map(|x| x * 100.0);
        let load = e.largest_load * 100.0;
        let [u, v, w] = [u, v, w].map(|x| with_sign(x, 4));
        let [kx, ky, kz, load] = [kx, ky, kz, load].map(|x| with_sign(x, 2));
        let _ = writeln!(out, "  {:<13} {u:>8} {v:>8} {w:>8}   {kx:>8} {ky:>8} {kz:>8}   {load:>8}", e.effect);
    }
}

/// Returns a self-contained HTML page.
///
/// # Errors
/// Returns an error if the template or a figure fails.
pub fn html(settled: &StaticEquilibrium) -> Result<String> {
    let mut pictures = settled.drawing.iter().map(rotor).collect::<Result<Vec<_>>>()?;
    for b in &settled.bearings {
        pictures.push(balance(&b.name, &of(settled, &b.name))?);
    }
    if let Some(drawing) = &settled.drawing {
        pictures.extend(mode_shapes(&settled.mode_shapes, drawing)?);
    }
    page(&settled.scene, "equilibrium", &pictures, &text(settled))
}

/// Returns a page of figures and preformatted text.
pub(super) fn page(scene: &str, what: &str, pictures: &[Picture], words: &str) -> Result<String> {
    let mut environment = Environment::new();
    environment.add_template("page.html", PAGE)?;
    let figures: Vec<_> = pictures
        .iter()
        .map(
            |p| context! { title => p.title.as_str(), note => p.note.as_str(), svg => minijinja::Value::from_safe_string(p.svg.clone()) },
        )
        .collect();
    Ok(environment.get_template("page.html")?.render(context! { scene, what, figures, words })?)
}
