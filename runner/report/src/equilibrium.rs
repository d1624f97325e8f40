//! Report of a static equilibrium: text for the terminal and HTML page.

use super::figures::{Shape, balance, mode_shapes, rotor};
use super::html::{column, rows, typeset};
use super::number::{alone, count, fixed, in_tens, with_sign};
use super::page::{self, Column, Fact, Level, Page, PageSection, Table, Verdict};
use super::text::broken;
use super::words;
use anyhow::Result;
use ballrace_twin::equilibrium::{BearingEquilibrium, EffectShare, Element, StaticEquilibrium};
use ballrace_twin::life::BearingLife;
use ballrace_twin::replay::outcome::{BearingOrders, FORCE_COMPONENTS};
use std::fmt::Write;

/// Length of the bar of the largest load, characters.
const BAR: usize = 24;
/// Largest line length of the description of the rotor, characters.
const WIDTH: usize = 80;

/// Returns the equilibrium as text for the terminal, 100 columns wide.
#[must_use]
pub fn text(settled: &StaticEquilibrium) -> String {
    let mut out = String::new();
    let rpm = settled.speed * 60.0 / std::f64::consts::TAU;
    line(&mut out, &format!("{}: equilibrium at {} rpm", settled.scene, alone(rpm)));
    if !settled.is_in_equilibrium() {
        line(&mut out, &format!("NOT IN EQUILIBRIUM: {}", unbalanced(settled)));
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
        let k: Vec<String> = (0..5).map(|i| in_tens(b.stiffness[i][i])).collect();
        line(&mut out, &format!("  stiffness     {} N/m, {} N m/rad", k[..3].join(" "), k[3..].join(" ")));
        if let Some(clearance) = &b.operating_clearance {
            line(&mut out, &format!("  clearance     {clearance}"));
        }
        life(&mut out, b);
        friction(&mut out, b);
        kinematics(&mut out, b);
        element_table(&mut out, settled, &b.name);
    }
    if let Some([pressed, limit]) = highest_pressure(settled).filter(|[pressed, limit]| pressed > limit) {
        let (found, limit) = (pressed / 1e9, limit / 1e9);
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
        for part in rotor.excess_error().iter().flat_map(|warning| broken(warning, WIDTH)) {
            line(&mut out, &part);
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

/// Returns the part of the load that is not balanced, and the directions in which nothing holds the rotor.
fn unbalanced(settled: &StaticEquilibrium) -> String {
    let directions = settled.unsupported();
    let at = if directions.is_empty() { "in some direction".to_owned() } else { directions.join(", ") };
    format!("{} % of the load is unbalanced; the rotor is unsupported {at}.", alone(settled.residual * 100.0))
}

fn line(out: &mut String, text: &str) {
    out.push_str(text);
    out.push('\n');
}

/// Writes the contact angle used for cage speed and orders, and the mean angle under load.
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

/// Returns a life, million revolutions, in words.
fn lasting(life: Option<f64>, of: &BearingLife) -> String {
    let Some(turns) = life else { return "no load".to_owned() };
    let hours = of.hours(turns).map_or_else(String::new, |hours| {
        if hours > words::LONGEST_HOURS {
            "beyond 1 000 000 h, ".to_owned()
        } else {
            format!("{} h, ", count(hours as u64))
        }
    });
    format!("{hours}{} million turns", alone(turns))
}

/// Returns the ratings of the geometry beside others, with the difference; `None` where there are no others.
fn ratings_beside(life: &BearingLife) -> Option<String> {
    let [dynamic, at_rest] = life.geometry_ratings;
    let used = [life.dynamic_rating, life.static_rating];
    let one = |name: &str, rating: f64, used: f64| {
        format!("{name} {} kN, {} %", fixed(rating / 1e3, 2), with_sign(100.0 * (rating / used - 1.0), 1))
    };
    (life.geometry_ratings != used)
        .then(|| format!("the geometry gives {}, {}", one("C", dynamic, used[0]), one("C0", at_rest, used[1])))
}

/// Writes load ratings and life of a bearing.
fn life(out: &mut String, b: &BearingEquilibrium) {
    let Some(life) = &b.life else { return };
    let kilonewtons = |load: f64| fixed(load / 1e3, 2);
    let [dynamic, at_rest] = [life.dynamic_rating, life.static_rating].map(kilonewtons);
    let source = match ratings_beside(life) {
        Some(beside) => format!("as given; {beside}"),
        None => "from the geometry (ISO 281, ISO 76)".to_owned(),
    };
    line(out, &format!("  ratings       C {dynamic} kN, C0 {at_rest} kN, {source}"));
    let reference = lasting(life.reference_life, life);
    line(out, &format!("  life L10r     {reference} by the loads of its elements (ISO/TS 16281)"));
    let load = life.equivalent_load.filter(|load| *load > 0.0).map(alone);
    if let Some(load) = load {
        line(out, &format!("  life L10      {} by P = {load} N (ISO 281)", lasting(life.basic_life, life)));
    }
    let Some(modified) = &life.modified else { return };
    let ratio = alone(modified.viscosity_ratio);
    match modified.factor {
        Some(factor) => {
            let lasts = lasting(modified.life, life);
            line(out, &format!("  life L10mr    {lasts} by a_ISO = {} with kappa = {ratio}", alone(factor)));
        }
        None => line(
            out,
            &format!("  life L10mr    not known: kappa = {ratio}, below 0.1 of ISO 281; a thicker oil is needed"),
        ),
    }
}

/// Returns a temperature in degrees Celsius.
fn celsius(kelvin: f64) -> String {
    fixed(kelvin - 273.15, 1)
}

/// Writes friction and temperatures of a bearing.
fn friction(out: &mut String, b: &BearingEquilibrium) {
    if let Some(lost) = &b.friction {
        let [all, viscous, load, spin] =
            [lost.moment, lost.viscous_moment, lost.load_moment, lost.spin_moment].map(|moment| alone(1e3 * moment));
        let (power, oil) = (alone(lost.power), alone(1e6 * lost.viscosity));
        let at = celsius(lost.temperature);
        line(
            out,
            &format!(
                "  friction      {all} N mm, {power} W: by viscosity {viscous}, by load {load}, by spin {spin} N mm"
            ),
        );
        line(out, &format!("                (Palmgren, to within a third), oil of {oil} mm^2/s at {at} degC"));
    }
    if let Some(warm) = &b.temperatures {
        let [inner, outer, housing] = [warm.inner, warm.outer, warm.housing].map(celsius);
        let [shaft, walls, oil] = [warm.through_shaft, warm.through_housing, warm.with_oil].map(alone);
        line(out, &format!("  temperatures  inner ring {inner}, outer ring {outer}, housing {housing} degC"));
        line(out, &format!("                heat: shaft {shaft}, housing {walls}, oil {oil} W"));
    }
}

fn of<'a>(settled: &'a StaticEquilibrium, name: &'a str) -> Vec<&'a Element> {
    settled.of(name).collect()
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
    for e in &elements {
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
    let pressed = |e: &&&Element| e.roller.as_ref().map_or(0.0, |roller| roller.largest_lamina_load);
    if let Some(roller) = elements.iter().max_by(|a, b| pressed(a).total_cmp(&pressed(b))) {
        pressure_along(out, roller);
    }
}

/// Largest number of lines for the pressure along a roller.
const PRESSURE_LINES: usize = 15;

/// Draws the pressure along a roller at the inner race; nothing for other elements.
fn pressure_along(out: &mut String, element: &Element) {
    let Some(roller) = element.roller.as_ref().filter(|roller| roller.largest_lamina_load > 0.0) else { return };
    let pressures = &roller.lamina_pressures;
    let most = pressures.iter().copied().fold(0.0, f64::max);
    let tilt = with_sign(roller.tilt * 1e3, 3);
    let heading = format!(
        "  pressure along roller {}, inner race, from -Z to +Z ({} laminae, largest load {} N, tilt {tilt} mrad):",
        element.number,
        pressures.len(),
        alone(roller.largest_lamina_load)
    );
    line(out, &heading);
    for lamina in shown_laminae(pressures.len()) {
        let pressure = pressures.get(lamina).copied().unwrap_or(0.0);
        let filled = if most > 0.0 { (pressure / most * BAR as f64).round() as usize } else { 0 };
        let text = format!("  {:>3} {:>6.0} MPa {}", lamina + 1, pressure / 1e6, "#".repeat(filled.min(BAR)));
        line(out, text.trim_end());
    }
}

/// Returns the laminae that are shown of `count`: the first, the last and some between, with each also that at the same distance from the other
/// end.
fn shown_laminae(count: usize) -> Vec<usize> {
    let shown = count.min(PRESSURE_LINES);
    let from_begin = |i: usize| if shown > 1 { i * (count - 1) / (shown - 1) } else { 0 };
    (0..shown).map(|i| if 2 * i < shown { from_begin(i) } else { count - 1 - from_begin(shown - 1 - i) }).collect()
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

/// Returns the peak pressure that is highest over the limit of its bearing, and that limit, Pa; none where no contact is known.
fn highest_pressure(settled: &StaticEquilibrium) -> Option<[f64; 2]> {
    let of_bearing = |bearing: &BearingEquilibrium| {
        let limit = bearing.pressure_limit?;
        let own = settled.elements.iter().filter(|element| element.bearing == bearing.name);
        let pressures = own.flat_map(|element| [element.inner_pressure, element.outer_pressure]).flatten();
        Some([pressures.fold(0.0, f64::max), limit])
    };
    let all = settled.bearings.iter().filter_map(of_bearing);
    all.max_by(|[a, of_a], [b, of_b]| (a / of_a).total_cmp(&(b / of_b)))
}

fn verdict(settled: &StaticEquilibrium) -> Verdict {
    let highest = highest_pressure(settled);
    let [found, limit] = highest.unwrap_or_default().map(|pressure| fixed(pressure / 1e9, 2));
    if !settled.is_in_equilibrium() {
        return Verdict {
            level: Level::Red,
            word: "NOT IN EQUILIBRIUM",
            sentence: unbalanced(settled),
            action: "support the rotor in the direction in which it has none, or reduce the load.".to_owned(),
        };
    }
    if highest.is_some_and(|[pressed, limit]| pressed > limit) {
        return Verdict {
            level: Level::Amber,
            word: "BEYOND YIELD",
            sentence: format!("The highest peak pressure is {found} GPa; the static limit of ISO 76 is {limit} GPa."),
            action: "reduce the load, or choose a larger bearing.".to_owned(),
        };
    }
    let pressure = if highest.is_some_and(|[pressed, _]| pressed > 0.0) {
        format!(" The highest peak pressure is {found} GPa, below the static limit of {limit} GPa (ISO 76).")
    } else {
        String::new()
    };
    Verdict {
        level: Level::Green,
        word: "IN EQUILIBRIUM",
        sentence: format!("Bearing forces and load balance to {:.0e} of the load.{pressure}", settled.residual),
        action: String::new(),
    }
}

/// Returns a self-contained HTML page.
///
/// # Errors
/// Returns an error if the page cannot be rendered.
pub fn html(settled: &StaticEquilibrium) -> Result<String> {
    let rpm = settled.speed * 60.0 / std::f64::consts::TAU;
    let loads = settled.bearings.iter().map(|b| balance(&b.name, &of(settled, &b.name))).collect();
    let mut sections = vec![PageSection::figures("Load on the elements", Shape::Wide, loads)];
    if let Some(drawing) = &settled.drawing {
        let shapes = mode_shapes(&settled.mode_shapes, drawing);
        sections.push(PageSection::figures("Rotor", Shape::Wide, shapes.into_iter().chain([rotor(drawing)]).collect()));
    }
    sections.push(PageSection::table("Displacements and forces", displacements(&settled.bearings)));
    sections.push(PageSection::table("Stiffness", stiffness(&settled.bearings)));
    if settled.bearings.iter().any(|b| b.life.is_some()) {
        sections.push(PageSection::table("Ratings and life", lives(&settled.bearings)));
    }
    if settled.bearings.iter().any(|b| b.friction.is_some()) {
        sections.push(PageSection::table("Friction and heat", frictions(&settled.bearings)));
    }
    let with_orders: Vec<&BearingEquilibrium> = settled.bearings.iter().filter(|b| b.orders.is_some()).collect();
    if !with_orders.is_empty() {
        sections.push(PageSection::table("Kinematics", orders(&with_orders)));
    }
    for b in &settled.bearings {
        let table = elements(&of(settled, &b.name));
        sections.push(PageSection::table(&format!("Elements of bearing {}", b.name), table));
    }
    if !settled.natural_frequencies_hz.is_empty() {
        let modes = settled.natural_frequencies_hz.iter().enumerate();
        let table = Table::of(
            vec![
                Column::name("Mode"),
                Column::number("Natural frequency", "Hz"),
                Column::number("Critical order", "X"),
            ],
            modes.map(|(i, hz)| {
                let order = if rpm == 0.0 { f64::NAN } else { 60.0 * hz / rpm.abs() };
                [format!("N{}", i + 1), fixed(*hz, 2), typeset(&fixed(order, 3))]
            }),
            "Undamped, at this speed. Critical order: natural frequency over the shaft's frequency.",
        );
        sections.push(PageSection::table("Natural frequencies", table));
    }
    if !settled.effects.is_empty() {
        sections.push(PageSection::table("Change when one effect is switched off", changes(&settled.effects)));
    }
    if let Some(rotor) = &settled.rotor {
        let facts = words::rotor(rotor).into_iter().map(|(name, value)| Fact::new(name, value)).collect();
        sections.push(PageSection::facts("Flexible rotor", facts));
    }
    page::render(Page {
        title: settled.scene.clone(),
        subtitle: format!("Static equilibrium at {} rpm", alone(rpm)),
        verdict: Some(verdict(settled)),
        facts: vec![
            Fact::new("Speed", format!("{} rpm", alone(rpm))),
            Fact::new("Bearings", settled.bearings.iter().map(|b| b.name.as_str()).collect::<Vec<_>>().join(", ")),
        ],
        sections,
        footer: "Axes: Z along the shaft, X and Y across it; azimuth from +X towards +Y. Displacement of the inner ring against the \
                 outer ring; force on the inner ring."
            .to_owned(),
        data: serde_json::Map::from_iter([("speed_hz".to_owned(), (rpm.abs() / 60.0).into())]),
        ..Page::default()
    })
}

fn names(bearings: &[BearingEquilibrium]) -> impl Iterator<Item = String> + use<'_> {
    bearings.iter().map(|b| b.name.clone())
}

fn displacements(bearings: &[BearingEquilibrium]) -> Table {
    let of = |value: &dyn Fn(&BearingEquilibrium) -> f64| column(bearings.iter().map(value));
    let clearance =
        |b: &BearingEquilibrium| b.operating_clearance.as_ref().map_or_else(String::new, ToString::to_string);
    let has_clearance = bearings.iter().any(|b| b.operating_clearance.is_some());
    let cells: Vec<Vec<String>> = (0..5)
        .map(|i| of(&|b| b.displacement[i] * if i < 3 { 1e6 } else { 1e3 }))
        .chain((0..5).map(|i| of(&|b| b.force[i])))
        .chain(has_clearance.then(|| bearings.iter().map(clearance).collect()))
        .collect();
    let mut heads = vec![
        Column::name("Bearing"),
        Column::number("X", "um"),
        Column::number("Y", "um"),
        Column::number("Z", "um"),
        Column::number("Tilt about X", "mrad"),
        Column::number("Tilt about Y", "mrad"),
    ];
    heads.extend(FORCE_COMPONENTS.map(|(name, unit)| Column::number(name, unit)));
    heads.extend(has_clearance.then(|| Column::words("Operating clearance")));
    Table {
        groups: vec![(1, ""), (5, "displacement"), (5, "force")],
        ..Table::of(heads, rows(names(bearings), &cells), "")
    }
}

fn stiffness(bearings: &[BearingEquilibrium]) -> Table {
    let of = |i: usize| bearings.iter().map(|b| typeset(&format!("{:.4e}", b.stiffness[i][i]))).collect();
    let heads = vec![
        Column::name("Bearing"),
        Column::number("X", "N/m"),
        Column::number("Y", "N/m"),
        Column::number("Z", "N/m"),
        Column::number("Tilt about X", "N m/rad"),
        Column::number("Tilt about Y", "N m/rad"),
    ];
    let note = "Diagonal of the tangent stiffness at the equilibrium.";
    Table::of(heads, rows(names(bearings), &(0..5).map(of).collect::<Vec<_>>()), note)
}

fn lives(bearings: &[BearingEquilibrium]) -> Table {
    let row = |b: &BearingEquilibrium| {
        let life = b.life.as_ref()?;
        let number = |x: Option<f64>| typeset(&fixed(x.unwrap_or(f64::NAN), 0));
        let hours = |turns: Option<f64>| match turns.and_then(|turns| life.hours(turns)) {
            Some(hours) if hours > words::LONGEST_HOURS => "beyond 1 000 000".to_owned(),
            hours => number(hours),
        };
        Some([
            b.name.clone(),
            number(Some(life.dynamic_rating)),
            number(Some(life.static_rating)),
            number(Some(life.reference_load)),
            hours(life.reference_life),
            hours(life.modified.and_then(|modified| modified.life)),
            number(life.equivalent_load),
            hours(life.basic_life),
        ])
    };
    let heads = vec![
        Column::name("Bearing"),
        Column::number("C", "N"),
        Column::number("C0", "N"),
        Column::number("Reference load", "N"),
        Column::number("L10r", "h"),
        Column::number("L10mr", "h"),
        Column::number("P", "N"),
        Column::number("L10", "h"),
    ];
    let note = "Ratings from the geometry (ISO 281, ISO 76) or as given. L10r from the loads of the elements (ISO/TS 16281), L10 from the equivalent load P \
                (ISO 281); both for 90 % reliability, without the influence of lubrication and contamination. L10mr has it, by a_ISO.";
    Table::of(heads, bearings.iter().filter_map(row), note)
}

fn frictions(bearings: &[BearingEquilibrium]) -> Table {
    let row = |b: &BearingEquilibrium| {
        let lost = b.friction.as_ref()?;
        let moments = [lost.viscous_moment, lost.load_moment, lost.spin_moment, lost.moment];
        let moments = moments.map(|moment| typeset(&fixed(1e3 * moment, 2)));
        let kelvin = b.temperatures.map(|warm| [warm.inner, warm.outer, warm.housing]);
        let oil = [celsius(lost.temperature), fixed(1e6 * lost.viscosity, 1)].map(|text| typeset(&text));
        let rings = kelvin.map_or([const { String::new() }; 3], |rings| rings.map(|ring| typeset(&celsius(ring))));
        let power = [typeset(&fixed(lost.power, 1))];
        Some([b.name.clone()].into_iter().chain(oil).chain(moments).chain(power).chain(rings).collect::<Vec<_>>())
    };
    let heads = vec![
        Column::name("Bearing"),
        Column::number("Oil", "degC"),
        Column::number("Viscosity", "mm^2/s"),
        Column::number("By viscosity", "N mm"),
        Column::number("By load", "N mm"),
        Column::number("By spin", "N mm"),
        Column::number("All", "N mm"),
        Column::number("Power", "W"),
        Column::number("Inner ring", "degC"),
        Column::number("Outer ring", "degC"),
        Column::number("Housing", "degC"),
    ];
    let note = "Moments by the equations of Palmgren and the spin of the balls: means over makers, to within a third. Temperatures are those \
                that friction and cooling keep, where they were sought.";
    Table {
        groups: vec![(1, ""), (2, "oil"), (4, "moment"), (1, ""), (3, "temperature")],
        ..Table::of(heads, bearings.iter().filter_map(row), note)
    }
}

fn orders(bearings: &[&BearingEquilibrium]) -> Table {
    let row = |b: &&BearingEquilibrium| {
        let used = b.orders.as_ref();
        let [cage, outer, inner, _] =
            BearingOrders::FIELDS.map(|field| typeset(&fixed(used.map_or(f64::NAN, field.value), 3)));
        let degrees = |angle: Option<f64>| typeset(&fixed(angle.map_or(f64::NAN, f64::to_degrees), 2));
        let source = if b.cage_ratio.is_some() { "cage_ratio of the scene" } else { "free contact angle" };
        [
            b.name.clone(),
            cage,
            outer,
            inner,
            source.to_owned(),
            degrees(b.contact_angle.map(|angle| angle.free)),
            degrees(b.contact_angle.and_then(|angle| angle.loaded)),
            typeset(&fixed(b.orders_under_load.as_ref().map_or(f64::NAN, |o| o.outer_race), 3)),
        ]
    };
    let [cage, outer, inner, _] = BearingOrders::FIELDS.map(|field| Column::field(&field));
    let heads = vec![
        Column::name("Bearing"),
        cage,
        outer,
        inner,
        Column::name("From"),
        Column::number("Free contact angle", "deg"),
        Column::number("Under load", "deg"),
        Column::number("Outer race by the angle under load", "X"),
    ];
    Table::of(heads, bearings.iter().map(row), "Orders per turn of the shaft, as every command uses them.")
}

fn elements(elements: &[&Element]) -> Table {
    let of = |value: &dyn Fn(&Element) -> f64| column(elements.iter().map(|e| value(e)));
    let maybe = |value: &dyn Fn(&Element) -> Option<f64>, decimals: usize| -> Vec<String> {
        elements.iter().map(|e| typeset(&fixed(value(e).unwrap_or(f64::NAN), decimals))).collect()
    };
    let mut cells = vec![
        of(&|e| e.azimuth.to_degrees()),
        of(&|e| e.inner_load),
        of(&|e| e.outer_load),
        maybe(&|e| e.inner_angle.map(f64::to_degrees), 2),
        maybe(&|e| e.outer_angle.map(f64::to_degrees), 2),
        maybe(&|e| e.inner_pressure.map(|p| p / 1e6), 0),
        maybe(&|e| e.outer_pressure.map(|p| p / 1e6), 0),
    ];
    let mut heads = vec![
        Column::name("No"),
        Column::number("Azimuth", "deg"),
        Column::number("Inner", "N"),
        Column::number("Outer", "N"),
        Column::number("Inner", "deg"),
        Column::number("Outer", "deg"),
        Column::number("Inner", "MPa"),
        Column::number("Outer", "MPa"),
    ];
    let mut groups = vec![(2, ""), (2, "load"), (2, "contact angle"), (2, "peak pressure")];
    if elements.iter().any(|e| e.outer_film > 0.0) {
        cells.extend([of(&|e| e.inner_film * 1e6), of(&|e| e.outer_film * 1e6), maybe(&|e| e.film_ratio, 1)]);
        let film = [Column::number("Inner", "um"), Column::number("Outer", "um"), Column::number("Ratio", "")];
        heads.extend(film);
        groups.push((3, "central film"));
    }
    let names = elements.iter().map(|e| e.number.to_string());
    Table { groups, ..Table::of(heads, rows(names, &cells), "") }
}

fn changes(effects: &[EffectShare]) -> Table {
    let row = |e: &EffectShare| {
        let lengths = e.displacement.iter().take(3).map(|x| typeset(&with_sign(x * 1e6, 4)));
        let shares = e.stiffness.iter().take(3).chain([&e.largest_load]).map(|x| typeset(&with_sign(x * 100.0, 2)));
        [e.effect.clone()].into_iter().chain(lengths).chain(shares).collect::<Vec<_>>()
    };
    let heads = vec![
        Column::name("Effect"),
        Column::number("X", "um"),
        Column::number("Y", "um"),
        Column::number("Z", "um"),
        Column::number("X", "%"),
        Column::number("Y", "%"),
        Column::number("Z", "%"),
        Column::number("Largest load", "%"),
    ];
    Table {
        groups: vec![(1, ""), (3, "displacement"), (3, "stiffness"), (1, "")],
        ..Table::of(heads, effects.iter().map(row), "")
    }
}
