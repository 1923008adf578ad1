"""Filters for a family of temperature fields: tilts of up to so many kelvins across a panel that has a field.

For a panel evenly warmer toward one side, T + (x g_x + z g_z)/2 with x and z from -1 to 1 over its box, there are
filters of two kinds. *Robust* filters minimise the mean squared error over the middle and both tilts along each
axis (the mean of the quadratic forms of a design is the form of the mean), and need no reading of the tilt.
*Tilted* filters follow it to second order along each axis,

    r(T, g) = r(T) + sum_a [ (r_a+ - r_a-) g_a/(2 G) + (r_a+ + r_a- - 2 r) g_a²/(2 G²) ],

r_a+ and r_a- being designed for the tilts G and -G along axis a. Between knots of T all parts are cubic splines.

What is known of a panel's field of temperatures: from thermometers, or from the panel's own response.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Protocol, Self

import numpy as np

from analysis.arrays import Complex, Mask, Real
from analysis.checked_fields import check_ascending, check_finite, check_shapes
from analysis.focusing.design import TapDesign
from analysis.focusing.energy import EnergyForms, FieldSpace
from analysis.focusing.fir import FirBank
from analysis.focusing.methods import designer
from analysis.focusing.panel import Panel
from analysis.focusing.panel_model import NoModes
from analysis.focusing.performance import contrast
from analysis.focusing.sound_aim import SoundAim
from analysis.progress import Progress


@dataclass(frozen=True)
class WarmAnswer:
    """A panel's answer at one field of temperatures.

    Attributes
    ----------
    amplitude : (N, F, r) ndarray
        Generalised coordinates of the field of every actuator, per V or N.
    charge : (N, N, F) ndarray
        Of every actuator (first), as a sensor, per volt on another, C/V; of forces, m/N.
    """

    amplitude: Complex
    charge: Complex

    def __post_init__(self) -> None:
        check_shapes(self, amplitude="N F r", charge="N N F")
        check_finite(self, "amplitude", "charge")


class WarmPanel(Protocol):
    """Model of a panel with a field of temperatures."""

    @property
    def space(self) -> FieldSpace:
        """The deflection shapes, with their inner products."""

    @property
    def points(self) -> Real:
        """Where temperatures are given, (Q, 2), m."""

    def tilted(self, temperature: float, across: tuple[float, float]) -> Real:
        """Temperatures (Q,), °C, of a panel evenly warmer toward the largest x and y.

        Parameters
        ----------
        temperature : float
            In the middle of the box around the plate, °C.
        across : (float, float)
            Temperature at largest x and y minus that at smallest x and y, K.
        """

    def answer(self, temperature: Real, frequency: Real) -> WarmAnswer:
        """Fields and charges at a field of temperatures.

        Parameters
        ----------
        temperature : (Q,) ndarray, °C
            At `points`.
        frequency : (F,) ndarray, Hz

        Raises
        ------
        ValueError
            Where a part of the panel leaves the range of the laws.
        """


Across = tuple[float, float]
"""By how much the side at largest x, and at largest y, is warmer than the opposite one, K."""
SIDES: tuple[Across, ...] = ((0.0, 0.0), (1.0, 0.0), (-1.0, 0.0), (0.0, 1.0), (0.0, -1.0))
"""Panels without a difference, and with one side warmer: right, left, upper, lower (along x and y)."""


@dataclass(frozen=True)
class FieldDesign:
    """Design of a panel's filters for fields of temperature, by its aim.

    Attributes
    ----------
    model : WarmPanel
    panel : Panel
    design : TapDesign
    sound : SoundAim or None
        What is aimed at in place of the field.
    """

    model: WarmPanel
    panel: Panel
    design: TapDesign
    sound: SoundAim | None

    @classmethod
    def of(cls, model: WarmPanel, panel: Panel, delay: int) -> Self:
        """Prepare designs with a modelling `delay`, samples; ValueError for a grid too coarse for the sound."""
        sound = SoundAim.designing(panel, model.space.grid, "stif")
        return cls(model, panel, TapDesign.of(panel, delay), sound)

    @property
    def band(self) -> Mask:
        """Lines of full gain among those of the panel."""
        return self.panel.filters.in_band(self.panel.filters.frequency)

    def amplitude(self, temperature: Real) -> Complex:
        """Fields (N, F, r) of the actuators at a field of temperatures (Q,), °C, at all lines of the panel."""
        return self.model.answer(temperature, self.panel.filters.frequency).amplitude

    def bank(self, taps: Real) -> FirBank:
        """Return the filters of several sets of taps (S, N, M)."""
        return self.design.bank(taps, np.zeros(len(taps)))

    def aimed(self, amplitude: Complex) -> EnergyForms:
        """Quadratic form of the design for amplitudes (N, F, r) at all lines of the panel."""
        field = self.model.space.forms([amplitude], self.panel.target.displacement)
        return field if self.sound is None else self.sound.forms(self.model.space, amplitude, field)

    def lost(self, amplitude: Complex, known: Real, used: Real) -> Real:
        """Contrast that taps lose against others.

        Parameters
        ----------
        amplitude : (N, F, r) ndarray
            At all lines of the panel.
        known, used : (N, M) ndarray

        Returns
        -------
        (2,) ndarray
            Of the mean over the band, and at the worst line.
        """
        forms = self.model.space.forms([amplitude[:, self.band]])
        lines = self.panel.filters.frequency[self.band]
        better, worse = (contrast(forms, one)[0] for one in self.bank(np.array([known, used])).response(lines))
        return np.array([(better - worse).mean(), (better - worse).max()])

    def taps(self, forms: EnergyForms) -> Real:
        """Taps (N, M) for the form of one field."""
        rule = designer("stif", NoModes(self.model.space), self.panel, self.panel.filters.frequency)
        nothing = np.zeros((0, 0, 0), dtype=complex)
        return self.design.taps(forms, rule((0.0, 0.0, 0.0), lambda: nothing, forms))


@dataclass(frozen=True)
class TiltFamily:
    """Filters of N actuators for tilted panels, at T temperatures in the middle.

    Attributes
    ----------
    temperature : (T,) ndarray
        Ascending, °C.
    across : float
        G, K.
    even, robust : (T, N, M) ndarray
        For panels without a tilt, and for all of the family.
    slope, bend : (T, 2, N, M) ndarray
        First and second derivative of the taps by the tilt along x and y, per K and per K2.
    """

    temperature: Real
    across: float
    even: Real
    robust: Real
    slope: Real
    bend: Real
    price: Real

    def __post_init__(self) -> None:
        shape = dict.fromkeys(("even", "robust"), "T N M")
        check_shapes(self, temperature="T", **shape)
        check_shapes(self, temperature="T", price="T 2", **dict.fromkeys(("slope", "bend"), "T 2 N M"))
        check_finite(self, "even", "robust", "slope", "bend")
        check_ascending(self, "temperature")

    @classmethod
    def of(
        cls,
        design: FieldDesign,
        temperature: Real,
        across: float,
        limits: tuple[float, float],
        report: Progress = lambda _stage, _share: None,
    ) -> Self:
        """Design the filters of a family.

        Parameters
        ----------
        temperature : (T,) ndarray
            Ascending, °C.
        across : float
            G, K.
        limits : (float, float)
            Of the laws, °C: at a knot nearer to them than G/2 the tilt is as much smaller, one kelvin at least.
        report : callable, optional
            Called with the stage and the share done.
        """
        rows = []
        for number, middle in enumerate(temperature.tolist(), start=1):
            room = 2.0 * min(middle - limits[0], limits[1] - middle)
            reach = float(np.clip(room, 1.0, across))
            fields = [design.model.tilted(middle, (reach * x, reach * y)) for x, y in SIDES]
            amplitudes = [design.amplitude(np.clip(field, *limits)) for field in fields]
            forms = [design.aimed(one) for one in amplitudes]
            even, *sides = (design.taps(form) for form in forms)
            robust = design.taps(_mean(forms))
            slope = [(sides[k] - sides[k + 1]) / (2.0 * reach) for k in (0, 2)]
            bend = [(sides[k] + sides[k + 1] - 2.0 * even) / reach**2 for k in (0, 2)]
            price = design.lost(amplitudes[0], even, robust)
            rows.append((even, robust, np.array(slope), np.array(bend), price))
            report("Filters of tilted panels", number / len(temperature))
        parts = (np.array(part) for part in zip(*rows, strict=True))
        return cls(temperature, across, *parts)

    def robust_taps(self, temperature: float) -> Real:
        """Robust filters (N, M) at a temperature, °C; outside the range those of its end."""
        _, robust, _, _ = self._at(temperature)
        return robust

    def taps(self, temperature: float, across: Across = (0.0, 0.0)) -> Real:
        """Return the filters (N, M) for a temperature in the middle, °C, and a tilt, K.

        Outside the range of temperatures those of its end; beyond `across` those of the largest tilt.
        """
        even, _, _, _ = self._at(temperature)
        return even + self.tilt(temperature, across)

    def tilt(self, temperature: float, across: Across) -> Real:
        """Return what a tilt adds to the filters (N, M) of a panel without one; arguments as for `taps`."""
        _, _, slope, bend = self._at(temperature)
        tilt = np.clip(across, -self.across, self.across)[:, None, None]
        return np.asarray(np.sum(slope * tilt + 0.5 * bend * tilt**2, axis=0))

    def _at(self, temperature: float) -> tuple[Real, ...]:
        here = float(np.clip(temperature, self.temperature[0], self.temperature[-1]))
        return tuple(np.asarray(spline(here)) for spline in self._splines)

    @cached_property
    def _splines(self) -> tuple[Callable[[float], Real], ...]:
        from scipy.interpolate import CubicSpline

        return tuple(
            CubicSpline(self.temperature, part) for part in (self.even, self.robust, self.slope, self.bend)
        )


def _mean(forms: list[EnergyForms]) -> EnergyForms:
    """Mean of the forms of one temperature each."""
    every = type(forms[0]).joined(forms)
    return type(every)(*(part.mean(axis=0, keepdims=True) for part in (every.plate, every.target, every.aim)))


STIFFNESS = 1e-3
"""Of a tilt against readings, in the least squares of `plane`: small enough to change no reading by a millikelvin,
and what keeps the tilt at 0 along a direction in which no two thermometers lie apart."""
DERIVATIVE_STEP = 0.5
"""K, of the differences from which derivatives are taken: the phase of a resonance then moves by a tenth."""
COMPARED_LINES = 64
"""Lines at which the panel's response is compared."""
PLANE_SIGMA, LEANING = 5.0, 10.0
"""Standard deviations of the plane before the response is heard, K: of its middle from one reading to the next,
and of its tilt."""


@dataclass(frozen=True)
class Believed:
    """A plane that is taken for the field of temperatures.

    Attributes
    ----------
    middle : float
        In the middle of the box around the plate, °C.
    across : (float, float)
        Tilt along x and y, K.
    """

    middle: float
    across: Across = (0.0, 0.0)


def plane(places: Real, readings: Real) -> Believed:
    """Return the plane through readings, by least squares where they are more than three.

    Parameters
    ----------
    places : (K, 2) ndarray
        Of the thermometers, -1 to 1 over the box around the plate.
    readings : (K,) ndarray
        °C.

    Returns
    -------
    Believed
        Without a tilt along directions that the thermometers do not tell, as with a single one.
    """
    middle, x, y = plane_weights(places) @ readings
    return Believed(float(middle), (float(x), float(y)))


def plane_weights(places: Real) -> Real:
    """Weights (3, K) of readings at `places` (K, 2) that give the plane: middle, tilt along x, tilt along y."""
    rows = np.column_stack([np.ones(len(places)), 0.5 * np.asarray(places)])
    held = STIFFNESS * np.array([[0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])
    found: Real = np.linalg.pinv(np.vstack([rows, held]))[:, : len(places)]
    return found


@dataclass(frozen=True)
class OwnThermometer:
    """The panel as its own thermometer: one patch listens while another plays, pair after pair.

    The plane of temperatures is sought whose charges explain those measured, at a gain a common to all pairs:

        min over T, g_x, g_y, a of sum abs(Y - a C(T, g))²/s² + (T - T_0)²/m² + (g_x² + g_y²)/l²

    by Gauss and Newton from the plane T_0 of the last reading; s² is the mean square of what is left of Y, m is
    `PLANE_SIGMA` and l `LEANING`. The last two terms hold what the response does not tell: two patches on one axis
    know little of a tilt across it.

    Attributes
    ----------
    model : WarmPanel
    lines : (F,) ndarray, Hz
    pairs : (N, N) ndarray of bool
        Which patch listens to which; none to itself.
    limits : (float, float)
        Of the laws, °C.
    """

    model: WarmPanel
    lines: Real
    pairs: Mask
    limits: tuple[float, float]

    @classmethod
    def of(cls, model: WarmPanel, lines: Real, actuators: int, limits: tuple[float, float]) -> Self:
        """Take evenly spaced ones of the `lines` (F,), Hz, and all pairs of patches."""
        chosen = np.unique(np.linspace(0, len(lines) - 1, COMPARED_LINES).round().astype(int))
        return cls(model, lines[chosen], ~np.eye(actuators, dtype=bool), limits)

    def measured(self, temperature: Real) -> Complex:
        """Charges of all pairs, (pairs F,), C/V, at a field of temperatures (Q,), °C."""
        return self.model.answer(np.clip(temperature, *self.limits), self.lines).charge[self.pairs].ravel()

    def read(self, measured: Complex, start: Believed, tries: int = 3) -> Believed:
        """Return the plane that explains charges (pairs F,), sought from `start`, in so many steps."""
        here = np.array([start.middle, *start.across])
        for _ in range(tries):
            value = self._at(here)
            slopes = np.array(
                [(self._at(here + step) - value) / DERIVATIVE_STEP for step in DERIVATIVE_STEP * np.eye(3)]
            )
            gain = np.vdot(value, measured).real / np.vdot(value, value).real
            columns = np.stack([value, *(gain * slopes)], axis=1)
            rest = measured - gain * value
            spread = np.sqrt(np.mean(np.abs(rest) ** 2))
            held = spread / np.array([PLANE_SIGMA, LEANING, LEANING])
            rows = np.concatenate([columns.real, columns.imag, np.column_stack([np.zeros(3), np.diag(held)])])
            right = np.concatenate([rest.real, rest.imag, -held * (here - [start.middle, 0.0, 0.0])])
            _, *move = np.linalg.lstsq(rows, right, rcond=None)[0]
            here = here + move
            here[0] = np.clip(here[0], *self.limits)
            if np.abs(move).max() < 0.01:
                break
        return Believed(float(here[0]), (float(here[1]), float(here[2])))

    def _at(self, plane: Real) -> Complex:
        middle, x, y = (float(one) for one in plane)
        return self.measured(self.model.tilted(middle, (x, y)))
