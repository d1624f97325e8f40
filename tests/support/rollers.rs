//! The golden cases of rollers by laminae, as the kernel's and the program's tests read them.

use ballrace::bearing::ElementPosition;
use ballrace::bearing::roller::{Lamina, LaminaRoller, RollerBearingParams, RollerInertia, RollerProfile};
use ballrace::{BearingKinematicState, Displacement, Math, Phase, Scalar};
use serde::{Deserialize, Deserializer};

/// Inputs and outputs of one case, SI.
#[derive(Deserialize)]
pub struct Case {
    pub model: String,
    pub kind: String,
    pub elements: usize,
    pub roller_diameter: f64,
    pub roller_length: f64,
    pub pitch_diameter: f64,
    pub contact_angle: f64,
    pub laminae: usize,
    /// Coefficient of the logarithmic profile.
    pub profile: f64,
    pub radial_play: f64,
    pub first_azimuth: f64,
    pub stiffness: f64,
    #[serde(default)]
    pub speed: f64,
    #[serde(default)]
    pub density: f64,
    pub displacement: [f64; 5],
    #[serde(deserialize_with = "decimals")]
    pub force: [f64; 5],
    /// Loads at inner and outer race, and tilt.
    #[serde(default)]
    pub rollers: Vec<[f64; 3]>,
    #[serde(default, deserialize_with = "decimal")]
    pub largest_lamina_load: f64,
}

/// A bearing of a case.
pub type Rollers<T, M> = LaminaRoller<T, M, Vec<ElementPosition<T>>, Vec<Lamina<T>>>;

fn number<E: serde::de::Error>(text: &str) -> Result<f64, E> {
    text.parse().map_err(E::custom)
}

fn decimal<'de, D: Deserializer<'de>>(text: D) -> Result<f64, D::Error> {
    number(&String::deserialize(text)?)
}

fn decimals<'de, D: Deserializer<'de>>(texts: D) -> Result<[f64; 5], D::Error> {
    let mut numbers = [0.0; 5];
    for (entry, text) in numbers.iter_mut().zip(<[String; 5]>::deserialize(texts)?) {
        *entry = number(&text)?;
    }
    Ok(numbers)
}

impl Case {
    pub fn is_in_equilibrium(&self) -> bool {
        self.model == "quasi-static"
    }

    /// The rollers in series.
    pub fn bearing<T: Scalar, M: Math<T>>(&self) -> Rollers<T, M> {
        let first = Phase::from_radians(self.first_azimuth);
        let positions =
            (0..self.elements).map(|j| ElementPosition::evenly_spaced(first, j, self.elements)).collect::<Vec<_>>();
        let profile = RollerProfile::Logarithmic { coefficient: self.profile };
        let lamina = |k| Lamina::try_new(self.roller_length, &profile, k, self.laminae).unwrap();
        let params = RollerBearingParams {
            pitch_diameter: self.pitch_diameter,
            contact_angle: self.contact_angle,
            radial_play: self.radial_play,
            stiffness: self.stiffness,
        };
        LaminaRoller::try_new(&params, positions, (0..self.laminae).map(lamina).collect()).unwrap()
    }

    pub fn inertia(&self) -> RollerInertia {
        RollerInertia::of_cylinders(self.roller_diameter, self.roller_length, self.pitch_diameter, self.density)
    }

    pub fn motion<T: Scalar>(&self) -> (Displacement<T>, BearingKinematicState<T>) {
        let at = BearingKinematicState { inner_speed: T::from_f64(self.speed), ..BearingKinematicState::default() };
        (Displacement::from_array(self.displacement.map(T::from_f64)), at)
    }
}

#[derive(Deserialize)]
struct File {
    cases: Vec<Case>,
}

/// All of them: 30 in series, 12 in equilibrium.
pub fn cases() -> Vec<Case> {
    let file: File = serde_json::from_str(include_str!("../golden/rollers.json")).expect("the golden file is whole");
    file.cases
}
