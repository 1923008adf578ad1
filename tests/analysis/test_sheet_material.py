"""Constants of a sheet by direction: definitions, and deviations against random draws."""

import numpy as np
import pytest

from analysis.estimates import SheetConstants, SheetMaterial
from analysis.material import Orthotropy

SHEET = Orthotropy(-0.84, -0.7)
LAWS = np.array([[np.log(6.5e9), 0.135, np.log(0.011)], [np.log(6.0e9), 0.15, np.log(0.02)]])
RATIOS = np.array([0.2, -0.1, 1.1, 0.3])


def made(covariance: np.ndarray, common: np.ndarray | None = None) -> SheetMaterial:
    own = np.zeros((2, 3))
    moved = np.zeros((2, 7, 0)) if common is None else common
    return SheetMaterial.of(SHEET, LAWS, RATIOS, np.array([covariance] * 2), moved, own)


def test_the_constants_are_those_of_their_definitions() -> None:
    found = made(np.zeros((7, 7)))
    value, e, nu, eta = found.value, np.exp(LAWS[:, 0]), LAWS[:, 1], np.exp(LAWS[:, 2])
    assert 0.5 * (value.youngs_modulus_x + value.youngs_modulus_y) == pytest.approx(e)
    ratio = value.youngs_modulus_y / value.youngs_modulus_x
    assert ratio == pytest.approx([0.16 / 1.84 * np.exp(0.2)] * 2)
    nu_yx = value.poisson_ratio_xy * ratio  # reciprocity
    assert value.poisson_ratio_xy * nu_yx == pytest.approx(nu**2)
    assert value.shear_modulus == pytest.approx(0.3 * np.exp(-0.1) * e / (2.0 * (1.0 + nu)))
    assert value.loss_factor_x * value.loss_factor_y == pytest.approx(eta**2)
    assert value.loss_factor_shear / eta == pytest.approx([np.exp(0.3)] * 2)
    declared = Orthotropy(found.delta_e, found.delta_g)  # as a panel of this sheet is declared
    assert e * (1.0 - declared.delta_e) == pytest.approx(value.youngs_modulus_x)
    assert e * (1.0 + declared.delta_e) == pytest.approx(value.youngs_modulus_y)
    assert (1.0 + declared.delta_g) * e / (2.0 * (1.0 + nu)) == pytest.approx(value.shear_modulus)


def test_deviations_are_those_of_draws_with_the_same_covariance() -> None:
    """E and the ratios are correlated: their errors partly cancel in one modulus and add in the other."""
    rng = np.random.default_rng(1)
    root = 0.01 * rng.standard_normal((7, 7))
    covariance = root @ root.T
    draws = rng.multivariate_normal(np.concatenate([LAWS[0], RATIOS]), covariance, 3000)
    nothing, empty = np.zeros((1, 7, 7)), np.zeros((1, 7, 0))
    values = np.array(
        [
            SheetMaterial.of(SHEET, row[None, :3], row[3:], nothing, empty, np.zeros((1, 3))).value.rows[:, 0]
            for row in draws
        ]
    )
    assert made(covariance).sigma.rows[:, 0] == pytest.approx(values.std(axis=0), rel=0.06)


def test_contributions_add_up_to_the_deviation() -> None:
    rng = np.random.default_rng(2)
    common = 0.01 * rng.standard_normal((2, 7, 3))
    own = np.array([[1e-4, 1e-5, 1e-4]] * 2)
    covariance = common @ common.transpose(0, 2, 1) + np.array([np.diag([*row, 0, 0, 0, 0]) for row in own])
    found = SheetMaterial.of(SHEET, LAWS, RATIOS, covariance, common, own)
    relative = found.sigma.rows / found.value.rows
    relative[3] = found.sigma.poisson_ratio_xy
    assert found.noise**2 + (found.common**2).sum(axis=2) == pytest.approx(relative.T**2)
    assert found.common[:, :, -1] == pytest.approx(np.zeros((2, 7)), abs=1e-9)  # all is noise and declaration
    later = found.at(LAWS[[1, 1, 0]], np.array([1, 1, 0]))
    assert later.value.rows[:, 2] == pytest.approx(found.value.rows[:, 0])
    assert later.sigma.rows[:, 0] == pytest.approx(found.sigma.rows[:, 1])


def test_nonsense_is_refused() -> None:
    rows = np.ones((7, 2))
    rows[1, 0] = -1.0
    with pytest.raises(ValueError, match=r"youngs_modulus_y is .*from 0 wanted"):
        SheetConstants(*rows)
