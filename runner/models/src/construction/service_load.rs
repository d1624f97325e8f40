//! Estimate of the approach of the most loaded ball in service, from the loads of the scene.

use ballrace::bearing::geometry::BallBearingGeometry;
use ballrace_scene::{Bearing, FreeAngle, PreloadAmount, Rotor, Scene};

/// Load of the most loaded element of a radially loaded bearing over the mean (Stribeck, for a bearing with clearance).
const STRIBECK: f64 = 5.0;
/// Least sine of the contact angle under thrust: the angle of a deep-groove bearing grows under its load.
const MIN_THRUST_SINE: f64 = 0.17;

/// Returns the approach of the most loaded ball, m; `None` where the scene states no load.
///
/// An estimate to within some factor: each bearing carries the whole load of the rotor.
pub(crate) fn approach_in_service(scene: &Scene, of: &Bearing, geometry: &BallBearingGeometry) -> Option<f64> {
    let [radial, mut axial] = scene.rotor.as_ref().map_or([0.0; 2], |rotor| rotor_load(scene, rotor));
    let mut without_load = match of.geometry.map(|g| g.fit) {
        Some(FreeAngle::DiametralClearance(clearance)) => (-0.5 * clearance).max(0.0),
        _ => 0.0,
    };
    match of.preload.map(|preload| preload.amount) {
        Some(PreloadAmount::Force(force)) => axial += force.abs(),
        Some(PreloadAmount::Displacement(w)) => without_load += w.abs() * geometry.contact_angle.sin(),
        None => {}
    }
    let count = of.elements.max(1) as f64;
    let thrust_sine = geometry.contact_angle.sin().max(MIN_THRUST_SINE);
    let load = STRIBECK * radial / (count * geometry.contact_angle.cos()) + axial / (count * thrust_sine);
    let approach = without_load + super::point_contact_approach(geometry.stiffness(), load);
    (approach > 0.0).then_some(approach)
}

/// Returns the radial and the axial load of the rotor, N.
fn rotor_load(scene: &Scene, rotor: &Rotor) -> [f64; 2] {
    let [gx, gy, gz] = rotor.gravity.map(|g| rotor.mass * g);
    let [fx, fy, fz, mx, my] = rotor.load;
    let (low, high) = scene.shaft.speed.range();
    let speed = low.abs().max(high.abs());
    let unbalance: f64 = rotor.unbalance.iter().map(|unbalance| unbalance.moment * speed * speed).sum();
    let stations = || scene.bearings.iter().map(|bearing| bearing.station);
    let (first, last) = stations().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), z| (a.min(z), b.max(z)));
    let span = last - first;
    // An overhung rotor loads the bearing next to it with more than its weight.
    let (lever, by_moment) =
        if span > 0.0 { ((first.abs().max(last.abs()) / span).max(1.0), mx.hypot(my) / span) } else { (1.0, 0.0) };
    [lever * ((gx + fx).hypot(gy + fy) + unbalance) + by_moment, (gz + fz).abs()]
}
