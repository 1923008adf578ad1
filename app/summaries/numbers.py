"""Numbers in words: values as far as their standard deviation lets them be known, times, numbers of sweeps."""

import math
from dataclasses import asdict
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from analysis.recordings.campaign import CampaignExtent

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


def duration(seconds: float) -> str:
    """Return hours and minutes, or seconds where it is less than two minutes."""
    if seconds < 120.0:
        return f"{seconds:.0f} s"
    minutes = round(seconds / 60.0)
    return f"{minutes // 60} h {minutes % 60:02d} min" if minutes >= 60 else f"{minutes} min"


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


def led(extent: CampaignExtent | None) -> str:
    """Return what a closing line begins with: ``interrupted, 20 of 31 sweeps, 15 to 45 °C: ``; else nothing."""
    return "" if extent is None else f"{extent.said}: "


def extent_record(extent: CampaignExtent | None) -> dict[str, Any]:
    """Return what ``--json`` prints of it under ``extent``; nothing of a complete campaign."""
    return {} if extent is None else {"extent": {**asdict(extent), "said": extent.said}}
