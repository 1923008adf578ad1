"""Run folders of a fleet whose truth is known: laws with drawn levels, estimates with known noise."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from analysis.material import Material, MaterialSigma
from analysis.updated import Updated
from analysis.updating.laws import fit_laws
from app.files.provenance import provenance
from app.files.results.laws_file import TwinFrf, save_laws

TEMPERATURES = np.arange(0.0, 61.0, 5.0)
NOISE = 0.002
"""Of log E, nu and log eta of one sweep."""

Piece = Callable[..., Path]


def true_modulus(temperature: np.ndarray, level: float) -> np.ndarray:
    """E of a piece, Pa: the fleet's law times its level."""
    return np.asarray(3.05e9 * np.exp(-0.016 * temperature + level))


def piece(
    run: Path, rng: np.random.Generator, level: float, temperatures: np.ndarray = TEMPERATURES, misfit: float = 1.0
) -> Path:
    """Write laws.h5 of a piece, with estimates at some temperatures."""
    shape = temperatures.shape
    e = true_modulus(temperatures, level) * np.exp(rng.normal(0.0, NOISE, shape))
    nu = 0.38 + rng.normal(0.0, NOISE, shape)
    eta = 0.05 * np.exp(0.01 * temperatures + rng.normal(0.0, NOISE, shape))
    sigma = MaterialSigma(NOISE * e, np.full(shape, NOISE), NOISE * eta)
    floor = np.full(shape, 0.01)
    updated = Updated(
        temperature=temperatures,
        material=Material(e, nu, eta),
        sigma=sigma,
        correlation=np.tile(np.eye(4), (*shape, 1, 1)),
        gain=14.0,
        sigma_gain=0.01,
        misfit_start=10.0 * floor,
        misfit=misfit * floor * np.exp(rng.normal(0.0, 0.02, shape)),
        noise_floor=floor,
        chi2_per_dof=np.full(shape, misfit**2),
        settled=np.ones(shape, bool),
    )
    laws = fit_laws(temperatures, updated.material, sigma) if temperatures.size > 2 else None
    twin = TwinFrf(np.array([100.0, 200.0]), np.ones((*shape, 1, 2), complex), 1e-5, 950.0)
    run.mkdir(parents=True)
    save_laws(run / "laws.h5", updated, laws, twin, provenance({}))
    return run


@pytest.fixture
def fleet(tmp_path: Path) -> tuple[dict[str, Path], np.ndarray]:
    """Twelve pieces with 3 % scatter; the fifth is of another batch, on the ninth something is not told."""
    rng = np.random.default_rng(11)
    levels = rng.normal(0.0, 0.03, 12)
    runs = {
        f"door-{k + 1}": piece(
            tmp_path / f"door-{k + 1}", rng, level - (0.2 if k == 4 else 0.0), misfit=2.0 if k == 8 else 1.0
        )
        for k, level in enumerate(levels)
    }
    return runs, np.delete(levels, [4, 8])
