"""The plate's temperature drifts while a sweep passes: each frequency is measured at a temperature of its own."""

import numpy as np

from analysis.arrays import Real
from analysis.sweep_point import SweepPoint
from simulation.state.plate_state import PlateState


def drifting(state: PlateState, point: SweepPoint, frequency: Real) -> PlateState:
    """Return the plate with the modulus that it has when the sweep passes each frequency.

    The laws of E and eta are followed to first order from the middle of the record, whose temperature is the
    sweep's reading. A sweep of 2 s on a ramp of 1 K/min drifts by 0.03 K, which changes a resonance of
    polypropylene by 0.7 % of its peak. The change of Poisson's ratio, below 1e-4, is neglected.

    Parameters
    ----------
    state : PlateState
        With the laws of the material.
    point : SweepPoint
        Its rate and timing; without a timing, `state` is returned.
    frequency : (F,) ndarray
        Hz.

    Returns
    -------
    PlateState
    """
    if point.timing is None or not point.rate:
        return state
    away = point.rate * point.timing.after_middle(frequency)
    by_modulus, _, by_loss = state.laws.rates(point.temperature)
    storage = np.exp(by_modulus * away)
    return state.with_(storage=state.storage * storage, loss=state.loss * storage * np.exp(by_loss * away))
