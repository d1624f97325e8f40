//! `labels.csv` of a folder of vibration recordings: one line a recording, with the fault, the geometry of the bearing
//! and the speed.

use std::collections::HashMap;
use std::error::Error;
use std::fs;
use std::path::Path;

/// Faults of a bearing in the words of the labels, with the kind of the diagnosis.
const DAMAGES: [(&str, &str); 4] =
    [("outer", "outer-race"), ("inner", "inner-race"), ("ball", "element"), ("cage", "cage")];

/// One recording.
#[derive(Debug, Clone, Default)]
pub struct Recording {
    pub file: String,
    pub dataset: String,
    pub fault: String,
    pub elements: usize,
    pub diameter_mm: f64,
    pub pitch_mm: f64,
    pub angle_deg: f64,
    pub rpm: f64,
    pub rate_hz: f64,
    pub channels: usize,
}

impl Recording {
    /// Returns the kind of diagnosis that names the damage; none of a good bearing.
    pub fn damage(&self) -> Option<&'static str> {
        DAMAGES.iter().find(|(fault, _)| *fault == self.fault).map(|(_, kind)| *kind)
    }

    /// Returns the orders of outer race, inner race, element and cage in pure rolling.
    pub fn orders(&self) -> [f64; 4] {
        let ratio = self.diameter_mm / self.pitch_mm;
        let along = ratio * self.angle_deg.to_radians().cos();
        let (n, cage) = (self.elements as f64, 0.5 * (1.0 - along));
        [n * cage, n * (1.0 - cage), (1.0 - along * along) / ratio, cage]
    }

    /// Returns the recording with another diameter of the elements, which moves the order of its damaged component by
    /// `share`.
    pub fn decoy(&self, share: f64) -> Self {
        let component = DAMAGES.iter().position(|(fault, _)| *fault == self.fault).unwrap_or(0);
        let target = self.orders()[component] * (1.0 + share);
        // The orders change monotonously with the diameter.
        let at = |diameter_mm: f64| Self { diameter_mm, ..self.clone() };
        let (mut low, mut high) = (0.3 * self.diameter_mm, 2.0 * self.diameter_mm);
        let rises = at(high).orders()[component] > at(low).orders()[component];
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if (at(middle).orders()[component] < target) == rises { low = middle } else { high = middle }
        }
        at(low)
    }

    /// Returns true for a good bearing on a good rotor.
    pub fn is_healthy(&self) -> bool {
        self.fault == "healthy"
    }

    /// Returns true for recordings of the same machine at the same speed.
    pub fn is_beside(&self, other: &Self) -> bool {
        self.dataset == other.dataset && self.rpm == other.rpm && self.elements == other.elements
    }
}

/// Reads the labels of a folder.
pub fn read(folder: &Path) -> Result<Vec<Recording>, Box<dyn Error>> {
    let text = fs::read_to_string(folder.join("labels.csv"))?;
    let mut lines = text.lines().map(cells);
    let header = lines.next().ok_or("labels.csv is empty")?;
    lines.filter(|cells| cells.len() > 1).map(|cells| recording(&header, &cells)).collect()
}

fn recording(header: &[String], cells: &[String]) -> Result<Recording, Box<dyn Error>> {
    let named: HashMap<&str, &str> = header.iter().map(String::as_str).zip(cells.iter().map(String::as_str)).collect();
    let text = |name: &str| named.get(name).copied().ok_or_else(|| format!("labels.csv has no column {name}"));
    let number = |name: &str| -> Result<f64, Box<dyn Error>> {
        let found = text(name)?;
        found.parse().map_err(|_| format!("labels.csv: {name} is {found:?}, expected a number").into())
    };
    Ok(Recording {
        file: text("file")?.to_owned(),
        dataset: text("dataset")?.to_owned(),
        fault: text("fault")?.to_owned(),
        elements: number("elements")? as usize,
        diameter_mm: number("diameter_mm")?,
        pitch_mm: number("pitch_mm")?,
        angle_deg: number("angle_deg")?,
        rpm: number("rpm")?,
        rate_hz: number("rate_hz")?,
        channels: number("channels")? as usize,
    })
}

/// Splits a line of a CSV file.
fn cells(line: &str) -> Vec<String> {
    let (mut cells, mut quoted) = (vec![String::new()], false);
    for c in line.chars() {
        match c {
            '"' => quoted = !quoted,
            ',' if !quoted => cells.push(String::new()),
            _ => cells.iter_mut().last().into_iter().for_each(|cell| cell.push(c)),
        }
    }
    cells
}
