"""What a plate's plain reduction rests on: functions and vectors, to which effects add theirs."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True)
class PlateBasis:
    """Chosen functions of a plate, and vectors over them.

    Attributes
    ----------
    kept : (5, N) ndarray of bool
        See `simulation.shell.choice.Choice`.
    dropped : float
        Likewise.
    vectors : (n, r) ndarray
        Orthonormal in the mass: the coordinates of the plain reduced model.
    error : float
        See `ReducedModel.error`.
    """

    kept: NDArray[np.bool_]
    dropped: float
    vectors: NDArray[np.float64]
    error: float
