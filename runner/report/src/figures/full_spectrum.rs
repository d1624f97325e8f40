//! Full spectra: forward and reverse precession in a plane.

use super::spectrum::full;
use super::{Context, Figure, Picture};
use anyhow::Result;
use ballrace_twin::replay::outcome::Pictures;

/// Full spectra, one per plane.
pub(super) struct FullSpectra;

impl Figure for FullSpectra {
    fn heading(&self) -> &'static str {
        "Full spectra"
    }

    fn lines(&self, data: &Pictures) -> usize {
        2 * data.full_spectra.len()
    }

    fn draw(&self, context: &Context<'_>) -> Result<Vec<Picture>> {
        let data = context.data;
        data.full_spectra.iter().map(|one| full(one, &data.lines, context.budget)).collect()
    }
}
