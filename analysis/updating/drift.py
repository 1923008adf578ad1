"""Drift of the temperature within sweeps and between repeats: no two numbers are measured at one temperature."""

from concurrent.futures import Executor
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline

from analysis.arrays import Complex, Real
from analysis.experiment import Protocol
from analysis.frf import Frf
from analysis.gap.data.preparation import sweep_points
from analysis.local_laws import LocalLaws
from analysis.material import MaterialLaws
from analysis.sweep_point import SweepPoint
from analysis.twin_model import NO_EFFECTS, TwinModel
from analysis.updated import Updated


def sweep_laws(updated: Updated, laws: MaterialLaws | None) -> list[LocalLaws]:
    """Laws through the material of every sweep, with the slopes of `laws` there; without `laws`, with none."""
    low, high = laws.temperature_range if laws else (0.0, 0.0)
    rows = zip(updated.temperature.tolist(), updated.constants, strict=True)
    return [
        LocalLaws.of_material(
            *material,
            reference=t,
            slope=tuple(laws.local(min(max(t, low), high)).slope) if laws else (0.0, 0.0, 0.0),
        )
        for t, material in rows
    ]


def drift_of_frfs(
    frf: Frf, model: TwinModel, updated: Updated, laws: MaterialLaws, protocol: Protocol, executor: Executor
) -> NDArray[np.complex128] | None:
    """Compute by how much FRFs differ from those at the mean temperature of each sweep.

    Parameters
    ----------
    frf : Frf
    model : TwinModel
    updated : Updated
        Model updating of these FRFs, taken as if measured at the mean temperature.
    laws : MaterialLaws
        Through its estimates; they give the slopes over temperature.
    protocol : Protocol
    executor : Executor
        Sweeps are computed on it.

    Returns
    -------
    (T, K, F) complex ndarray or None
        To first order in the drift within a sweep, to second in that between its repeats; None where neither is
        known to occur.
    """
    points = sweep_points(frf, protocol)
    if not any(point.drifts for point in points) and not protocol.spread:
        return None

    def change(law: LocalLaws, point: SweepPoint) -> NDArray[np.complex128]:
        by_temperature = model.linearise(law, frf.frequency, NO_EFFECTS, point).by_temperature
        within = point.drift(frf.frequency) * by_temperature
        between = 0.5 * protocol.spread**2 * _second(by_temperature, frf.frequency, law)
        return np.asarray(updated.gains[point.source] * (within + between))

    return np.array(list(executor.map(change, sweep_laws(updated, laws), points)))


def without_spread(
    frf: Frf, model: TwinModel, updated: Updated, laws: MaterialLaws | None, protocol: Protocol, executor: Executor
) -> Frf:
    """Correct means over the repeats of a sweep to FRFs at their mean temperature.

    It is the second part of `drift_of_frfs`, for twins that follow the drift within a sweep themselves.

    Parameters
    ----------
    frf : Frf
    model : TwinModel
    updated : Updated
        Model updating of these FRFs.
    laws : MaterialLaws or None
        Through its estimates; without them nothing is corrected.
    protocol : Protocol
    executor : Executor
        Sweeps are computed on it.

    Returns
    -------
    Frf
    """
    untimed = protocol.model_copy(update={"taper": None})
    spread = None if laws is None else drift_of_frfs(frf, model, updated, laws, untimed, executor)
    return frf if spread is None else replace(frf, h=frf.h - spread)


def _second(by_temperature: Complex, frequency: Real, law: LocalLaws) -> Complex:
    """Return the second derivative (K, F) of a transfer by temperature, 1/K2.

    All resonances move with the root of E, and they change what is seen near them by far the most: the transfer
    depends on frequency over root of E.
    """
    along = CubicSpline(frequency, by_temperature, axis=-1)(frequency, 1)
    return np.asarray(-0.5 * float(law.rates(law.reference)[0]) * frequency * along)
