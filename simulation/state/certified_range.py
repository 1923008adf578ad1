"""Certified range of a reduced plate with effects."""

from typing import Any

import numpy as np

from simulation.reduction.effect_operators import EffectOperators
from simulation.state.plate_state import PlateState
from simulation.state.sheet_departures import FARTHEST_MODULI, FARTHEST_SHEAR

ANISOTROPY = (0.88, 1.12)
THICKNESS = (0.9, 1.1)
BOND = (0.55, 1.0)
TRANSVERSE = (0.6, 1.4)
"""Over the nominal values: `extreme_states`, of the thickness all together, reach the ends of these ranges."""
SPREAD = 1.3
"""Largest ratio of a local modulus to the one at the mean temperature."""


def require_certified(state: PlateState, ops: EffectOperators) -> None:
    """ValueError, naming value and range, for a state for which the operators' error was not measured."""
    temperature = np.real(state.mean_temperature)
    laws = state.laws
    asked: list[tuple[str, Any, tuple[float, float]]] = [
        ("youngs_modulus [Pa]", laws.youngs_modulus(temperature), ops.box.youngs_modulus),
        ("poisson_ratio", laws.poisson_ratio(temperature), ops.box.poisson_ratio),
        ("loss_factor", laws.loss_factor(temperature), ops.box.loss_factor),
        ("modulus along x over E", state.modulus_x, ANISOTROPY),
        ("modulus along y over E", state.modulus_y, ANISOTROPY),
        ("in-plane shear modulus over its isotropic value", state.in_plane_shear, ANISOTROPY),
        ("local thickness over the nominal", state.thickness, THICKNESS),
        ("transverse shear modulus over its isotropic value", state.transverse_shear, TRANSVERSE),
        ("local density over the nominal", state.density, THICKNESS),
        ("bond factor", state.bond, BOND),
        ("bonded share of a patch", 1.0 - np.asarray(state.debonded), BOND),
        ("offset along x [m]", state.offset_x, (-ops.offset_range, ops.offset_range)),
        ("offset along y [m]", state.offset_y, (-ops.offset_range, ops.offset_range)),
        (
            "local modulus over its mean",
            state.modulus * laws.youngs_modulus(state.temperature) / laws.youngs_modulus(temperature),
            (1.0 / SPREAD, SPREAD),
        ),
    ]
    if len(ops.shear) > 1:
        asked += _of_the_sheet(state)
    for name, value, (low, high) in asked:
        values = np.atleast_1d(np.real(value))
        slack = 1e-9 * max(abs(low), abs(high))
        outside = values[~((values >= low - slack) & (values <= high + slack))]
        if outside.size:
            raise ValueError(
                f"{name} {outside[0]:.6g} is outside the twin's certified range, {low:.6g} to {high:.6g}"
            )


def _of_the_sheet(state: PlateState) -> list[tuple[str, Any, tuple[float, float]]]:
    """Return ratios of an orthotropic sheet over the declared ones, with their ranges."""
    away = state.departures
    moduli = (np.exp(-FARTHEST_MODULI), np.exp(FARTHEST_MODULI))
    across = tuple(np.exp(sign * (FARTHEST_SHEAR + FARTHEST_MODULI)) for sign in (-1.0, 1.0))
    return [
        ("Ey/Ex over the declared ratio", away.modulus_y / away.modulus_x, moduli),
        ("shear modulus of the sheet over its declared share", away.in_plane_shear, moduli),
        ("transverse shear modulus xz over its declared share", away.shear_x, across),
        ("transverse shear modulus yz over its declared share", away.shear_y, across),
    ]
