"""Filters at any temperature or tilt of it as weighted sums of a few fixed banks; temperature over time.

A network with a linear output layer, a spline through filters, straight lines between them, principal filters and
a single filter have one form: taps(T) = Σₖ wₖ(x(T)) · bankₖ. Only the weights, a handful of numbers, follow the
temperature; so one update costs the same few multiplications per tap for all of them, and one program runs them.

How often filters are changed for another temperature, and how without a click, is decided here too.

With g the tilt along x and y, `analysis.weather.family.TiltFamily` adds

    sum_a g_a s_a(T) + g_a²/2 b_a(T),

s_a and b_a being cubic splines over the temperature. So the taps are sums of the splines' values at the knots, the
banks, by weights c_k(T) as filters without a tilt have them.

Filters that follow the temperature, in 16-bit integers.
"""

from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from analysis.arrays import Real
from analysis.checked_fields import check_finite, check_shapes
from analysis.compensation.network import InputMap, NetworkBank
from analysis.focusing.fir import FirBank
from analysis.weather.family import Across, TiltFamily


@dataclass(frozen=True)
class TemperatureProgramme:
    """Temperatures at some moments, straight in between, held before the first and after the last.

    Attributes
    ----------
    time : (n,) ndarray
        Ascending, s.
    temperature : (n,) ndarray
        Degrees Celsius.
    """

    time: Real
    temperature: Real

    def __post_init__(self) -> None:
        if not len(self.time) or self.temperature.shape != self.time.shape:
            raise ValueError(f"{self.time.shape} moments for {self.temperature.shape} temperatures")
        if not (np.isfinite(self.time).all() and np.isfinite(self.temperature).all()):
            raise ValueError("moments and temperatures must be finite numbers")
        if not (np.diff(self.time) > 0.0).all():
            raise ValueError("moments must ascend")

    @classmethod
    def spread(cls, temperature: Real, duration: float) -> Self:
        """Spread `temperature` (n,) evenly over `duration`, s, from its beginning to its end."""
        if len(temperature) == 1:
            return cls(np.zeros(1), temperature)
        return cls(np.linspace(0.0, duration, len(temperature)), temperature)

    def at(self, time: ArrayLike) -> Real:
        """Temperature at `time`, s."""
        held: Real = np.asarray(np.interp(np.asarray(time, dtype=float), self.time, self.temperature))
        return held


@dataclass(frozen=True)
class TanhWeights:
    """Weights of a network: its hidden nodes, and 1 for the output biases.

    Attributes
    ----------
    slope, bias : (N, H) ndarray
        Node h of actuator n is tanh(slope · x + bias).
    """

    slope: Real
    bias: Real

    @property
    def count(self) -> int:
        """Number of weights K = H + 1."""
        return int(self.slope.shape[1]) + 1

    def at(self, x: Real) -> Real:
        """Weights (T, N, K) at `x` (T,)."""
        hidden = np.tanh(x[:, None, None] * self.slope + self.bias)
        return np.concatenate([hidden, np.ones((*hidden.shape[:2], 1))], axis=2)


@dataclass(frozen=True)
class CubicWeights:
    """Weights that are cubics between knots, the same for every actuator.

    Attributes
    ----------
    knots : (n,) ndarray
        Ascending; outside, the weights of the ends hold.
    coefficients : (max(n - 1, 1), 4, K) ndarray
        Of 1, s, s², s³ with s = x - knots[i], between knots i and i + 1.
    """

    knots: Real
    coefficients: Real

    def __post_init__(self) -> None:
        pieces = max(len(self.knots) - 1, 1)
        if self.coefficients.shape[:2] != (pieces, 4) or not (np.diff(self.knots) > 0.0).all():
            raise ValueError(
                f"coefficients {self.coefficients.shape} must be ({pieces}, 4, K) for "
                f"{len(self.knots)} ascending knots"
            )

    @property
    def count(self) -> int:
        """Number of weights K."""
        return int(self.coefficients.shape[2])

    def at(self, x: Real) -> Real:
        """Weights (T, 1, K) at `x` (T,)."""
        inside = np.clip(x, self.knots[0], self.knots[-1])
        piece = np.clip(np.searchsorted(self.knots, inside, side="right") - 1, 0, len(self.coefficients) - 1)
        s = (inside - self.knots[piece])[:, None]
        c = self.coefficients[piece]
        weights: Real = c[:, 0] + s * (c[:, 1] + s * (c[:, 2] + s * c[:, 3]))
        return weights[:, None]


@dataclass(frozen=True)
class FollowingBank:
    """Filters of N actuators and M taps that follow the temperature.

    Attributes
    ----------
    input : InputMap
        From temperature to x; its ends are the range, outside of which the filters of the ends hold.
    weights : TanhWeights or CubicWeights
        From x to K weights.
    banks : (N, K, M) ndarray
        V per unit of audio signal.
    sample_rate : float
        Hz.
    delay : int
        Modelling delay in the taps, samples.
    """

    input: InputMap
    weights: TanhWeights | CubicWeights
    banks: Real
    sample_rate: float
    delay: int

    def __post_init__(self) -> None:
        if self.banks.ndim != 3 or self.banks.shape[1] != self.weights.count:
            raise ValueError(
                f"banks {self.banks.shape} must be (N, {self.weights.count}, M), one for every weight"
            )
        if not np.isfinite(self.banks).all():
            raise ValueError("banks hold values that are not finite")

    @classmethod
    def of_networks(cls, networks: NetworkBank, sample_rate: float, delay: int) -> Self:
        """Trained networks as they are.

        Parameters
        ----------
        sample_rate : float
            Hz.
        delay : int
            Modelling delay in the taps, samples.

        Returns
        -------
        FollowingBank
        """
        weights = TanhWeights(networks.slope, networks.bias)
        return cls(networks.input, weights, networks.output, sample_rate, delay)

    @classmethod
    def of_filters(cls, filters: FirBank, kind: str = "cubic", feed: InputMap | None = None) -> Self:
        """Join filters at a few temperatures by a not-a-knot spline or by straight lines.

        Parameters
        ----------
        filters : FirBank
            At ascending temperatures; a single one holds everywhere.
        kind : str
            ``cubic`` or ``linear``. Fewer than four temperatures make a spline of lower degree.
        feed : InputMap, optional
            What the weights are taken at instead of the temperature.

        Raises
        ------
        ValueError
            For temperatures that do not ascend, or another kind.
        """
        known = filters.temperature
        if not (np.diff(known) > 0.0).all():
            raise ValueError("temperatures of the filters must ascend")
        fed = feed or _temperature_itself(known)
        x = fed.at(known)
        order = np.argsort(x)
        weights = CubicWeights(x[order], cardinal(x[order], kind)[:, :, np.argsort(order)])
        return cls(fed, weights, filters.taps.transpose(1, 0, 2), filters.sample_rate, filters.delay)

    @classmethod
    def of_principal(
        cls, temperature: Real, share: Real, filters: Real, mean: Real, sample_rate: float, delay: int
    ) -> Self:
        """Join a mean and K principal filters by splines through their shares.

        Parameters
        ----------
        temperature : (n,) ndarray, °C
            Ascending.
        share : (n, K) ndarray
            Of every principal filter, at each temperature.
        filters : (K, N, M) ndarray
            Principal filters, V per unit of audio signal.
        mean : (N, M) ndarray
            V per unit of audio signal.
        sample_rate : float
            Hz.
        delay : int
            Modelling delay in the taps, samples.

        Returns
        -------
        FollowingBank
        """
        curves = cardinal(temperature, "cubic")
        one = np.zeros((*curves.shape[:2], 1))
        one[:, 0] = 1.0
        weights = CubicWeights(temperature, np.concatenate([curves @ share, one], axis=2))
        banks = np.concatenate([filters, mean[None]]).transpose(1, 0, 2)
        return cls(_temperature_itself(temperature), weights, banks, sample_rate, delay)

    @property
    def temperature_range(self) -> tuple[float, float]:
        """Where filters follow the temperature, degrees Celsius; one temperature for a single filter."""
        low, high = self.input.temperature_range
        return (low, high) if self.weights.count > 1 else (0.5 * (low + high),) * 2

    def taps(self, temperature: ArrayLike) -> Real:
        """Return filters (T, N, M) at `temperature` (T,), degrees Celsius; outside the range, those of its end."""
        weights = self.weights.at(self.input.at(temperature))
        taps: Real = np.einsum(
            "tnk,nkm->tnm", np.broadcast_to(weights, (len(weights), *self.banks.shape[:2])), self.banks
        )
        return taps

    def bank(self, temperature: ArrayLike) -> FirBank:
        """Return filters at `temperature` (T,) with what belongs to them."""
        t = np.atleast_1d(np.asarray(temperature, dtype=float))
        return FirBank(self.taps(t), t, self.sample_rate, self.delay)


def _temperature_itself(known: Real) -> InputMap:
    if len(known) == 1:  # a range is needed for the map, and any will do: the one filter holds everywhere
        return InputMap(known[0] + np.array([-0.5, 0.5]), known[0] + np.array([-0.5, 0.5]))
    return InputMap(known[[0, -1]], known[[0, -1]])


def cardinal(x: Real, kind: str) -> Real:
    """Coefficients (n - 1, 4, n) of the curves that are 1 at one of `x` (n,) and 0 at the others."""
    from scipy.interpolate import CubicSpline

    count = len(x)
    if count == 1:
        return np.array([[[1.0], [0.0], [0.0], [0.0]]])
    if kind == "cubic":
        return np.ascontiguousarray(CubicSpline(x, np.eye(count)).c[::-1].transpose(1, 0, 2))
    if kind != "linear":
        raise ValueError(f"kind {kind!r}: cubic or linear")
    coefficients = np.zeros((count - 1, 4, count))
    coefficients[:, 0] = np.eye(count)[:-1]
    coefficients[:, 1] = np.diff(np.eye(count), axis=0) / np.diff(x)[:, None]
    return coefficients


FADE_TIME = 0.02
"""Seconds over which one set of filters fades into the next."""
TEMPERATURE_STEP = 0.25
"""Kelvin by which a reading has to leave the temperature of the filters in use before they are changed."""


def raised_cosine(first: int, count: int, length: int) -> NDArray[np.float64]:
    """Share of the new filters in a fade, sample by sample.

    Its spectrum falls by 18 dB an octave, so that a fade adds little beyond the band of the filters.

    Parameters
    ----------
    first : int
        Samples of the fade already past.
    count : int
        Samples wanted.
    length : int
        Samples of the whole fade.

    Returns
    -------
    (count,) ndarray
        0 to 1.
    """
    done = np.minimum(first + np.arange(count), length)
    share: NDArray[np.float64] = 0.5 - 0.5 * np.cos(np.pi * done / length)
    return share


@dataclass(frozen=True)
class TiltBank:
    """Filters of N actuators and M taps, added where the panel is tilted.

    Attributes
    ----------
    weights : CubicWeights
        K weights of the temperature in the middle, °C.
    banks : (N, 4, K, M) ndarray
        By the tilt along x, V per unit of audio signal and K, along y, and by half the square of each, per K².
    across : float
        Largest tilt, K; beyond, that of the largest holds.
    """

    weights: CubicWeights
    banks: Real
    across: float

    def __post_init__(self) -> None:
        check_shapes(self, banks="N 4 K M")
        check_finite(self, "banks", "across")
        if self.banks.shape[2] != self.weights.count:
            raise ValueError(f"TiltBank.banks has {self.banks.shape[2]} banks for {self.weights.count} weights")

    @classmethod
    def of(cls, family: TiltFamily) -> Self:
        """Take apart the filters of a family."""
        weights = CubicWeights(family.temperature, cardinal(family.temperature, "cubic"))
        terms = np.concatenate([family.slope, family.bend], axis=1)
        return cls(weights, np.ascontiguousarray(terms.transpose(2, 1, 0, 3)), family.across)

    def powers(self, across: Across) -> Real:
        """Factors (4,) of the banks for a tilt along x and y, K."""
        held = np.clip(across, -self.across, self.across)
        return np.concatenate([held, 0.5 * held**2])

    def weighted(self, temperature: float, across: Across) -> Real:
        """Factors (4, K) of the banks at a temperature in the middle, °C, and a tilt, K."""
        found: Real = self.powers(across)[:, None] * self.weights.at(np.array([temperature]))[0]
        return found

    def taps(self, temperature: float, across: Across) -> Real:
        """Taps (N, M) to be added at a temperature in the middle, °C, and a tilt, K."""
        return np.asarray(np.einsum("pk,npkm->nm", self.weighted(temperature, across), self.banks))

    def loudest(self, temperature: Real, taps: Real) -> tuple[float, float]:
        """Bounds of filters with any tilt that is allowed.

        Parameters
        ----------
        temperature : (T,) ndarray, °C
        taps : (T, N, M) ndarray
            Without a tilt.

        Returns
        -------
        (float, float)
            Of a tap, and of the sum of the taps of one actuator, without their signs. Every tap is a parabola in
            each tilt; its parts at their largest bound it.
        """
        weights = self.weights.at(temperature)[:, 0]
        terms = np.einsum("tk,npkm->tpnm", weights, self.banks)
        reach = self.across
        whole = np.abs(taps) + (np.abs(terms[:, :2]) * reach + np.abs(terms[:, 2:]) * (0.5 * reach**2)).sum(axis=1)
        return float(whole.max()), float(whole.sum(axis=2).max())


Short = NDArray[np.int16]
LARGEST_SHORT = 32_767
"""Of int16; its negative is used as the least, so that signs are symmetric."""


@dataclass(frozen=True)
class FixedPoint:
    """Banks, taps and signals of 16 bits.

    Attributes
    ----------
    banks : (N, K, M) int16 ndarray
    bank_scale : (N, K) ndarray
        V per unit of audio signal of one count of `banks`.
    tap_scale : float
        V per unit of audio signal of one count of a tap, the same for all actuators and temperatures.
    shift : int
        Bits by which the sum of tap times sample is shifted to the right to make an output of 16 bits, so that no
        input whatever overflows it.
    tilt_banks : (N, 4, K', M) int16 ndarray or None
        Of `TiltBank`.
    tilt_scale : (N, 4, K') ndarray or None
        Value of one count of `tilt_banks`.
    """

    banks: Short
    bank_scale: Real
    tap_scale: float
    shift: int
    tilt_banks: Short | None = None
    tilt_scale: Real | None = None

    @classmethod
    def of(cls, following: FollowingBank, tilt: TiltBank | None = None, temperatures: int = 241) -> Self:
        """Round a bank; how large its taps become is looked up at so many temperatures of its range."""
        banks, scale = _rounded(following.banks)
        every = np.linspace(*following.input.temperature_range, temperatures)
        taps = following.taps(every)
        largest, whole = float(np.abs(taps).max()), float(np.abs(taps).sum(axis=2).max())
        if tilt is not None:
            largest, whole = tilt.loudest(every, taps)
        tap_scale = 1.001 * max(largest, float(np.finfo(np.float32).tiny)) / LARGEST_SHORT
        # The sum of |tap| bounds the output whatever the input is: -32768 at every sample, in the worst order.
        loudest = 32_768.0 * (whole / tap_scale + 0.5 * taps.shape[2])
        shift = max(0, int(np.ceil(np.log2(loudest / (LARGEST_SHORT - 1)))))
        return cls(banks, scale, tap_scale, shift, *(() if tilt is None else _rounded(tilt.banks)))

    @property
    def volts_per_count(self) -> float:
        """Volts of one count of the output, where full scale of the input is one unit of audio signal."""
        return self.tap_scale * 2.0**self.shift / 32_768.0

    def taps(self, following: FollowingBank, temperature: Real) -> Short:
        """Taps (T, N, M) that the program on the target computes, in counts."""
        weights = following.weights.at(following.input.at(temperature)) * self.bank_scale
        volts = np.einsum("tnk,nkm->tnm", weights, self.banks.astype(float))
        counts: Short = np.clip(np.round(volts / self.tap_scale), -LARGEST_SHORT, LARGEST_SHORT).astype(np.int16)
        return counts


def _rounded(banks: Real) -> tuple[Short, Real]:
    """Return banks (..., M) in counts, and the value (...) of one count of each."""
    peak = np.abs(banks).max(axis=-1)
    scale = np.where(peak > 0.0, peak, 1.0) / LARGEST_SHORT
    return np.round(banks / scale[..., None]).astype(np.int16), scale
