"""Cost of a method on the device that runs the filters: numbers stored, and multiplications for new taps."""

from analysis.arrays import Real
from analysis.compensation.low_rank import LowRankBank
from analysis.compensation.outcome import (
    LINEAR,
    LOW_RANK,
    NETWORK,
    REDUCED_FREQUENCY,
    RIGIDITY_SPLINE,
    SPLINE,
)
from analysis.focusing.fir import FirBank


def burdens(filters: FirBank, low_rank: LowRankBank, nodes: int, lines: Real) -> dict[str, tuple[float, float]]:
    """Numbers stored and multiplications per update, of every method.

    Interpolation keeps the training filters; a spline's value is a sum over all of them with weights that follow
    from the temperature alone. Equal reduced frequency stretches four responses and fits a filter to each
    actuator.

    Parameters
    ----------
    filters : FirBank
        At the n training temperatures.
    low_rank : LowRankBank
        Of them.
    nodes : int
        Hidden nodes of a network.
    lines : (L,) ndarray, Hz
        Where filters are designed.

    Returns
    -------
    dict
        By the method's name: (numbers stored, multiplications per update).
    """
    count, actuators, taps = filters.taps.shape
    one, rank = float(actuators * taps), len(low_rank.filters)
    fit = 4.0 * 8.0 * len(lines) * actuators + 2.0 * len(lines) * one
    return {
        NETWORK: (float(actuators * (2 * nodes + (nodes + 1) * taps)), nodes * one),
        LINEAR: (count * one, 2.0 * one),
        SPLINE: (count * one, count * one),
        RIGIDITY_SPLINE: (count * one, count * one),
        REDUCED_FREQUENCY: (count * one, fit),
        LOW_RANK: ((rank + 1) * one + count * rank, rank * one),
    }
