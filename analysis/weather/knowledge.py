"""What is known of a panel's field of temperatures: from thermometers, or from the panel's own response."""

from dataclasses import dataclass
from typing import Self

import numpy as np

from analysis.arrays import Complex, Mask, Real
from analysis.weather.family import Across, WarmPanel

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
