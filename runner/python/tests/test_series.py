"""Samples, spectra and waterfalls of a replay."""

from __future__ import annotations

import pickle
import subprocess
from pathlib import Path

import numpy as np
import pytest

import ballrace


@pytest.fixture(scope="module")
def outcome() -> ballrace.Outcome:
    scene = ballrace.Scene.demonstration()
    return scene.replay(ballrace.demonstration_recording(), samples=True)


def test_samples_have_what_was_recorded_and_what_the_outcome_says(outcome: ballrace.Outcome) -> None:
    recording, samples = ballrace.demonstration_recording(), outcome.samples()
    assert len(samples) == len(recording["DE_X_um"]) == outcome.record.samples
    frame = samples.to_pandas()
    assert list(frame.columns) == samples.names and frame["status"].dtype == np.uint16
    probe = outcome.probes[1]
    np.testing.assert_allclose(frame[f"{probe.name}_measured_um"].mean(), probe.measured.mean_um, rtol=1e-9)
    residual = frame[f"{probe.name}_residual_um"]
    np.testing.assert_allclose(residual, frame[f"{probe.name}_measured_um"] - frame[f"{probe.name}_twin_um"], atol=1e-9)
    assert np.sqrt((residual**2).mean()) == pytest.approx(probe.residual_rms_um, rel=1e-9)
    assert np.diff(frame["time_s"]).max() == pytest.approx(1.0 / outcome.record.rate_hz, rel=1e-6)


@pytest.mark.parametrize("source", ["observer", "displacement"])
def test_forces_of_samples_are_those_of_the_bearing_there(
    source: ballrace.typing.ForceSource, scene: ballrace.Scene, tmp_path: Path
) -> None:
    file = tmp_path / "forces.csv"
    samples = scene.replay(ballrace.demonstration_recording(), forces=file, force_source=source, samples=True).samples()
    written = np.genfromtxt(file, delimiter=",", names=True, deletechars="")
    for bearing in ("DE", "NDE"):
        positions = np.stack([samples[f"{bearing}_{q}"] for q in ("u_m", "v_m", "w_m", "thu_rad", "thv_rad")], axis=1)
        forces = np.stack([samples[f"{bearing}_{f}"] for f in ("FX_N", "FY_N", "FZ_N", "MX_Nm", "MY_Nm")], axis=1)
        again = scene.bearing(bearing).force(positions, cage_angle=samples[f"{bearing}_element_1_azimuth_rad"])
        np.testing.assert_allclose(again, forces, rtol=1e-9, atol=1e-9)
        np.testing.assert_allclose(written[f"{bearing}_FY_N"], samples[f"{bearing}_FY_N"], rtol=1e-8)
    np.testing.assert_array_equal(written["status"], samples["status"])


def test_a_missing_reading_is_no_number(scene: ballrace.Scene) -> None:
    recording = ballrace.demonstration_recording()
    recording["DE_X_um"][5000] = np.nan
    samples = scene.replay(recording, samples=True).samples()
    for name in ("DE_X_um_measured_um", "DE_X_um_residual_um"):
        assert np.flatnonzero(np.isnan(samples[name])).tolist() == [5000]
    assert np.isfinite(samples["DE_X_um_twin_um"]).all() and np.isfinite(samples["DE_FX_N"]).all()


def test_samples_that_were_not_kept_are_an_error(scene: ballrace.Scene) -> None:
    outcome = scene.replay(ballrace.demonstration_recording())
    with pytest.raises(ballrace.InputError, match=r"samples: none are kept, expected replay\(..., samples=True\)"):
        outcome.samples()


def test_spectra_are_those_of_the_samples(outcome: ballrace.Outcome) -> None:
    spectra = outcome.spectra()
    frequencies = spectra["frequency_hz"]
    assert frequencies[1] == pytest.approx(outcome.record.spectra.bin_hz)
    one_x = np.abs(frequencies - outcome.record.mean_speed_rpm / 60.0).argmin()
    near = slice(one_x - 2, one_x + 3)
    probe = outcome.probes[1]
    # The window spreads a sine between two lines over several; the highest is at most 15 % too low.
    assert 0.85 * probe.measured.one_x_um < spectra[f"{probe.name}_measured_um"][near].max() < 1.02 * probe.measured.one_x_um
    dataset = spectra.to_xarray()
    assert dataset.sizes == {"frequency_hz": outcome.record.spectra.lines + 1}
    assert dataset[f"{probe.name}_twin_um"].attrs["units"] == "um" and dataset["frequency_hz"].attrs["units"] == "Hz"


def test_samples_are_a_labelled_dataset(outcome: ballrace.Outcome) -> None:
    dataset = outcome.samples().to_xarray()
    units = {name: dataset[name].attrs["units"] for name in ("speed_rpm", "DE_X_um_twin_um", "DE_u_m", "DE_thv_rad", "DE_MX_Nm", "status")}
    assert units == {
        "speed_rpm": "rpm", "DE_X_um_twin_um": "um", "DE_u_m": "m", "DE_thv_rad": "rad", "DE_MX_Nm": "N m", "status": "",
    }
    assert dataset["time_s"].attrs["units"] == "s"


def test_a_waterfall_over_time(outcome: ballrace.Outcome) -> None:
    first, second = outcome.waterfalls()
    assert (first.name, second.name) == ("DE_X_um / DE_Y_um", "NDE_X_um / NDE_Y_um")
    array = second.to_xarray()
    forward = array.sel(frequency_hz=50.0, method="nearest").mean().item()
    backward = array.sel(frequency_hz=-50.0, method="nearest").mean().item()
    # Unbalance turns forward.
    assert forward > 2.0 * backward > 0.0
    frame = second.to_pandas()
    assert len(frame) == array.size and frame["amplitude_um"].sum() == pytest.approx(array.sum().item())
    figure = outcome.plot_waterfall(second.name)
    assert figure.layout.title.text == f"Waterfall of {second.name}" and len(figure.data) == len(second.time_s)
    np.testing.assert_array_equal(figure.data[3].z, second.amplitude_um[3])
    assert (figure.layout.scene.yaxis.title.text, figure.data[3].y[0]) == ("time, s", second.time_s[3])
    assert outcome.plot_waterfall(over="speed").layout.scene.yaxis.title.text == "speed, rpm"
    with pytest.raises(ballrace.InputError, match="waterfall: none named 'X', expected 'DE_X_um / DE_Y_um'"):
        outcome.plot_waterfall("X")


def test_a_cascade_over_the_speed(scene: ballrace.Scene, program: Path, tmp_path: Path) -> None:
    """A run-up is drawn over its speed, and the forward motion is 1X."""
    ramp = {"from": "2000 rpm", "to": "3500 rpm", "over": "3 s"}
    path = tmp_path / "run-up.toml"
    path.write_text(scene.with_value("shaft.speed", ramp).text)
    output = str(tmp_path / "healthy.csv")
    run = [str(program), "simulate", str(path), "--duration", "3s", "--as-recording", "-o", output]
    subprocess.run(run, check=True, capture_output=True)
    outcome = ballrace.Scene.read(path).replay()
    figure = outcome.plot_waterfall()
    assert figure.layout.title.text == "Cascade of DE_X_um / DE_Y_um" and len(figure.data) > 10
    assert figure.data[0].y[0] < 2200.0 and figure.data[-1].y[0] > 3300.0
    low, high = figure.layout.scene.xaxis.range
    assert 60.0 < high < 200.0 and low == -high
    for spectrum in figure.data:
        forward = np.asarray(spectrum.x) > 10.0
        highest = np.asarray(spectrum.x)[forward][np.asarray(spectrum.z)[forward].argmax()]
        assert highest == pytest.approx(spectrum.y[0] / 60.0, abs=5.0)


def test_a_copy_has_samples_and_spectra(outcome: ballrace.Outcome) -> None:
    copy = pickle.loads(pickle.dumps(outcome))
    assert copy == outcome and copy.samples() == outcome.samples() and copy.spectra() == outcome.spectra()
    assert copy.waterfalls() == outcome.waterfalls() and copy.to_text() == outcome.to_text()
