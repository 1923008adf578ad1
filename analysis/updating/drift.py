"""Drift of the temperature within sweeps and between repeats: no two numbers are measured at one temperature."""

from collections.abc import Sequence
from concurrent.futures import Executor
from dataclasses import replace
from itertools import repeat

import numpy as np

from analysis.arrays import Complex, Real
from analysis.experiment import Protocol
from analysis.gap.data.preparation import nodes_over, sweep_points
from analysis.material import LocalLaws, Material, MaterialLaws
from analysis.recordings.frf import Frf
from analysis.recordings.sweep_point import SweepPoint
from analysis.twin_model import NO_EFFECTS, TwinModel

NEGLIGIBLE = 1e-4
"""Second order of the drift, as a share of a resonance's peak, below which it is not taken out: it changes a loss
factor by about the same share of it."""


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


def to_first_order(
    frf: Frf, model: TwinModel, laws: Sequence[LocalLaws], gains: Real, protocol: Protocol, executor: Executor
) -> Frf:
    """Take the second order of the drift out of FRFs, for a twin, which follows its first order itself.

    Parameters
    ----------
    frf : Frf
        As measured.
    laws : sequence of LocalLaws
        Of the sweeps, with their slopes over temperature. Approximate ones are enough: they only enter the change.
    gains : (I,) ndarray
        Of the inputs.
    executor : Executor
        Sweeps are computed on it.

    Returns
    -------
    Frf
        The same FRFs where the second order is negligible.
    """
    points = sweep_points(frf, protocol)
    away = [point.drift(frf.frequency) for point in points]
    if max(map(_share_of_peak, laws, away, repeat(protocol.spread))) < NEGLIGIBLE:
        return frf
    nodes = nodes_over(frf.frequency, laws)

    def change(law: LocalLaws, point: SweepPoint, away: Real) -> Complex:
        first = model.linearise(law, nodes.frequency, NO_EFFECTS, point).by_temperature
        second = nodes.at_lines(nodes.coefficients(_second(first, nodes.frequency, law)))
        return np.asarray(gains[point.source] * 0.5 * _squared(away, protocol.spread) * second)

    return replace(frf, h=frf.h - np.array(list(executor.map(change, laws, points, away))))


def _squared(away: Real, spread: float) -> Real:
    """Mean square (F,), over the repeats, of the temperature at each line less that of the sweep, K2."""
    return np.asarray(away**2 + spread**2)


def _share_of_peak(law: LocalLaws, away: Real, spread: float) -> float:
    """Largest second order of the drift, as a share of a resonance's peak: the shift in half widths, squared."""
    softening, eta = float(law.rates(law.reference)[0]), float(law.loss_factor(law.reference))
    return (softening / eta) ** 2 * float(_squared(away, spread).max())


def _second(by_temperature: Complex, frequency: Real, law: LocalLaws) -> Complex:
    """Return the second derivative (K, F) of a transfer by temperature, 1/K2.

    All resonances move with the root of E, and they change what is seen near them by far the most: the transfer
    depends on frequency over root of E.
    """
    from scipy.interpolate import CubicSpline  # not needed by the verbs that import this module for its notes

    along = CubicSpline(frequency, by_temperature, axis=-1)(frequency, 1)
    return np.asarray(-0.5 * float(law.rates(law.reference)[0]) * frequency * along)
