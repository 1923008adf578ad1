"""Complex mode indicator function: how many modes act at each line."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from analysis.estimation.transfer import MeasuredTransfer


def cmif(transfers: Sequence[MeasuredTransfer]) -> NDArray[np.float64]:
    """Singular values of the FRFs' matrix at every line (Shih et al., IMAC 1988).

    A peak of the first is a mode; one of the second at the same line a second mode, close or repeated.

    Parameters
    ----------
    transfers : sequence of MeasuredTransfer
        That share their lines; what was not measured counts as zero.

    Returns
    -------
    (R, F) ndarray
        From the largest, R the lesser of the numbers of responses and of references.
    """
    responses = list(dict.fromkeys(one.response for one in transfers))
    references = list(dict.fromkeys(one.reference for one in transfers))
    h = np.zeros((len(transfers[0].frequency), len(responses), len(references)), dtype=complex)
    for one in transfers:
        h[:, responses.index(one.response), references.index(one.reference)] = one.h
    values: NDArray[np.float64] = np.linalg.svd(h, compute_uv=False)
    return values.T
