//! Finite-element model of a rotor from its drawing, in one plane and along the axis.

use super::element::{Element, Material};
use super::{FlexibleRotor, Section};
use nalgebra::{DMatrix, Matrix2, Matrix3, Matrix3x2, Matrix4, Matrix6, Matrix6x4};

/// Distance below which two stations are one, m.
const SAME: f64 = 1e-7;

/// Largest number of ends of sections, disks and other stations of which every one has a node.
const MOST_NODES: usize = 64;
/// Number of disks that have a node among more stations, the heaviest.
const HEAVIEST_DISKS: usize = 32;

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
    /// Creates the model with no element longer than `longest`, and with nodes at `kept` and at the ends of all sections and the disks; where
    /// those are many, with nodes at `kept`, at the heaviest disks and in distances of `longest`, between which the elements are condensed.
    /// Cost: linear in the number of sections.
    pub fn new(rotor: &FlexibleRotor, kept: &[f64], longest: f64) -> Self {
        let fixed = fixed(rotor, kept);
        let all = stations(&fixed, longest);
        let nodes =
            if fixed.len() <= MOST_NODES { (0..all.len()).collect() } else { chosen_nodes(rotor, kept, longest, &all) };
        let material = material(rotor);
        let n = nodes.len();
        let zeros = |size: usize| DMatrix::zeros(size, size);
        let (mut mass, mut stiffness, mut polar) = (zeros(2 * n), zeros(2 * n), zeros(2 * n));
        let (mut axial_mass, mut axial_stiffness) = (zeros(n), zeros(n));
        for (i, ends) in nodes.windows(2).enumerate() {
            let mut pieces = all[ends[0]..=ends[1]].windows(2).map(|ends| {
                let element = element(rotor, [ends[0], ends[1]]);
                (ends[0], Segment::new(&element, &material))
            });
            let Some((_, first)) = pieces.next() else { continue };
            let segment = pieces.fold(first, |segment, (joint, next)| segment.joined(disks_at(rotor, joint), &next));
            let add = |to: &mut DMatrix<f64>, part: &Matrix4<f64>| {
                let mut view = to.fixed_view_mut::<4, 4>(2 * i, 2 * i);
                view += part;
            };
            add(&mut mass, &segment.mass);
            add(&mut stiffness, &segment.stiffness);
            add(&mut polar, &segment.polar);
            let mut view = axial_stiffness.fixed_view_mut::<2, 2>(i, i);
            view += segment.axial_stiffness;
            let mut view = axial_mass.fixed_view_mut::<2, 2>(i, i);
            view += segment.axial_mass;
        }
        let stations: Vec<f64> = nodes.iter().map(|i| all[*i]).collect();
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

/// Elements between two nodes, in `[x1 phi1 x2 phi2]` and `[w1 w2]`.
#[derive(Debug, Clone, Copy)]
struct Segment {
    stiffness: Matrix4<f64>,
    mass: Matrix4<f64>,
    polar: Matrix4<f64>,
    axial_stiffness: Matrix2<f64>,
    axial_mass: Matrix2<f64>,
}

impl Segment {
    fn new(element: &Element, material: &Material) -> Self {
        let [axial_stiffness, axial_mass] = element.axial(material);
        Self {
            stiffness: element.stiffness(material),
            mass: element.mass(material),
            polar: element.polar(material),
            axial_stiffness,
            axial_mass,
        }
    }

    /// Appends `next` and condenses the node between, which carries `[mass, diametral inertia, polar inertia]`: it follows the static deflection.
    /// Source: Guyan 1965, AIAA Journal 3.
    fn joined(&self, [mass, diametral, polar]: [f64; 3], next: &Self) -> Self {
        // Both nodes of this segment, then the far node of the next.
        let chain = |a: &Matrix4<f64>, b: &Matrix4<f64>| {
            let mut sum = Matrix6::zeros();
            let mut view = sum.fixed_view_mut::<4, 4>(0, 0);
            view += a;
            let mut view = sum.fixed_view_mut::<4, 4>(2, 2);
            view += b;
            sum
        };
        let stiffness = chain(&self.stiffness, &next.stiffness);
        let mut shape = Matrix6x4::zeros();
        (shape[(0, 0)], shape[(1, 1)], shape[(4, 2)], shape[(5, 3)]) = (1.0, 1.0, 1.0, 1.0);
        let joint = stiffness.fixed_view::<2, 2>(2, 2).into_owned();
        let coupling = stiffness.fixed_view::<2, 6>(2, 0) * shape;
        if let Some(flexibility) = joint.try_inverse() {
            shape.fixed_view_mut::<2, 4>(2, 0).copy_from(&(-flexibility * coupling));
        }
        let condensed = |of: Matrix6<f64>| shape.transpose() * of * shape;
        let mut inertia = chain(&self.mass, &next.mass);
        inertia[(2, 2)] += mass;
        inertia[(3, 3)] += diametral;
        let mut gyroscopic = chain(&self.polar, &next.polar);
        gyroscopic[(3, 3)] += polar;
        let [near, far] = [self.axial_stiffness[(0, 0)], next.axial_stiffness[(0, 0)]];
        let axial_shape = Matrix3x2::new(1.0, 0.0, near / (near + far), far / (near + far), 0.0, 1.0);
        let mut axial_inertia = Matrix3::zeros();
        let mut view = axial_inertia.fixed_view_mut::<2, 2>(0, 0);
        view += self.axial_mass;
        let mut view = axial_inertia.fixed_view_mut::<2, 2>(1, 1);
        view += next.axial_mass;
        axial_inertia[(1, 1)] += mass;
        let spring = near * far / (near + far);
        Self {
            stiffness: condensed(stiffness),
            mass: condensed(inertia),
            polar: condensed(gyroscopic),
            axial_stiffness: spring * Matrix2::new(1.0, -1.0, -1.0, 1.0),
            axial_mass: axial_shape.transpose() * axial_inertia * axial_shape,
        }
    }
}

/// Returns the sums of mass, diametral and polar inertia of the disks at a station.
fn disks_at(rotor: &FlexibleRotor, station: f64) -> [f64; 3] {
    let there = rotor.disks.iter().filter(|disk| (disk.station - station).abs() < SAME);
    there.fold([0.0; 3], |[m, d, p], disk| [m + disk.mass, d + disk.diametral_inertia, p + disk.polar_inertia])
}

/// Returns mass (kg), station of the centre of mass as drawn (m), and diametral and polar inertia about it (kg m^2).
pub fn rigid_body(rotor: &FlexibleRotor) -> [f64; 4] {
    // Short pieces: the inertia of a cone is the sum of those of cylinders.
    let longest = rotor.length() / 1000.0;
    let of = material(rotor);
    let pieces = stations(&fixed(rotor, &[]), longest);
    let mut parts: Vec<[f64; 4]> = pieces
        .windows(2)
        .map(|ends| {
            let element = element(rotor, [ends[0], ends[1]]);
            let [_, inertia] = element.axial(&of);
            let polar = element.polar(&of);
            let turned = nalgebra::Vector4::new(-0.5 * element.length, 1.0, 0.5 * element.length, 1.0);
            let quadratic = |m: &Matrix4<f64>| turned.dot(&(m * turned));
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

/// Returns the ends of the elements in order, between `fixed` ones.
fn stations(fixed: &[f64], longest: f64) -> Vec<f64> {
    let mut all = Vec::new();
    for ends in fixed.windows(2) {
        let parts = ((ends[1] - ends[0]) / longest * (1.0 - 1e-9)).ceil().max(1.0);
        all.extend((0..parts as usize).map(|i| ends[0] + (ends[1] - ends[0]) * i as f64 / parts));
    }
    all.extend(fixed.last());
    all
}

/// Returns the ends of the sections, the disks and `kept`, in order.
fn fixed(rotor: &FlexibleRotor, kept: &[f64]) -> Vec<f64> {
    let mut fixed: Vec<f64> = rotor.sections.iter().flat_map(|s| [s.from, s.to]).collect();
    fixed.extend(rotor.disks.iter().map(|d| d.station));
    fixed.extend(kept);
    fixed.sort_by(f64::total_cmp);
    fixed.dedup_by(|a, b| (*a - *b).abs() < SAME);
    fixed
}

/// Returns the indices of those of many `stations` that have a node: at `kept` ones, heavy disks, and not further apart than `longest`.
fn chosen_nodes(rotor: &FlexibleRotor, kept: &[f64], longest: f64, stations: &[f64]) -> Vec<usize> {
    let mut disks: Vec<_> = rotor.disks.iter().collect();
    disks.sort_by(|a, b| b.mass.total_cmp(&a.mass));
    let chosen: Vec<f64> = kept.iter().copied().chain(disks.iter().take(HEAVIEST_DISKS).map(|d| d.station)).collect();
    let mut nodes = vec![0];
    let mut last = stations.first().copied().unwrap_or_default();
    for (i, z) in stations.iter().enumerate().skip(1) {
        let is_chosen = chosen.iter().any(|at| (z - at).abs() < SAME) || i + 1 == stations.len();
        if is_chosen || z - last >= longest * (1.0 - 1e-9) {
            nodes.push(i);
            last = *z;
        }
    }
    nodes
}
