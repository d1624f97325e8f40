//! Finite-element model of a rotor from its drawing, in one plane and along the axis.

use super::element::{Element, Material};
use super::{FlexibleRotor, Section};
use nalgebra::DMatrix;

/// Distance below which two stations are one, m.
const SAME: f64 = 1e-7;

/// Matrices of the free rotor: in a plane with displacement and rotation of each node, and along the axis.
pub struct Mesh {
    /// Stations of the nodes, m from the centre of mass.
    pub stations: Vec<f64>,
    /// Mass in a plane, in `[x1 phi1 x2 phi2 ...]`.
    pub mass: DMatrix<f64>,
    /// Stiffness in a plane.
    pub stiffness: DMatrix<f64>,
    /// Polar inertia in a plane: `M x'' + w P y' + K x = 0`, `M y'' - w P x' + K y = 0`.
    pub polar: DMatrix<f64>,
    /// Mass along the axis.
    pub axial_mass: DMatrix<f64>,
    /// Stiffness along the axis.
    pub axial_stiffness: DMatrix<f64>,
}

impl Mesh {
    /// Creates the model with nodes at the ends of all sections, the disks and `kept`, and no element longer than `longest`.
    pub fn new(rotor: &FlexibleRotor, kept: &[f64], longest: f64) -> Self {
        let stations = stations(rotor, kept, longest);
        let material = material(rotor);
        let n = stations.len();
        let zeros = |size: usize| DMatrix::zeros(size, size);
        let (mut mass, mut stiffness, mut polar) = (zeros(2 * n), zeros(2 * n), zeros(2 * n));
        let (mut axial_mass, mut axial_stiffness) = (zeros(n), zeros(n));
        for (i, ends) in stations.windows(2).enumerate() {
            let element = element(rotor, [ends[0], ends[1]]);
            let add = |to: &mut DMatrix<f64>, part: &nalgebra::Matrix4<f64>| {
                let mut view = to.fixed_view_mut::<4, 4>(2 * i, 2 * i);
                view += part;
            };
            add(&mut mass, &element.mass(&material));
            add(&mut stiffness, &element.stiffness(&material));
            add(&mut polar, &element.polar(&material));
            let [along, inertia] = element.axial(&material);
            let mut view = axial_stiffness.fixed_view_mut::<2, 2>(i, i);
            view += along;
            let mut view = axial_mass.fixed_view_mut::<2, 2>(i, i);
            view += inertia;
        }
        for disk in &rotor.disks {
            let Some(i) = stations.iter().position(|z| (z - disk.station).abs() < SAME) else { continue };
            mass[(2 * i, 2 * i)] += disk.mass;
            mass[(2 * i + 1, 2 * i + 1)] += disk.diametral_inertia;
            polar[(2 * i + 1, 2 * i + 1)] += disk.polar_inertia;
            axial_mass[(i, i)] += disk.mass;
        }
        Self { stations, mass, stiffness, polar, axial_mass, axial_stiffness }
    }

    /// Returns the index of the node nearest to a station.
    pub fn node(&self, station: f64) -> usize {
        let distance = |i: &usize| (self.stations[*i] - station).abs();
        (0..self.stations.len()).min_by(|a, b| distance(a).total_cmp(&distance(b))).unwrap_or(0)
    }
}

fn material(of: &FlexibleRotor) -> Material {
    Material { youngs_modulus: of.youngs_modulus, poissons_ratio: of.poissons_ratio, density: of.density }
}

/// Returns mass (kg), station of the centre of mass as drawn (m), and diametral and polar inertia about it (kg m^2).
pub fn rigid_body(rotor: &FlexibleRotor) -> [f64; 4] {
    // Short pieces: the inertia of a cone is the sum of those of cylinders.
    let longest = rotor.length() / 1000.0;
    let of = material(rotor);
    let pieces = stations(rotor, &[], longest);
    let mut parts: Vec<[f64; 4]> = pieces
        .windows(2)
        .map(|ends| {
            let element = element(rotor, [ends[0], ends[1]]);
            let [_, inertia] = element.axial(&of);
            let polar = element.polar(&of);
            let turned = nalgebra::Vector4::new(-0.5 * element.length, 1.0, 0.5 * element.length, 1.0);
            let quadratic = |m: &nalgebra::Matrix4<f64>| turned.dot(&(m * turned));
            [inertia.sum(), 0.5 * (ends[0] + ends[1]), quadratic(&element.mass(&of)), quadratic(&polar)]
        })
        .collect();
    parts.extend(rotor.disks.iter().map(|d| [d.mass, d.station, d.diametral_inertia, d.polar_inertia]));
    let mass: f64 = parts.iter().map(|p| p[0]).sum();
    let centre = parts.iter().map(|p| p[0] * p[1]).sum::<f64>() / mass;
    let diametral = parts.iter().map(|p| p[2] + p[0] * (p[1] - centre).powi(2)).sum();
    [mass, centre, diametral, parts.iter().map(|p| p[3]).sum()]
}

/// Returns the element between two stations within one section.
fn element(rotor: &FlexibleRotor, ends: [f64; 2]) -> Element {
    let middle = 0.5 * (ends[0] + ends[1]);
    let within = |s: &&Section| s.from <= middle && middle <= s.to;
    let section = rotor.sections.iter().find(within).or(rotor.sections.first());
    let diameter = |z: f64| section.map_or(0.0, |s| s.outer_diameter_at(z));
    Element::new(ends[1] - ends[0], ends.map(diameter), section.map_or(0.0, |s| s.inner_diameter), rotor.poissons_ratio)
}

/// Returns the stations of the nodes in order.
fn stations(rotor: &FlexibleRotor, kept: &[f64], longest: f64) -> Vec<f64> {
    let mut fixed: Vec<f64> = rotor.sections.iter().flat_map(|s| [s.from, s.to]).collect();
    fixed.extend(rotor.disks.iter().map(|d| d.station));
    fixed.extend(kept);
    fixed.sort_by(f64::total_cmp);
    fixed.dedup_by(|a, b| (*a - *b).abs() < SAME);
    let mut all = Vec::new();
    for ends in fixed.windows(2) {
        let parts = ((ends[1] - ends[0]) / longest * (1.0 - 1e-9)).ceil().max(1.0);
        all.extend((0..parts as usize).map(|i| ends[0] + (ends[1] - ends[0]) * i as f64 / parts));
    }
    all.extend(fixed.last());
    all
}
