"""Law of another piece, from the fleet and a measurement of it at one temperature.

The fleet is the prior: the law of a piece is normal about the fleet's mean with the covariance of its scatter
(`Scatter.of_a_piece`). The value y_0 measured at temperature 0 with variance s^2 conditions it,

    z | y_0 ~ N(m + S_.0 (y_0 - m_0) / (S_00 + s^2),  S - S_.0 S_0. / (S_00 + s^2)).

As tau and omega are estimates, too, the band uses Student's t with P - 1 degrees of freedom: without the
measurement, and of pieces without errors, it is the exact prediction interval of one more normal value.
"""

from dataclasses import dataclass

import numpy as np
from scipy.stats import t as student

from analysis.arrays import Real
from analysis.checked_fields import check_finite, check_shapes
from analysis.fleet.scatter import Scatter


@dataclass(frozen=True)
class PredictedLaw:
    """Law of one constant of a piece, on the scale of its fleet.

    Attributes
    ----------
    value, low, high : (K,) ndarray
        At the fleet's temperatures, with the band.
    share : float
        Probability of the band.
    """

    value: Real
    low: Real
    high: Real
    share: float

    def __post_init__(self) -> None:
        check_shapes(self, value="K", low="K", high="K")
        check_finite(self, "value", "low", "high")


def predict_piece(
    fleet: Scatter, place: int | None = None, value: float = 0.0, sigma: float = 0.0, share: float = 0.9
) -> PredictedLaw:
    """Predict the law of a piece that is not in the fleet.

    Parameters
    ----------
    place : int, optional
        Temperature at which it was measured, as index of the fleet's; None where it was not.
    value, sigma : float
        Measured there, with its standard deviation.
    share : float
        Probability of the band.

    Returns
    -------
    PredictedLaw
    """
    if not 0.0 < share < 1.0:
        raise ValueError(f"share {share:g}; allowed: between 0 and 1")
    mean, spread = fleet.mean, fleet.of_a_piece
    if place is not None:
        gain = spread[:, place] / (spread[place, place] + sigma**2)
        mean = mean + gain * (value - mean[place])
        spread = spread - np.outer(gain, spread[place])
    width = student.ppf(0.5 + 0.5 * share, fleet.pieces - 1) * np.sqrt(np.clip(np.diag(spread), 0.0, None))
    return PredictedLaw(mean, mean - width, mean + width, share)
