"""How far resonances move over the repeats of a sweep, which follow each other while the temperature drifts.

Identification takes it from here, before and without tracks. `Protocol.spread`, in kelvins, is for twins, whose
derivative by temperature is known: model updating and the gap correct all lines with it, not only the poles.
"""

import numpy as np

from analysis.arrays import Complex


def repeat_shift(ratio: Complex, first: int) -> float:
    """Return the standard deviation of the relative shift of all frequencies over the repeats of a sweep.

    While the temperature drifts, all frequencies of a plate move by nearly the same factor. The straight drift of
    H over the repeats is then proportional to f dH/df. H averaged over the repeats is smoothed by this standard
    deviation. To the second order this changes the peak of a pole lambda = w (-zeta + j) by
    -R (shift w)^2/(s - lambda)^3, which is (shift/zeta)^2 of it.

    Parameters
    ----------
    ratio : (K, R, F) complex ndarray
        Response over drive on consecutive lines, of every output and repeat.
    first : int
        Number of the first line, from 0 Hz.

    Returns
    -------
    float
        0 for one repeat.
    """
    repeats = ratio.shape[1]
    if repeats == 1:
        return 0.0
    number = np.arange(repeats) - 0.5 * (repeats - 1)
    drift = np.einsum("r,krf->kf", number, ratio) / (number**2).sum()
    moved = (first + np.arange(ratio.shape[2])) * np.gradient(ratio.mean(axis=1), axis=1)
    size = float((np.abs(moved) ** 2).sum())
    step = float((moved.conj() * drift).sum().real) / size if size > 0.0 else 0.0
    return abs(step) * float(np.sqrt((number**2).mean()))
