"""Windowed segments of a stationary signal, and what they make of a resonance."""

from dataclasses import dataclass
from typing import get_args

import numpy as np
from numpy.typing import NDArray

from analysis.estimation.estimators import Estimator
from analysis.estimation.windows import Shape, segment_window

WINDOW_SAMPLES = 1024
"""Samples from which the few cosines that make up a window are taken."""


@dataclass(frozen=True)
class Segments:
    """Windowed segments over which spectra were averaged.

    Attributes
    ----------
    seconds : float
        Length of one, s.
    window : str
    estimator : str
        ``h1``, ``h2`` or ``hv``.
    """

    seconds: float
    window: Shape
    estimator: Estimator = "h1"

    def __post_init__(self) -> None:
        if not (np.isfinite(self.seconds) and self.seconds > 0.0):
            raise ValueError(f"segments of {self.seconds:g} s; above 0 allowed")
        for name, choices in (("window", get_args(Shape)), ("estimator", get_args(Estimator))):
            if getattr(self, name) not in choices:
                raise ValueError(f"{name} {getattr(self, name)!r} of segments; {', '.join(choices)} allowed")

    def changes(self, s: NDArray[np.complex128], poles: NDArray[np.complex128]) -> NDArray[np.complex128]:
        """Return what the window adds to the expectation of a resonance.

        The spectra of a flat force, averaged over segments with a window w, show H smoothed by |W|^2 (Bendat and
        Piersol, Random Data, 2010, ch. 8): the impulse response is multiplied by the autocorrelation of w. That of
        a sum of cosines is a sum of (A t + B) exp(-j w_m t); its product with a pole's has a closed transform.

        Parameters
        ----------
        s : (F,) complex ndarray
            jw, rad/s.
        poles : (P,) complex ndarray
            Left half plane, rad/s.

        Returns
        -------
        (P, F) complex ndarray
            To be added to 1 / (s - pole).
        """
        cosines = np.fft.fft(segment_window(self.window, WINDOW_SAMPLES)).real / WINDOW_SAMPLES
        place = np.flatnonzero(np.abs(cosines) > 1e-9)
        c, w = (
            cosines[place],
            2.0 * np.pi * np.fft.fftfreq(WINDOW_SAMPLES, 1.0 / WINDOW_SAMPLES)[place] / self.seconds,
        )
        apart = w[:, None] - w + np.eye(len(w))
        cross = (2.0 * np.outer(c, c) / (1j * apart) * (1.0 - np.eye(len(w)))).sum(1)
        changes = np.empty((len(poles), len(s)), dtype=complex)
        for row, pole in enumerate(poles):
            x = (pole - s - 1j * w[:, None]) * self.seconds
            grown = np.expm1(x)
            whole = c[:, None] ** 2 * self.seconds * (grown - x) / x**2 + cross[:, None] * grown / x
            changes[row] = whole.sum(0) / (c**2).sum() - 1.0 / (s - pole)
        return changes
