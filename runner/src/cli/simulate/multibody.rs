//! Balls and cage of the bearings whose model is `multibody`: file of their motion, page, summary.

use crate::error::UsageError;
use anyhow::Result;
use ballrace_report::element_motion::{self, RecordedBearing};
use ballrace_twin::motion::{ResponseSample, Span};
use ballrace_twin::multibody::{Balance, ElementMotion};
use ballrace_twin::output::AtomicFile;
use ballrace_twin::plant::{Plant, Twin};
use ballrace_twin::recording::write::{Writer, WrittenColumn};
use ballrace_twin::scene::Scene;
use serde::Serialize;
use std::path::{Path, PathBuf};

/// Largest number of samples of a page and a summary.
const MAX_SAMPLES: u64 = 4000;

/// Motion of balls and cage during a simulation.
pub(super) struct Bodies {
    /// Number of each bearing in the scene, and what is kept of it.
    bearings: Vec<(usize, RecordedBearing)>,
    writer: Option<Writer>,
    report: Option<PathBuf>,
    /// One in so many samples is kept.
    every: u64,
    index: u64,
}

/// Checks and mean values.
#[derive(Serialize)]
pub(super) struct Summary {
    bearings: Vec<BearingSummary>,
    steps: u64,
    repeated_steps: u64,
    steps_to_a_contact: u64,
    #[serde(skip)]
    pub(super) text: String,
}

#[derive(Serialize)]
struct BearingSummary {
    name: String,
    mean_cage_slip: f64,
    mean_loss_w: f64,
    #[serde(skip_serializing_if = "Option::is_none")]
    energy_error: Option<f64>,
    momentum_error: f64,
    angular_momentum_error: f64,
}

impl Bodies {
    /// Begins the outputs; `None` for a scene without such a bearing.
    ///
    /// # Errors
    /// An output that needs such a bearing, or that cannot be written.
    pub(super) fn try_new(
        scene: &Scene,
        plant: &Plant,
        span: Span,
        (elements, report): (Option<&Path>, Option<&Path>),
    ) -> Result<Option<Self>> {
        let recorded = plant.bearings.iter().enumerate().filter_map(|(i, mounted)| {
            let cage = mounted.multibody.as_ref()?.params().cage;
            Some((
                i,
                RecordedBearing { name: mounted.name.clone(), cage, samples: vec![], balance: Balance::default() },
            ))
        });
        let bearings: Vec<(usize, RecordedBearing)> = recorded.collect();
        if bearings.is_empty() {
            return match elements.map(|_| "--elements").or(report.map(|_| "--report")) {
                Some(option) => Err(UsageError(format!(
                    "{option}: no bearing with model = \"multibody\" in {}, expected one",
                    scene.path.display()
                ))
                .into()),
                None => Ok(None),
            };
        }
        let time = WrittenColumn { name: "t".to_owned(), unit: Some("s") };
        let of_bearing = |(i, bearing): &(usize, RecordedBearing)| {
            let elements = plant.bearings.get(*i).map_or(0, |mounted| mounted.elements);
            let prefix = bearing.name.clone();
            ElementMotion::columns(elements)
                .map(move |(name, unit)| WrittenColumn { name: format!("{prefix}_{name}"), unit: Some(unit) })
        };
        let columns: Vec<WrittenColumn> = std::iter::once(time).chain(bearings.iter().flat_map(of_bearing)).collect();
        Ok(Some(Self {
            bearings,
            writer: elements.map(|path| Writer::create(path, &columns, span.samples)).transpose()?,
            report: report.map(Path::to_owned),
            every: span.samples.div_ceil(MAX_SAMPLES).max(1),
            index: 0,
        }))
    }

    /// Adds a sample.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub(super) fn add(&mut self, now: &ResponseSample<'_>) -> Result<()> {
        let is_kept = self.index.is_multiple_of(self.every);
        self.index += 1;
        if !is_kept && self.writer.is_none() {
            return Ok(());
        }
        let mut row = vec![now.time];
        for (i, bearing) in &mut self.bearings {
            let Some(motion) = now.twin.element_motion(*i) else { continue };
            row.extend(motion.values());
            if is_kept {
                bearing.samples.push((now.time, motion));
            }
        }
        match &mut self.writer {
            Some(writer) => Ok(writer.add(&row)?),
            None => Ok(()),
        }
    }

    /// Completes the files.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub(super) fn finish(mut self, scene: &str, twin: &dyn Twin) -> Result<Summary> {
        if let Some(writer) = self.writer {
            writer.finish()?;
        }
        let checks = twin.multibody_checks().unwrap_or_default();
        for (i, bearing) in &mut self.bearings {
            let own = checks.balances.iter().find(|(index, _)| index == i);
            bearing.balance = own.map(|(_, balance)| *balance).unwrap_or_default();
        }
        let bearings: Vec<RecordedBearing> = self.bearings.into_iter().map(|(_, bearing)| bearing).collect();
        if let Some(path) = &self.report {
            AtomicFile::write(path, &element_motion::html(scene, &bearings)?)?;
        }
        let summary = |bearing: &RecordedBearing| BearingSummary {
            name: bearing.name.clone(),
            mean_cage_slip: bearing.mean(ElementMotion::cage_slip),
            mean_loss_w: bearing.mean(|motion| motion.loss.iter().sum()),
            energy_error: bearing.balance.energy,
            momentum_error: bearing.balance.momentum,
            angular_momentum_error: bearing.balance.angular_momentum,
        };
        Ok(Summary {
            text: element_motion::text(&bearings, checks.steps, self.every),
            bearings: bearings.iter().map(summary).collect(),
            steps: checks.steps.taken,
            repeated_steps: checks.steps.rejected,
            steps_to_a_contact: checks.steps.events,
        })
    }
}
