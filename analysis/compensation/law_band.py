"""Contrast of filters under the uncertainty of the material laws from which they were made."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from analysis.arrays import Complex, Real
from analysis.checked_fields import check_range, check_shapes
from analysis.focusing.fir import FirBank
from analysis.focusing.panel import Panel
from analysis.focusing.panel_model import PanelModel
from analysis.focusing.performance import contrast
from analysis.material import MaterialLaws

BAND_SHARE = 0.9
"""Share of the draws within the band."""
DRAWS = 2000
"""Of the laws' errors: ends of a band of 90 % then have standard errors of 0.05 standard deviations, if normal."""
ROUNDING = 1e-9
"""Amount by which a constant may exceed the box, for rounding."""
REACH = np.sqrt(3.0)
"""Distance of a parabola's outer points, standard deviations: the nodes of a three-point Gauss-Hermite rule."""


@dataclass(frozen=True)
class ContrastBand:
    """Contrast of given filters on plates whose laws are drawn from their estimated uncertainty.

    Attributes
    ----------
    temperature : (A,) ndarray
        Degrees Celsius.
    nominal : (A, 2) ndarray
        On a plate with the estimated laws: mean of the band's lines, and the worst line.
    mean, worst : (A, 2) ndarray
        Lower and upper quantile that enclose `share` of the draws, of the mean over the lines and of the worst
        line.
    share : float
    draws : int
    outside : (A,) ndarray, optional
        Share of the draws that lie outside the model's box, where the parabolas are extrapolated; None in files of
        earlier versions.
    """

    temperature: Real
    nominal: Real
    mean: Real
    worst: Real
    share: float
    draws: int
    outside: Real | None = None

    def __post_init__(self) -> None:
        check_shapes(self, temperature="A", nominal="A 2", mean="A 2", worst="A 2", outside="A")
        check_range(self, 0.0, 1.0, "share", "outside")
        check_range(self, 1, np.inf, "draws")


def law_band(
    models: Sequence[PanelModel],
    panel: Panel,
    laws: MaterialLaws,
    bank: FirBank,
    rng: np.random.Generator,
) -> ContrastBand:
    """Compute the contrast of filters on plates with laws drawn from the covariance of the estimated ones.

    Parameters
    ----------
    models : sequence of PanelModel
        Local models of the panel, one for each of the A temperatures; with them the error of the contrast is 1e-5,
        and 1e-4 with E 5 % off its law.
    laws : MaterialLaws
        Of the panel's plate, from which the filters were made.
    bank : FirBank
        At A temperatures, °C.

    Raises
    ------
    ValueError
        For a temperature outside the range of the laws.

    Notes
    -----
    At one temperature the laws are three numbers, log E, nu and log eta, each with its standard deviation. The log
    of C/(1 - C) of every line is approximated by a sum of three parabolas in them, through the values at the laws
    and `REACH` standard deviations to both sides (as far as the model's box goes; draws beyond it are extrapolated
    and counted). All draws then cost no more than seven evaluations of the plate. The same draws serve all
    temperatures.
    """
    lines = panel.filters.frequency
    lines = lines[panel.filters.in_band(lines)]
    response = bank.response(lines)
    draws = rng.standard_normal((DRAWS, 3))

    def at(t: int) -> tuple[list[float], Real, Real, float]:
        here = bank.temperature[t : t + 1]
        value, sigma = laws.at(here), laws.sigma(here)
        constants = tuple(float(x[0]) for x in (value.youngs_modulus, value.poisson_ratio, value.loss_factor))
        e, _, eta = constants
        spread = np.array([sigma.youngs_modulus[0] / e, sigma.poisson_ratio[0], sigma.loss_factor[0] / eta])

        def odds(step: Real) -> Real:
            return _odds(models[t], lines, response[t : t + 1], _stepped(constants, step))

        middle, allowed = odds(np.zeros(3)), _allowed(panel, constants)
        drawn = _drawn(odds, middle, spread, draws, allowed)
        beyond = (spread * draws < allowed[0] - ROUNDING) | (spread * draws > allowed[1] + ROUNDING)
        found, exact = _share_of(drawn), _share_of(middle)
        ends = [0.5 - 0.5 * BAND_SHARE, 0.5 + 0.5 * BAND_SHARE]
        return (
            [float(exact.mean()), float(exact.min())],
            np.quantile(found.mean(axis=1), ends),
            np.quantile(found.min(axis=1), ends),
            float(beyond.any(axis=1).mean()),
        )

    rows = [at(t) for t in range(len(bank.temperature))]
    nominal, mean, worst, outside = (np.array(part) for part in zip(*rows, strict=True))
    return ContrastBand(bank.temperature, nominal, mean, worst, BAND_SHARE, DRAWS, outside)


def _stepped(constants: tuple[float, ...], step: Real) -> tuple[float, float, float]:
    """E [Pa], nu and eta after a `step` (3,) in log E, nu and log eta."""
    e, nu, eta = constants
    return e * float(np.exp(step[0])), nu + float(step[1]), eta * float(np.exp(step[2]))


def _odds(model: PanelModel, lines: Real, response: Complex, constants: tuple[float, float, float]) -> Real:
    """Log of C/(1 - C) of every line (F,), with filter responses `response` (1, F, N) on a plate of constants."""
    found = contrast(model.forms(*constants, lines), response)[0]
    found = np.clip(found, 1e-9, 1.0 - 1e-9)
    return np.asarray(np.log(found / (1.0 - found)))


def _share_of(odds: Real) -> Real:
    return np.asarray(1.0 / (1.0 + np.exp(-odds)))


def _drawn(
    odds: Callable[[Real], Real], middle: Real, spread: Real, draws: Real, allowed: tuple[Real, Real]
) -> Real:
    """Log odds (D, F) of the draws: the `middle` (F,) plus a parabola along each uncertain constant."""
    drawn = np.tile(middle, (len(draws), 1))
    for k in np.flatnonzero(spread):
        axis = np.eye(3)[k]
        ends = np.clip(np.array([-REACH, REACH]) * spread[k], allowed[0][k], allowed[1][k])
        places = [float(end) for end in ends if abs(end) > 1e-12]
        answers = [odds(place * axis) for place in places]
        drawn += _parabola(places, answers, middle, spread[k] * draws[:, k])
    return drawn


def _allowed(panel: Panel, constants: tuple[float, ...]) -> tuple[Real, Real]:
    """How far log E, nu and log eta may go down and up within the model's box."""
    box, (e, nu, eta) = panel.box, constants
    logs = [np.log(np.array(box.youngs_modulus) / e), np.array(box.poisson_ratio) - nu]
    ends = np.array([*logs, np.log(np.array(box.loss_factor) / eta)])
    return np.minimum(ends[:, 0], 0.0), np.maximum(ends[:, 1], 0.0)


def _parabola(places: list[float], answers: list[Real], middle: Real, steps: Real) -> Real:
    """Change (D, F) from `middle` (F,) at `steps` (D,), by a parabola through 0 and two other places.

    A straight line where there is one other place, zero where there is none.
    """
    if not places:
        return np.zeros((len(steps), len(middle)))
    powers = np.arange(1, len(places) + 1)
    weights = np.linalg.solve(np.array(places)[:, None] ** powers, np.array(answers) - middle)
    return np.asarray((steps[:, None] ** powers) @ weights)
