"""A run folder of a plate whose poles are known, small enough to be written for every test."""

import gc
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from analysis.experiment import Acquisition, Experiment, OvenDeclaration, Patch, Plate, Protocol
from analysis.identification.modes import Modes
from analysis.identification.over_temperature.tracked_modes import TrackedModes
from analysis.identification.pole_residue import NONE
from analysis.material import Material, MaterialSigma
from analysis.recordings.frf import Frf
from analysis.updated import Updated
from analysis.updating.laws import fit_laws
from app.files.provenance import provenance
from app.files.results.laws_file import TwinFrf, save_laws
from app.files.results.modes_file import save_frf, save_modes
from app.twins.campaign_twin import shape_points

TEMPERATURE = np.array([0.0, 10.0, 20.0, 30.0, 40.0])
FREQUENCY = np.arange(100.0, 900.0, 2.0)
NATURAL = np.array([180.0, 320.0, 610.0])
MADE = provenance({"a.tdms": "00ff"})


def modes_at(temperature: float) -> Modes:
    """Three modes that sink by half a per cent each kelvin."""
    w = 2.0 * np.pi * NATURAL * (1.0 - 0.005 * temperature)
    poles = w * (-0.03 + 1j * np.sqrt(1.0 - 0.03**2))
    return Modes(
        poles=poles,
        residues=np.array([[3.0 - 20j, 2.0 + 15j, -40j], [1.0 - 9j, -12j, 2.0 + 22j]]),
        covariance=np.broadcast_to(1e-6 * np.eye(2), (3, 2, 2)).copy(),
        terms=NONE,
        coefficients=np.zeros((2, 0), complex),
        status=("kept", "kept", "weak"),
        reason=("", "", "faint"),
        band=(100.0, 900.0),
        misfit=0.01,
        lines=len(FREQUENCY),
    )


def experiment() -> Experiment:
    patches = tuple(
        Patch(id=name, role=role, center=center, size=(0.02, 0.02), thickness=5e-4)
        for name, role, center in (
            ("A1", "actuator", (0.2, 0.155)),
            ("S1", "sensor", (0.04, 0.035)),
            ("S2", "sensor", (0.2, 0.035)),
        )
    )
    return Experiment(
        title="known plate",
        plate=Plate(length_x=0.24, length_y=0.19, thickness=0.003, mass=0.13),
        patch=patches,
        acquisition=Acquisition(
            module="NI-9234", sample_rate=51200.0 / 6, input_resistance=305e3, input_capacitance=1.2e-10
        ),
        protocol=Protocol(
            sweep="linear",
            band=(100.0, 900.0),
            sweep_duration=0.15,
            tail=0.03,
            repeats=2,
            ramp_rate=0.4,
            temperatures=tuple(TEMPERATURE),
            directions=("up",),
            levels=(1.0,),
        ),
        oven=OvenDeclaration(room_temperature=22.0),
    )


def frf() -> Frf:
    h = np.array([modes_at(t).synthesis(FREQUENCY) for t in TEMPERATURE])
    excluded = np.abs(FREQUENCY - 150.0) < 0.1
    return Frf(
        temperature=TEMPERATURE,
        direction=("up",) * 5,
        level=np.ones(5),
        frequency=FREQUENCY,
        h=h,
        variance=np.full(h.shape, 1e-8),
        coherence=np.full(h.shape, 0.999),
        excluded=excluded,
        channels=("S1", "S2"),
    )


def tracked() -> TrackedModes:
    measured = frf()
    return TrackedModes(
        temperature=TEMPERATURE,
        direction=measured.direction,
        level=measured.level,
        channels=measured.channels,
        modes=tuple(modes_at(t) for t in TEMPERATURE),
        track=np.array([[0, 1, 2], [0, 1, 2], [0, 1, 2], [0, 1, -1], [0, 1, -1]]),
        start=2,
    )


def updated() -> Updated:
    material = Material(3e9 - 3e7 * TEMPERATURE, 0.34 + 0.001 * TEMPERATURE, 0.04 + 0.0005 * TEMPERATURE)
    return Updated(
        temperature=TEMPERATURE,
        material=material,
        sigma=MaterialSigma(np.full(5, 1e7), np.full(5, 1e-3), np.full(5, 1e-3)),
        correlation=np.broadcast_to(np.eye(4), (5, 4, 4)).copy(),
        gain=13.7,
        sigma_gain=0.02,
        misfit_start=np.full(5, 0.1),
        misfit=np.full(5, 0.02),
        noise_floor=np.full(5, 0.01),
        chi2_per_dof=np.full(5, 4.0),
        settled=np.array([True, True, True, True, False]),
    )


@pytest.fixture
def shown(qtbot: Any) -> Callable[[Any], Any]:
    """Show a window and wait until keys go to it."""

    def show(window: Any) -> Any:
        qtbot.addWidget(window)
        window.show()
        window.activateWindow()
        qtbot.waitUntil(window.isActiveWindow)
        return window

    return show


class SinePlate:
    """A plate whose modes are half-waves along x, 5 Hz above those identified at 20 C."""

    points = shape_points(experiment().plate)
    deflection = np.sin(np.pi * np.outer(points[:, 0] / 0.24, (1, 2, 3)))

    def loaded(self, masses: Any) -> "SinePlate":
        """Carry no transducers."""
        assert not masses.size
        return self

    @staticmethod
    def modes(e: float, nu: float, eta: float, count: int) -> tuple[Any, Any]:
        f = np.array([n * (1.0 - 0.005 * 20.0) + 5.0 for n in NATURAL])
        return (2.0 * np.pi * f) ** 2 * (1.0 + 1j * eta), np.eye(3)


@pytest.fixture(autouse=True)
def _plate_of_sines(monkeypatch: pytest.MonkeyPatch) -> None:
    """Spare the windows the reduction of a real plate."""
    monkeypatch.setattr("app.twins.campaign_twin.campaign_reduction", lambda *_: SinePlate())
    monkeypatch.setattr(
        "simulation.reduction.reduced_model.lowest_modes", lambda plate, *asked: plate.modes(*asked)
    )


@pytest.fixture
def run(tmp_path: Path) -> Path:
    """Write a run folder as it is after `identify` and `update`."""
    folder = tmp_path / "plate-run"
    folder.mkdir()
    measured, found = frf(), updated()
    save_frf(folder / "frf.h5", experiment(), measured, MADE)
    save_modes(folder / "modes.h5", tracked(), MADE)
    laws = fit_laws(TEMPERATURE, found.material, found.sigma, temperature_range=(0.0, 40.0))
    save_laws(folder / "laws.h5", found, laws, TwinFrf(FREQUENCY, 1.01 * measured.h, 1e-4, 950.0), MADE)
    return folder


@pytest.fixture(autouse=True)
def _garbage_stays_in_this_thread() -> Iterator[None]:
    """Keep the threads of a test from taking windows apart, as `flexura view` does.

    What was there before is frozen: to look through it again took a second of each test, in a process of many.
    """
    gc.disable()
    gc.freeze()
    yield
    gc.collect()
    gc.unfreeze()
    gc.enable()
