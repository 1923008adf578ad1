"""Types of arrays by what they hold; shapes and units stand in the docstrings."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

Real = NDArray[np.float64]
Complex = NDArray[np.complex128]
Whole = NDArray[np.int_]
"""Counts and indices."""
Mask = NDArray[np.bool_]
Numbers = NDArray[Any]
"""Any kind of number, for functions that accept all."""
