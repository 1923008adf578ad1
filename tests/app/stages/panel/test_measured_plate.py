"""A panel that is the plate that was measured has what was found about it; any other panel keeps its own."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from analysis.estimates import Estimate
from analysis.experiment import Attachment
from analysis.focusing.panel import Panel
from app.files.results.best_twin import best_twin
from app.stages.panel.laws import MeasuredPlate, laws_for
from app.twins.panel_twin import panel_twin
from tests.app.corrected_run import DECLARED, laws_of, write_run
from tests.app.view.conftest import experiment, updated

THICKER, HEAVIER, SHIFT = (one.value for one in DECLARED)
TARGET = {"center": (0.3, 0.55), "size": (0.25, 0.3)}
FILTERS = {
    "taps": 64,
    "sample_rate": 4000.0,
    "band": (100.0, 300.0),
    "edges": (60.0, 360.0),
    "transform_length": 512,
    "delay": 32,
}


def panel(**changes: Any) -> Panel:
    """Declare the campaign's plate with two of its patches as actuators."""
    declared = experiment()
    patches = [one.model_copy(update={"role": "actuator"}) for one in declared.patch[:2]]
    table = {
        "title": "own plate",
        "plate": declared.plate,
        "patch": tuple(patches),
        "target": TARGET,
        "grid": (20, 16),
        "filters": FILTERS,
        "twin": {"function_tolerance": 1e-6, "basis_tolerance": 1e-2},
    }
    return Panel.model_validate(table | changes)


@pytest.fixture
def measured(tmp_path: Path) -> MeasuredPlate:
    run = write_run(tmp_path / "run")
    found = MeasuredPlate.of_run(run, best_twin(run, "test"))
    assert found is not None
    return replace(found, experiment=experiment().model_copy(update={"cable": (Attachment(point=(0.1, 0.1)),)}))


def test_its_thickness_mass_and_places_are_those_with_which_e_was_estimated(measured: MeasuredPlate) -> None:
    declared = panel()
    found, notes = measured.on(declared)
    assert found.plate.thickness == pytest.approx(declared.plate.thickness * (1.0 + THICKER))
    assert found.plate.mass == pytest.approx(declared.plate.mass * (1.0 + HEAVIER))
    assert found.patch[1].center[0] == pytest.approx(declared.patch[1].center[0] + SHIFT)
    assert found.patch[0] == declared.patch[0]
    assert "thickness 3.006 mm" in notes[0]
    assert "a mass of 0.8 g at 100, 100 mm" in notes[0]
    (load,) = found.load
    assert (load.mass, load.point) == (7.997e-4, (0.1, 0.1))


def test_it_is_put_in_once(measured: MeasuredPlate) -> None:
    """Filters keep the panel they were made for: what is made from it later must not be corrected again."""
    once, _ = measured.on(panel())
    again, _ = measured.on(once)
    assert again == once
    exact = replace(measured, departures={})
    loaded, _ = exact.on(panel())
    assert exact.on(loaded)[0].load == loaded.load


def test_another_panel_keeps_its_own_thickness(measured: MeasuredPlate) -> None:
    clamped = panel(plate=experiment().plate.model_copy(update={"boundary": "clamped"}))
    found, notes = measured.on(clamped)
    assert found == clamped
    assert notes == ["added mass at the cable: on the plate that was measured, not on the panel"]


def test_a_sensor_that_was_named_moves_its_patch(measured: MeasuredPlate) -> None:
    offset = (Estimate("dx", 1e-3, 1e-5, "m"), Estimate("dy", -2e-3, 1e-5, "m"))
    named = replace(measured, departures={}, effects={"sensor_offset": offset})
    found, _ = named.on(panel())
    moved = np.subtract(found.patch[1].center, panel().patch[1].center)
    np.testing.assert_allclose(moved, (1e-3, -2e-3), atol=1e-12)


def test_what_a_panel_cannot_hold_is_said(measured: MeasuredPlate) -> None:
    taper = {
        "thickness_taper": (Estimate("tx", 0.02, 1e-3, "1"),),
        "thermal_lag": (Estimate("tau", 9.0, 1.0, "s"),),
    }
    named = replace(measured, departures={}, effects=taper, words={"thickness_taper": "plate of uneven thickness"})
    found, notes = named.on(panel())
    assert found == panel()
    assert len(notes) == 1
    assert notes[0].startswith(
        "plate of uneven thickness: found on this plate, but the panel's twin cannot hold it"
    )


def test_a_run_hands_it_to_whoever_designs_filters(tmp_path: Path) -> None:
    run = write_run(tmp_path / "run")
    found, notes = laws_for(run, None, "test").on(panel())
    assert found.plate.thickness > panel().plate.thickness
    assert len(notes) == 2
    (run / "frf.h5").unlink()
    assert laws_for(run, None, "test").on(panel())[0] == panel()


def test_a_mass_that_rides_on_a_panel_lowers_its_modes() -> None:
    """By Rayleigh's quotient a small mass m lowers w by m phi**2 w/2 to first order, phi of unit modal mass."""
    clamped = experiment().plate.model_copy(update={"boundary": "clamped"})
    point, laws, material = (0.1, 0.08), laws_of(updated()), (2e9, 0.36, 0.05)
    light, heavy = (
        panel_twin(panel(plate=clamped, load=({"point": point, "mass": mass},)), laws, lambda *_: None)
        for mass in (1e-9, 1e-4)
    )
    one, other = (twin.modes(*material, 1) for twin in (light, heavy))
    nearest = int(np.hypot(*(light.reduced.points - point).T).argmin())
    phi = float(light.reduced.deflection[nearest] @ one.shapes[:, 0])
    lower = float(np.sqrt(other.eigenvalues[0].real / one.eigenvalues[0].real)) - 1.0
    assert lower == pytest.approx(-0.5 * 1e-4 * phi**2, rel=0.03)
    assert lower < -1e-3
    lines = panel().filters.frequency
    assert heavy.amplitudes(*material, lines).shape[0] == 2  # the mass is no actuator
