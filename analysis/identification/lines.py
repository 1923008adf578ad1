"""The lines of an FRF that a fit uses, each with its weight."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from analysis.identification.damping_prior import DampingPrior
from analysis.identification.residual_terms import ResidualTerms
from analysis.identification.running_median import running_median
from analysis.identification.settings import LEAST_LINES
from analysis.identification.weighted_lines import WeightedLines

MEDIAN_GAPS = 5
"""Gaps whose median is the spacing of uneven lines at a place: up to two of them may be holes."""

EVEN_GAP_RATIO = 0.9
"""Ratio of the smallest of these medians to the largest above which lines are even."""

SAME_WEIGHT = 1e-8
"""Difference below which two weights, whose rms is about 1, are one."""

SAME_LINE = 1e-6
"""Relative distance of two lines below which one was measured twice: no resonance is so narrow."""


@dataclass(frozen=True)
class WeightGroup:
    """Responses whose weights are proportional to each other.

    Attributes
    ----------
    weight : (2F,) ndarray
        Of the real and the imaginary part of every line, alternating.
    rows : (N,) ndarray of int
        Responses.
    scales : (N,) ndarray
        1/deviation = scale * weight.
    data : (N, 2F) ndarray
        Measured, weighted, in units of the deviations.
    """

    weight: NDArray[np.float64]
    rows: NDArray[np.intp]
    scales: NDArray[np.float64]
    data: NDArray[np.float64]

    @classmethod
    def of(
        cls, h: NDArray[np.complex128], weight: NDArray[np.float64], rows: list[int], scales: list[float]
    ) -> "WeightGroup":
        """Apply weights to some rows of FRFs.

        Parameters
        ----------
        h : (K, F) complex ndarray
        weight : (F,) ndarray
        rows : list of int
            N of the K.
        scales : list of float
            One for each of these.
        """
        data = h[rows] * np.array(scales)[:, None] * weight
        return cls(np.repeat(weight, 2), np.array(rows), np.array(scales), data.view(float))


@dataclass(frozen=True)
class Lines:
    """FRFs of one condition with the standard deviation of every line.

    Attributes
    ----------
    frequency : (F,) ndarray
        Hz, ascending, above zero.
    h : (K, F) complex ndarray
        FRFs from one drive to K responses.
    deviation : (K, F) ndarray
        Square root of E|h - H|^2; above zero.
    hidden : int
        Complex values removed by averaging neighbouring lines: they still count as measured, each with a misfit of
        1.
    as_measured : (G,) ndarray, optional
        Frequencies before any averaging, Hz; `frequency` unless given.
    correlation : float
        Number of lines that carry the information of one independent line, tau = 1 + 2 sum rho_k with the errors'
        autocorrelation rho_k; 1 where lines are independent.
    shared : float
        Number of responses that carry the information of one independent response, see
        `noise.shared_by_responses`; 1 where their errors are independent.
    damping : DampingPrior, optional
        Prior of the modes' damping ratios, added to the misfit of a fit.
    at_rest : bool
        Whether they come from records without a window, at the end of which the response was at rest.
    shift : float
        Relative standard deviation of all frequencies while the lines were measured, see `analysis.recordings.h1`.
    together : bool
        Whether the FRFs come from the same records, so that the structure is the same in all of them.
    """

    frequency: NDArray[np.float64]
    h: NDArray[np.complex128]
    deviation: NDArray[np.float64]
    hidden: int = 0
    as_measured: NDArray[np.float64] | None = None
    correlation: float = 1.0
    shared: float = 1.0
    damping: DampingPrior | None = None
    at_rest: bool = False
    shift: float = 0.0
    together: bool = False

    def __post_init__(self) -> None:
        if self.h.ndim != 2 or self.h.shape[1] != len(self.frequency) or self.deviation.shape != self.h.shape:
            raise ValueError(
                f"h {self.h.shape} and deviation {self.deviation.shape} must be (K, F) with "
                f"F = {len(self.frequency)} frequencies"
            )
        if len(self.frequency) < LEAST_LINES:
            raise ValueError(
                f"{len(self.frequency)} frequency lines are too few to identify a pole; {LEAST_LINES} needed"
            )
        if not self.frequency[0] > 0.0 or not (np.diff(self.frequency) > 0.0).all():
            raise ValueError("frequencies must ascend from above 0 Hz")
        if not np.isfinite(self.h).all():
            raise ValueError("the FRF holds values that are not finite")
        if not (np.isfinite(self.deviation).all() and (self.deviation > 0.0).all()):
            raise ValueError("standard deviations of lines must be above 0")
        if not 1.0 <= self.correlation < np.inf:
            raise ValueError(f"correlation {self.correlation:g} of lines: 1 or more wanted")
        if not 1.0 <= self.shared < np.inf:
            raise ValueError(f"{self.shared:g} responses that share their errors: 1 or more wanted")

    @property
    def s(self) -> NDArray[np.complex128]:
        """Points jw on the imaginary axis, rad/s."""
        points: NDArray[np.complex128] = np.asarray(2j * np.pi * self.frequency, dtype=np.complex128)
        return points

    @property
    def grid(self) -> NDArray[np.float64]:
        """Frequencies before any averaging, Hz."""
        return self.frequency if self.as_measured is None else self.as_measured

    @cached_property
    def even(self) -> bool:
        """Whether the lines have one spacing, gaps of lines left out aside."""
        return bool(self._around.min() > EVEN_GAP_RATIO * self._around.max())

    @cached_property
    def spacing(self) -> float:
        """Distance of neighbouring lines as measured, Hz; of uneven ones where they are densest."""
        return float(np.median(np.diff(self._distinct)) if self.even else self._around.min())

    def spacing_at(self, frequency: NDArray[np.float64] | float) -> NDArray[np.float64]:
        """Distance of the lines around some frequencies, Hz, of the same shape.

        A stepped sine has its lines at the resonances, a logarithmic sweep at low frequencies.
        """
        if self.even:
            return np.full(np.shape(frequency), self.spacing)
        middle = 0.5 * (self._distinct[1:] + self._distinct[:-1])
        return np.asarray(self._around[np.minimum(np.searchsorted(middle, frequency), len(middle) - 1)])

    @cached_property
    def _distinct(self) -> NDArray[np.float64]:
        """Lines before any averaging, those measured twice once; Hz."""
        again = np.diff(self.grid) < SAME_LINE * self.grid[1:]
        return np.asarray(self.grid[np.append(True, ~again)])

    @cached_property
    def _around(self) -> NDArray[np.float64]:
        """Median of the gaps around every gap between lines, Hz."""
        return np.asarray(running_median(np.diff(self._distinct)[None], MEDIAN_GAPS, "nearest")[0])

    @property
    def band(self) -> tuple[float, float]:
        """First and last line, rad/s."""
        low, high = 2.0 * np.pi * self.frequency[[0, -1]]
        return float(low), float(high)

    @property
    def scale(self) -> float:
        """Geometric middle of the band, rad/s: the unit in which powers of s stay near 1."""
        return float(2.0 * np.pi * np.sqrt(self.frequency[0] * self.frequency[-1]))

    @property
    def values(self) -> int:
        """Number of real values measured."""
        return 2 * (self.h.size + self.hidden)

    @property
    def independent(self) -> float:
        """Number of independent real values among `values`, the n of an information criterion."""
        return self.values / self.redundancy

    @property
    def redundancy(self) -> float:
        """Number of values that carry the information of one independent value."""
        return self.correlation * self.shared

    @property
    def responses(self) -> float:
        """Number of responses with independent errors that carry the information of all."""
        return max(len(self.h) / self.shared, 1.0)

    @cached_property
    def _term_columns(self) -> dict[ResidualTerms, NDArray[np.complex128]]:
        return {}

    @cached_property
    def _weighted(self) -> dict[ResidualTerms, list[WeightedLines]]:
        return {}

    def weighted(self, terms: ResidualTerms) -> list[WeightedLines]:
        """Lines with residual terms (P) and data after them as rows, one item per weight group."""
        if terms not in self._weighted:
            fixed = self.term_columns(terms)
            self._weighted[terms] = [
                WeightedLines.of(
                    self.s.imag,
                    group.weight[::2],
                    np.concatenate([fixed * group.weight[::2], group.data.view(complex)]),
                )
                for group in self.weight_groups
            ]
        return self._weighted[terms]

    def term_columns(self, terms: ResidualTerms) -> NDArray[np.complex128]:
        """Columns of residual terms on these lines, (P, F), computed once."""
        if terms not in self._term_columns:
            self._term_columns[terms] = terms.columns(self.s, self.scale)
        return self._term_columns[terms]

    @cached_property
    def weight_groups(self) -> list["WeightGroup"]:
        """Responses whose deviations are proportional, so that they share one factorisation."""
        groups: list[tuple[NDArray[np.float64], list[int], list[float]]] = []
        for row, deviation in enumerate(self.deviation):
            level = float(np.sqrt(np.mean(deviation**2)))
            weight = level / deviation
            for known, rows, scales in groups:
                # most differ on the first line already: hundreds of rows are compared in pairs
                if abs(known[0] - weight[0]) <= SAME_WEIGHT and (np.abs(known - weight) <= SAME_WEIGHT).all():
                    rows.append(row)
                    scales.append(1.0 / level)
                    break
            else:
                groups.append((weight, [row], [1.0 / level]))
        return [WeightGroup.of(self.h, *group) for group in groups]
