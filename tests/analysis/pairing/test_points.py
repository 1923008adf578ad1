"""CoMAC, and sensors at wrong points, of wrong sign or of wrong sensitivity, on shapes of a known plate."""

import numpy as np
import pytest
from numpy.typing import NDArray

from analysis.pairing.points import LEAST_MODES, PointComparison, compare_points

X, Y = (grid.ravel() for grid in np.meshgrid(np.linspace(0.05, 0.95, 6), np.linspace(0.08, 0.9, 4)))
ORDERS = [(1, 1), (2, 1), (1, 2), (3, 1), (2, 2), (3, 2), (1, 3), (4, 1)]
FREQUENCY = np.array([float(m**2 + n**2) for m, n in ORDERS])
NAMES = tuple(str(k + 1) for k in range(X.size))


def shapes() -> NDArray[np.complex128]:
    """Residues of a simply supported plate driven at (0.31, 0.27), (K, N)."""
    drive = np.array([np.sin(m * np.pi * 0.31) * np.sin(n * np.pi * 0.27) for m, n in ORDERS])
    rows = np.array([np.sin(m * np.pi * X) * np.sin(n * np.pi * Y) for m, n in ORDERS]).T
    return np.asarray(1j * rows * drive, dtype=complex)


def measured(noise: float = 0.03, seed: int = 0) -> NDArray[np.complex128]:
    rng = np.random.default_rng(seed)
    true = shapes() * rng.uniform(0.6, 1.6, len(ORDERS)) * np.exp(1j * rng.uniform(-0.2, 0.2, len(ORDERS)))
    rms = np.sqrt((np.abs(true) ** 2).mean(axis=0))
    return np.asarray(
        true + noise * rms * (rng.standard_normal(true.shape) + 1j * rng.standard_normal(true.shape))
    )


def compared(rows: NDArray[np.complex128]) -> PointComparison:
    found = compare_points(NAMES, ["velocity"] * len(NAMES), FREQUENCY, rows, shapes())
    assert found is not None
    return found


def test_comac_is_that_of_its_definition() -> None:
    rows = measured(0.2)
    found, twin = compared(rows), shapes()
    for k in (0, 7, 20):
        r, c = [], []
        for n in range(len(ORDERS)):
            unit = twin[:, n] / np.linalg.norm(twin[:, n])
            scale = np.vdot(rows[:, n], unit) / np.vdot(rows[:, n], rows[:, n])
            r.append(scale * rows[k, n])
            c.append(unit[k])
        wanted = abs(np.vdot(r, c)) ** 2 / (np.vdot(r, r).real * np.vdot(c, c).real)
        assert found.comac[k] == pytest.approx(wanted, rel=1e-9)


@pytest.mark.parametrize("seed", range(20))
def test_of_a_sound_test_nothing_is_said(seed: int) -> None:
    found = compared(measured(0.1, seed))
    assert not found.wrong.any()
    assert found.said == ()


@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize("noise", [0.0, 0.05])
def test_wrong_sign_and_exchanged_points_are_named(noise: float, seed: int) -> None:
    rows = measured(noise, seed)
    rows[[2, 3]] = rows[[3, 2]]
    rows[6] *= -1.0
    found = compared(rows)
    assert [k for k in range(len(NAMES)) if found.wrong[k]] == [2, 3, 6]
    exchanged, sign = found.said
    assert exchanged.startswith("points 3 and 4 are exchanged")
    assert sign.startswith("point 7 moves like its mirror: sign")


def test_points_in_a_circle_sensitivity_and_a_place_that_is_not_declared() -> None:
    rows = measured()
    rows[[1, 8, 16]] = rows[[8, 16, 1]]
    rows[11] *= 2.5
    there = np.array([np.sin(m * np.pi * 0.2) * np.sin(n * np.pi * 0.5) for m, n in ORDERS])
    rows[21] = 1j * there
    found = compared(rows)
    said = " | ".join(found.said)
    assert "points 2, 9, 17 are mixed up: 2 moves as the twin at 9, 9 moves as the twin at 17" in said
    assert "point 12 moves 2." in said
    assert found.factor[11] == pytest.approx(2.5, rel=0.06)
    assert "point 22 moves like no declared point" in said
    assert found.wrong.sum() == 5


def test_points_of_other_quantities_are_not_exchanged() -> None:
    """A row in other units is no larger for it."""
    rows, kinds = measured(), ["velocity"] * len(NAMES)
    twin = shapes()
    for k in (3, 4):
        kinds[k] = "voltage"
        rows[k] *= 1e-4
        twin[k] *= 1e-4
    found = compare_points(NAMES, kinds, FREQUENCY, rows, twin)
    assert found is not None
    assert found.said == ()
    rows[[3, 10]] = rows[[10, 3]]
    found = compare_points(NAMES, kinds, FREQUENCY, rows, twin)
    assert found is not None
    assert not any("exchanged" in one for one in found.said)


def test_too_few_modes_or_no_majority_say_nothing() -> None:
    rows = measured()
    few = LEAST_MODES - 1
    assert compare_points(NAMES, ["v"] * len(NAMES), FREQUENCY[:few], rows[:, :few], shapes()[:, :few]) is None
    order = np.random.default_rng(1).permutation(len(NAMES))
    mixed = compare_points(NAMES, ["v"] * len(NAMES), FREQUENCY, rows[order], shapes())
    assert mixed is None or not mixed.said
    with pytest.raises(ValueError, match="of 3 points"):
        compare_points(NAMES[:3], ["v"] * 3, FREQUENCY, rows, shapes())


def test_shapes_are_scaled_to_the_computed_ones() -> None:
    found, twin = compared(measured(0.0)), shapes()
    np.testing.assert_allclose(found.measured, found.computed, atol=1e-9)
    np.testing.assert_allclose(np.abs(found.computed), np.abs(twin) / np.abs(twin).max(axis=0), atol=1e-9)
    assert found.frequency.tolist() == FREQUENCY.tolist()
