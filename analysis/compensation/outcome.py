"""Result of a compensation: every method over a fine grid of temperatures, its cost, and the trained networks."""

from dataclasses import dataclass

import numpy as np

from analysis.arrays import Complex, Real
from analysis.checked_fields import check_ascending, check_shapes
from analysis.compensation.knots import PlacedTemperatures
from analysis.compensation.law_band import ContrastBand
from analysis.compensation.network import LowRankBank, NetworkBank
from analysis.compensation.settings import Training
from analysis.compensation.tilted import TiltedContrast
from analysis.focusing.fir import FirBank
from analysis.focusing.performance import Aim, decibels
from analysis.weather.family import TiltFamily
from analysis.weather.judged import WeatherJudgement

NETWORK, LINEAR, SPLINE, RIGIDITY_SPLINE, REDUCED_FREQUENCY, LOW_RANK = METHODS = (
    "network",
    "linear",
    "cubic-spline",
    "cubic-spline-rigidity",
    "reduced-frequency",
    "low-rank",
)

FAIR_LOSS = 0.005
"""Acceptable loss of contrast at the worst line; of the methods within it, the smallest is recommended."""


@dataclass(frozen=True)
class Trained:
    """A network bank and how its training went; arrays are per actuator (N,).

    Attributes
    ----------
    networks : NetworkBank
    settings : Training
    training_error : ndarray
        Largest relative error at the temperatures trained on, %.
    gamma : ndarray
        Parameters the data determine, of 2H + M(H+1).
    alpha, beta : ndarray
        Weight of the squared parameters and of the squared scaled errors.
    log_evidence : ndarray
    epochs : ndarray
        Steps tried.
    restart : ndarray
        Which restart was kept.
    used : (N, T) ndarray
        1 for temperatures trained on, 0 for those left out by the split.
    """

    networks: NetworkBank
    settings: Training
    training_error: Real
    gamma: Real
    alpha: Real
    beta: Real
    log_evidence: Real
    epochs: Real
    restart: Real
    used: Real

    def __post_init__(self) -> None:
        rows = ("training_error", "gamma", "alpha", "beta", "log_evidence", "epochs", "restart")
        check_shapes(self, used="N T", **dict.fromkeys(rows, "N"))


@dataclass(frozen=True)
class Compensation:
    """Filters predicted by every method from those at a few temperatures; m methods, N actuators.

    Attributes
    ----------
    methods : tuple of str
    focusing : str
        Design method of the filters: ``stif`` or one it is compared with.
    filters : FirBank
        Those at the training temperatures, (n, N, M).
    temperature : (T,) ndarray
        Temperatures of the assessment, degrees Celsius.
    frequency : (F,) ndarray
        Lines of the band, Hz.
    relative_error : (m, T, N) ndarray
        Paper eq. (13), %.
    left_out : (m, n-2, N) ndarray
        Relative error at inner training temperatures left out, %: needs no filters in between.
    contrast_direct : (T, F) ndarray
        With the FIR filters computed at that temperature.
    contrast : (m, T, F) ndarray
        With those of each method.
    response : (m, T, F) ndarray
        Complex: mean displacement of the target over the desired one, modelling delay removed.
    peak_drive : (m, T, N) ndarray
        Largest drive that any audio within ±1 can cause, V or N.
    seconds : (m,) ndarray
        Training or fitting, and all T evaluations: processor time, or wall time where trained on another device.
    size : (m,) ndarray
        Memory on the device that runs the filters, bytes in single precision.
    update_cost : (m,) ndarray
        Multiplications for a new set of taps.
    trained : Trained
        The networks.
    low_rank : LowRankBank
        The principal filters.
    aim_temperature : (A,) ndarray
        Degrees Celsius.
    direct_aim, network_aim : Aim
        Contrast and spot error there (A, F), with filters computed directly and by the networks.
    target_share : float
        Area of the target over area of the plate.
    judged : str
        ``everywhere``: against filters computed at `temperature`; ``left-out``: at inner training temperatures,
        each predicted without its own filter.
    placed : PlacedTemperatures, optional
        The placed training temperatures, compared with equidistant ones.
    law_band : ContrastBand, optional
        Contrast of the networks' filters under the uncertainty of the laws.
    tilted : TiltedContrast, optional
        Contrast where one side of the panel is warmer than the other.
    weather : WeatherJudgement, optional
        Filters while the panel's field of temperatures moves.
    family : TiltFamily, optional
        The filters of tilted panels that were judged there.
    """

    methods: tuple[str, ...]
    focusing: str
    filters: FirBank
    temperature: Real
    frequency: Real
    relative_error: Real
    left_out: Real
    contrast_direct: Real
    contrast: Real
    response: Complex
    peak_drive: Real
    seconds: Real
    size: Real
    update_cost: Real
    trained: Trained
    low_rank: LowRankBank
    aim_temperature: Real
    direct_aim: Aim
    network_aim: Aim
    target_share: float
    judged: str = "everywhere"
    placed: PlacedTemperatures | None = None
    law_band: ContrastBand | None = None
    tilted: TiltedContrast | None = None
    weather: WeatherJudgement | None = None
    family: TiltFamily | None = None

    def __post_init__(self) -> None:
        by_method = dict.fromkeys(("seconds", "size", "update_cost"), "m")
        lines = dict.fromkeys(("contrast", "response"), "m T F")
        drives = dict.fromkeys(("relative_error", "peak_drive"), "m T N")
        check_shapes(self, methods="m", temperature="T", frequency="F", contrast_direct="T F", **lines)
        check_shapes(self, methods="m", temperature="T", left_out="m t N", **by_method, **drives)
        check_ascending(self, "frequency", "temperature", "filters.temperature")

    @property
    def training_temperature(self) -> Real:
        """Temperatures of the training filters (n,), degrees Celsius."""
        return self.filters.temperature

    @property
    def contrast_loss(self) -> Real:
        """Contrast (m, T, F) lost against the filters computed directly."""
        return self.contrast_direct - self.contrast

    @property
    def largest_loss(self) -> Real:
        """Contrast (m,) lost at the worst line and temperature."""
        return np.asarray(self.contrast_loss.max(axis=(1, 2)))

    @property
    def phase_error(self) -> Real:
        """Largest deviation of the target's phase from a pure delay (m,), degrees."""
        return np.asarray(np.abs(np.angle(self.response, deg=True)).max(axis=(1, 2)))

    @property
    def level_ripple(self) -> Real:
        """Loudest less softest line of the band (m,), dB, at the worst temperature."""
        return np.asarray(np.ptp(decibels(self.response), axis=2).max(axis=1))

    @property
    def recommended(self) -> str:
        """Method of least memory within `FAIR_LOSS`; the best one where none is."""
        fair = self.largest_loss <= FAIR_LOSS
        return self.methods[int(np.argmin(np.where(fair, self.size, np.inf)))] if fair.any() else self.best

    @property
    def recommendation(self) -> str:
        """The recommended method and the reason, in words."""
        place = self.methods.index(self.recommended)
        if self.largest_loss[place] > FAIR_LOSS:
            return f"{self.recommended}, of which none loses at most {FAIR_LOSS:g}: it loses least"
        return (
            f"{self.recommended}, of least memory ({self.size[place] / 1e3:.0f} kB) among those that nowhere lose "
            f"more than {FAIR_LOSS:g}"
        )

    @property
    def best(self) -> str:
        """Method of the smallest largest loss of contrast."""
        return self.methods[int(np.argmin(self.largest_loss))]


@dataclass(frozen=True)
class NetworkStudy:
    """Networks trained with several settings; NaN where the evidence collapsed in every restart.

    Attributes
    ----------
    nodes, spacing : (k,) ndarray
        Of each choice; spacing in °C.
    squared_error : (k, N) ndarray
        Mean over the temperatures of the relative error, paper eq. (13), %, for each actuator.
    contrast_loss : (k,) ndarray
        At the worst line of the worst temperature.
    """

    nodes: Real
    spacing: Real
    squared_error: Real
    contrast_loss: Real

    def __post_init__(self) -> None:
        check_shapes(self, nodes="k", spacing="k", squared_error="k N", contrast_loss="k")


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
