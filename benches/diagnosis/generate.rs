//! Random rotors with known faults, simulated by the program.
//!
//! The ranges are those of the rotors with two ball bearings that the diagnosis is meant for: 3 to 30 kg, 1200 to 6000 rpm, 7 to
//! 12 balls. The generating scene has cage slip, cage angle and the fault; the scenes to diagnose have none of them. A tilted
//! ring is not in the scene language, so misalignment is left out.

use crate::fleet::{Fault, Fleet, HEALTHY, Recording};
use crate::program::Program;
use crate::random::Random;
use crate::site::{self, Disturbance, Site};
use std::error::Error;
use std::f64::consts::{PI, TAU};
use std::fmt::Write as _;
use std::fs;
use std::path::Path;

/// Elements, ball diameter and pitch diameter, mm.
const BEARINGS: [(usize, f64, f64); 8] = [
    (7, 6.35, 28.5),
    (8, 12.3, 52.0),
    (8, 15.081, 65.0),
    (8, 17.462, 72.5),
    (9, 7.94, 39.04),
    (9, 9.525, 46.0),
    (10, 11.1, 60.0),
    (12, 9.0, 62.0),
];
const NAMES: [&str; 2] = ["DE", "NDE"];
pub const COLUMNS: [&str; 6] = ["DE_X", "DE_Y", "NDE_X", "NDE_Y", "axial", "keyphasor"];
const DURATION: f64 = 1.5;
/// Transient that is not recorded, s.
const SETTLE: f64 = 0.6;
/// Distance of the probes from their bearing, m.
const PROBE_DISTANCE: f64 = 0.02;
/// Noise of the recordings with much noise, um.
const MUCH_NOISE: f64 = 1.0;
const MUCH_NOISE_GROUP: &str = "1 um noise";
/// A fault that moves no probe by this share of its noise (rms) is drawn again.
const SMALLEST_EFFECT: f64 = 0.5;
const DRAWS: usize = 20;
/// Gravity, m/s^2.
const GRAVITY: f64 = 9.80665;

/// One bearing of a rotor: SI units.
#[derive(Clone)]
struct Bearing {
    station: f64,
    elements: usize,
    ball_diameter: f64,
    pitch_diameter: f64,
    conformities: [f64; 2],
    clearance: f64,
    youngs_modulus: f64,
    /// Share by which the cage is slower than pure rolling, and its angle at the start.
    slip: f64,
    first_element: f64,
    /// Entries of `waviness` and `defect` in the generating scene.
    waves: Vec<String>,
    damage: Vec<String>,
}

impl Bearing {
    /// Cosine of the free contact angle.
    fn contact_cosine(&self) -> f64 {
        let groove_distance = (self.conformities[0] + self.conformities[1] - 1.0) * self.ball_diameter;
        1.0 - self.clearance / (2.0 * groove_distance)
    }

    /// Cage speed over shaft speed.
    fn cage_ratio(&self) -> f64 {
        0.5 * (1.0 - self.ball_diameter * self.contact_cosine() / self.pitch_diameter) * (1.0 - self.slip)
    }
}

/// A rotor on two bearings: SI units.
#[derive(Clone)]
struct Machine {
    name: String,
    rpm: f64,
    mass: f64,
    inertias: [f64; 2],
    damping: [f64; 2],
    load: [f64; 3],
    /// kg m, rad, m
    unbalance: [f64; 3],
    bearings: [Bearing; 2],
    probe_angle: f64,
    rate: f64,
    /// um
    noise: f64,
}

impl Machine {
    fn random(random: &mut Random, name: String) -> Self {
        let mass = random.log_between(3.0, 30.0);
        let rpm = 100.0 * random.between(12.0, 60.0).round();
        let stations = [-random.between(0.07, 0.15), random.between(0.07, 0.15)];
        let same = random.between(0.0, 1.0) < 0.6;
        let bearing = |random: &mut Random, station: f64| {
            let (elements, ball, pitch) = random.choice(&BEARINGS);
            Bearing {
                station,
                elements,
                ball_diameter: 1e-3 * ball,
                pitch_diameter: 1e-3 * pitch,
                conformities: [random.between(0.515, 0.535), random.between(0.515, 0.535)],
                clearance: 1e-6 * random.between(4.0, 20.0),
                youngs_modulus: 206e9,
                slip: 0.0,
                first_element: 0.0,
                waves: vec![],
                damage: vec![],
            }
        };
        let first = bearing(random, stations[0]);
        let second =
            if same { Bearing { station: stations[1], ..first.clone() } } else { bearing(random, stations[1]) };
        let diametral = mass * (random.between(0.23, 0.33) * (stations[1] - stations[0])).powi(2);
        let radial_load = random.between(0.0, 1.0) < 0.3;
        let weight = mass * GRAVITY;
        let axial_load = weight * random.between(0.3, 1.6) * random.choice(&[-1.0, 1.0]);
        // Product of eccentricity and speed, m/s.
        let grade = 1e-3 * random.log_between(1.8, 12.0);
        Self {
            name,
            rpm,
            mass,
            inertias: [diametral, diametral * random.between(0.13, 0.5)],
            damping: [65.0 * mass, 0.085 * mass],
            load: [0.0, if radial_load { -weight } else { 0.0 }, axial_load],
            unbalance: [grade * mass / (rpm * TAU / 60.0), random.angle(), random.between(-0.045, 0.045)],
            bearings: [first, second],
            probe_angle: random.choice(&[0.0, 45.0]),
            rate: random.choice(&[12_800.0, 25_600.0]),
            noise: random.choice(&[0.03, 0.05, 0.1]),
        }
    }

    /// Returns the machine with another slip and angle of each cage.
    fn with_cages(&self, random: &mut Random) -> Self {
        let mut machine = self.clone();
        for bearing in &mut machine.bearings {
            bearing.slip = random.between(0.0, 0.02);
            bearing.first_element = random.angle();
        }
        machine
    }

    /// Returns the machine as a rough scene describes it.
    fn rough(&self, random: &mut Random) -> Self {
        let mut rough = self.clone();
        let factor = |random: &mut Random, share: f64| random.between(1.0 - share, 1.0 + share);
        for bearing in &mut rough.bearings {
            bearing.clearance *= factor(random, 0.1);
            bearing.youngs_modulus *= factor(random, 0.05);
        }
        let damping = factor(random, 0.3);
        rough.damping = rough.damping.map(|d| d * damping);
        rough.unbalance[0] *= factor(random, 0.3);
        rough.unbalance[1] += random.between(-0.3, 0.3);
        rough
    }

    /// The scene without a recording; with the cages and faults where it generates one.
    fn scene(&self, is_generating: bool) -> String {
        let Self { name, rpm, mass, inertias: [diametral, polar], damping: [d, r], load: [x, y, z], .. } = self;
        let [moment, angle, station] = self.unbalance;
        let mut text = format!(
            "name = \"{name}\"\n[shaft]\nspeed = \"{rpm} rpm\"\n[rotor]\nmass = {mass:e}\ndiametral_inertia = {diametral:e}\n\
             polar_inertia = {polar:e}\ndamping = [{d:e}, {d:e}, {d:e}, {r:e}, {r:e}]\nload = [{x:e}, {y:e}, {z:e}, 0, 0]\n\
             unbalance = [{{ moment = \"{} g mm\", angle = {angle:e}, station = {station:e} }}]\n",
            1e6 * moment
        );
        for (bearing, name) in self.bearings.iter().zip(NAMES) {
            let Bearing { station, elements, ball_diameter, pitch_diameter, conformities: [inner, outer], .. } =
                bearing;
            _ = write!(
                text,
                "[[bearing]]\nname = \"{name}\"\nstation = {station:e}\nfacing = \"both\"\nmodel = \"angular\"\n\
                 elements = {elements}\nball_diameter = {ball_diameter:e}\npitch_diameter = {pitch_diameter:e}\n\
                 inner_conformity = {inner}\nouter_conformity = {outer}\ndiametral_clearance = {:e}\n\
                 youngs_modulus = {:e}\npoissons_ratio = 0.3\n",
                bearing.clearance, bearing.youngs_modulus
            );
            if is_generating {
                let Bearing { first_element, waves, damage, .. } = bearing;
                _ = writeln!(
                    text,
                    "cage_ratio = {}\nfirst_element_azimuth = {first_element:e}\nwaviness = [{}]\ndefect = [{}]",
                    bearing.cage_ratio(),
                    waves.join(", "),
                    damage.join(", ")
                );
            }
        }
        if is_generating {
            text += "[integration]\nstep = \"10 us\"\n";
        }
        text
    }

    /// The scene to diagnose.
    fn scene_to_diagnose(&self) -> String {
        let mut text = self.scene(false);
        _ = write!(text, "[recording]\nfile = \"{HEALTHY}.npy\"\nrate = \"{} Hz\"\nprobes = [\n", self.rate);
        for (column, (station, angle)) in COLUMNS.iter().zip(self.radial_probes()) {
            _ = writeln!(
                text,
                "  {{ column = \"{column}\", unit = \"um\", station = {station:e}, angle = \"{angle} deg\", noise = \"{} um\" }},",
                self.noise
            );
        }
        _ = write!(
            text,
            "  {{ column = \"axial\", unit = \"um\", axial = true, noise = \"{} um\" }},\n]\n\
             keyphasor = {{ column = \"keyphasor\", pulses_per_turn = 1 }}\n",
            self.noise
        );
        text
    }

    /// Station and angle (deg) of each radial probe.
    fn radial_probes(&self) -> [(f64, f64); 4] {
        let [de, nde] = [self.bearings[0].station - PROBE_DISTANCE, self.bearings[1].station + PROBE_DISTANCE];
        let [x, y] = [self.probe_angle, self.probe_angle + 90.0];
        [(de, x), (de, y), (nde, x), (nde, y)]
    }

    /// Adds a fault; returns what is true of it.
    fn add(&mut self, cause: Cause, bearing: usize, random: &mut Random) -> Fault {
        let name = Some(NAMES[bearing].to_owned());
        let mounted = &mut self.bearings[bearing];
        let of_kind = |kind: &str| Fault { kind: kind.to_owned(), bearing: name.clone(), ..Fault::default() };
        match cause {
            Cause::Unbalance => {
                self.unbalance =
                    [self.unbalance[0] * random.between(3.0, 6.0), random.angle(), random.between(-0.045, 0.045)];
                let [moment, angle, station] = self.unbalance.map(Some);
                Fault { kind: "unbalance".to_owned(), moment, angle, station, ..Fault::default() }
            }
            Cause::Worn => {
                let slip_kept = mounted.cage_ratio();
                mounted.clearance *= random.between(1.5, 2.5);
                // The cage keeps its speed.
                mounted.slip = 1.0 - slip_kept / (mounted.cage_ratio() / (1.0 - mounted.slip));
                Fault { clearance: Some(mounted.clearance), ..of_kind("clearance") }
            }
            Cause::Spall(surface) => {
                let half_width = random.between(0.02, 0.06) * if surface == Surface::Ball { 3.0 } else { 1.0 };
                let (azimuth, depth) = (random.angle(), 1e-6 * random.between(1.5, 5.0));
                mounted.damage.push(format!(
                    "{{ surface = \"{}\", azimuth = {azimuth:e}, half_width = {half_width:e}, depth = {depth:e}, shape = \"half-sine\" }}",
                    surface.name()
                ));
                let azimuth = (surface != Surface::Ball).then_some(azimuth);
                Fault { azimuth, half_width: Some(half_width), depth: Some(depth), ..of_kind(surface.kind()) }
            }
            Cause::Waviness(surface) => {
                let order = if surface == Surface::Ball {
                    // Waves of odd order keep the sum of both deflections of an element.
                    random.choice(&[2.0, 4.0, 6.0])
                } else {
                    let multiple = random.choice(&[1.0, 2.0]) * mounted.elements as f64;
                    multiple + random.choice(&[-1.0, 0.0, 1.0])
                };
                let amplitude = 1e-6 * random.between(0.15, 0.6);
                mounted.waves.push(format!(
                    "{{ surface = \"{}\", order = {order}, amplitude = {amplitude:e}, phase = {:e} }}",
                    surface.name(),
                    random.angle()
                ));
                // A scene has the radial amplitude, a diagnosis that normal to the race.
                let normal = if surface == Surface::Ball { amplitude } else { amplitude * mounted.contact_cosine() };
                Fault { order: Some(order), amplitude: Some(normal), ..of_kind(surface.kind()) }
            }
        }
    }
}

#[derive(Clone, Copy, PartialEq)]
enum Surface {
    Outer,
    Inner,
    Ball,
}

impl Surface {
    /// The surface in a scene.
    const fn name(self) -> &'static str {
        match self {
            Self::Outer => "outer",
            Self::Inner => "inner",
            Self::Ball => "ball",
        }
    }

    /// The kind of diagnosis.
    const fn kind(self) -> &'static str {
        match self {
            Self::Outer => "outer-race",
            Self::Inner => "inner-race",
            Self::Ball => "element",
        }
    }
}

#[derive(Clone, Copy)]
enum Cause {
    Unbalance,
    Worn,
    Spall(Surface),
    Waviness(Surface),
}

/// The recordings of a rotor: name, and causes with their bearing: 0 is that of the rotor's single faults, 1 the other.
const RECORDINGS: [(&str, &[(Cause, usize)]); 12] = [
    (HEALTHY, &[]),
    ("healthy-again", &[]),
    ("unbalance", &[(Cause::Unbalance, 0)]),
    ("outer-spall", &[(Cause::Spall(Surface::Outer), 0)]),
    ("inner-spall", &[(Cause::Spall(Surface::Inner), 0)]),
    ("ball-spall", &[(Cause::Spall(Surface::Ball), 0)]),
    ("outer-waviness", &[(Cause::Waviness(Surface::Outer), 0)]),
    ("inner-waviness", &[(Cause::Waviness(Surface::Inner), 0)]),
    ("worn", &[(Cause::Worn, 0)]),
    ("unbalance-and-inner-spall", &[(Cause::Unbalance, 0), (Cause::Spall(Surface::Inner), 0)]),
    ("outer-spall-both", &[(Cause::Spall(Surface::Outer), 0), (Cause::Spall(Surface::Outer), 1)]),
    ("ball-waviness", &[(Cause::Waviness(Surface::Ball), 0)]),
];

/// Readings of the probes in um, one column a probe, then the keyphasor.
pub type Readings = Vec<[f64; COLUMNS.len()]>;

/// Reads the motion that the program computed, at the probes; in place of the keyphasor the turns of the shaft.
fn motion(machine: &Machine, file: &Path) -> Result<Readings, Box<dyn Error>> {
    let text = fs::read_to_string(file)?;
    let mut rows = vec![];
    for line in text.lines().skip(1) {
        let cells: Result<Vec<f64>, _> = line.split(',').take(6).map(str::parse).collect();
        let [t, u, v, w, thu, thv] = cells?.try_into().map_err(|_| "a row of the motion is short")?;
        let mut row = [0.0; COLUMNS.len()];
        for (reading, (station, angle)) in row.iter_mut().zip(machine.radial_probes()) {
            let (sin, cos) = (angle * PI / 180.0).sin_cos();
            *reading = 1e6 * ((u + station * thv) * cos + (v - station * thu) * sin);
        }
        row[4] = 1e6 * w;
        row[5] = t * machine.rpm / 60.0;
        rows.push(row);
    }
    Ok(rows)
}

/// Returns the readings of a motion without anything of a site.
fn with_pulses(mut readings: Readings) -> Readings {
    let mut revolutions = -1.0;
    for row in &mut readings {
        // A pulse in the sample in which the shaft passes angle 0; rounding of the time does not delay it.
        let whole = (row[5] + 1e-6).floor();
        // The shaft need not be at angle 0 in the first sample.
        let is_first = revolutions < 0.0;
        row[5] = f64::from(u8::from(if is_first { row[5].fract() < 1e-6 } else { whole > revolutions }));
        revolutions = whole;
    }
    readings
}

/// Returns the largest change of a probe's reading about its mean (rms), and that of a mean, um.
fn effect(healthy: &Readings, faulty: &Readings) -> [f64; 2] {
    let n = healthy.len() as f64;
    let mean =
        |p: usize, power: i32| healthy.iter().zip(faulty).map(|(a, b)| (b[p] - a[p]).powi(power)).sum::<f64>() / n;
    let largest = |of: &dyn Fn(usize) -> f64| (0..COLUMNS.len() - 1).map(of).fold(0.0, f64::max);
    [largest(&|p| (mean(p, 2) - mean(p, 1).powi(2)).max(0.0).sqrt()), largest(&|p| mean(p, 1).abs())]
}

/// The readings with noise, in steps of the converter, in the NPY format.
fn npy(readings: &Readings, (noise, step): (f64, f64), random: &mut Random) -> Vec<u8> {
    let fields: Vec<String> = COLUMNS.iter().map(|column| format!("('{column}', '<f4')")).collect();
    let mut header =
        format!("{{'descr': [{}], 'fortran_order': False, 'shape': ({},), }}", fields.join(", "), readings.len());
    // The header ends with a line feed at a multiple of 64 bytes.
    let begin = 10;
    let padded = (begin + header.len() + 1).next_multiple_of(64) - begin - 1;
    header = format!("{header:padded$}\n");
    let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
    bytes.extend((header.len() as u16).to_le_bytes());
    bytes.extend(header.as_bytes());
    for row in readings {
        let [probes @ .., key] = row;
        let noisy = probes.iter().map(|reading| {
            let noisy = reading + noise * random.normal();
            (if step > 0.0 { (noisy / step).round() * step } else { noisy }) as f32
        });
        for value in noisy.chain([*key as f32]) {
            bytes.extend(value.to_le_bytes());
        }
    }
    bytes
}

/// Folder and scratch files of a fleet that is generated.
struct Workshop<'a> {
    program: &'a Program,
    folder: &'a Path,
    scratch: tempfile::TempDir,
}

impl<'a> Workshop<'a> {
    /// Takes a folder that does not exist yet or is empty.
    fn new(program: &'a Program, folder: &'a Path) -> Result<Self, Box<dyn Error>> {
        if folder.is_dir() && fs::read_dir(folder)?.next().is_some() {
            return Err(format!("{}: the folder is not empty", folder.display()).into());
        }
        Ok(Self { program, folder, scratch: tempfile::tempdir()? })
    }

    fn fleet(&self) -> Fleet {
        Fleet { folder: self.folder.to_owned(), recordings: vec![], no_slow_roll: false }
    }

    fn simulate(&self, machine: &Machine) -> Result<Readings, Box<dyn Error>> {
        let [scene, file] = ["scene.toml", "motion.csv"].map(|name| self.scratch.path().join(name));
        fs::write(&scene, machine.scene(true))?;
        self.program.simulate(&scene, DURATION, SETTLE, machine.rate, &file)?;
        motion(machine, &file)
    }

    /// Adds faults that move a probe by more than `least` (rms, um); returns them with the machine that has them and its motion.
    fn add(
        &self,
        (machine, healthy): (&Machine, &Readings),
        (causes, bearing): (&[(Cause, usize)], usize),
        least: f64,
        random: &mut Random,
    ) -> Result<(Vec<Fault>, Readings), Box<dyn Error>> {
        let (mut faults, mut faulty, mut readings) = (vec![], machine.clone(), healthy.clone());
        for &(cause, other) in causes {
            let drawn = (0..DRAWS).find_map(|draw| {
                let mut candidate = faulty.clone();
                let fault = candidate.add(cause, bearing ^ other, random);
                let after = self.simulate(&candidate);
                let is_last = draw + 1 == DRAWS;
                let is_kept = |after: &Readings| {
                    let [moved, mean] = effect(&readings, after);
                    is_last || moved.hypot(mean) > least
                };
                after.as_ref().map_or(true, is_kept).then_some((fault, candidate, after))
            });
            if let Some((fault, candidate, after)) = drawn {
                (faulty, readings) = (candidate, after?);
                faults.push(fault);
            }
        }
        Ok((faults, readings))
    }
}

/// Generates `rotors` rotors into a folder that does not exist yet or is empty.
pub fn generate(program: &Program, folder: &Path, rotors: usize, seed: u64) -> Result<Fleet, Box<dyn Error>> {
    let workshop = Workshop::new(program, folder)?;
    let mut fleet = workshop.fleet();
    for number in 0..rotors {
        let mut random = Random::of_rotor(seed, number);
        let rig = format!("rig{number:02}");
        let noisy_rig = format!("{rig}-noisy");
        let machine = Machine::random(&mut random, format!("rig {number}"));
        let noisy = Machine { noise: MUCH_NOISE, ..machine.clone() };
        let rough = machine.rough(&mut random);
        for (rig, exact, rough) in
            [(&rig, &machine, &rough), (&noisy_rig, &noisy, &Machine { noise: MUCH_NOISE, ..rough.clone() })]
        {
            fs::create_dir_all(folder.join(rig))?;
            fs::write(fleet.scene(rig, false), exact.scene_to_diagnose())?;
            fs::write(fleet.scene(rig, true), rough.scene_to_diagnose())?;
        }
        let machine = machine.with_cages(&mut random);
        let faulty_bearing = random.choice(&[0, 1]);
        let healthy = workshop.simulate(&machine)?;
        let mut entries = vec![];
        for (name, causes) in RECORDINGS {
            let least = SMALLEST_EFFECT * machine.noise;
            let (faults, motion) = workshop.add((&machine, &healthy), (causes, faulty_bearing), least, &mut random)?;
            let readings = with_pulses(motion);
            fs::write(fleet.file(&rig, name), npy(&readings, (machine.noise, 0.0), &mut random))?;
            fleet.recordings.push(Recording::new(&rig, name, "", &faults));
            if faults.len() < 2 {
                fs::write(fleet.file(&noisy_rig, name), npy(&readings, (MUCH_NOISE, 0.0), &mut random))?;
                entries.push(Recording::new(&noisy_rig, name, MUCH_NOISE_GROUP, &faults));
            }
        }
        fleet.recordings.append(&mut entries);
        eprintln!("rotor {} of {rotors}", number + 1);
    }
    fleet.write()?;
    Ok(fleet)
}

/// The recordings of a rotor at a site, beside those of single faults.
const AT_SITE: [(&str, Disturbance); 5] = [
    ("healthy-again", Disturbance::None),
    ("healthy-third", Disturbance::None),
    ("hum", Disturbance::Hum),
    ("drift", Disturbance::Drift),
    ("scratched", Disturbance::Scratch),
];
/// Recording at slow roll.
const SLOW_ROLL: &str = "slow-roll";

/// Generates `rotors` rotors at a site: imperfect bearings and measurement, the scene that an owner knows, a recording at slow roll.
pub fn generate_site(program: &Program, folder: &Path, rotors: usize, seed: u64) -> Result<Fleet, Box<dyn Error>> {
    let workshop = Workshop::new(program, folder)?;
    let mut fleet = workshop.fleet();
    for number in 0..rotors {
        let mut random = Random::of_rotor(seed, number);
        let rig = format!("rig{number:02}");
        let mut machine = Machine { noise: 0.1, ..Machine::random(&mut random, format!("rig {number}")) };
        let rough = machine.rough(&mut random);
        fs::create_dir_all(folder.join(&rig))?;
        let owned = machine.scene_to_diagnose();
        fs::write(fleet.scene(&rig, false), owned)?;
        let slow_roll = format!("run_out = \"{SLOW_ROLL}.npy\"\n");
        fs::write(fleet.scene(&rig, true), rough.scene_to_diagnose() + &slow_roll)?;
        for bearing in &mut machine.bearings {
            (bearing.waves, bearing.damage) = site::imperfections(bearing.elements, &mut random);
        }
        let site = Site::random(&mut random);
        let faulty_bearing = random.choice(&[0, 1]);
        let mut write = |name: &str, causes: &[(Cause, usize)], disturbance, random: &mut Random| {
            let mut run = machine.with_cages(random);
            run.rpm *= 1.0 + site::SPEED_ERROR * random.normal();
            let healthy = workshop.simulate(&run)?;
            let (faults, motion) = workshop.add((&run, &healthy), (causes, faulty_bearing), site::VISIBLE, random)?;
            let measured = site.read(&motion, (run.rpm, run.probe_angle, run.rate), disturbance, random);
            fs::write(fleet.file(&rig, name), npy(&measured, (machine.noise, site::STEP), random))?;
            let moved = (!faults.is_empty()).then(|| effect(&healthy, &motion));
            fleet.recordings.push(Recording::new(&rig, name, "", &faults).with_effect(moved));
            Ok::<Readings, Box<dyn Error>>(healthy)
        };
        let healthy = write(HEALTHY, &[], Disturbance::None, &mut random)?;
        for (name, disturbance) in AT_SITE {
            write(name, &[], disturbance, &mut random)?;
        }
        for (name, causes) in RECORDINGS.iter().filter(|(_, causes)| causes.len() == 1) {
            write(name, causes, Disturbance::None, &mut random)?;
        }
        let mean =
            std::array::from_fn(|probe| healthy.iter().map(|row| row[probe]).sum::<f64>() / healthy.len() as f64);
        let rolled = site.slow_roll(mean, (machine.rpm, machine.probe_angle, machine.rate));
        fs::write(fleet.file(&rig, SLOW_ROLL), npy(&rolled, (machine.noise, site::STEP), &mut random))?;
        eprintln!("rotor {} of {rotors}", number + 1);
    }
    fleet.write()?;
    Ok(fleet)
}
