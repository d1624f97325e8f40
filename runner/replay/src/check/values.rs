//! Checks of single values of a scene against each other and against the readings: mass, load, stations, noise, zero of the probes.

use super::{Implausibility, ReadingSummary};
use ballrace::Phase;
use ballrace::bearing::Bearing as _;
use ballrace_diagnosis::plausibility::range::{self, LARGEST_UNSEEN_FORCE, STANDARD_GRAVITY};
use ballrace_models::build::{BuildError, ElementContact};
use ballrace_plant::Plant;
use ballrace_scene::{Bearing, Direction, Probe, Recording, Scene};
use serde::Serialize;
use std::f64::consts::PI;

/// Density of steel, kg/m^3.
const STEEL: f64 = 7850.0;
/// Least mass of a rotor over that of a solid steel shaft of the bearings' bore between its bearings: shafts may be hollow, and of
/// light metal.
const LEAST_MASS: f64 = 0.1;
/// Largest constant load over the weight of the rotor.
const LARGEST_LOAD: f64 = 100.0;
/// Largest distance of a probe from the outermost bearing over the distance of the outermost bearings.
const LARGEST_OVERHANG: f64 = 2.0;
/// Ratio of the given noise to the whole motion of a probe beyond which they contradict each other.
const NOISE_ABOVE_MOTION: f64 = 2.0;
/// Ratio of the noise in the readings to the given one beyond which they contradict each other.
const NOISE_ABOVE_GIVEN: f64 = 30.0;
/// Fewest readings for a check of the noise.
const MIN_READINGS: u64 = 256;
/// Factor on the position that the bearings allow.
const MARGIN: f64 = 3.0;

/// Mean of a radial probe beside the positions that the bearings allow, um.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ProbeCentre {
    /// The column.
    pub column: String,
    /// Mean reading.
    pub mean_um: f64,
    /// Reading in the static equilibrium of the scene.
    pub equilibrium_um: f64,
    /// Half of the diametral clearance of the nearest bearing; none where it is not known.
    pub half_clearance_um: Option<f64>,
    /// Offset at which the mean is that of the static equilibrium.
    pub offset_um: f64,
}

/// Returns everything about the values of a scene that is not plausible.
pub(super) fn of_scene(scene: &Scene, plant: Option<&Plant>) -> Result<Vec<Implausibility>, BuildError> {
    let mut all: Vec<Implausibility> = mass(scene).into_iter().chain(load(scene)).collect();
    if let Some(plant) = plant {
        all.extend(pressures(scene, plant)?);
    }
    let probes = scene.recording.iter().flat_map(|recording| &recording.probes);
    all.extend(probes.flat_map(|probe| [overhang(scene, probe), station(scene, probe)]).flatten());
    Ok(all)
}

/// Returns everything about the readings of a recording that contradicts noise and zero of its probes.
pub(super) fn of_readings(
    (scene, recording): (&Scene, &Recording),
    plant: Option<&Plant>,
    readings: &[ReadingSummary],
) -> Vec<Implausibility> {
    let mut all: Vec<Implausibility> = readings.iter().filter_map(empty).collect();
    let pairs = || recording.probes.iter().zip(readings);
    all.extend(pairs().filter_map(|(probe, reading)| noise(probe, reading)));
    let Some(plant) = plant else { return all };
    for (largest, (probe, reading)) in range::positions(scene, plant, &recording.probes).into_iter().zip(pairs()) {
        all.extend(centre(scene, plant, (probe, reading), MARGIN * largest));
    }
    all
}

/// Returns the mean of every radial probe with readings beside the position that the bearings allow.
pub(super) fn centres(
    (scene, recording): (&Scene, &Recording),
    plant: &Plant,
    readings: &[ReadingSummary],
) -> Vec<ProbeCentre> {
    let radial = |(probe, reading): &(&Probe, &ReadingSummary)| {
        matches!(probe.direction, Direction::Radial(_)) && reading.samples > 0 && !plant.layout.is_given()
    };
    recording.probes.iter().zip(readings).filter(radial).map(|pair| probe_centre(scene, plant, pair)).collect()
}

fn probe_centre(scene: &Scene, plant: &Plant, (probe, reading): (&Probe, &ReadingSummary)) -> ProbeCentre {
    let row = plant.layout.probe_row(probe);
    let equilibrium_um = 1e6 * row.iter().zip(&plant.rest).map(|(a, q)| a * q).sum::<f64>();
    let half = nearest(scene, probe).and_then(|bearing| bearing.clearance()).map(|clearance| 0.5e6 * clearance);
    ProbeCentre {
        column: reading.column.clone(),
        mean_um: reading.mean,
        equilibrium_um,
        half_clearance_um: half,
        offset_um: reading.mean + probe.offset * 1e6 - equilibrium_um,
    }
}

fn nearest<'a>(scene: &'a Scene, probe: &Probe) -> Option<&'a Bearing> {
    let distance = |bearing: &&Bearing| (bearing.station - probe.station).abs();
    scene.bearings.iter().min_by(|a, b| distance(a).total_cmp(&distance(b)))
}

/// Returns the first and the last station of the bearings, m; none with one station.
fn span(scene: &Scene) -> Option<[f64; 2]> {
    let ends = |(low, high): (f64, f64), bearing: &Bearing| (low.min(bearing.station), high.max(bearing.station));
    let (low, high) = scene.bearings.iter().fold((f64::INFINITY, f64::NEG_INFINITY), ends);
    (low < high).then_some([low, high])
}

/// Returns the diameter of the bearing's bore, m: of the catalogue, else about that inside of two ball diameters.
fn bore(bearing: &Bearing) -> Option<f64> {
    let listed = bearing.catalogue.as_ref().map(|catalogue| catalogue.listed.entry.bore * 1e-3);
    listed.or_else(|| bearing.geometry.map(|geometry| geometry.pitch_diameter - 2.0 * geometry.ball_diameter))
}

fn mass(scene: &Scene) -> Option<Implausibility> {
    let rotor = scene.rotor.as_ref().filter(|rotor| rotor.flexible.is_none())?;
    let [low, high] = span(scene)?;
    let bore = scene.bearings.iter().filter_map(bore).fold(f64::INFINITY, f64::min);
    let shaft = STEEL * 0.25 * PI * bore * bore * (high - low);
    (shaft.is_finite() && rotor.mass < LEAST_MASS * shaft).then(|| Implausibility {
        subject: "rotor.mass".to_owned(),
        found: format!(
            "{} kg, while a steel shaft through the bearings has {} kg between them",
            short(rotor.mass),
            short(shaft)
        ),
        cause: "g and kg taken for each other".to_owned(),
        remedy: "the mass of the whole rotor, such as \"12 kg\"".to_owned(),
    })
}

fn load(scene: &Scene) -> Option<Implausibility> {
    let rotor = scene.rotor.as_ref()?;
    let [x, y, z, ..] = rotor.load;
    let (load, weight) = (x.hypot(y).hypot(z), rotor.mass * STANDARD_GRAVITY);
    (load > LARGEST_LOAD * weight).then(|| Implausibility {
        subject: "rotor.load".to_owned(),
        found: format!(
            "{} N on a rotor of {} kg, {:.0} times its weight",
            short(load),
            short(rotor.mass),
            load / weight
        ),
        cause: "N and kN, or g and kg, taken for each other".to_owned(),
        remedy: "check the units of load and mass".to_owned(),
    })
}

/// Returns an implausibility for each bearing whose static load is beyond the limit of ISO 76.
fn pressures(scene: &Scene, plant: &Plant) -> Result<Vec<Implausibility>, BuildError> {
    let mut all = Vec::new();
    for (i, (of, mounted)) in scene.bearings.iter().zip(&plant.bearings).enumerate() {
        let Some(contact) = ElementContact::of(of)? else { continue };
        let most = contact.load_limit();
        let mut loads = vec![0.0; mounted.elements];
        let (u, at) = (plant.displacement(i, &plant.rest), plant.resting(mounted, Phase::ZERO));
        mounted.bearing.element_loads(&u, &at, &mut loads);
        let found = loads.iter().copied().fold(0.0, f64::max);
        if found > most {
            all.push(Implausibility {
                subject: format!("bearing {}", of.name),
                found: format!(
                    "{} N on an element in static equilibrium, beyond {} N, the static limit of ISO 76 ({:.1} GPa)",
                    short(found),
                    short(most),
                    contact.limit() * 1e-9
                ),
                cause: "a load in another unit, a smaller bearing than that of the machine, or too large a preload"
                    .to_owned(),
                remedy: "check load, preload, clearance and size of the bearing".to_owned(),
            });
        }
    }
    Ok(all)
}

fn overhang(scene: &Scene, probe: &Probe) -> Option<Implausibility> {
    if !matches!(probe.direction, Direction::Radial(_)) || scene.system.is_some() {
        return None;
    }
    let [low, high] = span(scene)?;
    let beyond = (low - probe.station).max(probe.station - high);
    (beyond > LARGEST_OVERHANG * (high - low)).then(|| Implausibility {
        subject: format!("{}: station", probe.column),
        found: format!(
            "{} mm, while the bearings are at {} to {} mm",
            short(probe.station * 1e3),
            short(low * 1e3),
            short(high * 1e3)
        ),
        cause: "a digit too many, or another zero of the stations".to_owned(),
        remedy: "the station of the probe, from the same zero as those of the bearings".to_owned(),
    })
}

/// Returns an implausibility if the name of a column has the name of one bearing and its station is nearest to another.
fn station(scene: &Scene, probe: &Probe) -> Option<Implausibility> {
    if !matches!(probe.direction, Direction::Radial(_)) {
        return None;
    }
    let words = || probe.column.split(|c: char| !c.is_alphanumeric());
    let is_named = |bearing: &&Bearing| words().any(|word| word.eq_ignore_ascii_case(&bearing.name));
    let mut all = scene.bearings.iter().filter(is_named);
    let (named, None) = (all.next()?, all.next()) else { return None };
    let nearest = nearest(scene, probe)?;
    let distance = |bearing: &Bearing| (bearing.station - probe.station).abs();
    (distance(nearest) < distance(named)).then(|| Implausibility {
        subject: format!("{}: station", probe.column),
        found: format!(
            "{} mm is nearer to bearing {} than to {}",
            short(probe.station * 1e3),
            nearest.name,
            named.name
        ),
        cause: "exchanged stations or columns".to_owned(),
        remedy: format!("the station of the probe at {}, or of the bearing", named.name),
    })
}

fn empty(reading: &ReadingSummary) -> Option<Implausibility> {
    (reading.samples == 0).then(|| Implausibility {
        subject: reading.column.clone(),
        found: "no reading in the whole column".to_owned(),
        cause: "a channel that was not connected, or another column".to_owned(),
        remedy: "the column of the probe, or a scene without it".to_owned(),
    })
}

fn noise(probe: &Probe, reading: &ReadingSummary) -> Option<Implausibility> {
    let given = probe.noise? * 1e6;
    if reading.samples < MIN_READINGS {
        return None;
    }
    let of_readings = reading.noise?;
    let (found, cause) = if given > NOISE_ABOVE_MOTION * reading.rms {
        (
            format!("more than the whole motion, {} um rms", short(reading.rms)),
            "um and nm, or rms and range, taken for each other",
        )
    } else if of_readings > NOISE_ABOVE_GIVEN * given {
        (format!("far below the noise of the readings, about {} um rms", short(of_readings)), "another unit")
    } else {
        return None;
    };
    Some(Implausibility {
        subject: format!("{}: noise", reading.column),
        found: format!("{} um is {found}", short(given)),
        cause: cause.to_owned(),
        remedy: format!("noise = \"{} um\"", short(of_readings)),
    })
}

fn centre(
    scene: &Scene,
    plant: &Plant,
    (probe, reading): (&Probe, &ReadingSummary),
    largest: f64,
) -> Option<Implausibility> {
    let is_radial = matches!(probe.direction, Direction::Radial(_));
    if !is_radial || reading.samples == 0 || reading.mean.abs() <= largest * 1e6 {
        return None;
    }
    let ProbeCentre { mean_um, equilibrium_um, offset_um, .. } = probe_centre(scene, plant, (probe, reading));
    Some(Implausibility {
        subject: format!("{}: offset", reading.column),
        found: format!(
            "mean of {} um, while the bearings allow {} um under the static force and {LARGEST_UNSEEN_FORCE} times the loads on the rotor",
            short(mean_um),
            short(largest * 1e6)
        ),
        cause: "the gap of the probe is in the readings".to_owned(),
        remedy: format!(
            "offset = \"{offset_um:.1} um\", with the mean at {} um as in static equilibrium",
            short(equilibrium_um)
        ),
    })
}

/// Returns a number with at most four digits.
fn short(x: f64) -> String {
    if x == 0.0 || !x.is_finite() {
        return format!("{x}");
    }
    let digits = (3 - x.abs().log10().floor() as i32).clamp(0, 9) as usize;
    let text = format!("{x:.digits$}");
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
}

#[cfg(test)]
mod tests {
    use super::short;

    #[test]
    fn numbers_are_short() {
        for (x, text) in [(0.012, "0.012"), (12_000.0, "12000"), (-103.27, "-103.3"), (0.0001, "0.0001"), (6.0, "6")] {
            assert_eq!(short(x), text);
        }
    }
}
