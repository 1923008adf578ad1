"""Corrections of modes: their predicted errors are those against the full model, and they cure them."""

import numpy as np
import pytest
import scipy.linalg

from analysis.material import MaterialBox
from simulation.reduction.damped_modes import root_mean_square
from simulation.reduction.vectors.certification import mode_corrections
from simulation.reduction.vectors.energy_decomposition import projected
from simulation.reduction.vectors.reduce import reduce

BAND = (100.0, 700.0)
LINES = np.linspace(*BAND, 200)
LOSS = 0.005
MATERIAL = (2.3e9, 0.36)


@pytest.fixture(scope="module")
def vectors(coarse_model):
    """Of a plate reduced at one material, which is not `MATERIAL`."""
    return reduce(coarse_model, MaterialBox((2e9, 2e9), (0.38, 0.38), (LOSS, 0.1)), BAND)[1]


@pytest.fixture(scope="module")
def reduced(coarse_model, vectors):
    box = MaterialBox((2e9, 2.5e9), (0.35, 0.38), (LOSS, 0.1))
    return projected(coarse_model, vectors, box, BAND, np.zeros((coarse_model.size, 0)))


@pytest.fixture(scope="module")
def found(coarse_model, vectors, reduced):
    how = {"lines": LINES, "loss_factor": LOSS, "tolerance": 1e-4}
    return mode_corrections(coarse_model, vectors, reduced, MATERIAL, **how)


def test_predicted_errors_are_those_against_the_full_model(coarse_model, reduced, found):
    within = np.flatnonzero((found.frequency > BAND[0]) & (found.frequency < BAND[1]))
    largest = within[np.argsort(found.error[within])[-4:]]
    lines = found.frequency[largest]
    over = reduced.damped_modes(*MATERIAL).lines(LOSS, LINES)
    rms = root_mean_square(reduced.compliance(*MATERIAL, LOSS, over), over)[..., None]
    wrong = reduced.compliance(*MATERIAL, LOSS, lines) - coarse_model.compliance(*MATERIAL, LOSS, lines)
    expected = (np.abs(wrong) / rms).max(axis=(0, 1))
    assert expected.max() > 1e-5
    assert found.error[largest] == pytest.approx(expected, rel=0.2)


def test_missing_parts_bring_the_modes_to_those_of_the_full_model(coarse_model, vectors, found):
    def frequencies(basis):
        stiffness, mass = (
            basis.T @ (matrix @ basis) for matrix in (coarse_model.stiffness(*MATERIAL), coarse_model.mass)
        )
        return np.sqrt(np.abs(scipy.linalg.eigh(stiffness, mass, eigvals_only=True))) / (2 * np.pi)

    both = np.linalg.qr(np.hstack([vectors, found.missing / np.linalg.norm(found.missing, axis=0)]))[0]
    exact = coarse_model.eigenfrequencies(*MATERIAL, 25)
    exact = exact[(exact > BAND[0]) & (exact < BAND[1])]
    before, after = (
        np.array([np.abs(candidates - f).min() for f in exact]) for candidates in map(frequencies, (vectors, both))
    )
    assert after.max() < 0.01 * before.max()
