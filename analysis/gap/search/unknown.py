"""Unknown cause: evidence that a smooth discrepancy of no known effect explains the residual.

After Kennedy and O'Hagan (J. R. Statist. Soc. B 63, 2001) a twin's discrepancy is a Gaussian process. Here it is
expanded in averages over neighbouring nodes (a fraction of a resonance) and in the lowest cosines over
temperature. Its variance in each frequency band and order is estimated from the residual, so its evidence has a
closed form. A named effect that explains less than this discrepancy is not accepted.
"""

import numpy as np
from numpy.typing import NDArray
from scipy.fft import dct

from analysis.gap.data.sweeps import GapSweeps
from analysis.gap.fitting.state import GapState

NODES_TOGETHER = 2
"""Number of nodes per average: a third of the width of a resonance."""
ORDERS = 6
"""Number of cosines over temperature."""
BANDS = 12
"""Number of frequency bands with a variance of their own."""


def unknown_evidence(sweeps: GapSweeps, residual: NDArray[np.complex128], state: GapState) -> float:
    """Log evidence, over pure noise, of a smooth discrepancy behind a residual.

    Computed at fixed frequencies and at frequencies that shift with E like resonances; the larger value is
    returned.

    Parameters
    ----------
    sweeps : GapSweeps
    residual : (T, K, n) complex ndarray
        Whitened.
    state : GapState
        Its laws give the shift of resonances with temperature.

    Returns
    -------
    float
        Nats.
    """
    fixed = np.zeros(sweeps.count, dtype=int)
    frequency = sweeps.nodes.frequency
    per_node = float(np.median(np.diff(np.log(frequency))))
    stiffness = state.laws[sweeps.groups.of_sweep, 0]
    moving = np.round(0.5 * (stiffness - stiffness.mean()) / per_node).astype(int)
    return max(_evidence(sweeps, residual, shift) for shift in (fixed, moving))


def _evidence(sweeps: GapSweeps, residual: NDArray[np.complex128], shift: NDArray[np.int_]) -> float:
    n = residual.shape[-1]
    aligned = np.zeros_like(residual)
    for s, by in enumerate(shift):
        width = n - abs(int(by))
        if width > 0:
            here, there = max(-int(by), 0), max(int(by), 0)
            aligned[s, :, here : here + width] = residual[s, :, there : there + width]
    usable = n // NODES_TOGETHER * NODES_TOGETHER
    blocks = aligned[..., :usable].reshape(*aligned.shape[:2], -1, NODES_TOGETHER)
    averages = blocks.sum(-1) / np.sqrt(NODES_TOGETHER)
    total = 0.0
    for leg in sweeps.legs:
        ordered = averages[leg]
        orders = dct(ordered.real, axis=0, norm="ortho") + 1j * dct(ordered.imag, axis=0, norm="ortho")
        for order in orders[:ORDERS]:
            for band in np.array_split(order, BANDS, axis=-1):
                total += _free_variance(band)
    return total


def _free_variance(values: NDArray[np.complex128]) -> float:
    """Log evidence that complex `values` have more variance than unit noise in each part.

    The best variance v gives N (v - 1 - log v) for N complex numbers, less half of log N as its penalty.
    """
    count = values.size
    if count == 0:
        return 0.0
    v = float((np.abs(values) ** 2).mean()) / 2.0
    if v <= 1.0:
        return 0.0
    return max(float(count * (v - 1.0 - np.log(v)) - 0.5 * np.log(count)), 0.0)
