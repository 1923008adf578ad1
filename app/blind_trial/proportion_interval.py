"""Wilson's interval for a proportion (E. B. Wilson, Journal of the American Statistical Association 22, 1927)."""

import numpy as np

NINETY_FIVE = 1.959963984540054
"""Half width of the 95 % interval of a normal distribution, in standard deviations."""


def proportion_interval(hits: int, count: int, z: float = NINETY_FIVE) -> tuple[float, float]:
    """Return the ends of the interval for a proportion.

    Parameters
    ----------
    hits, count : int
        Hits among all that were counted.
    z : float
        Half width of the interval in standard deviations of a normal distribution; 95 % by default.

    Returns
    -------
    low, high : float
        0 and 1 where nothing was counted.

    Raises
    ------
    ValueError
        For more hits than were counted, or less than none.
    """
    if not 0 <= hits <= count:
        raise ValueError(f"{hits} hits of {count}: between none and all are possible")
    if count == 0:
        return 0.0, 1.0
    share, weight = hits / count, z**2 / count
    middle = (share + 0.5 * weight) / (1.0 + weight)
    half = z * np.sqrt(share * (1.0 - share) / count + 0.25 * weight / count) / (1.0 + weight)
    low, high = float(max(middle - half, 0.0)), float(min(middle + half, 1.0))
    return (0.0 if hits == 0 else low), (1.0 if hits == count else high)
