"""Placement of training temperatures so that filters between them lose least contrast."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Complex, Real
from analysis.checked_fields import check_ascending, check_shapes
from analysis.compensation.settings import FEWEST_TRAINING_TEMPERATURES
from analysis.focusing.energy import EnergyForms
from analysis.focusing.fir import FirBank
from analysis.focusing.performance import contrast

TEMPERATURE_GRID = 1.0
"""Training temperatures are multiples of this step, K: an oven is not set more finely."""
TRIED_MOVES = (1, -1, 2, -2, 4, -4)
"""Moves of a temperature that are tried, in steps of `TEMPERATURE_GRID`."""
POWER_MEAN_EXPONENT = 8
"""Exponent of the power mean of losses that is minimised: close to the maximum, but smooth in every loss."""


@dataclass(frozen=True)
class PlacedTemperatures:
    """Placed training temperatures, compared with as many equidistant ones.

    Attributes
    ----------
    temperature, equidistant : (n,) ndarray
        Ascending, both ends of the range among them, °C.
    loss, equidistant_loss : float
        Loss of contrast of a cubic spline through the filters there, at the worst line of the worst temperature.
    """

    temperature: Real
    equidistant: Real
    loss: float
    equidistant_loss: float

    def __post_init__(self) -> None:
        check_shapes(self, temperature="n", equidistant="n")
        check_ascending(self, "temperature", "equidistant")


def place_temperatures(truth: FirBank, forms: EnergyForms, frequency: Real, count: int) -> PlacedTemperatures:
    """Place `count` training temperatures, given the filters at all temperatures.

    Starting equidistant, temperatures are moved one by one as long as the losses of a cubic spline fall.

    Parameters
    ----------
    truth : FirBank
        Filters at T temperatures.
    forms : EnergyForms
        There, at the F lines.
    frequency : (F,) ndarray, Hz
        Lines of the band.
    count : int
        n, `FEWEST_TRAINING_TEMPERATURES` or more.

    Raises
    ------
    ValueError
        See `check_places`.
    """
    everywhere = truth.temperature
    low, high = float(everywhere[0]), float(everywhere[-1])
    rows = np.unique(np.argmin(np.abs(everywhere - check_places(count, low, high)[:, None]), axis=1))
    judged = _Judge.of(truth, forms, frequency, rows)
    equidistant = np.unique(np.rint(np.linspace(0, len(rows) - 1, count)).astype(int))
    places = _moved(equidistant, judged)
    whole = _Judge.of(truth, forms, frequency, np.arange(len(everywhere)))
    even = np.linspace(low, high, count)
    nearest = np.argmin(np.abs(everywhere - even[:, None]), axis=1)
    found, plain = float(whole.losses(rows[places]).max()), float(whole.losses(nearest).max())
    if found >= plain:  # equidistant is best here
        return PlacedTemperatures(everywhere[nearest], everywhere[nearest], plain, plain)
    return PlacedTemperatures(everywhere[rows[places]], everywhere[nearest], found, plain)


def check_places(count: int, low: float, high: float) -> Real:
    """Return where training temperatures may be put, steps of `TEMPERATURE_GRID` from `low` to `high` (P,), °C.

    Parameters
    ----------
    count : int
        Number of training temperatures.
    low, high : float
        Ends of the range, °C.

    Returns
    -------
    (P,) ndarray, °C

    Raises
    ------
    ValueError
        For fewer than `FEWEST_TRAINING_TEMPERATURES`, or more than there are places.
    """
    places = np.append(np.arange(low, high - 1e-9, TEMPERATURE_GRID), high)
    if not FEWEST_TRAINING_TEMPERATURES <= count <= len(places):
        raise ValueError(
            f"{count} training temperatures; allowed {FEWEST_TRAINING_TEMPERATURES} to {len(places)}, "
            f"{low:g} to {high:g} °C"
        )
    return places


@dataclass(frozen=True)
class _Judge:
    """Filters at T temperatures, to predict all of them from a few and compute the loss."""

    temperature: Real
    response: Complex
    forms: EnergyForms
    direct: Real

    @classmethod
    def of(cls, truth: FirBank, forms: EnergyForms, frequency: Real, rows: NDArray[np.intp]) -> "_Judge":
        response, here = truth.response(frequency)[rows], forms.at(rows)
        return cls(truth.temperature[rows], response, here, contrast(here, response))

    def losses(self, places: NDArray[np.intp]) -> Real:
        """Contrast lost at the worst line of every temperature (T,), with a spline through those at `places`."""
        from scipy.interpolate import CubicSpline

        weights = CubicSpline(self.temperature[places], np.eye(len(places)))(self.temperature)
        predicted = np.tensordot(weights, self.response[places], axes=1)
        return np.asarray((self.direct - contrast(self.forms, predicted)).max(axis=1))


def _moved(places: NDArray[np.intp], judged: _Judge) -> NDArray[np.intp]:
    """Move inner places one by one as long as the power mean of the losses falls.

    No two come closer than half of their mean distance: closer ones only improve the spline at its ends, and make
    networks worse.
    """

    def mean_loss(places: NDArray[np.intp]) -> float:
        losses = np.maximum(judged.losses(places), 0.0)
        return float((losses**POWER_MEAN_EXPONENT).mean() ** (1.0 / POWER_MEAN_EXPONENT))

    best, moving = mean_loss(places), True
    closest = 0.5 * (places[-1] - places[0]) / (len(places) - 1)
    while moving:
        moving = False
        for k in range(1, len(places) - 1):
            for shift in TRIED_MOVES:
                tried = places.copy()
                tried[k] += shift
                if (np.diff(tried) < closest).any():
                    continue
                cost = mean_loss(tried)
                if cost < best * (1.0 - 1e-3):
                    places, best, moving = tried, cost, True
    return places
