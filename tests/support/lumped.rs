//! The golden cases of the lumped law, as the kernel's and the program's tests read them.

use serde::Deserialize;

/// Separate axial elements.
#[derive(Deserialize, Clone, Copy)]
pub struct Axial {
    pub exponent: f64,
    pub stiffness: f64,
    pub play: f64,
    pub radius: f64,
}

/// Inputs and outputs of one case, SI.
#[derive(Deserialize)]
pub struct Case {
    pub elements: usize,
    pub exponent: f64,
    pub stiffness: f64,
    pub radial_play: f64,
    pub azimuth_of_first_element: f64,
    pub axial: Option<Axial>,
    pub displacement: [f64; 5],
    pub housing_displacement: Option<Vec<[f64; 3]>>,
    pub force: [f64; 5],
    pub element_loads: Vec<[f64; 2]>,
}

#[derive(Deserialize)]
struct File {
    cases: Vec<Case>,
}

/// All of them.
pub fn cases() -> Vec<Case> {
    let file: File = serde_json::from_str(include_str!("../golden/lumped.json")).expect("the golden file is whole");
    file.cases
}
