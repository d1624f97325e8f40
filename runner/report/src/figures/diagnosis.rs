//! Evidence of the diagnoses: the damaged bearing, the unexplained force, the motion with and without the fault.

use super::damaged_bearing::damaged_bearing;
use super::fault_motion::fault_motion;
use super::force_spectrum::force_spectra;
use super::{Context, Figure, Picture};
use ballrace_twin::replay::outcome::Diagnosis;

/// Evidence of the diagnoses, up to three pictures each.
pub(super) struct Diagnoses;

impl Figure for Diagnoses {
    fn heading(&self) -> &'static str {
        "Diagnosis"
    }

    fn draw(&self, context: &Context<'_>) -> Vec<Picture> {
        let one = |diagnosis: &Diagnosis| -> Vec<Picture> {
            let figures = &diagnosis.figures;
            let bearing = figures.rose.as_ref().map(|rose| damaged_bearing(diagnosis, rose, context.forward));
            let motion = figures.motion.as_ref().map(|motion| fault_motion(diagnosis, motion, context.budget));
            let spectra = (!figures.spectra.is_empty()).then(|| force_spectra(diagnosis, context.budget));
            [bearing, spectra, motion].into_iter().flatten().collect()
        };
        context.outcome.diagnoses.iter().flat_map(one).collect()
    }
}
