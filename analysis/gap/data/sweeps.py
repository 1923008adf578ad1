"""A campaign prepared for comparison with a twin: compressed sweeps, weights, groups; with wider resonances.

A response known over frequency is given wider resonances by convolution with Cauchy's kernel of half-width d,

    (S h)(f) = ∫ h(g) d / π / ((f - g)² + d²) dg = h(f - j d),

the response at a complex frequency, that of a plate with more damping. Recordings, responses of the twin and their
derivatives go through the same S, so that nothing is approximated, not even at the ends of the band. Noise matters
no longer; what the twin does not know does, a share of the response.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Complex, Real
from analysis.gap.data.compression import CompressedSweep, Nodes
from analysis.gap.data.groups import LawSmoothness, TemperatureGroups
from analysis.gap.thresholds import MODEL_ERROR_ALONG, MOVED_ALONG
from analysis.recordings.sweep_point import SweepPoint


@dataclass(frozen=True)
class LineWeights:
    """Factors on the two parts of every whitened number of some sweeps.

    Attributes
    ----------
    direction : (T, K, n) complex ndarray
        Of unit size.
    along, across : (T, K, n) ndarray
        0 to 1; both 1 where only noise is expected.
    """

    direction: NDArray[np.complex128] = field(repr=False)
    along: Real = field(repr=False)
    across: Real = field(repr=False)

    @classmethod
    def equal(cls, shape: tuple[int, ...]) -> "LineWeights":
        """Weights of 1 for sweeps of some `shape`."""
        return cls(np.ones(shape, dtype=complex), np.ones(shape), np.ones(shape))

    def weigh(
        self, white: NDArray[np.complex128], sweep: int, channels: slice = slice(None)
    ) -> NDArray[np.complex128]:
        """Turn and weigh whitened numbers.

        Parameters
        ----------
        white : (..., K, n) complex ndarray
        sweep : int
            Theirs.
        channels : slice
            Of which they are; all unless given.

        Returns
        -------
        (..., K, n) complex ndarray
        """
        turned = white * self.direction[sweep, channels].conj()
        along, across = self.along[sweep, channels], self.across[sweep, channels]
        return np.asarray(along * turned.real + 1j * across * turned.imag)

    def undone(self, weighted: NDArray[np.complex128]) -> NDArray[np.complex128]:
        """Return the whitened numbers (T, K, n) of which `weighted` ones were made."""
        found: NDArray[np.complex128] = (
            weighted.real / self.along + 1j * weighted.imag / self.across
        ) * self.direction
        return found

    def only_channels(self, channels: Sequence[int]) -> "LineWeights":
        """Return those of some channels."""
        kept = list(channels)
        return LineWeights(self.direction[:, kept], self.along[:, kept], self.across[:, kept])

    def only(self, sweeps: Sequence[int]) -> "LineWeights":
        """Return those of some sweeps."""
        kept = list(sweeps)
        return LineWeights(self.direction[kept], self.along[kept], self.across[kept])


@dataclass(frozen=True)
class GapSweeps:
    """Sweeps of a campaign in whitened form.

    Attributes
    ----------
    nodes : Nodes
        Common to all sweeps and channels.
    points : tuple of SweepPoint
    direction : tuple of str
    drives : tuple of str
        Level of each sweep as text: ``10 V``, ``2 N at hammer``.
    channels : tuple of str
    compressed : tuple of CompressedSweep
        With the noise rescaled by its check.
    groups : TemperatureGroups
    reading_sigma : float
        Standard deviation of a sweep's temperature reading, K.
    rough : (G, 3) ndarray
        Approximate laws, from which `smoothness` is computed.
    smoothness : LawSmoothness
        Slopes and curvatures of the laws, given their values.
    twin_error : float
        Error of the twin common to all lines, as a share of rms|H|.
    rows : (T, K, n) bool ndarray
        Which whitened numbers are used; all of them except for held-out data.
    original : (T,) int ndarray
        Index of each sweep in the FRFs.
    weights : LineWeights
        Below 1 where the twin is expected to differ from the plate by more than the noise, see
        `analysis.gap.imperfect`.
    heard : tuple of int
        Which of the twin's channels these are; all where it is empty.
    """

    nodes: Nodes
    points: tuple[SweepPoint, ...]
    direction: tuple[str, ...]
    drives: tuple[str, ...]
    channels: tuple[str, ...]
    compressed: tuple[CompressedSweep, ...]
    groups: TemperatureGroups
    reading_sigma: float
    rough: NDArray[np.float64]
    smoothness: LawSmoothness
    twin_error: float
    rows: NDArray[np.bool_] = field(repr=False)
    original: NDArray[np.int_] = field(repr=False)
    weights: LineWeights = field(repr=False)
    heard: tuple[int, ...] = ()

    @property
    def count(self) -> int:
        """Number of sweeps."""
        return len(self.points)

    @property
    def levels(self) -> dict[int, set[float]]:
        """Levels at which each input drove: those of different inputs are not comparable."""
        found: dict[int, set[float]] = {}
        for point in self.points:
            found.setdefault(point.source, set()).add(point.level)
        return found

    @property
    def level_count(self) -> int:
        """Largest number of levels at which one input drove, told apart by a twentieth."""
        return max(1 + sum(b > 1.05 * a for a, b in pairwise(sorted(its))) for its in self.levels.values())

    @property
    def legs(self) -> list[list[int]]:
        """Sweeps on one ramp, at one level and from one input, the coldest of each first."""
        legs: dict[tuple[str, float, int], list[int]] = {}
        for s in sorted(range(self.count), key=lambda s: self.points[s].temperature):
            legs.setdefault((self.direction[s], self.points[s].level, self.points[s].source), []).append(s)
        return [legs[leg] for leg in sorted(legs)]

    @property
    def numbers(self) -> int:
        """Number of real values used."""
        return 2 * int(self.rows.sum())

    @property
    def power(self) -> float:
        """Sum of |h|^2 in units of the noise: a relative residual e has a chi2 of e**2 times this."""
        sweeps = enumerate(self.compressed)
        white = np.array([self.weights.weigh(one.whitened(one.coefficients), s) for s, one in sweeps])
        return float((np.abs(white[self.rows]) ** 2).sum())

    @property
    def allowed(self) -> float:
        """chi2 that the twin's own error may cause."""
        return self.twin_error**2 * self.power

    @property
    def overstated(self) -> float:
        """Factor by which evidence is too large because the twin's own error is common to all lines.

        Along a tangent the residual has the noise's variance of 1 plus that of the error: a log evidence of g
        counts as g over their sum.
        """
        return 1.0 + MODEL_ERROR_ALONG**2 * self.allowed

    def overstated_with(self, moved_error: float) -> float:
        """Return the same with an error (share of rms|H|) by moved patches, which fewer directions share."""
        return self.overstated + (MOVED_ALONG * moved_error) ** 2 * self.power

    @property
    def between(self) -> tuple[float, float]:
        """Return chi2 of the lines about the splines, which depends on no model, and its degrees of freedom.

        Over the channels and sweeps used; if only a part of the band is used, an equal share of both.
        """
        share = self.rows.mean(-1)
        chi2 = sum(float(s.chi2_within.sum(1) @ part) for s, part in zip(self.compressed, share, strict=True))
        dof = sum(s.dof_within * float(part.sum()) for s, part in zip(self.compressed, share, strict=True))
        return chi2, dof

    def only(self, sweeps: Sequence[int]) -> "GapSweeps":
        """Return some of the sweeps, in the order given, with the groups they still form."""
        kept = np.asarray(sweeps, dtype=int)
        labels = np.unique(self.groups.of_sweep[kept], return_inverse=True)[1]
        temperature = np.array([self.points[s].temperature for s in kept])
        groups = TemperatureGroups.labelled(labels, temperature)
        rough = self.rough[np.unique(self.groups.of_sweep[kept])]
        return replace(
            self,
            points=tuple(self.points[s] for s in kept),
            direction=tuple(self.direction[s] for s in kept),
            drives=tuple(self.drives[s] for s in kept),
            compressed=tuple(self.compressed[s] for s in kept),
            groups=groups,
            rough=rough,
            smoothness=LawSmoothness.of(groups.reference, rough),
            rows=self.rows[kept],
            original=self.original[kept],
            weights=self.weights.only(kept.tolist()),
        )

    def original_places(self, whole: "GapSweeps") -> list[int]:
        """Return the indices of these sweeps in `whole`."""
        place = {int(sweep): i for i, sweep in enumerate(whole.original)}
        return [place[int(sweep)] for sweep in self.original]

    def only_groups(self, groups: Sequence[int]) -> "GapSweeps":
        """Return all sweeps of some of the groups."""
        return self.only(np.flatnonzero(np.isin(self.groups.of_sweep, np.asarray(groups))).tolist())

    def only_channels(self, channels: Sequence[int]) -> "GapSweeps":
        """Return the same sweeps with some of the twin's channels, of all of which these are."""
        kept = list(channels)
        return replace(
            self,
            channels=tuple(self.channels[k] for k in kept),
            compressed=tuple(one.only_channels(kept) for one in self.compressed),
            rows=self.rows[:, kept],
            weights=self.weights.only_channels(kept),
            heard=tuple(kept),
        )

    def masked(self, rows: NDArray[np.bool_]) -> "GapSweeps":
        """Return the same sweeps with only `rows` (broadcast to (T, K, n)) taking part."""
        return replace(self, rows=self.rows & rows)


PLACES_PER_HALF_WIDTH = 4.0
"""Number of frequencies within a half-width at which the widened response is taken: between two of them h changes
by less than what the twin does not know."""
WIDEST = 1e-3
"""Lowest frequency at which it is taken, over the highest: a band that begins at 0 Hz has no end of widths."""


def cauchy_kernel(frequency: Real, width: float, places: Real | None = None) -> Real:
    """Return S, (m, n): values over `frequency` (n,) to those of wider resonances at `places` (m,).

    Parameters
    ----------
    frequency : (n,) ndarray
        Ascending, Hz.
    width : float
        Half-width d as a share of the frequency.
    places : (m,) ndarray, optional
        Hz; `frequency` itself unless given.
    """
    at = frequency if places is None else places
    half = width * at[:, None]
    return np.asarray(half / np.pi / ((at[:, None] - frequency) ** 2 + half**2) * np.gradient(frequency))


@dataclass(frozen=True)
class WidenedSweep(CompressedSweep):
    """A sweep whose whitened numbers are those of wider resonances, in units of what the twin does not know.

    Attributes
    ----------
    kernel : (m, n) ndarray
        Coefficients of the splines to widened values.
    scale : (K, 1) ndarray
        Standard deviation of a widened value.
    """

    kernel: Real = field(repr=False)
    scale: Real = field(repr=False)

    def whitened(self, coefficients: Complex, channels: slice = slice(None)) -> Complex:
        """Widen `coefficients` (..., K, n): (..., K, m) numbers of about unit variance."""
        flat = coefficients.reshape(-1, coefficients.shape[-1])
        wide = flat.real @ self.kernel.T + 1j * (flat.imag @ self.kernel.T)
        return np.asarray(wide.reshape(*coefficients.shape[:-1], -1) / self.scale[channels])


def widened(sweeps: GapSweeps, width: float, twin_error: float) -> GapSweeps:
    """Return the same sweeps with wider resonances, for fits that begin far from the data.

    Parameters
    ----------
    sweeps : GapSweeps
        All of whose numbers take part.
    width : float
        Half-width added to the resonances, as a share of the frequency.
    twin_error : float
        What the twin does not know of a widened response, as a share of its root mean square.
    """
    places = _places(sweeps.nodes, width)
    kernel = cauchy_kernel(sweeps.nodes.frequency, width, places) @ _values(sweeps.nodes)
    error = twin_error * np.sqrt(PLACES_PER_HALF_WIDTH)  # neighbours tell the same
    found = []
    for one in sweeps.compressed:
        wide = WidenedSweep(**vars(one), kernel=kernel, scale=np.ones((len(one.coefficients), 1)))
        size = np.sqrt((np.abs(wide.whitened(one.coefficients)) ** 2).mean(axis=-1, keepdims=True))
        found.append(replace(wide, scale=error * size))
    shape = (*sweeps.rows.shape[:2], places.size)
    return replace(
        sweeps, compressed=tuple(found), rows=np.ones(shape, dtype=bool), weights=LineWeights.equal(shape)
    )


def _places(nodes: Nodes, width: float) -> Real:
    high = float(nodes.frequency[-1])
    low = max(float(nodes.frequency[0]), WIDEST * high)
    count = int(np.ceil(PLACES_PER_HALF_WIDTH * np.log(high / low) / width)) + 1
    return np.geomspace(low, high, max(count, 2))


def _values(nodes: Nodes) -> Real:
    """Return the matrix (n, n) that takes coefficients of splines to their values at the nodes."""
    return np.ascontiguousarray(nodes.at_nodes(np.eye(nodes.frequency.size, dtype=complex)).real.T)
