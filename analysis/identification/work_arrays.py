"""Work arrays shared by fits."""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray


@dataclass(eq=False)
class WorkArrays:
    """Work arrays for the columns of a fit, shared by all `Lines` of the same FRFs: allocating anew is slow."""

    _kept: NDArray[np.complex128] = field(default_factory=lambda: np.empty(0, dtype=complex))

    def arrays(self, rows: int, lines: int) -> NDArray[np.complex128]:
        """Return two uninitialised arrays as one of shape (2, rows, lines), valid until the next call."""
        size = 2 * rows * lines
        if len(self._kept) < size:
            self._kept = np.empty(size + size // 4, dtype=complex)
        return self._kept[:size].reshape(2, rows, lines)
