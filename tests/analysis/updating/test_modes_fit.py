"""Natural frequencies to E, nu and eta: a twin in closed form, of simply supported plates."""

import numpy as np
import pytest
from numpy.typing import NDArray

from analysis.effect_card import EffectCard, Parameter
from analysis.material import LocalLaws, MaterialBox
from analysis.recordings.frf_campaign import ModesAtTemperature
from analysis.scatter import scatter_of
from analysis.twin_model import Effects
from analysis.updating.modes_fit import fit_modes

BOX = MaterialBox((0.8e9, 4.0e9), (0.30, 0.49), (0.005, 0.15))
NAN = float("nan")
THICKNESS = EffectCard("plate_thickness", "thickness", (Parameter("share", "1", -0.05, 0.05, 0.005),), "-", "-")


def poles(law: LocalLaws, values: Effects) -> NDArray[np.complex128]:
    """Poles of a thin plate: bending D k^4 = rho h w^2 of several wave numbers, and torsion that goes with G.

    Bending stiffness goes with E/(1 - nu^2), torsion with E/(1 + nu), so that both together tell nu.
    """
    e, nu = law.youngs_modulus(law.reference), law.poisson_ratio(law.reference)
    eta = law.loss_factor(law.reference)
    h = 1.0 + values.get("plate_thickness", {}).get("share", 0.0)
    bending = np.array([90.0, 170.0, 240.0, 390.0, 520.0]) * np.sqrt(e / 1e9 / (1.0 - nu**2)) * h
    torsion = np.array([120.0, 205.0, 333.0, 460.0]) * np.sqrt(e / 1e9 / (1.0 + nu)) * h
    squares = (2.0 * np.pi * np.concatenate([bending, torsion])) ** 2 * (1.0 + 1j * eta)
    roots = 1j * np.sqrt(squares)
    return np.asarray((-np.abs(roots.real) + 1j * np.abs(roots.imag))[np.argsort(np.abs(roots))])


def measured(
    e: float,
    nu: float,
    *,
    keep: list[int],
    seed: int = 0,
    noise: float = 2e-4,
    scatter: float = 0.3,
    eta: float = 0.04,
) -> ModesAtTemperature:
    rng = np.random.default_rng(seed)
    true = poles(LocalLaws.of_material(e, nu, eta), {})[keep]
    k = -(true**2)
    f = np.sqrt(k.real) / (2.0 * np.pi) * (1.0 + noise * rng.normal(size=len(keep)))
    loss = eta * np.exp(scatter * rng.normal(size=len(keep)))
    unknown = np.full(len(keep), NAN)
    return ModesAtTemperature(20.0, f, noise * f, loss, unknown, np.zeros(len(keep), dtype=int))


ALL = list(range(9))


@pytest.mark.parametrize("keep", [ALL, [0, 1, 3, 4, 6, 8]])
def test_the_constants_are_found_without_mode_numbers(keep: list[int]) -> None:
    """Modes that a list leaves out move no others."""
    found = fit_modes([measured(2.1e9, 0.36, keep=keep)], poles, BOX, {})
    assert found.pairs[0].tolist() == keep
    updated = found.updated
    assert abs(updated.material.youngs_modulus[0] / 2.1e9 - 1.0) < 4.0 * updated.sigma.youngs_modulus[0] / 2.1e9
    assert abs(updated.material.poisson_ratio[0] - 0.36) < 4.0 * updated.sigma.poisson_ratio[0]
    assert updated.settled.all()
    assert not found.held


def test_standard_deviations_are_those_of_repeated_lists() -> None:
    """Over sixty lists nineteen of twenty values of E, nu and eta lie within two standard deviations."""
    away = []
    for seed in range(60):
        found = fit_modes([measured(1.5e9, 0.42, keep=ALL, seed=seed)], poles, BOX, {}).updated
        away.append(
            [
                (found.material.youngs_modulus[0] - 1.5e9) / found.sigma.youngs_modulus[0],
                (found.material.poisson_ratio[0] - 0.42) / found.sigma.poisson_ratio[0],
                np.log(found.material.loss_factor[0] / 0.04)
                * found.material.loss_factor[0]
                / found.sigma.loss_factor[0],
            ]
        )
    inside = np.mean(np.abs(np.array(away)) < 1.96, axis=0)
    assert (inside > 0.87).all()
    assert np.std(np.array(away)[:, :2], axis=0).min() > 0.7


def test_the_tolerance_of_the_thickness_reaches_the_modulus() -> None:
    """Frequencies go with h sqrt(E): half a per cent of thickness is one per cent of E."""
    found = fit_modes([measured(2.1e9, 0.36, keep=ALL)], poles, BOX, {"plate_thickness": THICKNESS}).updated
    assert found.sigma.youngs_modulus[0] / 2.1e9 == pytest.approx(0.01, rel=0.1)
    assert found.sigma.poisson_ratio[0] < 0.003
    assert found.common is not None
    assert abs(found.common[0, 0, 0]) == pytest.approx(0.01, rel=0.05)


def test_bending_modes_alone_leave_nu_at_its_prior() -> None:
    true = measured(2.1e9, 0.36, keep=ALL)
    bending = [j for j in ALL if j in (0, 2, 4, 6, 8)][:2]
    one = ModesAtTemperature(
        20.0,
        true.frequency[bending[:1]],
        true.sigma[bending[:1]],
        true.loss_factor[bending[:1]],
        true.sigma_loss_factor[bending[:1]],
        np.array([1]),
    )
    found = fit_modes([one], poles, BOX, {})
    assert any("hardly tell nu" in said for said in found.held)
    assert found.updated.sigma.poisson_ratio[0] > 0.03
    assert abs(found.updated.material.youngs_modulus[0] / 2.1e9 - 1.0) < 0.15


def test_without_damping_eta_is_no_estimate() -> None:
    true = measured(2.1e9, 0.36, keep=ALL)
    quiet = ModesAtTemperature(
        20.0, true.frequency, true.sigma, np.full(9, NAN), np.full(9, NAN), np.zeros(9, dtype=int)
    )
    found = fit_modes([quiet], poles, BOX, {})
    assert any("no damping" in said for said in found.held)
    assert np.isnan(found.scatter)


def test_a_list_that_fits_two_moduli_is_refused() -> None:
    """A single frequency is any of the twin's modes."""
    one = measured(2.1e9, 0.36, keep=[3])
    with pytest.raises(ValueError, match="equally well; give their numbers"):
        fit_modes([one], poles, BOX, {})


def test_few_frequencies_without_deviations_are_refused() -> None:
    true = measured(2.1e9, 0.36, keep=ALL)
    few = ModesAtTemperature(
        20.0,
        true.frequency[:3],
        np.full(3, NAN),
        true.loss_factor[:3],
        np.full(3, NAN),
        np.array([1, 2, 3]),
    )
    with pytest.raises(ValueError, match="give sigma_frequency"):
        fit_modes([few], poles, BOX, {})


def test_scatter_of_numbers_with_errors() -> None:
    """Of 400 numbers N(0, 0.3^2) with errors of 0.1 the scatter is 0.3 within its own error of 4 %."""
    rng = np.random.default_rng(5)
    values = 0.3 * rng.normal(size=400) + 0.1 * rng.normal(size=400)
    assert scatter_of(values, np.full(400, 0.01), (0.01, 1.0)) == pytest.approx(0.3, rel=0.12)
    assert scatter_of(0.0 * values, np.full(400, 1e-8), (0.01, 1.0)) == pytest.approx(0.01, rel=0.1)


def test_a_constant_at_the_end_of_its_range_is_named() -> None:
    found = fit_modes([measured(2.1e9, 0.36, keep=ALL, eta=0.25, scatter=0.0)], poles, BOX, {})
    assert not found.updated.settled.all()
    assert any("loss_factor comes to an end of the material's range, 0.005 to 0.15" in said for said in found.held)
