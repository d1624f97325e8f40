//! The outcome of a replay.

use crate::error::wrong_argument;
use crate::text::{json_of, page};
use ballrace_report as report;
use ballrace_twin::outcome;
use numpy::{IntoPyArray, PyArrayMethods};
use pyo3::prelude::*;

/// Names of columns and their values, an array of shape (rows, columns).
type Table = (Vec<String>, Py<PyAny>);
/// Name, times (s), speeds (rpm), frequencies (Hz), and amplitudes (um) of shape (times, frequencies).
type Cascade<'py> = (String, Bound<'py, PyAny>, Bound<'py, PyAny>, Bound<'py, PyAny>, Bound<'py, PyAny>);

/// Outcome of a replay.
#[pyclass(frozen, module = "ballrace._native")]
pub struct Outcome {
    outcome: outcome::Outcome,
    samples: Option<Table>,
}

impl Outcome {
    /// Takes an outcome, whose samples become an array without a copy.
    ///
    /// # Errors
    /// Samples that are no table.
    pub fn new(py: Python<'_>, mut outcome: outcome::Outcome) -> PyResult<Self> {
        let samples = outcome.samples.take();
        let samples =
            samples.map(|of| Ok::<_, PyErr>((of.names.clone(), array(py, of.values, of.names.len())?.unbind())));
        Ok(Self { samples: samples.transpose()?, outcome })
    }
}

/// Returns values that are stored row by row as an array of shape (rows, columns).
fn array(py: Python<'_>, values: Vec<f64>, columns: usize) -> PyResult<Bound<'_, PyAny>> {
    let shape = [values.len() / columns.max(1), columns];
    Ok(values.into_pyarray(py).reshape(shape)?.into_any())
}

#[pymethods]
impl Outcome {
    fn json(&self, py: Python<'_>) -> PyResult<String> {
        page(py, report::json(&self.outcome))
    }

    fn html(&self, py: Python<'_>) -> PyResult<String> {
        py.detach(|| report::html(&self.outcome)).map_err(|e| wrong_argument(py, &format!("{e:#}")))
    }

    fn text(&self) -> String {
        report::text(&self.outcome)
    }

    /// Returns the learned baseline as JSON.
    fn baseline(&self, py: Python<'_>) -> PyResult<String> {
        if let Some(reason) = self.outcome.no_baseline() {
            return Err(wrong_argument(py, &format!("no baseline: {reason}")));
        }
        json_of(py, &self.outcome.learned)
    }

    /// Returns the table of all samples; `None` where they were not kept.
    fn samples(&self, py: Python<'_>) -> Option<Table> {
        self.samples.as_ref().map(|(names, values)| (names.clone(), values.clone_ref(py)))
    }

    /// Returns the amplitude spectra of every probe over the frequency.
    fn spectra<'py>(&self, py: Python<'py>) -> PyResult<(Vec<String>, Bound<'py, PyAny>)> {
        let spectra = &self.outcome.pictures.half_spectra;
        let mut names = vec!["frequency_hz".to_owned()];
        for spectrum in spectra {
            names.extend(["measured", "twin", "residual"].map(|kind| format!("{}_{kind}_um", spectrum.name)));
        }
        // All are of the same windows.
        let bins = spectra.first().map_or(0, |spectrum| spectrum.measured.len());
        let mut values = Vec::with_capacity(bins * names.len());
        for i in 0..bins {
            values.push(i as f64 * spectra[0].bin_hz);
            for spectrum in spectra {
                values.extend([&spectrum.measured, &spectrum.twin, &spectrum.residual].map(|amplitudes| amplitudes[i]));
            }
        }
        let columns = names.len();
        Ok((names, array(py, values, columns)?))
    }

    /// Returns the spectra in the order of time of every plane, or of every radial probe where there is no plane.
    fn cascades<'py>(&self, py: Python<'py>) -> PyResult<Vec<Cascade<'py>>> {
        let cascade = |of: &outcome::Cascade| {
            let bins = of.slices.first().map_or(0, |slice| slice.amplitude_um.len());
            let first = if of.two_sided { 0 } else { bins / 2 };
            let frequencies = (first..bins).map(|i| (i as f64 - (bins / 2) as f64) * of.bin_hz).collect::<Vec<_>>();
            let times: Vec<f64> = of.slices.iter().map(|slice| slice.time_s).collect();
            let speeds: Vec<f64> = of.slices.iter().map(|slice| slice.speed_rpm).collect();
            let amplitudes =
                of.slices.iter().flat_map(|slice| slice.amplitude_um.iter().skip(first)).copied().collect();
            let amplitudes = array(py, amplitudes, bins - first)?;
            let one = |values: Vec<f64>| values.into_pyarray(py).into_any();
            Ok((of.name.clone(), one(times), one(speeds), one(frequencies), amplitudes))
        };
        self.outcome.pictures.cascades.iter().map(cascade).collect()
    }
}
