"""Moduli and loss factors of a declared orthotropic sheet, by direction, as declared quantities of the twin."""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from analysis.effect_card import EffectCard, Parameter
from analysis.experiment import Experiment
from analysis.sheet_material import LOSS, MODULI, TRANSVERSE
from simulation.effects.effect import Effect
from simulation.state.plate_state import Circumstances, PlateState
from simulation.state.sheet_departures import (
    FARTHEST_LOSS,
    FARTHEST_MODULI,
    FARTHEST_SHEAR,
    departed_loss,
    departed_moduli,
    departed_transverse,
)
from simulation.tolerance import RANGE_IN_TOLERANCES, Tolerance

UNDECLARED_TOLERANCE = 1.5
"""Tolerance of the logarithm of a transverse shear modulus that is not declared: that of wood's yz plane is a
twentieth, those of laminates are a half to one of the shear modulus in the plane."""


def sheet_tolerances(experiment: Experiment) -> Iterator[Effect]:
    """Yield the quantities of a declared orthotropic sheet that are not exact; none for an isotropic one.

    All are natural logarithms of ratios, see `simulation.state.sheet_departures`.
    """
    material, given = experiment.plate.material, experiment.tolerances
    sheet = None if material is None else material.departure
    if sheet is None:
        return
    each = float(np.sqrt(2.0)) * given.moduli  # a ratio of two, each known so well
    yield from _quantity(
        MODULI,
        "moduli of the sheet, over their mean",
        {"ratio": each, "shear": each},
        FARTHEST_MODULI,
        lambda v: departed_moduli(sheet, v.get("ratio", 0.0), v.get("shear", 0.0)),
    )
    across = (
        given.transverse_shear if sheet.declared_transverse or not given.transverse_shear else UNDECLARED_TOLERANCE
    )
    yield from _quantity(
        TRANSVERSE,
        "transverse shear moduli of the sheet",
        {"xz": across, "yz": across},
        FARTHEST_SHEAR,
        lambda v: departed_transverse(v["xz"], v["yz"]),
    )
    yield from _quantity(
        LOSS,
        "loss factors of the sheet by direction",
        {"ratio": given.loss_direction, "shear": given.loss_direction},
        FARTHEST_LOSS,
        lambda v: departed_loss(v["ratio"], v["shear"]),
    )


def _quantity(
    name: str,
    words: str,
    wanted: Mapping[str, float],
    farthest: float,
    factors: Callable[[Mapping[str, Any]], dict[str, Any]],
) -> Iterator[Effect]:
    """Yield a quantity with its parameters, {name: tolerance}, unless it is exact."""
    if not all(tolerance > 0.0 for tolerance in wanted.values()):
        return
    parameters = tuple(
        Parameter(key, "log", -reach, reach, tolerance)
        for key, tolerance in wanted.items()
        for reach in (min(farthest, RANGE_IN_TOLERANCES * tolerance),)
    )
    card = EffectCard(name, words, parameters, "nothing: it is always free", "cut strips and measure their moduli")

    def change(away: Any, values: Mapping[str, Any]) -> dict[str, Any]:
        return {attribute: getattr(away, attribute) * share for attribute, share in factors(values).items()}

    def apply(state: PlateState, circumstances: Circumstances, values: Mapping[str, Any]) -> PlateState:
        return state.with_(departures=replace(state.departures, **change(state.departures, values)))

    yield Tolerance(lambda _: card, apply, change=change)
