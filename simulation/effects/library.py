"""The project's effects in the order of application, and a user's own.

Candidates only beside another effect: a second of two alike, and the size of a damaged spot.
"""

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np

from analysis.effect_card import EffectCard
from analysis.experiment import Experiment
from simulation.effects import (
    accelerometer_mass,
    air_loading,
    amplitude_softening,
    annealing,
    bond_shear_lag,
    cable_stiffness,
    channel_skew,
    crosstalk,
    damage_size,
    damping_dispersion,
    dashpot_at_place,
    density_gradient,
    depolarization,
    draught_gradient,
    elastic_foundation,
    feedthrough,
    fractional_viscosity,
    high_pass,
    insulation_leak,
    local_damage,
    loss_orthotropy,
    low_pass,
    mass_at_place,
    modulus_gradient,
    mounting_resonance,
    orthotropy,
    patch_debond,
    patch_loss,
    permittivity_drift,
    piezo_drift,
    piezo_loss,
    piezo_nonlinearity,
    point_mass,
    poisson_loss,
    relaxation,
    resonator_at_place,
    sensor_offset,
    spring_at_place,
    string_mass,
    surface_damping,
    suspension,
    thermal_crown,
    thermal_gradient,
    thermal_lag,
    thickness_crown,
    thickness_taper,
    transverse_shear,
    viscoelastic_dispersion,
)
from simulation.effects.effect import Effect
from simulation.effects.user_folder import load_folder
from simulation.state.plate_state import Circumstances, PlateState
from simulation.tolerances import tolerances

LIBRARY: Mapping[str, Effect] = MappingProxyType(
    {
        # First the plate's mean temperature, because other effects depend on it.
        "thermal_lag": thermal_lag.EFFECT,
        # Effects that depend on the plate's temperature, or on no temperature.
        "orthotropy": orthotropy.EFFECT,
        "loss_orthotropy": loss_orthotropy.EFFECT,
        "poisson_loss": poisson_loss.EFFECT,
        "transverse_shear": transverse_shear.EFFECT,
        "modulus_gradient": modulus_gradient.EFFECT,
        "density_gradient": density_gradient.EFFECT,
        "thickness_taper": thickness_taper.EFFECT,
        "thickness_crown": thickness_crown.EFFECT,
        "suspension": suspension.EFFECT,
        "string_mass": string_mass.EFFECT,
        "point_mass": point_mass.EFFECT,
        "cable_stiffness": cable_stiffness.EFFECT,
        "accelerometer_mass": accelerometer_mass.EFFECT,
        "bond_shear_lag": bond_shear_lag.EFFECT,
        "patch_debond": patch_debond.EFFECT,
        "patch_loss": patch_loss.EFFECT,
        "piezo_drift": piezo_drift.EFFECT,
        "permittivity_drift": permittivity_drift.EFFECT,
        "insulation_leak": insulation_leak.EFFECT,
        "piezo_loss": piezo_loss.EFFECT,
        "piezo_nonlinearity": piezo_nonlinearity.EFFECT,
        "depolarization": depolarization.EFFECT,
        "viscoelastic_dispersion": viscoelastic_dispersion.EFFECT,
        "fractional_viscosity": fractional_viscosity.EFFECT,
        "relaxation": relaxation.EFFECT,
        "damping_dispersion": damping_dispersion.EFFECT,
        "annealing": annealing.EFFECT,
        "air_loading": air_loading.EFFECT,
        "elastic_foundation": elastic_foundation.EFFECT,
        "surface_damping": surface_damping.EFFECT,
        "local_damage": local_damage.EFFECT,
        "mass_at_place": mass_at_place.EFFECT,
        "spring_at_place": spring_at_place.EFFECT,
        "dashpot_at_place": dashpot_at_place.EFFECT,
        "resonator_at_place": resonator_at_place.EFFECT,
        "sensor_offset": sensor_offset.EFFECT,
        "channel_skew": channel_skew.EFFECT,
        "high_pass": high_pass.EFFECT,
        "low_pass": low_pass.EFFECT,
        "mounting_resonance": mounting_resonance.EFFECT,
        "feedthrough": feedthrough.EFFECT,
        "crosstalk": crosstalk.EFFECT,
        "amplitude_softening": amplitude_softening.EFFECT,
        # Last the temperature gradients, because afterwards the mean over unevenly spaced points is no longer the
        # plate's temperature; the one that uses this temperature comes first.
        "thermal_gradient": thermal_gradient.EFFECT,
        "thermal_crown": thermal_crown.EFFECT,
        "draught_gradient": draught_gradient.EFFECT,
    }
)
"""By name, in the order of application."""


def library(experiment: Experiment, folder: Path | None = None) -> dict[str, Effect]:
    """Return the effects for which `experiment` declares enough, by name, in the order of application.

    Those of the Python files in `folder` follow the project's own, by file name, and act on the resulting state.
    ValueError as from `load_folder`.
    """
    return {name: effect for name, effect in _all(experiment, folder).items() if effect.available(experiment)}


def untried(experiment: Experiment, folder: Path | None = None) -> dict[str, str]:
    """Say what `experiment` must declare for the effects that `library` leaves out, by effect."""
    return {
        name: effect.wants or effect.card(experiment).needs
        for name, effect in _all(experiment, folder).items()
        if not (effect.nothing_missing or effect.available(experiment))
    }


def _all(experiment: Experiment, folder: Path | None) -> dict[str, Effect]:
    if folder is None:
        return dict(LIBRARY)
    declared = tolerances(experiment, np.ones(len(experiment.patch)))
    return {**LIBRARY, **load_folder(folder, experiment, taken={**LIBRARY, **declared})}


def apply_all(
    effects: Mapping[str, Effect],
    state: PlateState,
    circumstances: Circumstances,
    values: Mapping[str, Mapping[str, Any]],
) -> PlateState:
    """Apply those effects that have values, in the order of `effects`.

    With a value v + 1j * step, every number of the state has step times its derivative as imaginary part.

    Parameters
    ----------
    circumstances : Circumstances
        Of the sweep.
    values : mapping of str to mapping
        Parameter values of every effect that is on, in the units of its card.

    Raises
    ------
    ValueError
        For values of an effect that is not among `effects`.
    """
    for name in values:
        if name not in effects:
            raise ValueError(f"no effect is named {name!r}; there are {', '.join(effects)}")
    for name, effect in effects.items():
        if name in values:
            state = effect.apply(state, circumstances, values[name])
    return state


TWICE = ("mass_at_place", "spring_at_place")
"""Effects of which a plate may have two. Without a second mass a resonator far above the band stood for it: on an
aluminium L 3 g and 2 g were named a resonator of 2.2 g at 1680 Hz, and 2.1 g."""


def seconds(library: Mapping[str, Effect]) -> dict[str, Effect]:
    """Return what is a candidate once an effect of a library is on, by name."""
    twice = {f"second_{name}": _second(library[name], name) for name in TWICE if name in library}
    return twice | ({"damage_size": damage_size.EFFECT} if "local_damage" in library else {})


def _second(first: Effect, name: str) -> Effect:
    def card(experiment: Experiment) -> EffectCard:
        known = first.card(experiment)
        return replace(
            known,
            name=f"second_{name}",
            summary=f"beside {name}, a second one: {known.summary}",
            title=f"second {known.said}",
            after=name,
        )

    return replace(first, card=card)
