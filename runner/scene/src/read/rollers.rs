//! Keys of rollers in `[[bearing]]`.

use super::super::bearing::STEEL_DENSITY;
use super::super::table::{Node, Read, Table};
use super::super::units::Dimension;
use super::super::{Law, Model, ModelInput, RollerKind, RollerProfile, Rollers};
use super::pitch_circle::{ROLLER_DIAMETER, check_fit_on_pitch_circle, contact_angle, pitch_diameter};
use crate::model::{choice_of, models_with};
use ballrace::contact::line::roller_stiffness;

/// Keys that only rollers have.
pub(super) const ROLLERS: [&str; 5] = [ROLLER_DIAMETER, "roller_length", "kind", "laminae", "profile"];
/// Keys of balls and of their models.
const OF_BALLS: [&str; 13] = [
    "ball_diameter",
    "inner_conformity",
    "outer_conformity",
    "youngs_modulus",
    "poissons_ratio",
    "exponent",
    "axial",
    "housing_displacement",
    "outer_ring",
    "race_control",
    "friction_sharing",
    "lubricant",
    "table",
];
/// Laminae where the scene has no number: the least of ISO/TS 16281.
const LAMINAE: usize = 30;
/// Largest number of laminae.
pub(super) const MOST_LAMINAE: i64 = 1000;
/// Exponent of a line contact.
pub(super) const LINE_EXPONENT: f64 = 10.0 / 9.0;

/// `profile` as a word: straight or not.
pub(super) const PROFILES: [(&str, bool); 2] = [("iso", false), ("straight", true)];

/// Returns true for a bearing whose elements are rollers with a geometry.
pub(super) fn has_rollers(table: &Table<'_>, input: ModelInput) -> bool {
    match input {
        ModelInput::Rollers => true,
        ModelInput::Law => table.has(ROLLER_DIAMETER),
        ModelInput::Stiffness | ModelInput::ContactAngle | ModelInput::Orders => false,
    }
}

/// Rejects the keys of rollers of a bearing with other elements.
pub(super) fn check_without_rollers(table: &Table<'_>, input: ModelInput) -> Read<()> {
    // A bearing without model has a diameter of its rollers too.
    let keys = if input == ModelInput::Orders { ROLLERS.get(1..).unwrap_or_default() } else { &ROLLERS };
    let models = choice_of(models_with(|of| of.input == ModelInput::Rollers));
    table.check_without(
        keys,
        &format!("only with rollers: model = {models}, or \"lumped\" with roller_diameter; remove it"),
    )
}

/// Reads rollers of a bearing that is evaluated by `model`, with their stiffness and play.
pub(super) fn read(table: &Table<'_>, model: Model, elements: usize) -> Read<(Rollers, Law)> {
    table.check_without(&OF_BALLS, "not with rollers (roller_diameter); remove it")?;
    let diameter = table.quantity(ROLLER_DIAMETER)?;
    let length = table.quantity("roller_length")?;
    let pitch = pitch_diameter(table, (ROLLER_DIAMETER, diameter))?;
    check_fit_on_pitch_circle(table, elements, (ROLLER_DIAMETER, diameter), pitch)?;
    let (kind, contact_angle) = kind(table, model)?;
    let (laminae, profile) = profile(table, kind.profile_ratio() * diameter)?;
    let rollers = Rollers {
        kind,
        diameter,
        length,
        pitch_diameter: pitch,
        contact_angle,
        laminae,
        profile,
        density: table.optional_quantity("density")?.unwrap_or(STEEL_DENSITY),
    };
    let given = table.read("stiffness", |n| n.quantity_in(Dimension::ContactStiffness(LINE_EXPONENT)))?;
    let law = Law {
        stiffness: Some(given.unwrap_or_else(|| roller_stiffness(length))),
        exponent: LINE_EXPONENT,
        radial_play: Some(radial_play(table, contact_angle)?),
    };
    Ok((rollers, law))
}

/// Reads kind and contact angle.
fn kind(table: &Table<'_>, model: Model) -> Read<(RollerKind, f64)> {
    let angle = table.read("contact_angle", contact_angle)?;
    let default = if angle.unwrap_or(0.0) > 0.0 { RollerKind::Tapered } else { RollerKind::Cylindrical };
    let given = table.optional("kind");
    let kind = given.as_ref().map(|node| node.choice(&RollerKind::ALL)).transpose()?.unwrap_or(default);
    let radial_only = !model.properties().inclined_rollers;
    if radial_only && !kind.is_radial() {
        let models = choice_of(models_with(|of| of.inclined_rollers));
        let of = if model == Model::QuasiStaticRoller {
            "rollers in equilibrium".to_owned()
        } else {
            format!("model = \"{}\"", model.name())
        };
        let expected = format!("\"cylindrical\" or \"needle\" with {of} (others: model = {models})");
        let node = given.or_else(|| table.optional("contact_angle"));
        return Err(node.map_or_else(|| table.fail("inclined rollers", &*expected), |node| node.refuse(&*expected)));
    }
    let name = kind.name();
    match (angle, kind.is_radial()) {
        (None, true) => Ok((kind, 0.0)),
        (Some(angle), is_radial) if is_radial == (angle == 0.0) => Ok((kind, angle)),
        (Some(_), is_radial) => {
            let range = if is_radial { "0" } else { "above 0 and at most 60 deg" };
            let expected = format!("an angle: {range} with kind = \"{name}\"");
            Err(table.required("contact_angle", &expected)?.refuse(expected))
        }
        (None, false) => {
            let expected = format!("an angle above 0 and at most 60 deg with kind = \"{name}\", such as \"15 deg\"");
            Err(table.missing("contact_angle", &expected))
        }
    }
}

/// Reads number of laminae and profile; `iso` is the coefficient of ISO/TS 16281, m.
fn profile(table: &Table<'_>, iso: f64) -> Read<(usize, RollerProfile)> {
    let range = format!("a whole number from 1 to {MOST_LAMINAE} (laminae of a roller)");
    let given = table.read("laminae", |n| Ok(usize::try_from(n.integer(&range)?).unwrap_or(LAMINAE)))?;
    let Some(node) = table.optional("profile") else {
        return Ok((given.unwrap_or(LAMINAE), RollerProfile::Logarithmic(iso)));
    };
    let expected = "\"iso\", \"straight\", { coefficient = \"2.6 um\" } or a list of the profile drop of each lamina";
    if node.is_table() {
        let coefficient = node.table()?.quantity("coefficient")?;
        return Ok((given.unwrap_or(LAMINAE), RollerProfile::Logarithmic(coefficient)));
    }
    if !node.is_list() {
        let straight = node.choice(&PROFILES).map_err(|_| node.refuse(expected))?;
        let profile = if straight { RollerProfile::Straight } else { RollerProfile::Logarithmic(iso) };
        return Ok((given.unwrap_or(LAMINAE), profile));
    }
    let drops: Vec<f64> = node.list(expected)?.iter().map(Node::quantity).collect::<Read<_>>()?;
    let laminae = given.unwrap_or(drops.len());
    if drops.is_empty() || drops.len() != laminae {
        let wanted = if given.is_some() { format!("{laminae}") } else { "at least one".to_owned() };
        return Err(
            node.fail(format!("a list of {}", drops.len()), format!("a list of {wanted}: a drop of each lamina"))
        );
    }
    Ok((laminae, RollerProfile::Drops(drops)))
}

/// Reads the play; inclined rollers without one just touch both races.
fn radial_play(table: &Table<'_>, contact_angle: f64) -> Read<f64> {
    match (table.optional("radial_play"), table.optional("diametral_clearance")) {
        (Some(play), None) => play.quantity(),
        (None, Some(clearance)) => clearance.quantity().map(|clearance| 0.5 * clearance),
        (Some(_), Some(clearance)) => Err(clearance.fail(
            "both radial_play and diametral_clearance",
            "one of them: radial_play is half of diametral_clearance",
        )),
        (None, None) if contact_angle > 0.0 => Ok(0.0),
        (None, None) => {
            let expected =
                "half the diametral clearance, such as \"5 um\" (negative is preload); or diametral_clearance";
            Err(table.missing("radial_play", expected))
        }
    }
}
