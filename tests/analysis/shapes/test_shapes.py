"""Shapes, participations and repeated roots of structures whose residues are known."""

import numpy as np
import pytest
from numpy.typing import NDArray

from analysis.estimation.transfer import MeasuredTransfer
from analysis.identification.automatic import identify
from analysis.identification.measured import Measured
from analysis.identification.pole_residue import NONE
from analysis.identification.settings import Settings
from analysis.shapes.participation import mac, mode_shapes, mpc, residue_deviation
from analysis.shapes.stabilization import cmif, stabilization_chart

F = np.arange(20.0, 400.0, 0.25)
S = 2j * np.pi * F
RNG = np.random.default_rng(2)


def pole(f: float, zeta: float) -> complex:
    return complex(2 * np.pi * f * (-zeta + 1j * np.sqrt(1 - zeta**2)))


POLES = np.array([pole(80, 0.01), pole(170, 0.008), pole(310, 0.012)])
SHAPES = np.array([[1.0, 0.4, -0.6, 0.2], [-0.5, 1.0, 0.3, 0.8], [0.7, -0.2, 1.0, -0.9]])


def structure(
    poles: np.ndarray, shapes: np.ndarray, responses: list[int], references: list[int], order: int = 0
) -> list[MeasuredTransfer]:
    """FRFs of a structure whose modes have unit modal mass; displacement, velocity or acceleration per force."""
    made = []
    for i in responses:
        for j in references:
            h = sum(
                s[i] * s[j] / (2j * p.imag) / (S - p) + np.conj(s[i] * s[j] / (2j * p.imag)) / (S - np.conj(p))
                for p, s in zip(poles, shapes, strict=True)
            )
            quantity = ("displacement", "velocity", "acceleration")[order]
            made.append(MeasuredTransfer(f"{i}/{j}", f"{i + 1}:+3", f"{j + 1}:+3", quantity, F, h * S**order))
    return made


def residues(
    transfers: list[MeasuredTransfer], poles: np.ndarray, shapes: np.ndarray, order: int = 0
) -> np.ndarray:
    ends = [(int(t.response[0]) - 1, int(t.reference[0]) - 1) for t in transfers]
    return np.array(
        [[s[i] * s[j] / (2j * p.imag) * p**order for p, s in zip(poles, shapes, strict=True)] for i, j in ends]
    )


@pytest.mark.parametrize("order", [0, 1, 2])
def test_shapes_and_participations_rebuild_the_residues(order: int) -> None:
    transfers = structure(POLES, SHAPES, [0, 1, 2, 3], [0, 2], order)
    given = residues(transfers, POLES, SHAPES, order)
    found = mode_shapes(transfers, POLES, given, np.ones(3, dtype=bool))
    np.testing.assert_allclose(
        found.shape, SHAPES / SHAPES[np.arange(3), np.abs(SHAPES).argmax(1)][:, None], atol=1e-12
    )
    np.testing.assert_allclose(found.rank_one, 1.0)
    again = np.einsum("sk,sm->kms", found.shape, found.participation).reshape(8, 3)
    np.testing.assert_allclose(again * POLES**order, given, rtol=1e-10)


def test_a_moved_hammer_gives_the_same_shapes() -> None:
    transfers = structure(POLES, SHAPES, [1], [0, 1, 2, 3])
    found = mode_shapes(transfers, POLES, residues(transfers, POLES, SHAPES), np.ones(3, dtype=bool))
    assert found.places == ("1:+3", "2:+3", "3:+3", "4:+3")
    assert found.references == ("2:+3",)
    np.testing.assert_allclose(mac(found.shape, SHAPES.astype(complex)).diagonal(), 1.0)


def test_what_was_not_measured_with_every_reference_is_filled_by_rank_one() -> None:
    transfers = structure(POLES, SHAPES, [0, 1, 2, 3], [0, 2])
    given = residues(transfers, POLES, SHAPES)
    kept = [n for n in range(8) if n not in (1, 6)]
    found = mode_shapes([transfers[n] for n in kept], POLES, given[kept], np.ones(3, dtype=bool))
    np.testing.assert_allclose(mac(found.shape, SHAPES.astype(complex)).diagonal(), 1.0, atol=1e-6)


def test_two_modes_of_one_frequency_are_found_as_one_pole_with_two_shapes() -> None:
    """As of a square plate: the FRFs cannot be distinguished from those of any other pair in the same plane."""
    twice = np.array([POLES[0], POLES[1], POLES[1]])
    transfers = structure(twice, SHAPES, [0, 1, 2, 3], [0, 1, 2])
    h = np.array([one.h for one in transfers])
    h = h + 1e-4 * np.abs(h).max() * (RNG.standard_normal(h.shape) + 1j * RNG.standard_normal(h.shape))
    modes = identify(Measured(F, h), Settings(mains=None))
    real = modes.real
    np.testing.assert_allclose(modes.poles[real], POLES[:2], rtol=1e-4)
    found = mode_shapes(transfers, modes.poles, modes.residues, real)
    assert list(np.bincount(found.pole, minlength=2)[np.flatnonzero(real)]) == [1, 2]
    plane = np.linalg.qr(SHAPES[1:].T)[0]
    for shape in found.shape[1:]:
        inside = plane @ (plane.T @ shape)
        assert np.linalg.norm(inside) ** 2 / np.linalg.norm(shape) ** 2 > 0.999
    second = cmif(transfers)[1]
    near, far = np.abs(F - 170) < 1, np.abs(F - 80) < 1
    assert second[near].max() > 10 * second[far].max()


def test_noise_of_a_mode_that_hardly_shows_is_no_second_shape() -> None:
    """Noise of a fifth of the middle mode's largest residue: without the deviations two shapes."""
    rng = np.random.default_rng(7)
    small = SHAPES * np.array([1.0, 0.12, 1.0])[:, None]
    transfers = structure(POLES, small, [0, 1, 2, 3], [0, 1, 2])
    true = residues(transfers, POLES, small)
    size = 0.2 * np.abs(true[:, 1]).max()
    given = true + size / np.sqrt(2) * (rng.normal(size=true.shape) + 1j * rng.normal(size=true.shape))
    every = np.ones(3, dtype=bool)
    assert list(mode_shapes(transfers, POLES, given, every).pole) == [0, 1, 1, 2]
    assert list(mode_shapes(transfers, POLES, given, every, np.full(true.shape, size)).pole) == [0, 1, 2]


@pytest.mark.parametrize("frequency", [F, np.geomspace(20.0, 400.0, 3000), np.geomspace(0.05, 400.0, 3000)])
def test_deviations_of_residues_are_those_of_their_fits(frequency: NDArray[np.float64]) -> None:
    """White noise on 400 FRFs of one mode, residues by least squares; lines even in Hz, and in their ratio."""
    rng = np.random.default_rng(8)
    one = 1.0 / (2j * np.pi * frequency - POLES[1])
    size = (400, len(frequency))
    noise = 0.01 / np.sqrt(2) * (rng.normal(size=size) + 1j * rng.normal(size=size))
    fitted = noise @ one.conj() / (np.abs(one) ** 2).sum()
    deviation = residue_deviation(frequency, noise, POLES[1:2])
    assert np.sqrt(np.mean(np.abs(fitted) ** 2)) == pytest.approx(np.sqrt(np.mean(deviation**2)), rel=0.1)


def test_mac_and_mpc_of_known_shapes() -> None:
    shapes = SHAPES.astype(complex)
    np.testing.assert_allclose(mac(shapes * 3j, shapes).diagonal(), 1.0)
    a, b = np.array([[1.0, 1.0]], dtype=complex), np.array([[1.0, 0.0]], dtype=complex)
    assert mac(a, b)[0, 0] == pytest.approx(0.5)
    assert mac(a, np.array([[1.0, np.nan]], dtype=complex))[0, 0] == pytest.approx(1.0)
    np.testing.assert_allclose(mpc(shapes * np.exp(0.7j)), 1.0)
    assert mpc(np.array([[1.0, 1j]]))[0] == pytest.approx(0.0)


def test_poles_of_the_structure_are_stable_in_the_chart() -> None:
    transfers = structure(POLES, SHAPES, [0, 1, 2, 3], [0])
    h = np.array([one.h for one in transfers])
    h = h + 1e-3 * np.abs(h).mean() * (RNG.standard_normal(h.shape) + 1j * RNG.standard_normal(h.shape))
    chart = stabilization_chart(Measured(F, h), NONE, [2, 4, 6, 8])
    for f in (80.0, 170.0, 310.0):
        near = (np.abs(chart.frequency / f - 1.0) < 0.002) & (chart.order >= 6)
        assert (chart.stable[near] == 2).sum() == 2
    assert chart.order.max() == 8
