"""Sweeps whose resonances are widened, over which a change that moves resonances far is still nearly linear.

A response known over frequency is given wider resonances by convolution with Cauchy's kernel of half-width d,

    (S h)(f) = ∫ h(g) d / π / ((f - g)² + d²) dg = h(f - j d),

the response at a complex frequency, that of a plate with more damping. Recordings, responses of the twin and their
derivatives go through the same S, so that nothing is approximated, not even at the ends of the band. Noise matters
no longer; what the twin does not know does, a share of the response.
"""

from dataclasses import dataclass, field, replace

import numpy as np

from analysis.arrays import Complex, Real
from analysis.gap.data.compression import CompressedSweep, Nodes
from analysis.gap.data.sweeps import GapSweeps, LineWeights

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
