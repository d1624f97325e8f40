//! Evidence of the findings: the damaged bearing, the unexplained force, the motion with and without the fault.

use super::damaged_bearing::damaged_bearing;
use super::fault_motion::fault_motion;
use super::force_spectrum::force_spectra;
use super::{Context, Figure, Picture};
use ballrace_twin::replay::outcome::Finding;

/// Evidence of the findings of a diagnosis, up to three pictures each.
pub(super) struct Diagnoses;

impl Figure for Diagnoses {
    fn heading(&self) -> &'static str {
        "Diagnosis"
    }

    fn draw(&self, context: &Context<'_>) -> Vec<Picture> {
        let one = |finding: &Finding| -> Vec<Picture> {
            let figures = &finding.figures;
            let bearing = figures.rose.as_ref().map(|rose| damaged_bearing(finding, rose, context.forward));
            let motion = figures.motion.as_ref().map(|motion| fault_motion(finding, motion, context.budget));
            let spectra = (!figures.spectra.is_empty()).then(|| force_spectra(finding, context.budget));
            [bearing, spectra, motion].into_iter().flatten().collect()
        };
        context.outcome.findings.iter().flat_map(one).collect()
    }
}
