//! Sweep of a scene over ranges of its keys, in parallel, with the results on disk as they are computed.

mod axis;
mod journal;
mod measure;
mod tables;

pub use axis::Axis;
pub use journal::{Journal, read};
pub use measure::{EffectChange, Figures, Measure, State, measure};
pub use tables::{csv, parquet, sections};

use crate::effect_significance::{self, EffectSignificance};
use ballrace_plant::error::{Error, Result, SweepError};
use ballrace_scene::Scene;
use ballrace_scene::edit::{dimension_of, put};
use ballrace_scene::read::read_str;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};
use toml_edit::DocumentMut;

/// How points follow each other along the first axis.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "clap", derive(clap::ValueEnum))]
pub enum Follow {
    /// Start each point from static equilibrium.
    None,
    /// Follow with increasing values.
    Up,
    /// Follow with decreasing values.
    Down,
    /// Follow up and then down; a difference between the two shows hysteresis.
    Both,
}

/// A whole sweep.
pub struct Plan {
    /// The scene's text.
    pub text: String,
    /// Path of the scene.
    pub path: PathBuf,
    /// The keys and their values; the first runs fastest.
    pub axes: Vec<Axis>,
    /// How points follow each other.
    pub follow: Follow,
    /// Options of every point.
    pub measure: Measure,
}

/// Points that are computed one after the other: a single point, or all along the first axis.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Chain {
    /// Number of the chain, from 0.
    pub number: usize,
    /// Its points in the order of computation.
    pub rows: Vec<Row>,
}

/// Results at one point.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Row {
    /// Number of the point, from 0; the same upwards and downwards.
    pub point: usize,
    /// `rest`, `up` or `down`.
    #[serde(alias = "way")]
    pub direction: String,
    /// Value of each axis in its unit.
    pub values: Vec<f64>,
    /// Measures of the motion.
    pub figures: Figures,
}

/// A point at which the motion overflows.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct OverflowedPoint {
    /// Number of the point.
    pub point: usize,
    /// `rest`, `up` or `down`.
    pub direction: String,
    /// The keys with their values.
    pub values: String,
    /// The error.
    pub reason: String,
}

/// Largest number of values in the results of a sweep: 1 GiB in memory at the end.
const MAX_NUMBERS: usize = 1 << 27;
/// Number of values of one point besides its sections.
const NUMBERS_OF_POINT: usize = 256;

/// Rejects numbers without a unit of a quantity whose usual unit is not that of SI.
pub(crate) fn check_units(text: &str, path: &Path, axes: &[Axis]) -> Result<(), SweepError> {
    for axis in axes.iter().filter(|axis| axis.unit.is_empty()) {
        let dimension = dimension_of(text, path, &axis.key);
        if let Some(expected) = dimension.and_then(|dimension| axis.likely(dimension)) {
            let found = format!("{}={}", axis.key, axis.range(""));
            return Err(SweepError::NoUnit { found, expected });
        }
    }
    Ok(())
}

/// Returns the value of each axis at a point; the first axis runs fastest.
pub(crate) fn values_at(axes: &[Axis], point: usize) -> Vec<f64> {
    let mut rest = point;
    let value = |axis: &Axis| {
        let count = axis.values.len().max(1);
        let value = axis.values.get(rest % count).copied().unwrap_or(0.0);
        rest /= count;
        value
    };
    axes.iter().map(value).collect()
}

/// Returns the scene of a text with these values of the axes.
///
/// # Errors
/// A key that the scene does not have, a value that it rejects.
pub(crate) fn scene_at(text: &str, path: &Path, axes: &[Axis], values: &[f64]) -> Result<Scene> {
    let syntax = |source| SweepError::Syntax { file: path.to_owned(), source };
    let mut document: DocumentMut = text.parse().map_err(syntax)?;
    for (axis, &value) in axes.iter().zip(values) {
        put(&mut document, &axis.key, axis.written(value)).map_err(SweepError::Key)?;
    }
    Ok(read_str(&document.to_string(), path)?)
}

/// Returns the axes with their values at a point.
pub(crate) fn named(axes: &[Axis], values: &[f64]) -> String {
    let one = |(axis, value): (&Axis, &f64)| format!("{} = {value} {}", axis.key, axis.unit);
    let all: Vec<String> = axes.iter().zip(values).map(one).collect();
    all.iter().map(|one| one.trim_end()).collect::<Vec<_>>().join(", ")
}

impl Plan {
    /// Checks the units of the axes, and the number of points before memory for them is allocated.
    ///
    /// # Errors
    /// Results of more than 2^27 numbers; numbers without a unit where the usual unit is not that of SI.
    pub fn checked(self) -> Result<Self> {
        let both_ways = if self.follow == Follow::Both { 2 } else { 1 };
        let most = MAX_NUMBERS / (both_ways * (NUMBERS_OF_POINT + 2 * self.measure.periods));
        let points = self.axes.iter().try_fold(1_usize, |product, axis| product.checked_mul(axis.values.len()));
        if points.is_some_and(|points| points <= most) {
            check_units(&self.text, &self.path, &self.axes)?;
            return Ok(self);
        }
        let counts: Vec<String> = self.axes.iter().map(|axis| axis.values.len().to_string()).collect();
        Err(SweepError::Points { found: counts.join(" x "), most, periods: self.measure.periods }.into())
    }

    /// Returns the number of points.
    #[must_use]
    pub fn points(&self) -> usize {
        self.axes.iter().map(|axis| axis.values.len()).product()
    }

    fn along(&self) -> usize {
        self.axes.first().map_or(1, |axis| axis.values.len())
    }

    /// Returns the number of chains.
    #[must_use]
    pub fn chains(&self) -> usize {
        match self.follow {
            Follow::None => self.points(),
            Follow::Up | Follow::Down => self.points() / self.along(),
            Follow::Both => 2 * self.points() / self.along(),
        }
    }

    /// Returns the identity of this sweep, which a journal stores.
    ///
    /// # Errors
    /// None in practice.
    pub fn identity(&self) -> Result<String, SweepError> {
        let axes: Vec<_> = self.axes.iter().map(|a| (&a.key, &a.values, &a.unit)).collect();
        let all = serde_json::to_string(&(env!("CARGO_PKG_VERSION"), &self.text, axes, self.follow, &self.measure))?;
        // FNV-1a.
        let hash = all.bytes().fold(0xcbf2_9ce4_8422_2325_u64, |h, b| (h ^ u64::from(b)).wrapping_mul(0x100_0000_01b3));
        Ok(format!("{hash:016x}"))
    }

    /// Returns the points of chain `number` in the order of computation, and their direction.
    fn chain(&self, number: usize) -> (Vec<usize>, &'static str) {
        let along = self.along();
        let up = |which: usize| (which * along..(which + 1) * along).collect::<Vec<_>>();
        let down = |which: usize| up(which).into_iter().rev().collect();
        match self.follow {
            Follow::None => (vec![number], "rest"),
            Follow::Up => (up(number), "up"),
            Follow::Down => (down(number), "down"),
            Follow::Both if number.is_multiple_of(2) => (up(number / 2), "up"),
            Follow::Both => (down(number / 2), "down"),
        }
    }

    /// Returns the value of each axis at a point.
    #[must_use]
    pub fn values(&self, point: usize) -> Vec<f64> {
        values_at(&self.axes, point)
    }

    /// Returns the scene at a point.
    ///
    /// # Errors
    /// A key that the scene does not have, a value that it rejects.
    pub fn scene(&self, values: &[f64]) -> Result<Scene> {
        scene_at(&self.text, &self.path, &self.axes, values)
    }

    /// Computes one chain.
    ///
    /// # Errors
    /// As [`measure`], with the point named.
    pub fn compute(&self, number: usize) -> Result<Chain> {
        let (points, direction) = self.chain(number);
        let (mut rows, mut state) = (Vec::new(), None);
        for point in points {
            let values = self.values(point);
            let (figures, end) =
                self.scene(&values)
                    .and_then(|scene| measure(&scene, &self.measure, state.as_ref()))
                    .map_err(|error| Error::Point { point: self.named(&values), source: Box::new(error) })?;
            state = end.filter(|_| self.follow != Follow::None);
            rows.push(Row { point, direction: direction.to_owned(), values, figures });
        }
        Ok(Chain { number, rows })
    }

    /// Returns each effect at the point of `rows` where its change of force is largest, with that point named.
    ///
    /// # Errors
    /// Returns an error if the kernel rejects a parameter.
    pub fn significance(&self, rows: &[&Row]) -> Result<Vec<EffectSignificance>> {
        let mut worst: BTreeMap<(&str, &str), (f64, &Row)> = BTreeMap::new();
        for row in rows {
            for EffectChange { bearing, effect, change } in &row.figures.effects {
                let entry = worst.entry((bearing, effect)).or_insert((*change, row));
                if *change > entry.0 {
                    *entry = (*change, row);
                }
            }
        }
        let mut points: Vec<&Row> = worst.into_values().map(|(_, row)| row).collect();
        points.sort_by_key(|row| row.point);
        points.dedup_by_key(|row| row.point);
        let mut all = Vec::new();
        for row in points {
            let point = self.named(&row.values);
            let at = |effect: &EffectSignificance| match &effect.at {
                Some(speed) => format!("{point}, {speed}"),
                None => point.clone(),
            };
            let of_point = effect_significance::of_scene(&self.scene(&row.values)?)?;
            all.extend(of_point.into_iter().map(|effect| EffectSignificance { at: Some(at(&effect)), ..effect }));
        }
        Ok(effect_significance::largest(all))
    }

    /// Returns the points at which the motion overflows, in the order of `rows`.
    #[must_use]
    pub fn overflowed(&self, rows: &[&Row]) -> Vec<OverflowedPoint> {
        let point = |row: &&Row| {
            let reason = row.figures.overflow.clone()?;
            Some(OverflowedPoint {
                point: row.point,
                direction: row.direction.clone(),
                values: self.named(&row.values),
                reason,
            })
        };
        rows.iter().filter_map(point).collect()
    }

    fn named(&self, values: &[f64]) -> String {
        named(&self.axes, values)
    }

    /// Computes the `chains` that the journal does not have, `jobs` in parallel; calls `progress` after each.
    ///
    /// # Errors
    /// The first error; earlier results stay in the journal.
    pub fn run(&self, chains: &[usize], journal: Journal, jobs: usize, progress: impl Fn() + Sync) -> Result<Journal> {
        let open: Vec<usize> = chains.iter().copied().filter(|number| !journal.done.contains_key(number)).collect();
        let (next, journal, failed) = (AtomicUsize::new(0), Mutex::new(journal), Mutex::new(None));
        let work = || {
            while let Some(&number) = open.get(next.fetch_add(1, Ordering::Relaxed)) {
                let found = self.compute(number).and_then(|chain| Ok(locked(&journal).add(chain)?));
                if let Err(error) = found {
                    locked(&failed).get_or_insert(error);
                    next.store(open.len(), Ordering::Relaxed);
                }
                progress();
            }
        };
        std::thread::scope(|scope| {
            let mut threads = Vec::new();
            for _ in 0..jobs.clamp(1, open.len().max(1)) {
                match std::thread::Builder::new().name("sweep".to_owned()).spawn_scoped(scope, work) {
                    Ok(thread) => threads.push(thread),
                    Err(error) => {
                        locked(&failed).get_or_insert(Error::from(error));
                    }
                }
            }
            // The caller ends the work by unwinding from `progress`. A scope that finds a thread unwound prints a panic of its own.
            let ends: Vec<_> = threads.into_iter().map(std::thread::ScopedJoinHandle::join).collect();
            for end in ends {
                end.unwrap_or_else(|payload| std::panic::resume_unwind(payload));
            }
        });
        match locked(&failed).take() {
            Some(error) => Err(error),
            None => Ok(journal.into_inner().unwrap_or_else(std::sync::PoisonError::into_inner)),
        }
    }
}

/// Locks a mutex; a thread that panicked leaves consistent data.
fn locked<T>(mutex: &Mutex<T>) -> std::sync::MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(std::sync::PoisonError::into_inner)
}
