//! Lubrication and cooling of a bearing, on which its friction, its rating life and its temperatures depend.

/// `lubrication`
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Lubrication {
    /// How the lubricant comes to the bearing.
    pub method: LubricationMethod,
    /// Kinematic viscosity of the oil, or of the base oil of a grease, at 40 degrees Celsius, m^2/s, above 0.
    pub viscosity_40: f64,
    /// The same at 100 degrees Celsius, below that at 40.
    pub viscosity_100: f64,
    /// Temperature in the bearing, K; the mean of the rings where it is not given.
    pub temperature: Option<f64>,
    /// Contamination factor `e_C` of ISO 281, above 0 and at most 1; without it the life is not modified.
    pub contamination: Option<f64>,
    /// `f0` of the viscous friction, where it is given.
    pub viscous_factor: Option<f64>,
    /// `f1` of the load-dependent friction, where it is given.
    pub load_factor: Option<f64>,
    /// Coefficient of friction in sliding contacts.
    pub sliding_friction: f64,
}

/// Temperatures at which data sheets state a viscosity, K.
const STATED: [f64; 2] = [313.15, 373.15];

impl Lubrication {
    /// Returns the kinematic viscosity at a temperature in K, m^2/s, by the equation of Walther (ASTM D341) through the two stated values:
    /// `lg lg (nu + 0.7) = A - B lg T`, nu in mm^2/s.
    #[must_use]
    pub fn viscosity(&self, temperature: f64) -> f64 {
        let twice = |viscosity: f64| (1e6 * viscosity + 0.7).log10().log10();
        let [cold, hot] = [self.viscosity_40, self.viscosity_100].map(twice);
        let slope = (cold - hot) / (STATED[1] / STATED[0]).log10();
        let raised = 10_f64.powf(10_f64.powf(cold - slope * (temperature / STATED[0]).log10()));
        1e-6 * (raised - 0.7).max(0.0)
    }
}

/// `lubrication.method`
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LubricationMethod {
    /// `"grease"`
    Grease,
    /// `"oil-mist"`, also oil and air
    OilMist,
    /// `"oil-bath"`, up to the middle of the lowest element
    OilBath,
    /// `"oil-jet"`, also a bath with a vertical shaft
    OilJet,
}

impl LubricationMethod {
    /// All methods by their names in a scene.
    pub const ALL: [(&'static str, Self); 4] =
        [("grease", Self::Grease), ("oil-mist", Self::OilMist), ("oil-bath", Self::OilBath), ("oil-jet", Self::OilJet)];
}

/// `cooling`: where the heat of a bearing goes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cooling {
    /// Temperature of the surroundings, K.
    pub ambient: f64,
    /// Conductance from the inner ring through the shaft to the surroundings, W/K, 0 or more.
    pub shaft: f64,
    /// Conductance from the housing to the surroundings, W/K, 0 or more.
    pub housing: f64,
    /// Conductance from the outer ring to the housing, W/K, above 0; none where the housing has the temperature of the ring.
    pub seat: Option<f64>,
    /// Conductance from ring to ring through the elements, W/K, 0 or more.
    pub elements: f64,
    /// Oil that flows through the bearing.
    pub oil: Option<OilFlow>,
}

/// Oil that flows through a bearing.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OilFlow {
    /// m^3/s, above 0
    pub flow: f64,
    /// Temperature where it enters, K.
    pub inlet: f64,
}

impl OilFlow {
    /// Heat capacity of a volume of mineral oil, J/(m^3 K): 880 kg/m^3 times 1900 J/(kg K).
    const HEAT_CAPACITY: f64 = 1.67e6;

    /// Returns the heat that the oil carries away for each kelvin that it is warmed, W/K.
    #[must_use]
    pub fn conductance(&self) -> f64 {
        self.flow * Self::HEAT_CAPACITY
    }
}

/// Conductance of the seat of a ring per area, W/(m^2 K): the reference heat flow of ISO 15312 for radial bearings, 0.016 W/mm^2 over a rise of
/// 50 K.
const SEAT: f64 = 0.016e6 / 50.0;
/// Area of both seats above which the flow of ISO 15312 falls, m^2, and the power by which it does.
const LARGE: (f64, f64) = (0.05, -0.34);

/// Returns the conductances of the seats of inner and outer ring by the reference conditions of ISO 15312, W/K; all sizes in m.
pub(crate) fn reference_conductances(bore: f64, outside: f64, width: f64) -> [f64; 2] {
    let areas = [bore, outside].map(|diameter| std::f64::consts::PI * diameter * width);
    let (limit, power) = LARGE;
    let flow = SEAT * ((areas[0] + areas[1]) / limit).max(1.0).powf(power);
    areas.map(|area| flow * area)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// ISO VG 32 with the viscosity index 100 has 5.4 mm^2/s at 100 degrees, and about 12 at 70, as ISO 15312 has it.
    #[test]
    fn walther_between_and_at_the_stated_values() {
        let oil = Lubrication {
            method: LubricationMethod::OilBath,
            viscosity_40: 32e-6,
            viscosity_100: 5.4e-6,
            temperature: None,
            contamination: None,
            viscous_factor: None,
            load_factor: None,
            sliding_friction: 0.05,
        };
        assert!((oil.viscosity(313.15) - 32e-6).abs() < 1e-12);
        assert!((oil.viscosity(373.15) - 5.4e-6).abs() < 1e-12);
        assert!((oil.viscosity(343.15) - 12e-6).abs() < 1e-6);
        // A tenth of a kelvin over absolute zero and a furnace are finite.
        assert!(oil.viscosity(999.0) >= 0.0 && oil.viscosity(999.0) < 1e-6);
    }

    /// A 6205 under the conditions of ISO 15312 loses 58 W.
    #[test]
    fn conductance_of_the_seats() {
        let [inner, outer] = reference_conductances(25e-3, 52e-3, 15e-3);
        assert!(((inner + outer) * 50.0 - 58.06).abs() < 0.05);
        assert!((outer / inner - 52.0 / 25.0).abs() < 1e-12);
        let large = reference_conductances(0.5, 0.7, 0.1);
        assert!((large[0] + large[1]) * 50.0 < 0.016e6 * std::f64::consts::PI * 1.2 * 0.1);
    }
}
