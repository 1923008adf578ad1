"""Limits of a campaign so far beyond the oven's own that they would stop nothing in time."""

from collections.abc import Iterator

from analysis.protocol.limits import Limits
from app.files.campaign_error import Problem
from drivers.ovens.settings import OvenSettings

FAR = 30.0
"""How far beyond the oven's set-points the limits of a campaign may lie, K."""


def far_limits(name: str, limits: Limits, oven: OvenSettings) -> Iterator[Problem]:
    """Yield what is wrong with the limits of a campaign.

    Parameters
    ----------
    name : str
        Of the experiment's file.
    limits : Limits
    oven : OvenSettings

    Yields
    ------
    Problem
        A limit more than `FAR` beyond the oven's own.
    """
    least, most = oven.minimum - FAR, oven.maximum + FAR
    remedy = (
        "choose a nearer limit, or correct [oven]: it must stop a campaign that leaves the range of the set-points"
    )
    if limits.hottest > most:
        allowed = f"at most {most:g} °C, oven.maximum + {FAR:g} K"
        yield Problem(name, "limits.hottest", f"{limits.hottest:g} °C", allowed, remedy)
    if limits.coldest < least:
        allowed = f"at least {least:g} °C, oven.minimum - {FAR:g} K"
        yield Problem(name, "limits.coldest", f"{limits.coldest:g} °C", allowed, remedy)
