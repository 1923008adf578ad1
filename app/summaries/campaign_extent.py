"""An incomplete campaign in a verb's closing line and in its JSON."""

from dataclasses import asdict
from typing import Any

from analysis.campaign_extent import CampaignExtent


def led(extent: CampaignExtent | None) -> str:
    """Return what a closing line begins with: ``interrupted, 20 of 31 sweeps, 15 to 45 °C: ``; else nothing."""
    return "" if extent is None else f"{extent.said}: "


def extent_record(extent: CampaignExtent | None) -> dict[str, Any]:
    """Return what ``--json`` prints of it under ``extent``; nothing of a complete campaign."""
    return {} if extent is None else {"extent": {**asdict(extent), "said": extent.said}}
