"""Whether FRFs follow exp(+jwt), in which the phase falls through a resonance, or its conjugate."""

import numpy as np
from numpy.typing import NDArray

CERTAIN_RISE_SIGMA = 3.0
"""Standard deviations from which the phase is known to rise."""

LEAST_PHASE_TURN = 1.0
"""Radians by which the phase turns at least where an FRF is large: a third of what it does over a resonance."""


def turns_backward(h: NDArray[np.complex128]) -> bool:
    """Whether the phase of FRFs rises where they are large, as it does with exp(-jwt).

    The phase of a causal system falls by pi over each resonance. It rises over antiresonances, but the turns from
    line to line are weighted with the magnitude.

    Parameters
    ----------
    h : (L, F) complex ndarray

    Returns
    -------
    bool
        False where it is not certain.
    """
    size = np.abs(h) / np.maximum(np.abs(h).max(axis=1, keepdims=True), np.finfo(float).tiny)
    unit = h / np.maximum(np.abs(h), np.finfo(float).tiny)
    turns = np.sqrt(size[:, :-1] * size[:, 1:]) * (unit[:, :-1].conj() * unit[:, 1:]).imag
    return bool(turns.sum() > max(CERTAIN_RISE_SIGMA * np.sqrt((turns**2).sum()), LEAST_PHASE_TURN * len(h)))
