"""Force, stiffness and element loads of a bearing."""

from __future__ import annotations

import doctest
import pickle
import warnings
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

import ballrace
from ballrace.typing import Model

N = 400


@pytest.fixture(scope="module")
def displacements() -> np.ndarray:
    scales = np.array([2e-5, 2e-5, 1e-5, 1e-4, 1e-4])
    return np.asarray(np.random.default_rng(7).normal(size=(N, 5)) * scales)


def test_one_and_many_are_the_same(scene: ballrace.Scene, displacements: np.ndarray) -> None:
    bearing = scene.bearing("DE")
    angles = np.linspace(0.0, 6.0, N)
    many = bearing.force(displacements, cage_angle=angles)
    assert many.shape == (N, 5)
    for i in (0, 17, N - 1):
        one = bearing.force(displacements[i], cage_angle=angles[i])
        assert one.shape == (5,)
        assert np.array_equal(one, many[i])


def test_out_is_filled_and_returned(scene: ballrace.Scene, displacements: np.ndarray) -> None:
    bearing = scene.bearing("DE")
    out = np.full((N, 5), np.nan)
    assert bearing.force(displacements, out=out) is out
    assert np.array_equal(out, bearing.force(displacements))


@pytest.mark.parametrize("model", ["angular", "quasi-static", "tabulated"])
def test_stiffness_is_the_slope_of_the_force(scene: ballrace.Scene, model: Model) -> None:
    bearing = scene.bearing("DE")
    u = np.array([4e-6, -12e-6, 8e-6, 1e-5, -2e-5])
    steps = np.array([1e-9, 1e-9, 1e-9, 1e-7, 1e-7])
    stiffness = bearing.stiffness(u, model=model)
    plus = bearing.force(u + np.diag(steps), model=model)
    minus = bearing.force(u - np.diag(steps), model=model)
    # The force on the inner ring falls as it is displaced: K = -dF/du.
    slope = -((plus - minus) / (2 * steps[:, None])).T
    scale = np.sqrt(np.outer(np.diag(stiffness), np.diag(stiffness)))
    tolerance = 5e-3 if model == "tabulated" else 1e-4
    assert np.max(np.abs(slope - stiffness) / np.abs(scale)) < tolerance


def test_element_loads_add_up_to_the_force(scene: ballrace.Scene) -> None:
    bearing = scene.bearing("DE")
    loads = bearing.element_loads(np.array([[0.0, -15e-6, 0.0, 0.0, 0.0]]))
    assert loads.shape == (1, bearing.elements)
    force = bearing.force(np.array([0.0, -15e-6, 0.0, 0.0, 0.0]))
    assert 0 < np.linalg.norm(force[:3]) < loads.sum()


def test_precision_and_math(scene: ballrace.Scene, displacements: np.ndarray) -> None:
    bearing = scene.bearing("DE")
    exact = bearing.force(displacements)
    largest = np.abs(exact).max()
    single = np.abs(bearing.force(displacements, precision="f32") - exact).max() / largest
    fast = np.abs(bearing.force(displacements, precision="f32", math="fast") - exact).max() / largest
    assert 0 < single < 1e-4
    assert single < fast < 0.2


def test_not_finite_rows_repeat_the_last_valid_force(scene: ballrace.Scene, displacements: np.ndarray) -> None:
    bearing = scene.bearing("DE")
    u = displacements[:3].copy()
    u[1, 2] = np.nan
    status = np.empty(3, dtype=np.uint8)
    force = bearing.force(u, status=status)
    assert np.array_equal(force[1], force[0])
    flags = [ballrace.Status(int(bits)) for bits in status]
    assert ballrace.Status.INPUT_NOT_FINITE in flags[1]
    assert ballrace.Status.INPUT_NOT_FINITE not in flags[2]


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda u: u[:, :4].copy(), r"u: of shape \[400, 4\], expected \(n, 5\)"),
        (lambda u: u.astype(complex), "u: values of type complex128, expected u, v, w"),
        (lambda u: [[1e-6, 0.0], [0.0]], "u: rows of different lengths, expected u, v, w"),
        (lambda u: "wide", "u: values of type <U4, expected u, v, w"),
        (lambda u: {"u": u[:, 0], "v": u[:, 1]}, "u: no column w, thu, thv, expected u, v, w"),
        (lambda u: dict(zip("u v w thu thv".split(), [u[:, 0], u[:2, 1], *u.T[2:]])), r"columns of \[2, 400\] values"),
        (lambda u: np.full((2, 5), np.inf), "row 0 is not finite"),
        (lambda u: u[0, :3].copy(), "expected an array of shape"),
    ],
)
def test_wrong_displacements(scene: ballrace.Scene, displacements: np.ndarray, change: object, message: str) -> None:
    with pytest.raises(ballrace.InputError, match=message):
        scene.bearing("DE").force(change(displacements))  # type: ignore[operator]


def test_wrong_arguments(scene: ballrace.Scene, displacements: np.ndarray) -> None:
    bearing = scene.bearing("DE")
    with pytest.raises(ballrace.InputError, match="cage_angle: 3 values, expected"):
        bearing.force(displacements, cage_angle=np.zeros(3))
    with pytest.raises(ballrace.InputError, match="cage_angle: not finite"):
        bearing.force(displacements, cage_angle=float("nan"))
    with pytest.raises(ballrace.InputError, match="model: no such model"):
        bearing.force(displacements, model="newtonian")  # type: ignore[call-overload]
    with pytest.raises(ballrace.InputError, match=r"out: of shape \[3, 5\], expected \(400, 5\)"):
        bearing.force(displacements, out=np.empty((3, 5)))
    read_only = np.empty((N, 5))
    read_only.flags.writeable = False
    with pytest.raises(ballrace.InputError, match="read-only"):
        bearing.force(displacements, out=read_only)
    with pytest.raises(ballrace.InputError, match="in use|also written"):
        bearing.force(displacements, out=displacements)
    with pytest.raises(ballrace.InputError, match="XX"):
        scene.bearing("XX")


def test_threads_share_a_bearing(scene: ballrace.Scene, displacements: np.ndarray) -> None:
    """Models are built at their first use; threads that need the same one at once do not block each other."""
    expected = scene.bearing("DE").force(displacements, model="tabulated")
    bearing = scene.bearing("DE")
    with ThreadPoolExecutor(8) as pool:
        found = list(pool.map(lambda _: bearing.force(displacements, model="tabulated"), range(16)))
    assert all(np.array_equal(one, expected) for one in found)


def test_a_force_that_overflows_is_an_error_without_status(scene: ballrace.Scene, displacements: np.ndarray) -> None:
    bearing = scene.bearing("DE")
    u = displacements[:3].copy()
    u[1] = 1e250
    with pytest.raises(ballrace.InputError, match="u: the force at row 1 overflows"):
        bearing.force(u)
    status = np.empty(3, dtype=np.uint8)
    force = bearing.force(u, status=status)
    assert np.array_equal(force[1], force[0])
    assert ballrace.Status.RESULT_NOT_FINITE in ballrace.Status(int(status[1]))


def test_an_inaccurate_force_warns_without_status(scene: ballrace.Scene) -> None:
    bearing = scene.bearing("DE")
    far = np.array([[0.0, -1e-5, 1e-5, 0.0, 0.0], [0.0, -3e-3, 0.0, 0.0, 0.0]])
    status = np.empty(2, dtype=np.uint8)
    bearing.force(far, model="tabulated", status=status)
    assert ballrace.Status.OUT_OF_TABLE in ballrace.Status(int(status[1]))
    with pytest.warns(RuntimeWarning, match="1 of 2 forces are outside the table .* the first at row 1"):
        bearing.force(far, model="tabulated")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        bearing.force(far[:1], model="tabulated")


def test_masked_elements_are_refused(scene: ballrace.Scene, displacements: np.ndarray) -> None:
    bearing = scene.bearing("DE")
    whole = np.ma.array(displacements, mask=False)
    assert np.array_equal(bearing.force(whole), bearing.force(displacements))
    mask = np.zeros(displacements.shape, dtype=bool)
    mask[7, 2] = True
    for call in (bearing.force, bearing.stiffness, bearing.element_loads):
        with pytest.raises(ballrace.InputError, match="u: 1 masked elements, expected an array without"):
            call(np.ma.array(displacements, mask=mask))
    with pytest.raises(ballrace.InputError, match="u: 1 masked elements"):
        bearing.force(np.ma.array(displacements[7], mask=mask[7]))
    with pytest.raises(ballrace.InputError, match="cage_angle: 400 masked elements"):
        bearing.force(displacements, cage_angle=np.ma.array(np.zeros(N), mask=True))


def test_a_bearing_is_pickled(scene: ballrace.Scene, displacements: np.ndarray) -> None:
    bearing = scene.bearing("NDE")
    copy = pickle.loads(pickle.dumps(bearing))
    assert copy.name == "NDE" and np.array_equal(copy.force(displacements), bearing.force(displacements))


@pytest.mark.parametrize("name", ["force", "stiffness", "element_loads"])
def test_help_has_units_and_examples_that_run(name: str) -> None:
    text = getattr(ballrace.Bearing, name).__doc__
    assert all(part in text for part in ("Parameters\n", "Returns\n", "(rad)", "N")), text
    examples = doctest.DocTestParser().get_doctest(text, {}, name, None, 0)
    assert len(examples.examples) == (4 if name == "force" else 0)
    assert doctest.DocTestRunner().run(examples).failed == 0
