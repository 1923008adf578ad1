"""Numbers of sweeps and ranges of values in words, for one as for several."""

import numpy as np
from numpy.typing import ArrayLike


def sweeps(count: int) -> str:
    """Return ``1 sweep`` or ``16 sweeps``."""
    return f"{count} sweep" if count == 1 else f"{count} sweeps"


def span(values: ArrayLike, form: str) -> str:
    """Return ``0.0 to 60.0``, or ``20.0`` where lowest and highest read alike.

    Parameters
    ----------
    values : (n,) array_like
        At least one.
    form : str
        Of a number, such as ``z.1f``.
    """
    low, high = (format(float(one), form) for one in (np.min(values), np.max(values)))
    return low if low == high else f"{low} to {high}"
