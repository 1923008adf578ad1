"""A value as far as its standard deviation lets it be known."""

import math

FIXED = "\u00a0"
"""A space at which no line is broken."""


def with_sigma(value: float, sigma: float, unit: str = "1") -> str:
    """Return value, standard deviation to two digits, and unit; the value to the same decimal.

    Parameters
    ----------
    sigma : float
        Of the same unit; not printed unless above 0 and finite.
    unit : str
        Not printed where it is 1.
    """
    unit = "" if unit == "1" else f" {unit}"
    if not 0.0 < sigma < math.inf:
        return f"{value:.4g}{unit}"
    decimals = 1 - math.floor(math.log10(sigma))
    if 0 <= decimals <= 6:
        return f"{value:.{decimals}f} ± {sigma:.{decimals}f}{unit}"
    power = math.floor(math.log10(max(abs(value), sigma)))
    decimals = max(decimals + power, 0)
    scale = 10.0**power
    return f"({value / scale:.{decimals}f} ± {sigma / scale:.{decimals}f})e{power}{unit}"


def roughly(value: float, sigma: float, unit: str = "1") -> str:
    """Return what `with_sigma` does for a reader in a hurry: sigma to one digit, to two if it begins with 1.

    Parameters
    ----------
    sigma : float
        Of the same unit; not printed unless above 0 and finite.
    unit : str
        Not printed where it is 1.
    """
    said = "" if unit == "1" else f"{FIXED}{unit}"
    if not 0.0 < sigma < math.inf:
        return f"{value:.3g}{said}"
    first = math.floor(math.log10(sigma))
    decimals = max((1 if sigma / 10.0**first < 2.0 else 0) - first, 0)
    if decimals > 6:
        return with_sigma(value, sigma, unit)
    return f"{value:.{decimals}f}{FIXED}±{FIXED}{sigma:.{decimals}f}{said}"
