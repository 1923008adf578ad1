"""A faultless file of every verb's results, of a small plate, a small panel and a small test; and of the cache."""

import json
from dataclasses import fields
from itertools import count
from pathlib import Path

import numpy as np

from analysis.compensation.outcome import NetworkStudy
from analysis.compensation.settings import Training
from analysis.compensation.study import compensate
from analysis.estimates import FittedLaws
from analysis.estimation.estimators import Segments
from analysis.estimation.transfer import MeasuredTransfer
from analysis.focusing.methods import compare
from analysis.focusing.over_temperature import focus
from analysis.focusing.played import play_methods
from analysis.focusing.radiated import radiate
from analysis.gap.fitting.residual_map import Signature
from analysis.shapes.stabilization import StabilizationChart
from analysis.updating.laws import fit_laws
from app.files.basis_cache import save_basis
from app.files.effect_cache import PLAIN, SCALARS, save_operators
from app.files.provenance import provenance
from app.files.results.gap_file import GapFigures, save_gap
from app.files.results.laws_file import TwinFrf, remember_laws, save_laws
from app.files.results.modes_file import save_frf, save_modes
from app.files.results.panel_files import (
    Studies,
    Surfaces,
    save_compensation,
    save_focusing,
    save_radiation,
    save_studies,
)
from app.modal_test.frf_set import FrfSet
from app.modal_test.modes_of_test import save_frfs, save_stabilization
from simulation.reduction.effect_operators import EffectOperators
from simulation.reduction.plate_basis import PlateBasis
from tests.app.corrected_run import record
from tests.app.files.test_basis_cache import model
from tests.app.view.conftest import FREQUENCY, MADE, TEMPERATURE, experiment, frf, tracked, updated
from tests.app.view.test_gap_and_fields import PANEL, SinePanel, gap_map

PLATE = (1.1e9, 0.33, 0.06)
"""Modulus, Pa, Poisson's ratio and loss factor of the panel where only one plate is looked at."""


def write_results(root: Path) -> None:
    """Write them into folders of their own."""
    _write_run(root / "run")
    _write_panel(root / "panel")
    _write_test(root / "test")
    _write_cache(root / "cache")


def _write_run(folder: Path) -> None:
    measured, found = frf(), updated()
    save_frf(folder / "frf.h5", experiment(), measured, MADE)
    save_modes(folder / "modes.h5", tracked(), MADE)
    laws = fit_laws(TEMPERATURE, found.material, found.sigma, temperature_range=(0.0, 40.0))
    save_laws(folder / "laws.h5", found, laws, TwinFrf(FREQUENCY, 1.01 * measured.h, 1e-4, 950.0), MADE)
    known = FittedLaws(np.array([0.0, 20.0]), np.array([[21.8, 0.35, -2.6]] * 2), np.full((2, 3), 1e-3))
    figures = GapFigures(gap_map(9.0), gap_map(1.0), known, known)
    alone = [
        Signature("point_mass", figures.before.sigma, True),
        Signature("suspension", figures.after.sigma, False),
    ]
    told = record("explained")
    save_gap(folder / "gap.h5", figures, alone, told, MADE)
    (folder / "gap.json").write_text(json.dumps(told), encoding="utf-8")
    (apart := folder.with_name("apart")).mkdir(exist_ok=True)
    remember_laws(apart, folder / "laws.h5", kind="run")


def _write_panel(folder: Path) -> None:
    """Focus on a plate of sines, follow the temperature with small networks, and study both."""
    plate, found = SinePanel(), updated()
    laws = fit_laws(TEMPERATURE, found.material, found.sigma, temperature_range=(0.0, 40.0))
    focusing = focus(plate, PANEL, laws, np.array([0.0, 20.0, 40.0]))
    comparison, made = compare(plate, PANEL, PLATE), provenance({"laws.h5": "00ff"}, {"measured": False})
    save_focusing(folder / "filters.h5", PANEL, focusing, comparison, made, focusing.fixed)
    made = provenance({"filters.h5": "00ff"}, {})
    save_radiation(folder / "radiation.h5", PANEL, radiate(plate, PANEL, laws, focusing.bank, 20.0), made)
    ticks = count()
    training = Training(nodes=2, epochs=20, largest_error=100.0)
    followed = compensate(plate, PANEL, laws, 10.0, training, lambda: float(next(ticks)), step=10.0)
    save_compensation(folder / "compensation.h5", PANEL, followed, made)
    few = NetworkStudy(np.array([2.0]), np.array([10.0]), np.ones((1, 4)), np.array([0.01]))
    surfaces = Surfaces(followed.temperature, followed.trained.networks.taps(followed.temperature), 4000.0)
    played = play_methods(plate, PANEL, PLATE, seconds=0.1)
    save_studies(folder / "studies.h5", PANEL, Studies(played, focusing, followed, surfaces, few, few), made)


def _write_test(folder: Path) -> None:
    """Write the FRFs of three places with coherence, and a chart of their poles."""
    lines, rng = np.arange(10.0, 60.0), np.random.default_rng(4)
    h = rng.normal(size=(3, len(lines))) + 1j * rng.normal(size=(3, len(lines)))
    known = {"variance": np.full(len(lines), 1e-4), "coherence": np.full(len(lines), 0.99)}
    transfers = tuple(
        MeasuredTransfer(f"H {n}", f"{n}:+z", "1:-x", "acceleration", lines, one, units=("m/s2", "N"), **known)
        for n, one in enumerate(h, start=1)
    )
    points = {n: (0.1 * n, 0.05, 0.0) for n in (1, 2, 3)}
    told = FrfSet(
        "door",
        transfers,
        points,
        window_rate=3.0,
        segments=Segments(1.0, "hann"),
        temperature=21.5,
        mains=50.0,
        notes=("blow 2 left out",),
        hashes={"a.csv": "00ff"},
    )
    save_frfs(folder / "transfers.h5", told, MADE)
    order = np.repeat([2, 4, 6], 3)
    chart = StabilizationChart(order, 12.0 + order, 0.01 * order, order % 3)
    save_stabilization(folder / "stabilization.h5", chart, MADE)


def _write_cache(folder: Path) -> None:
    """Write reduced models of a few random coordinates: what is read is not looked into by these."""
    reduced, rng = model(), np.random.default_rng(5)
    save_basis(folder / "basis.h5", reduced)
    vectors = rng.standard_normal((9, 6))
    save_basis(
        folder / "plate-basis.h5", reduced, PlateBasis(rng.random((5, 7)) > 0.5, 1e-6, vectors, reduced.error)
    )
    symmetric = rng.standard_normal((2, 6, 6))
    arrays = {
        entry.name: rng.standard_normal((4, 6)) if entry.name in PLAIN else symmetric + symmetric.swapaxes(1, 2)
        for entry in fields(EffectOperators)
        if entry.name not in (*SCALARS, "box", "band")
    }
    scalars = dict.fromkeys(SCALARS, 1e-3)
    save_operators(folder / "effects.h5", EffectOperators(**arrays, **scalars, box=reduced.box, band=reduced.band))
