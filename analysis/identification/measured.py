"""Measured FRFs of one condition, and the weighted lines made from them for a fit."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from analysis.checked_fields import check_ascending, check_finite, check_range, check_shapes
from analysis.identification.averaging import roughness
from analysis.identification.lines import Lines
from analysis.identification.missing import residual
from analysis.identification.noise import correlation, deviation_from_residual, pooled, shared_by_responses
from analysis.identification.pole_search import PoleFit


@dataclass(frozen=True)
class Measured:
    """Measured FRFs of one condition.

    Attributes
    ----------
    frequency : (F,) ndarray
        Hz.
    h : (K, F) complex ndarray
        One drive, K responses.
    variance : (K, F) ndarray or None
        E|h - H|^2; None, or not above zero on some line, where it is not known.
    at_rest : bool
        Whether they come from records without a window, at the end of which the response was at rest.
    shift : float
        Relative standard deviation of all frequencies over the repeats, see `analysis.repeat_shift`.
    together : bool
        Whether the FRFs come from the same records, so that the structure is the same in all of them.
    """

    frequency: NDArray[np.float64]
    h: NDArray[np.complex128]
    variance: NDArray[np.float64] | None = None
    at_rest: bool = False
    shift: float = 0.0
    together: bool = False

    def __post_init__(self) -> None:
        check_shapes(self, frequency="F", h="K F", variance="K F")
        check_finite(self, "frequency", "h")
        check_ascending(self, "frequency")
        check_range(self, 0.0, np.inf, "frequency", unit="Hz")

    @property
    def known(self) -> bool:
        """Whether every line has a variance."""
        return self.variance is not None and bool((self.variance > 0.0).all())

    def without(self, spoilt: NDArray[np.bool_]) -> "Measured":
        """Leave out lines (F,)."""
        variance = None if self.variance is None else self.variance[:, ~spoilt]
        return replace(self, frequency=self.frequency[~spoilt], h=self.h[:, ~spoilt], variance=variance)

    def rows(self, which: NDArray[np.bool_]) -> "Measured":
        """Return some of the FRFs (K,)."""
        return replace(self, h=self.h[which], variance=None if self.variance is None else self.variance[which])

    def lines(self) -> Lines:
        """Lines weighted by the variance if it is known, by the roughness along frequency otherwise."""
        deviation = np.sqrt(self.variance) if self.known and self.variance is not None else roughness(self.h)
        return Lines(
            self.frequency,
            self.h,
            pooled(deviation),
            at_rest=self.at_rest,
            shift=self.shift,
            together=self.together,
        )

    def reweighted(self, lines: Lines, fitted: PoleFit) -> Lines:
        """Lines with weights from a fit's residual, unless the variance is known, and with its correlations."""
        return self._weighed(lines, residual(lines, fitted), fitted.poles)

    def weighed(self, left: NDArray[np.complex128], poles: NDArray[np.complex128]) -> Lines:
        """Return the same from a residual (K, F) and the poles that it belongs to."""
        return self._weighed(self.lines(), left, poles)

    def _weighed(self, lines: Lines, left: NDArray[np.complex128], poles: NDArray[np.complex128]) -> Lines:
        deviation = lines.deviation if self.known else pooled(deviation_from_residual(left, lines.h))
        normalised = left / deviation
        tau = correlation(normalised, _reach(poles, lines.spacing))
        return replace(
            lines, deviation=deviation, correlation=tau, shared=shared_by_responses(normalised, lines.h, tau)
        )


def _reach(poles: NDArray[np.complex128], spacing: float) -> float:
    """Typical half width of poles in lines; 0 where there are none."""
    return float(np.median(-poles.real)) / (2.0 * np.pi * spacing) if len(poles) else 0.0
