//! A scene and the studies on it.

use crate::balance::{BalanceOptions, highest_speed};
use crate::bearing::Bearing;
use crate::error::{exception, wrong_argument};
use crate::interrupt::interruptible;
use crate::outcome::Outcome;
use crate::quantity::Quantity;
use crate::recording::Source;
use crate::text::{json_of, page};
use ballrace_report as report;
use ballrace_twin::balance::{self, TolerancePlane, TwinCoefficients};
use ballrace_twin::campbell::campbell;
use ballrace_twin::equilibrium::static_equilibrium;
use ballrace_twin::error::Error;
use ballrace_twin::fit::parameters::{ALL, Group};
use ballrace_twin::fit::{FitPlan, fit_recording, written};
use ballrace_twin::motion::{self, Span};
use ballrace_twin::plant::Plant;
use ballrace_twin::replay::{Options, Source as ForceSource, replay};
use ballrace_twin::scene;
use ballrace_twin::scene::build::pick;
use ballrace_twin::scene::edit::{put, value_of_json};
use ballrace_twin::scene::read::{load, read_str};
use ballrace_twin::scene::units::Dimension;
use ballrace_twin::scene::{Clock, RotationSource};
use ballrace_twin::sweep::{Axis, Follow, Journal, Measure, Plan};
use ballrace_twin::thermal::thermal_equilibrium;
use ballrace_twin::trade::{self, Goal, Target};
use ballrace_twin::vectors::{RecordedRuns, vector_table};
use numpy::{IntoPyArray, PyArrayMethods};
use pyo3::exceptions::PyMemoryError;
use pyo3::prelude::*;
use serde_json::json;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Duration;

/// A scene: its text and its content.
#[pyclass(frozen, module = "ballrace._native")]
pub struct Scene {
    text: String,
    content: Arc<scene::Scene>,
}

/// Result of a trade study.
#[pyclass(frozen, module = "ballrace._native")]
pub struct Trade {
    result: trade::Trade,
    /// Text of the scene with the chosen model; `None` if no model is chosen.
    chosen: Option<String>,
}

#[pymethods]
impl Scene {
    /// Reads a scene file.
    #[staticmethod]
    fn read(py: Python<'_>, path: PathBuf) -> PyResult<Self> {
        let text = py.detach(|| load(&path)).map_err(|e| exception(py, e))?;
        Self::from_text(py, text, path)
    }

    /// Reads a scene from its text; `path` names it in errors and is the start of relative paths.
    #[staticmethod]
    fn from_text(py: Python<'_>, text: String, path: PathBuf) -> PyResult<Self> {
        let content = read_str(&text, &path).map_err(|e| exception(py, e))?;
        Ok(Self { text, content: Arc::new(content) })
    }

    #[getter]
    fn text(&self) -> &str {
        &self.text
    }

    #[getter]
    fn name(&self) -> &str {
        &self.content.name
    }

    #[getter]
    fn path(&self) -> &Path {
        &self.content.path
    }

    #[getter]
    fn bearing_names(&self) -> Vec<&str> {
        self.content.bearings.iter().map(|b| b.name.as_str()).collect()
    }

    /// Columns of a recording that the scene names; `None` without a recording.
    #[getter]
    fn columns(&self) -> Option<Vec<&str>> {
        let recording = self.content.recording.as_ref()?;
        let probes = recording.probes.iter().map(|p| p.column.as_str());
        let sensors = recording.sensors.iter().map(|s| s.column.as_str());
        let temperatures = recording.temperatures.iter().map(|t| t.column.as_str());
        let rotation = match &recording.rotation {
            RotationSource::Keyphasor { column, .. } | RotationSource::SpeedColumn { column, .. } => {
                Some(column.as_str())
            }
            RotationSource::Scene | RotationSource::Synchronous => None,
        };
        let clock = match &recording.clock {
            Clock::Column { name, .. } => Some(name.as_str()),
            Clock::Rate(_) | Clock::Stated | Clock::Number { .. } => None,
        };
        Some(probes.chain(sensors).chain(temperatures).chain(rotation).chain(clock).collect())
    }

    /// Returns the scene with another value at a key; `value` is JSON.
    fn with_value(&self, py: Python<'_>, key: &str, value: &str) -> PyResult<Self> {
        let wrong = |message: String| wrong_argument(py, &message);
        let json = serde_json::from_str(value).map_err(|e| wrong(e.to_string()))?;
        let Some(value) = value_of_json(&json) else {
            return Err(wrong(format!("{key}: {json}, expected a number, a text, a list or a table")));
        };
        let mut document = self.text.parse().map_err(|e| wrong(format!("{e}")))?;
        put(&mut document, key, value).map_err(|e| wrong(e.to_string()))?;
        Self::from_text(py, document.to_string(), self.content.path.clone())
    }

    /// Returns a bearing by its name.
    #[pyo3(signature = (name=None))]
    fn bearing(&self, py: Python<'_>, name: Option<&str>) -> PyResult<Bearing> {
        let found = pick(&self.content, name).map_err(|e| exception(py, Error::setup(e)))?;
        Bearing::new(py, self.content.clone(), self.text.clone(), found.clone())
    }

    /// Computes the static equilibrium; returns JSON and HTML.
    #[pyo3(signature = (bearing=None, load=None, thermal=false))]
    fn equilibrium(
        &self,
        py: Python<'_>,
        bearing: Option<&str>,
        load: Option<[f64; 5]>,
        thermal: bool,
    ) -> PyResult<(String, String)> {
        let solve = if thermal { thermal_equilibrium } else { static_equilibrium };
        let settled = interruptible(py, |_| solve(&self.content, bearing, load))?.map_err(|e| exception(py, e))?;
        Ok((json_of(py, &settled)?, page(py, report::equilibrium::html(&settled))?))
    }

    /// Computes the natural frequencies over the speed, with `speeds` as on the command line or in rad/s; returns JSON.
    fn campbell(&self, py: Python<'_>, speeds: &Bound<'_, PyAny>) -> PyResult<String> {
        let speeds: Vec<f64> = match speeds.extract::<String>() {
            Ok(text) => {
                let invalid = |e: &dyn std::fmt::Display| {
                    wrong_argument(py, &e.to_string().replace("--over", "speeds").replace("speed=", ""))
                };
                let axis = Axis::parse(&format!("speed={text}")).map_err(|e| invalid(&e))?;
                axis.in_si(Dimension::Speed).map_err(|e| invalid(&e))?
            }
            Err(_) => {
                let each: Vec<Quantity> = speeds.extract()?;
                each.iter().map(|speed| speed.si(py, "speeds", Dimension::Speed)).collect::<PyResult<_>>()?
            }
        };
        let diagram = interruptible(py, |_| campbell(&self.content, &speeds))?.map_err(|e| exception(py, e))?;
        json_of(py, &diagram)
    }

    /// Simulates the motion from equilibrium; returns the names of the columns and their values in an array of shape (samples, columns).
    #[pyo3(signature = (duration, rate, settle=None))]
    fn simulate<'py>(
        &self,
        py: Python<'py>,
        duration: Quantity,
        rate: Quantity,
        settle: Option<Quantity>,
    ) -> PyResult<(Vec<String>, Bound<'py, PyAny>)> {
        let duration = duration.si(py, "duration", Dimension::Time)?;
        let rate = rate.si(py, "rate", Dimension::Frequency)?;
        let settle = settle.map_or(Ok(0.0), |settle| settle.si(py, "settle", Dimension::Time))?;
        let span = Span::try_new(duration, rate, settle)
            .map_err(|invalid| wrong_argument(py, &format!("duration, rate, settle: {invalid}")))?;
        let computed = interruptible(py, |interrupt| {
            let plant = Plant::try_new(&self.content)?;
            let columns = motion::columns(&plant);
            let mut values = Vec::new();
            let count = columns.len().saturating_mul(span.samples as usize);
            if values.try_reserve_exact(count).is_err() {
                return Ok(None);
            }
            motion::run::<Error>(
                &self.content,
                &plant,
                span,
                |_| {},
                |now| {
                    values.extend(now.row());
                    interrupt.check();
                    Ok(())
                },
            )?;
            Ok::<_, Error>(Some((columns, values)))
        })?;
        let Some((columns, values)) = computed.map_err(|e| exception(py, e))? else {
            let message = format!("duration, rate: {} samples, expected a number that fits into memory", span.samples);
            return Err(PyMemoryError::new_err(message));
        };
        let shape = [values.len() / columns.len(), columns.len()];
        Ok((columns, values.into_pyarray(py).reshape(shape)?.into_any()))
    }

    /// Computes the response over ranges of keys, `KEY=VALUES` as on the command line; returns JSON of the rows and HTML.
    #[pyo3(signature = (over, settle=None, periods=96, by_shaft=false, follow="none", lyapunov=false, jobs=None))]
    #[expect(clippy::too_many_arguments, reason = "keyword arguments of Python")]
    fn sweep(
        &self,
        py: Python<'_>,
        over: Vec<String>,
        settle: Option<Quantity>,
        periods: usize,
        by_shaft: bool,
        follow: &str,
        lyapunov: bool,
        jobs: Option<usize>,
    ) -> PyResult<(String, String)> {
        let follow = match follow {
            "none" => Follow::None,
            "up" => Follow::Up,
            "down" => Follow::Down,
            "both" => Follow::Both,
            other => {
                return Err(wrong_argument(
                    py,
                    &format!("follow: {other:?}, expected \"none\", \"up\", \"down\" or \"both\""),
                ));
            }
        };
        if !(16..=4096).contains(&periods) {
            return Err(wrong_argument(py, &format!("periods: out of range: {periods}, expected 16 to 4096")));
        }
        let settle = settle.map(|settle| settle.si(py, "settle", Dimension::Time)).transpose()?;
        let measure = Measure { settle, periods, by_shaft, lyapunov };
        let jobs = jobs.or_else(|| std::thread::available_parallelism().ok().map(Into::into)).unwrap_or(1);
        let run = interruptible(py, |interrupt| {
            let axes = over.iter().map(|text| Axis::parse(text)).collect::<Result<Vec<_>, _>>()?;
            let path = self.content.path.clone();
            let plan = Plan { text: self.text.clone(), path, axes, follow, measure }.checked()?;
            for point in [0, plan.points().saturating_sub(1)] {
                plan.scene(&plan.values(point))?;
            }
            let folder = tempfile::tempdir()?;
            let journal = Journal::open(&folder.path().join("journal"), plan.identity()?)?;
            let chains: Vec<usize> = (0..plan.chains()).collect();
            let journal = plan.run(&chains, journal, jobs, || interrupt.check())?;
            let rows: Vec<_> = journal.done.values().flat_map(|chain| &chain.rows).collect();
            let html = report::sweep::html(&self.content.name, &plan.axes, &rows).map_err(|e| e.to_string());
            let axes: Vec<_> = plan.axes.iter().map(|axis| json!({ "key": axis.key, "unit": axis.unit })).collect();
            Ok::<_, Error>((json!({ "axes": axes, "rows": rows }).to_string(), html))
        })?;
        let (rows, html) = run.map_err(|e| exception(py, e))?;
        Ok((rows, page(py, html)?))
    }

    /// Computes error and cost of every model.
    #[pyo3(signature = (error=None, deadline=None, clock=None, on="cortex-m4f", forces_only=false))]
    fn trade(
        &self,
        py: Python<'_>,
        error: Option<f64>,
        deadline: Option<Quantity>,
        clock: Option<Quantity>,
        on: &str,
        forces_only: bool,
    ) -> PyResult<Trade> {
        let target = match on {
            "cortex-m4f" => Target::CortexM4f,
            "desktop" => Target::Desktop,
            other => return Err(wrong_argument(py, &format!("on: {other:?}, expected \"cortex-m4f\" or \"desktop\""))),
        };
        let goal = match (error, deadline, clock) {
            (None, None, None) => None,
            (Some(error), None, None) if error > 0.0 && error.is_finite() => Some(Goal::Error(error, target)),
            (None, Some(time), Some(clock)) => Some(Goal::Deadline {
                time: time.si(py, "deadline", Dimension::Time)?,
                clock: clock.si(py, "clock", Dimension::Frequency)?,
            }),
            _ => {
                let message = "error, deadline, clock: expected an error above 0, or deadline and clock together";
                return Err(wrong_argument(py, message));
            }
        };
        let run = interruptible(py, |interrupt| {
            let progress = |_: usize, _: usize| interrupt.check();
            let result = trade::trade(&self.content, &self.text, (goal.as_ref(), !forces_only), &progress)?;
            let choice = result.choice.as_ref();
            let chosen = choice.map(|choice| trade::written(&self.content, &self.text, &choice.model)).transpose()?;
            Ok::<_, Error>(Trade { result, chosen })
        })?;
        run.map_err(|e| exception(py, e))
    }

    /// Balances the rotor from recordings; returns JSON and HTML.
    #[pyo3(signature = (runs, trials, trims, planes, options))]
    fn balance(
        &self,
        py: Python<'_>,
        runs: Vec<PathBuf>,
        trials: Vec<(PathBuf, String)>,
        trims: Vec<(PathBuf, String)>,
        planes: Vec<String>,
        options: BalanceOptions,
    ) -> PyResult<(String, String)> {
        let scene = &self.content;
        let wrong = |message: String| wrong_argument(py, &message);
        if runs.is_empty() {
            return Err(wrong("runs: none, expected a recording without added masses".to_owned()));
        }
        let runs = RecordedRuns::new(scene, &runs, [&trials, &trims], &planes).map_err(|e| wrong(e.to_string()))?;
        let names: Vec<String> = runs.planes.iter().map(|plane| plane.name.clone()).collect();
        let placement = options.placement(py, &names)?;
        let found = py.detach(|| {
            let table = vector_table(scene, &runs)?;
            let twin = TwinCoefficients::new(scene, &runs.planes, &table)?;
            Ok::<_, Error>((balance::balance(&table, Some(&twin), &placement), highest_speed(&table)))
        });
        let (found, highest) = found.map_err(|e| exception(py, e))?;
        let mut found = found.map_err(|e| wrong(e.to_string()))?;
        let mass = scene.rotor.as_ref().map(|rotor| rotor.mass);
        let required = options.requirement(py, mass, highest, TolerancePlane::of_scene(scene, &runs.planes))?;
        found.quality = required.map(|required| required.quality(&found.correction));
        options.written(py, &scene.name, &found)
    }

    /// Estimates parameters from a recording; returns JSON and the text of the fitted scene.
    #[pyo3(signature = (recording, only=None, turns=64.0))]
    fn fit<'py>(
        &self,
        py: Python<'py>,
        recording: &Bound<'py, PyAny>,
        only: Option<Vec<String>>,
        turns: f64,
    ) -> PyResult<(String, String)> {
        if !(turns >= 1.0 && turns.is_finite()) {
            return Err(wrong_argument(py, &format!("turns: out of range: {turns}, expected 1 or more")));
        }
        let groups = only.map_or_else(|| Ok(ALL.to_vec()), |only| groups(py, &only))?;
        // The caller ends a fit that takes too long.
        let plan = FitPlan { groups: &groups, turns, time_limit: Duration::MAX };
        let source = Source::new(recording)?;
        let opening = source.opening(py, &self.content)?;
        let run = interruptible(py, |interrupt| {
            let (reader, name) = opening.reader(&self.content)?;
            let fitted = fit_recording(&self.content, reader, &name, &plan, &mut |_| interrupt.check())?;
            let text = written(&fitted, &self.content, &self.text)?;
            Ok::<_, Error>((fitted, text))
        })?;
        let (fitted, text) = run.map_err(|e| exception(py, e))?;
        Ok((json_of(py, &fitted)?, text))
    }

    /// Replays a recording.
    #[pyo3(signature = (recording, baseline=None, learn=false, error=None, forces=None, force_source="observer", force=false,
                        samples=false))]
    #[expect(clippy::too_many_arguments, reason = "keyword arguments of Python")]
    fn replay<'py>(
        &self,
        py: Python<'py>,
        recording: &Bound<'py, PyAny>,
        baseline: Option<PathBuf>,
        learn: bool,
        error: Option<f64>,
        forces: Option<PathBuf>,
        force_source: &str,
        force: bool,
        samples: bool,
    ) -> PyResult<Outcome> {
        let force_source = match force_source {
            "observer" => ForceSource::Observer,
            "displacement" => ForceSource::Displacement,
            other => {
                let message = format!("force_source: {other:?}, expected \"observer\" or \"displacement\"");
                return Err(wrong_argument(py, &message));
            }
        };
        let source = Source::new(recording)?;
        let opening = source.opening(py, &self.content)?;
        let run = interruptible(py, |interrupt| {
            let (reader, name) = opening.reader(&self.content)?;
            let progress = |_| interrupt.check();
            let options = Options {
                forces: forces.as_deref(),
                samples,
                source: force_source,
                error,
                baseline: baseline.as_deref(),
                learn,
                force_diagnosis: force,
                progress: Some(&progress),
                ..Options::default()
            };
            replay(&self.content, reader, &name, &options)
        })?;
        Outcome::new(py, run.map_err(|e| exception(py, e))?)
    }
}

/// Returns groups of parameters by their names on the command line.
fn groups(py: Python<'_>, names: &[String]) -> PyResult<Vec<Group>> {
    let group = |name: &String| {
        let found = ALL.into_iter().find(|group| group.name() == name);
        let all = || ALL.map(Group::name).join(", ");
        found.ok_or_else(|| wrong_argument(py, &format!("only: no such parameters: {name:?}, expected {}", all())))
    };
    names.iter().map(group).collect()
}

#[pymethods]
impl Trade {
    fn json(&self, py: Python<'_>) -> PyResult<String> {
        json_of(py, &self.result)
    }

    fn html(&self, py: Python<'_>) -> PyResult<String> {
        page(py, report::trade::html(&self.result))
    }

    #[getter]
    fn chosen(&self) -> Option<&str> {
        self.chosen.as_deref()
    }
}
