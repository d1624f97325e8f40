//! Full spectra: forward and reverse precession in a plane.

use super::spectrum::full;
use super::{Context, Figure, Picture, Source};
use ballrace_twin::replay::outcome::{FullSpectrum, Pictures};

/// Full spectra, one per plane.
pub(super) struct FullSpectra;

impl Figure for FullSpectra {
    fn heading(&self) -> &'static str {
        "Full spectra"
    }

    fn lines(&self, data: &Pictures) -> usize {
        4 * data.full_spectra.len()
    }

    fn draw(&self, context: &Context<'_>) -> Vec<Picture> {
        let data = context.data;
        let one = |(i, spectrum): (usize, &FullSpectrum)| Picture {
            source: Some(Source::FullSpectrum(i)),
            ..full(spectrum, data, context.budget)
        };
        data.full_spectra.iter().enumerate().map(one).collect()
    }
}
