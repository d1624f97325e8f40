//! One bearing: force, stiffness and element loads at given displacements.

use crate::array::{checked, read, unmasked, write};
use crate::error::{exception, wrong_argument};
use crate::interrupt::interruptible;
use ballrace::bearing::Bearing as _;
use ballrace::bearing::lumped::LARGEST_PLAY;
use ballrace::{BearingKinematicState, Displacement, Phase, Status};
use ballrace_twin::error::Error;
use ballrace_twin::force::{BearingForce, MathBackend, Precision, bearing_model};
use ballrace_twin::handle::AnyBearing;
use ballrace_twin::scene::build::rotation_at;
use ballrace_twin::scene::{self, Model};
use numpy::ndarray::{Ix1, Ix2};
use numpy::{IntoPyArray, PyArray1, PyArray2, PyArrayDyn, PyArrayMethods, PyReadonlyArray1, PyUntypedArrayMethods};
use pyo3::exceptions::PyRuntimeWarning;
use pyo3::prelude::*;
use std::sync::{Arc, Mutex, PoisonError};

/// Model, precision and math of a force.
type Choice = (Model, Precision, MathBackend);

/// Number of displacements up to which Ctrl-C waits for the result: a thread of its own takes longer to start than they take.
const AT_ONCE: usize = 256;

/// A bearing of a scene. Each model is built at its first use and stored.
#[pyclass(frozen, module = "ballrace")]
pub struct Bearing {
    scene: Arc<scene::Scene>,
    /// Text of the scene.
    text: String,
    bearing: scene::Bearing,
    forces: Mutex<Vec<(Choice, Arc<BearingForce>)>>,
    models: Mutex<Vec<(Model, AnyBearing<f64>)>>,
    /// Kinematic state at time 0.
    at_start: BearingKinematicState<f64>,
}

impl Bearing {
    pub fn new(py: Python<'_>, scene: Arc<scene::Scene>, text: String, bearing: scene::Bearing) -> PyResult<Self> {
        let at_start = rotation_at(&scene, &bearing, 0.0).map_err(|e| exception(py, e))?;
        Ok(Self { scene, text, bearing, forces: Mutex::default(), models: Mutex::default(), at_start })
    }

    fn model(&self, py: Python<'_>, name: Option<&str>) -> PyResult<Model> {
        let Some(name) = name else { return Ok(self.bearing.model) };
        let names = Model::with_forces().map(Model::name).collect::<Vec<_>>().join(", ");
        Model::from_name(name)
            .ok_or_else(|| wrong_argument(py, &format!("model: no such model: {name:?}, expected one of {names}")))
    }

    fn force_of(&self, py: Python<'_>, choice: Choice) -> PyResult<Arc<BearingForce>> {
        let (model, precision, math) = choice;
        let build = || BearingForce::try_new(&self.scene, &self.bearing, model, (precision, math)).map(Arc::new);
        kept(py, &self.forces, choice, build)
    }

    fn model_of(&self, py: Python<'_>, model: Model) -> PyResult<AnyBearing<f64>> {
        kept(py, &self.models, model, || bearing_model(&self.scene, &self.bearing, model))
    }
}

/// Returns the stored value of `key`, or builds it with the interpreter detached. The lock is not held during the build: a thread that
/// waits for the lock holds the interpreter, which the building thread needs at its end.
fn kept<K: Copy + PartialEq + Send, V: Clone + Send>(
    py: Python<'_>,
    all: &Mutex<Vec<(K, V)>>,
    key: K,
    build: impl FnOnce() -> Result<V, Error> + Send,
) -> PyResult<V> {
    let lock = || all.lock().unwrap_or_else(PoisonError::into_inner);
    let found = lock().iter().find(|(own, _)| *own == key).map(|(_, value)| value.clone());
    if let Some(value) = found {
        return Ok(value);
    }
    let value = py.detach(build).map_err(|e| exception(py, e))?;
    lock().push((key, value.clone()));
    Ok(value)
}

/// Angles of the cage or times: none, one for all displacements, or one for each.
enum PerSample<'py> {
    None,
    One(f64),
    Each(PyReadonlyArray1<'py, f64>),
}

/// Borrowed values of a [`PerSample`], for use while the interpreter is detached.
#[derive(Clone, Copy)]
enum Values<'a> {
    None,
    One(f64),
    Each(&'a [f64]),
}

impl<'py> PerSample<'py> {
    fn new(name: &str, given: Option<&Bound<'py, PyAny>>, n: usize) -> PyResult<Self> {
        let Some(given) = given else { return Ok(Self::None) };
        let wrong = |found: &str| {
            wrong_argument(
                given.py(),
                &format!("{name}: {found}, expected one finite number or an array of shape ({n},)"),
            )
        };
        if let Ok(one) = given.extract::<f64>() {
            return if one.is_finite() { Ok(Self::One(one)) } else { Err(wrong(&format!("not finite: {one}"))) };
        }
        unmasked(name, given)?;
        let numbers = match given.cast::<PyArray1<f64>>() {
            Ok(array) if array.is_c_contiguous() => given.clone(),
            _ => given.py().import(FRAMES)?.call_method1("numbers", (name, given))?,
        };
        let array = read(name, &checked::<f64, Ix1>(name, &numbers, &format!("of shape ({n},)"))?)?;
        if array.len() != n {
            return Err(wrong(&format!("{} values", array.len())));
        }
        match array.as_slice()?.iter().position(|x| !x.is_finite()) {
            None => Ok(Self::Each(array)),
            Some(i) => Err(wrong(&format!("value {i} is not finite"))),
        }
    }

    fn values(&self) -> PyResult<Values<'_>> {
        Ok(match self {
            Self::None => Values::None,
            Self::One(x) => Values::One(*x),
            Self::Each(array) => Values::Each(array.as_slice()?),
        })
    }
}

impl Values<'_> {
    fn at(self, i: usize) -> Option<f64> {
        match self {
            Self::None => None,
            Self::One(x) => Some(x),
            Self::Each(all) => all.get(i).copied(),
        }
    }
}

/// Module of Python that makes arrays of lists, frames and tables.
const FRAMES: &str = "ballrace._frames";

/// Displacements from Python as rows of five numbers; `is_single` is true for one row of shape (5,).
struct Rows<'py> {
    array: Bound<'py, PyArrayDyn<f64>>,
    is_single: bool,
    /// True for a frame or table, whose forces are one too.
    has_columns: bool,
    /// True for an array of `float32`.
    is_single_precision: bool,
}

impl<'py> Rows<'py> {
    fn new(given: &Bound<'py, PyAny>) -> PyResult<Self> {
        unmasked("u", given)?;
        let as_it_is = given.cast::<PyArray2<f64>>().is_ok_and(|array| array.is_c_contiguous())
            || given.cast::<PyArray1<f64>>().is_ok_and(|array| array.is_contiguous());
        if as_it_is {
            return Self::of_array(given);
        }
        let converted = given.py().import(FRAMES)?.call_method1("displacements", (given,))?;
        let (array, has_columns, is_single_precision): (Bound<'py, PyAny>, bool, bool) = converted.extract()?;
        Ok(Self { has_columns, is_single_precision, ..Self::of_array(&array)? })
    }

    /// Takes an array of double precision that is stored in rows.
    fn of_array(given: &Bound<'py, PyAny>) -> PyResult<Self> {
        let (has_columns, is_single_precision) = (false, false);
        if let Ok(single) = given.cast::<PyArray1<f64>>()
            && single.len() == 5
        {
            let array = single.to_dyn().clone();
            return Ok(Self { array, is_single: true, has_columns, is_single_precision });
        }
        let array = checked::<f64, Ix2>("u", given, "of shape (n, 5)")?;
        if array.shape().get(1) != Some(&5) {
            let message = format!("u: of shape {:?}, expected (n, 5): u, v, w (m), thu, thv (rad)", array.shape());
            return Err(wrong_argument(given.py(), &message));
        }
        Ok(Self { array: array.to_dyn().clone(), is_single: false, has_columns, is_single_precision })
    }

    fn len(&self) -> usize {
        self.array.len() / 5
    }
}

/// Checks displacements whose flags the caller does not take.
fn check_rows(py: Python<'_>, of: &scene::Bearing, rows: &[[f64; 5]]) -> PyResult<()> {
    let most = of.diameters().map_or(LARGEST_PLAY, |[element, _]| element);
    // One pass through memory for ordinary displacements.
    if rows.iter().all(|[u, v, w, thu, thv]| [u, v, w].iter().all(|x| x.abs() <= most) && (thu + thv).is_finite()) {
        return Ok(());
    }
    not_finite(py, rows)?;
    within_bearing(py, most, rows)
}

fn not_finite(py: Python<'_>, rows: &[[f64; 5]]) -> PyResult<()> {
    match rows.iter().position(|row| !row.iter().all(|x| x.is_finite())) {
        None => Ok(()),
        Some(i) => {
            let message =
                format!("u: row {i} is not finite, expected numbers, or status= to repeat the last valid force");
            Err(wrong_argument(py, &message))
        }
    }
}

/// Warns of displacements beyond the diameter of an element, at which no bearing is one: lengths in another unit.
fn within_bearing(py: Python<'_>, most: f64, rows: &[[f64; 5]]) -> PyResult<()> {
    let is_beyond = |row: &[f64; 5]| row.iter().take(3).any(|x| x.abs() > most);
    let Some(first) = rows.iter().position(is_beyond) else { return Ok(()) };
    let count = rows.iter().filter(|row| is_beyond(row)).count();
    let message = format!(
        "u: {count} of {} displacements are beyond {:.1} mm, the diameter of an element or the largest play, the first at row {first}, expected m",
        rows.len(),
        1e3 * most
    );
    PyErr::warn(py, &py.get_type::<PyRuntimeWarning>(), &std::ffi::CString::new(message)?, 1)
}

/// Checks that each force is that of its displacement, where the caller does not take the flags. Inaccurate forces raise a warning.
fn without_flags(py: Python<'_>, flags: &[Status]) -> PyResult<()> {
    if let Some(i) = flags.iter().position(|flags| flags.contains(Status::RESULT_NOT_FINITE)) {
        let message = format!(
            "u: the force at row {i} overflows, expected a displacement within the bearing, or status= to repeat the last valid force"
        );
        return Err(wrong_argument(py, &message));
    }
    for (flag, what) in
        [(Status::NOT_CONVERGED, "have not converged"), (Status::OUT_OF_TABLE, "are outside the table of the model")]
    {
        let count = flags.iter().filter(|flags| flags.contains(flag)).count();
        if let (1.., Some(first)) = (count, flags.iter().position(|flags| flags.contains(flag))) {
            let message = format!(
                "force: {count} of {} forces {what} and are inaccurate, the first at row {first}; status= has the flags of each",
                flags.len()
            );
            let message = std::ffi::CString::new(message)?;
            PyErr::warn(py, &py.get_type::<PyRuntimeWarning>(), &message, 1)?;
        }
    }
    Ok(())
}

/// Does `work` on `n` displacements without the interpreter. It gets a function to call before each displacement, which ends the
/// work of many by Ctrl-C.
fn without_interpreter<T: Send>(
    py: Python<'_>,
    n: usize,
    work: impl FnOnce(&(dyn Fn() + Sync)) -> T + Send,
) -> PyResult<T> {
    if n <= AT_ONCE {
        return Ok(py.detach(|| work(&|| ())));
    }
    interruptible(py, |interrupt| work(&|| interrupt.check()))
}

#[pymethods]
impl Bearing {
    /// Name of the bearing in the scene.
    #[getter]
    fn name(&self) -> &str {
        &self.bearing.name
    }

    /// Number of rolling elements.
    #[getter]
    fn elements(&self) -> usize {
        self.bearing.elements
    }

    /// Computes forces and moments on the inner ring.
    ///
    /// Parameters
    /// ----------
    /// u : array, list, frame, table or dictionary
    ///     Displacements of the inner ring against the outer ring: ``u, v, w`` (m), ``thu, thv`` (rad), of shape (n, 5) or (5,); or a frame,
    ///     a table or a dictionary with these columns.
    /// cage_angle : float or array, optional
    ///     Angle of the cage, rad: one or one for each displacement.
    /// time : float or array, optional
    ///     Time of the scene, s, from which all angles follow.
    /// model : str, optional
    ///     Bearing model; the scene's by default.
    /// precision : {"f64", "f32"}, optional
    ///     "f32" for an array of float32, else "f64", by default.
    /// math : {"exact", "fast"}
    ///     Functions as firmware has them.
    /// out : array of float64, optional
    ///     Array for the result.
    /// status : array of uint8, optional
    ///     Array for the flags of :class:`ballrace.Status`; with it, a displacement that is not finite repeats the last valid force.
    ///
    /// Returns
    /// -------
    /// array or table
    ///     ``FX, FY, FZ`` (N), ``MX, MY`` (N m), of the shape of ``u``, or the same kind of table.
    ///
    /// Examples
    /// --------
    /// >>> import ballrace
    /// >>> bearing = ballrace.Scene.demonstration().bearing("DE")
    /// >>> force = bearing.force([10e-6, -20e-6, 0.0, 0.0, 0.0], cage_angle=0.1)
    /// >>> force.round(1).tolist()[:2]
    /// [-538.3, 1133.7]
    #[pyo3(signature = (u, *, cage_angle=None, time=None, model=None, precision=None, math="exact", out=None, status=None))]
    #[expect(clippy::too_many_arguments, reason = "keyword arguments of Python")]
    fn force<'py>(
        &self,
        py: Python<'py>,
        u: &Bound<'py, PyAny>,
        cage_angle: Option<&Bound<'py, PyAny>>,
        time: Option<&Bound<'py, PyAny>>,
        model: Option<&str>,
        precision: Option<&str>,
        math: &str,
        out: Option<&Bound<'py, PyAny>>,
        status: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let rows = Rows::new(u)?;
        let precision = match precision {
            None if rows.is_single_precision => Precision::F32,
            None | Some("f64") => Precision::F64,
            Some("f32") => Precision::F32,
            Some(other) => {
                return Err(wrong_argument(py, &format!("precision: {other:?}, expected \"f64\" or \"f32\"")));
            }
        };
        let math = match math {
            "exact" => MathBackend::Exact,
            "fast" => MathBackend::Fast,
            other => return Err(wrong_argument(py, &format!("math: {other:?}, expected \"exact\" or \"fast\""))),
        };
        let force = self.force_of(py, (self.model(py, model)?, precision, math))?;
        let n = rows.len();
        let (angles, times) = (PerSample::new("cage_angle", cage_angle, n)?, PerSample::new("time", time, n)?);
        let result = match out {
            Some(out) if rows.is_single => checked::<f64, Ix1>("out", out, "of shape (5,)")?.to_dyn().clone(),
            Some(out) => checked::<f64, Ix2>("out", out, "of shape (n, 5)")?.to_dyn().clone(),
            None => PyArrayDyn::zeros(py, rows.array.shape(), false),
        };
        if result.shape() != rows.array.shape() {
            let expected = if rows.is_single { "(5,)".to_owned() } else { format!("({n}, 5)") };
            return Err(wrong_argument(py, &format!("out: of shape {:?}, expected {expected}", result.shape())));
        }
        let displacements = read("u", &rows.array)?;
        let (displacements, _) = displacements.as_slice()?.as_chunks::<5>();
        let mut flags = vec![Status::OK; n];
        if status.is_none() {
            check_rows(py, &self.bearing, displacements)?;
        }
        {
            let mut forces = write("out", &result)?;
            let (forces, _) = forces.as_slice_mut()?.as_chunks_mut::<5>();
            let (angles, times) = (angles.values()?, times.values()?);
            let flags = &mut flags;
            without_interpreter(py, n, |check| {
                let at = |i: usize| {
                    check();
                    self.rotation(angles.at(i), times.at(i))
                };
                force.evaluate(displacements, &at, forces, flags);
            })?;
        }
        if status.is_none() {
            without_flags(py, &flags)?;
        }
        if let Some(status) = status {
            let status = checked::<u8, Ix1>("status", status, "of shape (n,)")?;
            if status.len() != n {
                return Err(wrong_argument(py, &format!("status: {} values, expected {n}", status.len())));
            }
            let mut status = write("status", &status)?;
            for (to, flags) in status.as_slice_mut()?.iter_mut().zip(flags) {
                *to = flags.bits();
            }
        }
        match out {
            Some(out) => Ok(out.clone()),
            None if rows.has_columns => py.import(FRAMES)?.call_method1("forces", (result, u)),
            None => {
                let result = result.into_any();
                if rows.is_single_precision { result.call_method1("astype", ("float32",)) } else { Ok(result) }
            }
        }
    }

    /// Computes the tangent stiffness ``-d(force)/d(u)``.
    ///
    /// Parameters
    /// ----------
    /// u : array, list, frame, table or dictionary
    ///     Displacements of the inner ring against the outer ring: ``u, v, w`` (m), ``thu, thv`` (rad), of shape (n, 5) or (5,); or a frame,
    ///     a table or a dictionary with these columns.
    /// cage_angle : float or array, optional
    ///     Angle of the cage, rad: one or one for each displacement.
    /// time : float or array, optional
    ///     Time of the scene, s, from which all angles follow.
    /// model : str, optional
    ///     Bearing model; the scene's by default.
    ///
    /// Returns
    /// -------
    /// array
    ///     Of shape (n, 5, 5) or (5, 5), N/m, N/rad, N m/m and N m/rad.
    #[pyo3(signature = (u, *, cage_angle=None, time=None, model=None))]
    fn stiffness<'py>(
        &self,
        py: Python<'py>,
        u: &Bound<'py, PyAny>,
        cage_angle: Option<&Bound<'py, PyAny>>,
        time: Option<&Bound<'py, PyAny>>,
        model: Option<&str>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let (values, rows) = self.evaluated(py, (u, cage_angle, time, model), 25, |bearing, u, at, k| {
            let (_, stiffness) = bearing.reaction_and_stiffness(u, at);
            for (i, row) in k.chunks_mut(5).enumerate() {
                row.iter_mut().enumerate().for_each(|(j, entry)| *entry = stiffness[(i, j)]);
            }
        })?;
        let (array, n) = (values.into_pyarray(py), rows.len());
        Ok(if rows.is_single { array.reshape([5, 5])?.into_any() } else { array.reshape([n, 5, 5])?.into_any() })
    }

    /// Computes the load on each rolling element.
    ///
    /// Parameters
    /// ----------
    /// u : array, list, frame, table or dictionary
    ///     Displacements of the inner ring against the outer ring: ``u, v, w`` (m), ``thu, thv`` (rad), of shape (n, 5) or (5,); or a frame,
    ///     a table or a dictionary with these columns.
    /// cage_angle : float or array, optional
    ///     Angle of the cage, rad: one or one for each displacement.
    /// time : float or array, optional
    ///     Time of the scene, s, from which all angles follow.
    /// model : str, optional
    ///     Bearing model; the scene's by default.
    ///
    /// Returns
    /// -------
    /// array
    ///     Of shape (n, elements) or (elements,), N.
    #[pyo3(signature = (u, *, cage_angle=None, time=None, model=None))]
    fn element_loads<'py>(
        &self,
        py: Python<'py>,
        u: &Bound<'py, PyAny>,
        cage_angle: Option<&Bound<'py, PyAny>>,
        time: Option<&Bound<'py, PyAny>>,
        model: Option<&str>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let count = self.bearing.elements;
        let (values, rows) = self.evaluated(py, (u, cage_angle, time, model), count, |bearing, u, at, loads| {
            bearing.element_loads(u, at, loads);
        })?;
        let (array, n) = (values.into_pyarray(py), rows.len());
        Ok(if rows.is_single { array.into_any() } else { array.reshape([n, count])?.into_any() })
    }

    /// Pickles the bearing as its scene and its name.
    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyAny>, (String, String, String))> {
        let again = py.import("ballrace._scene")?.getattr("_bearing")?;
        let path = self.scene.path.to_string_lossy().into_owned();
        Ok((again, (self.text.clone(), path, self.bearing.name.clone())))
    }

    fn __repr__(&self) -> String {
        let scene::Bearing { name, model, elements, .. } = &self.bearing;
        format!("<ballrace.Bearing {name}: {}, {elements} elements>", model.name())
    }
}

/// Displacements, cage angles, times and model from Python.
type Arguments<'a, 'py> =
    (&'a Bound<'py, PyAny>, Option<&'a Bound<'py, PyAny>>, Option<&'a Bound<'py, PyAny>>, Option<&'a str>);

impl Bearing {
    fn rotation(&self, cage_angle: Option<f64>, time: Option<f64>) -> BearingKinematicState<f64> {
        // `new` has checked the geometry, so that an error is not expected.
        let at = time.and_then(|time| rotation_at(&self.scene, &self.bearing, time).ok()).unwrap_or(self.at_start);
        BearingKinematicState { cage: cage_angle.map_or(at.cage, Phase::from_radians), ..at }
    }

    /// Computes `width` numbers at each displacement.
    fn evaluated<'py>(
        &self,
        py: Python<'py>,
        (u, cage_angle, time, model): Arguments<'_, 'py>,
        width: usize,
        one: impl Fn(&AnyBearing<f64>, &Displacement<f64>, &BearingKinematicState<f64>, &mut [f64]) + Sync,
    ) -> PyResult<(Vec<f64>, Rows<'py>)> {
        let bearing = self.model_of(py, self.model(py, model)?)?;
        let rows = Rows::new(u)?;
        let n = rows.len();
        let (angles, times) = (PerSample::new("cage_angle", cage_angle, n)?, PerSample::new("time", time, n)?);
        let displacements = read("u", &rows.array)?;
        let (displacements, _) = displacements.as_slice()?.as_chunks::<5>();
        check_rows(py, &self.bearing, displacements)?;
        let (angles, times) = (angles.values()?, times.values()?);
        let values = without_interpreter(py, n, |check| {
            let mut values = vec![0.0; n * width];
            for (i, (u, to)) in displacements.iter().zip(values.chunks_mut(width.max(1))).enumerate() {
                check();
                one(&bearing, &Displacement::from_array(*u), &self.rotation(angles.at(i), times.at(i)), to);
            }
            values
        })?;
        Ok((values, rows))
    }
}
