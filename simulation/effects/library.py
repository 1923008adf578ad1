"""The effects that come with the project, in the order in which they change a plate's state, and a user's own."""

from collections.abc import Mapping
from pathlib import Path
from types import MappingProxyType
from typing import Any

from analysis.effect_card import EffectCard
from analysis.experiment import Experiment
from simulation.effects import (
    air_loading,
    amplitude_softening,
    bond_shear_lag,
    channel_skew,
    damping_dispersion,
    draught_gradient,
    feedthrough,
    high_pass,
    local_damage,
    orthotropy,
    piezo_drift,
    point_mass,
    sensor_offset,
    suspension,
    thermal_gradient,
    thermal_lag,
    thickness_taper,
    viscoelastic_dispersion,
)
from simulation.effects.effect import Effect
from simulation.effects.user_folder import load_folder
from simulation.state.plate_state import Circumstances, PlateState

LIBRARY: Mapping[str, Effect] = MappingProxyType(
    {
        # The plate's temperature, as a whole: all others that look at it want it settled.
        "thermal_lag": thermal_lag.EFFECT,
        # Read the plate's temperature, or nothing.
        "orthotropy": orthotropy.EFFECT,
        "thickness_taper": thickness_taper.EFFECT,
        "suspension": suspension.EFFECT,
        "point_mass": point_mass.EFFECT,
        "bond_shear_lag": bond_shear_lag.EFFECT,
        "piezo_drift": piezo_drift.EFFECT,
        "viscoelastic_dispersion": viscoelastic_dispersion.EFFECT,
        "damping_dispersion": damping_dispersion.EFFECT,
        "air_loading": air_loading.EFFECT,
        "local_damage": local_damage.EFFECT,
        "sensor_offset": sensor_offset.EFFECT,
        "channel_skew": channel_skew.EFFECT,
        "high_pass": high_pass.EFFECT,
        "feedthrough": feedthrough.EFFECT,
        "amplitude_softening": amplitude_softening.EFFECT,
        # Tilt the temperature over the plate. Last, for the mean over sampling points that crowd somewhere is
        # not the plate's temperature any more; the one that reads it before the one that does not.
        "thermal_gradient": thermal_gradient.EFFECT,
        "draught_gradient": draught_gradient.EFFECT,
    }
)
"""By name, in the order of application."""


def library(experiment: Experiment, folder: Path | None = None) -> dict[str, Effect]:
    """Return the effects that `experiment` declares enough for, by name, in the order of application.

    Those of the Python files in `folder` follow the project's own, by file name: they see all that these did.
    ValueError as from `load_folder`.
    """
    return {name: effect for name, effect in _all(experiment, folder).items() if effect.available(experiment)}


def untried(experiment: Experiment, folder: Path | None = None) -> dict[str, EffectCard]:
    """Cards of those effects that `library` leaves out, `experiment` not declaring enough for them."""
    return {
        name: effect.card(experiment)
        for name, effect in _all(experiment, folder).items()
        if not effect.available(experiment)
    }


def _all(experiment: Experiment, folder: Path | None) -> dict[str, Effect]:
    own = {} if folder is None else load_folder(folder, experiment, taken=LIBRARY)
    return {**LIBRARY, **own}


def apply_all(
    effects: Mapping[str, Effect],
    state: PlateState,
    circumstances: Circumstances,
    values: Mapping[str, Mapping[str, Any]],
) -> PlateState:
    """Apply those effects that have values, in the order of `effects`.

    A value v + 1j * step makes step times the derivative the imaginary part of whatever in the state follows that
    parameter.

    Parameters
    ----------
    effects : mapping of str to Effect
    state : PlateState
    circumstances : Circumstances
        Of the sweep.
    values : mapping of str to mapping
        Of every effect that is on, its parameters' values in the units of its card.

    Returns
    -------
    PlateState

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
