"""Memory that fits share."""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray


@dataclass(eq=False)
class Room:
    """Memory for the columns of a fit, handed on from FRFs to all lines made of them: fresh memory is slow."""

    _kept: NDArray[np.complex128] = field(default_factory=lambda: np.empty(0, dtype=complex))

    def arrays(self, rows: int, lines: int) -> NDArray[np.complex128]:
        """Return two arrays (2, rows, lines), to be filled, good until the next call."""
        size = 2 * rows * lines
        if len(self._kept) < size:
            self._kept = np.empty(size + size // 4, dtype=complex)
        return self._kept[:size].reshape(2, rows, lines)
