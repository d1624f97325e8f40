//! Operating clearance: clearance before mounting less the reductions by press fits and by temperature.
//!
//! Press fits: thick-walled cylinders (Lame; Timoshenko, Strength of Materials, Part II, chapter on thick-walled cylinders), each
//! ring a plain cylinder from its fit to its raceway. Temperature: free expansion of rings and elements. Source of the method:
//! Harris and Kotzalas, Rolling Bearing Analysis, chapter on interference fitting and clearance, where the expansion of the
//! elements is neglected.

/// Elastic constants and thermal expansion of a shaft, a housing or the rings.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PartMaterial {
    /// Pa, above 0
    pub youngs_modulus: f64,
    /// 0 or more, below 0.5
    pub poissons_ratio: f64,
    /// Linear expansion, 1/K
    pub expansion: f64,
}

/// Fit of one ring on the shaft or in the housing.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RingFit {
    /// Diametral interference at the temperature of assembly, m; negative is a loose fit.
    pub interference: f64,
    /// Diameter of the fit: bore of the inner ring, outside diameter of the outer ring, m.
    pub diameter: f64,
    /// Free diameter of the part on the other side, m: bore of the shaft (0 for a solid one), outside diameter of the
    /// housing (infinite where it is not given).
    pub free_diameter: f64,
    /// Material of shaft or housing.
    pub material: PartMaterial,
}

/// Temperatures of a bearing, K.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Temperatures {
    /// Inner ring and shaft.
    pub inner: f64,
    /// Outer ring and housing.
    pub outer: f64,
    /// Assembly, at which clearance and interferences hold.
    pub assembled: f64,
}

impl Temperatures {
    /// Returns the temperatures with a measured ring. The other ring keeps its difference to it.
    #[must_use]
    pub fn measured(self, ring: Ring, temperature: f64) -> Self {
        match ring {
            Ring::Inner => Self { inner: temperature, outer: temperature + self.outer - self.inner, ..self },
            Ring::Outer => Self { outer: temperature, inner: temperature + self.inner - self.outer, ..self },
        }
    }
}

/// Ring of a bearing.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Ring {
    /// Inner ring.
    Inner,
    /// Outer ring.
    Outer,
}

/// Mounting of a bearing.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Mounting {
    /// Diametral clearance before mounting, m.
    pub unmounted_clearance: f64,
    /// Diameters of inner and outer raceway, m.
    pub raceways: [f64; 2],
    /// Material of rings and elements.
    pub ring_material: PartMaterial,
    /// Fits of inner and outer ring; none where `fit` is not given.
    pub fits: Option<[RingFit; 2]>,
    /// `temperatures`, where given.
    pub temperatures: Option<Temperatures>,
}

/// Operating clearance and its parts, m.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OperatingClearance {
    /// Diametral clearance before mounting.
    pub unmounted: f64,
    /// Reduction by the fits at the operating temperatures.
    pub by_fits: f64,
    /// Reduction by the temperatures of rings and elements.
    pub by_temperature: f64,
}

impl OperatingClearance {
    /// Returns the operating clearance, m.
    #[must_use]
    pub fn value(&self) -> f64 {
        self.unmounted - self.reduction()
    }

    /// Returns the reduction of the clearance, m.
    #[must_use]
    pub fn reduction(&self) -> f64 {
        self.by_fits + self.by_temperature
    }
}

impl Mounting {
    /// Returns the operating clearance at the temperatures of the scene.
    #[must_use]
    pub fn operating(&self) -> OperatingClearance {
        self.at(self.temperatures)
    }

    /// Returns the operating clearance at these temperatures, or at that of the assembly.
    #[must_use]
    pub fn at(&self, temperatures: Option<Temperatures>) -> OperatingClearance {
        let [inner, outer] = temperatures.map_or([0.0; 2], |t| [t.inner - t.assembled, t.outer - t.assembled]);
        let [inner_raceway, outer_raceway] = self.raceways;
        let elements = 0.5 * (outer_raceway - inner_raceway);
        let expansion = self.ring_material.expansion;
        let mean = 0.5 * (inner + outer);
        let by_temperature = expansion * (inner_raceway * inner + 2.0 * elements * mean - outer_raceway * outer);
        let by_fits = self.fits.map_or(0.0, |[on_shaft, in_housing]| {
            self.inner_growth(&on_shaft, inner) + self.outer_shrinkage(&in_housing, outer)
        });
        OperatingClearance { unmounted: self.unmounted_clearance, by_fits, by_temperature }
    }

    /// Returns the growth of the inner raceway by the press fit on the shaft, `rise` K above the temperature of assembly, m.
    fn inner_growth(&self, fit: &RingFit, rise: f64) -> f64 {
        let (diameter, raceway) = (fit.diameter, self.raceways[0]);
        let interference = fit.interference + diameter * rise * (fit.material.expansion - self.ring_material.expansion);
        let ring = (ratio(raceway, diameter) + self.ring_material.poissons_ratio) / self.ring_material.youngs_modulus;
        let shaft = (ratio(diameter, fit.free_diameter) - fit.material.poissons_ratio) / fit.material.youngs_modulus;
        let pressure = pressure(interference, diameter, ring + shaft);
        2.0 * pressure * diameter * diameter * raceway
            / (self.ring_material.youngs_modulus * (raceway * raceway - diameter * diameter))
    }

    /// Returns the shrinkage of the outer raceway by the press fit in the housing, `rise` K above the temperature of assembly, m.
    fn outer_shrinkage(&self, fit: &RingFit, rise: f64) -> f64 {
        let (diameter, raceway) = (fit.diameter, self.raceways[1]);
        let interference = fit.interference + diameter * rise * (self.ring_material.expansion - fit.material.expansion);
        let ring = (ratio(diameter, raceway) - self.ring_material.poissons_ratio) / self.ring_material.youngs_modulus;
        let housing = (ratio(fit.free_diameter, diameter) + fit.material.poissons_ratio) / fit.material.youngs_modulus;
        let pressure = pressure(interference, diameter, ring + housing);
        2.0 * pressure * diameter * diameter * raceway
            / (self.ring_material.youngs_modulus * (diameter * diameter - raceway * raceway))
    }
}

/// Returns `(b^2 + a^2)/(b^2 - a^2)` of a cylinder with the diameters `b` (outer, possibly infinite) and `a`.
fn ratio(outer: f64, inner: f64) -> f64 {
    let square = (inner / outer).powi(2);
    (1.0 + square) / (1.0 - square)
}

/// Returns the pressure of a fit, Pa, from the compliances of both parts; 0 in a loose fit.
fn pressure(interference: f64, diameter: f64, compliance: f64) -> f64 {
    interference.max(0.0) / (diameter * compliance)
}

#[cfg(test)]
mod tests {
    use super::*;

    const STEEL: PartMaterial = PartMaterial { youngs_modulus: 206e9, poissons_ratio: 0.3, expansion: 12e-6 };
    const ALUMINIUM: PartMaterial = PartMaterial { youngs_modulus: 70e9, poissons_ratio: 0.33, expansion: 23e-6 };
    /// Raceways of a 6205.
    const RACEWAYS: [f64; 2] = [31.1e-3, 46.98e-3];

    fn mounting(shaft: RingFit, housing: RingFit) -> Mounting {
        Mounting {
            unmounted_clearance: 20e-6,
            raceways: RACEWAYS,
            ring_material: STEEL,
            fits: Some([shaft, housing]),
            temperatures: None,
        }
    }

    fn on_shaft(interference: f64, bore: f64, material: PartMaterial) -> RingFit {
        RingFit { interference, diameter: 25e-3, free_diameter: bore, material }
    }

    fn in_housing(interference: f64, outside: f64, material: PartMaterial) -> RingFit {
        RingFit { interference, diameter: 52e-3, free_diameter: outside, material }
    }

    fn near(found: f64, expected: f64) {
        assert!((found / expected - 1.0).abs() < 1e-12, "{found:e} {expected:e}");
    }

    /// Same material: `I d/d_i` on a solid shaft, `I d_o/D` in an unlimited housing.
    #[test]
    fn closed_forms_of_one_material() {
        let loose = in_housing(-5e-6, f64::INFINITY, STEEL);
        near(mounting(on_shaft(10e-6, 0.0, STEEL), loose).operating().by_fits, 10e-6 * 25.0 / 31.1);
        let tight = in_housing(8e-6, f64::INFINITY, STEEL);
        near(mounting(on_shaft(0.0, 0.0, STEEL), tight).operating().by_fits, 8e-6 * 46.98 / 52.0);
        // A hollow shaft of the same material: I (d_i/d) (d^2 - a^2)/(d_i^2 - a^2), which the solid one includes.
        let hollow = mounting(on_shaft(10e-6, 12e-3, STEEL), loose).operating().by_fits;
        near(hollow, 10e-6 * (31.1 / 25.0) * (625.0 - 144.0) / (31.1 * 31.1 - 144.0));
        // A housing of 80 mm: I (D/d_o) (h^2 - D^2)/(h^2 - d_o^2) times (d_o/D)^2.
        let finite = mounting(on_shaft(0.0, 0.0, STEEL), in_housing(8e-6, 80e-3, STEEL)).operating().by_fits;
        near(finite, 8e-6 * (46.98 / 52.0) * (6400.0 - 2704.0) / (6400.0 - 46.98 * 46.98));
    }

    /// Against the boundary-value problem of two cylinders in plane stress, solved for its four Lame constants with 30 digits.
    #[test]
    fn fits_of_two_materials() {
        let none = in_housing(0.0, f64::INFINITY, STEEL);
        near(mounting(on_shaft(10e-6, 12e-3, ALUMINIUM), none).operating().by_fits, 5.231106932415019e-6);
        let housing = in_housing(8e-6, 80e-3, ALUMINIUM);
        near(mounting(on_shaft(0.0, 0.0, STEEL), housing).operating().by_fits, 4.418445076938154e-6);
    }

    #[test]
    fn temperature_and_fits() {
        let temperatures = Temperatures { inner: 333.15, outer: 318.15, assembled: 293.15 };
        let mut warm = mounting(on_shaft(10e-6, 0.0, STEEL), in_housing(20e-6, 80e-3, ALUMINIUM));
        warm.temperatures = Some(temperatures);
        // alpha d_m (T_i - T_o); a common rise changes nothing.
        near(warm.operating().by_temperature, 12e-6 * 39.04e-3 * 15.0);
        // The aluminium housing grows by 14.3 um more than the ring: 5.7 um of 20 um are left.
        near(warm.operating().by_fits, 10e-6 * 25.0 / 31.1 + 3.148142117318435e-6);
        near(warm.operating().value(), 20e-6 - warm.operating().by_fits - warm.operating().by_temperature);
        // Beyond, it is loose.
        let hot = temperatures.measured(Ring::Outer, 353.15);
        assert_eq!(hot, Temperatures { inner: 368.15, outer: 353.15, assembled: 293.15 });
        near(warm.at(Some(hot)).by_fits, 10e-6 * 25.0 / 31.1);
        near(warm.at(Some(temperatures.measured(Ring::Inner, 333.15))).value(), warm.operating().value());
    }
}
