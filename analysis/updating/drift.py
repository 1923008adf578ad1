"""Drift of the temperature within sweeps and between repeats: no two numbers are measured at one temperature."""

from collections.abc import Sequence
from concurrent.futures import Executor
from dataclasses import replace

import numpy as np

from analysis.arrays import Complex, Real
from analysis.experiment import Protocol
from analysis.frf import Frf
from analysis.gap.data.preparation import nodes_over, sweep_points
from analysis.local_laws import LocalLaws
from analysis.material import Material, MaterialLaws
from analysis.sweep_point import SweepPoint
from analysis.twin_model import NO_EFFECTS, TwinModel
from analysis.updated import Updated


def sweep_laws(temperature: Real, material: Material, laws: MaterialLaws | None) -> list[LocalLaws]:
    """Laws through the material of every sweep, with the slopes of smooth laws there.

    Parameters
    ----------
    temperature : (T,) ndarray
        Of the sweeps, degrees Celsius.
    material : Material
        Of every sweep, (T,) arrays.
    laws : MaterialLaws or None
        Through all sweeps; without them, the slopes are zero.

    Returns
    -------
    list of LocalLaws
    """
    low, high = laws.temperature_range if laws else (0.0, 0.0)
    constants = zip(material.youngs_modulus, material.poisson_ratio, material.loss_factor, strict=True)
    return [
        LocalLaws.of_material(
            *map(float, one),
            reference=t,
            slope=tuple(laws.local(min(max(t, low), high)).slope) if laws else (0.0, 0.0, 0.0),
        )
        for t, one in zip(temperature.tolist(), constants, strict=True)
    ]


def steady(
    frf: Frf, model: TwinModel, laws: Sequence[LocalLaws], gains: Real, protocol: Protocol, executor: Executor
) -> Frf:
    """FRFs as at the mean temperature of each sweep, for twins that do not follow the drift.

    Parameters
    ----------
    frf : Frf
        As measured.
    model : TwinModel
    laws : sequence of LocalLaws
        Of the sweeps, with their slopes over temperature. Approximate ones are enough: they only enter the
        difference, which is a few standard deviations of what is fitted.
    gains : (I,) ndarray
        Of the inputs.
    protocol : Protocol
    executor : Executor
        Sweeps are computed on it.

    Returns
    -------
    Frf
        Corrected to second order in the drift within a sweep and between its repeats; the same FRFs where neither
        is known to occur.
    """
    orders = _orders(frf, model, laws, gains, protocol, executor)
    return frf if orders is None else replace(frf, h=frf.h - orders.sum(axis=1))


def to_first_order(
    frf: Frf, model: TwinModel, updated: Updated, laws: MaterialLaws | None, protocol: Protocol, executor: Executor
) -> Frf:
    """Take the second order of the drift out of FRFs, for twins that follow its first order themselves.

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
    if laws is None:
        return frf
    local = sweep_laws(updated.temperature, updated.material, laws)
    orders = _orders(frf, model, local, updated.gains, protocol, executor)
    return frf if orders is None else replace(frf, h=frf.h - orders[:, 1])


def _orders(
    frf: Frf, model: TwinModel, laws: Sequence[LocalLaws], gains: Real, protocol: Protocol, executor: Executor
) -> Complex | None:
    """First and second order of the drift, (T, 2, K, F); None where none is known to occur."""
    points = sweep_points(frf, protocol)
    if not any(point.drifts for point in points) and not protocol.spread:
        return None
    nodes = nodes_over(frf.frequency, laws)

    def change(law: LocalLaws, point: SweepPoint) -> Complex:
        first = model.linearise(law, nodes.frequency, NO_EFFECTS, point).by_temperature
        both = np.array([first, _second(first, nodes.frequency, law)])
        first, second = nodes.at_lines(nodes.coefficients(both))
        away = point.drift(frf.frequency)
        squared = away**2 + protocol.spread**2  # mean over the repeats
        return np.asarray(gains[point.source] * np.array([away * first, 0.5 * squared * second]))

    return np.array(list(executor.map(change, laws, points)))


def _second(by_temperature: Complex, frequency: Real, law: LocalLaws) -> Complex:
    """Return the second derivative (K, F) of a transfer by temperature, 1/K2.

    All resonances move with the root of E, and they change what is seen near them by far the most: the transfer
    depends on frequency over root of E.
    """
    from scipy.interpolate import CubicSpline  # not needed by the verbs that import this module for its notes

    along = CubicSpline(frequency, by_temperature, axis=-1)(frequency, 1)
    return np.asarray(-0.5 * float(law.rates(law.reference)[0]) * frequency * along)
