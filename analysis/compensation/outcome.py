"""What a compensation came to: every method at every quarter of a degree, with the networks trained."""

from dataclasses import dataclass

import numpy as np

from analysis.arrays import Complex, Real
from analysis.compensation.knots import PlacedTemperatures
from analysis.compensation.law_band import ContrastBand
from analysis.compensation.low_rank import LowRankBank
from analysis.compensation.network import NetworkBank
from analysis.compensation.settings import Training
from analysis.compensation.tilted import TiltedContrast
from analysis.focusing.aim import Aim
from analysis.focusing.fir import FirBank
from analysis.focusing.performance import decibels

NETWORK, LINEAR, SPLINE, RIGIDITY_SPLINE, REDUCED_FREQUENCY, LOW_RANK = METHODS = (
    "network",
    "linear",
    "cubic-spline",
    "cubic-spline-rigidity",
    "reduced-frequency",
    "low-rank",
)

FAIR_LOSS = 0.005
"""Contrast at the worst line not worth mentioning; of methods that lose no more, the smallest is recommended."""


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


@dataclass(frozen=True)
class Compensation:
    """What every method makes of the filters at a few temperatures; m methods, N actuators.

    Attributes
    ----------
    methods : tuple of str
    focusing : str
        How the filters themselves were designed: ``stif`` or a rival of it.
    filters : FirBank
        Those at the training temperatures, (n, N, M).
    temperature : (T,) ndarray
        Where all is judged, degrees Celsius.
    frequency : (F,) ndarray
        Lines of the band, Hz.
    relative_error : (m, T, N) ndarray
        Paper eq. (13), %.
    left_out : (m, n-2, N) ndarray
        Relative error at inner training temperatures left out, %: known without the filters in between.
    contrast_direct : (T, F) ndarray
        With the FIR filters computed at that temperature.
    contrast : (m, T, F) ndarray
        With those of each method.
    response : (m, T, F) ndarray
        Complex: mean displacement of the target over what was asked for, modelling delay taken out.
    peak_drive : (m, T, N) ndarray
        Largest drive any audio within ±1 can bring about, V or N.
    seconds : (m,) ndarray
        Training or fitting, and all T evaluations: processor time, or wall time where trained on another device.
    size : (m,) ndarray
        Of what has to be kept where the filters run, bytes in single precision.
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
        ``everywhere``: against filters computed at `temperature`; ``left-out``: at inner training temperatures, by
        filters made without the one judged.
    placed : PlacedTemperatures, optional
        The training temperatures where they were placed, beside equidistant ones.
    law_band : ContrastBand, optional
        What the uncertainty of the laws does to the contrast of the networks' filters.
    tilted : TiltedContrast, optional
        What is lost where one side of the panel is warmer than the other.
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

    def __post_init__(self) -> None:
        """Refuse arrays of another number of methods."""
        for name in ("relative_error", "left_out", "contrast", "response", "peak_drive", "size", "update_cost"):
            shape = np.shape(getattr(self, name))
            if shape[:1] != (len(self.methods),):
                raise ValueError(f"{name} {shape} is not given for each of {len(self.methods)} methods")

    @property
    def training_temperature(self) -> Real:
        """Where the filters trained on were designed (n,), degrees Celsius."""
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
        """Smallest method that loses no contrast worth mentioning; the best one where each loses some."""
        fair = self.largest_loss <= FAIR_LOSS
        return self.methods[int(np.argmin(np.where(fair, self.size, np.inf)))] if fair.any() else self.best

    @property
    def best(self) -> str:
        """Method of the smallest largest loss of contrast."""
        return self.methods[int(np.argmin(self.largest_loss))]


@dataclass(frozen=True)
class NetworkStudy:
    """Networks trained with one choice after another; NaN where the evidence collapsed, with every restart.

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
