"""How much of a campaign's protocol has been measured, in words."""

from dataclasses import replace
from typing import Any

import pytest

from analysis.recordings.campaign import CampaignExtent

TWENTY = CampaignExtent("interrupted", sweeps=20, asked=31, given_up=0, lowest=14.98, highest=45.2)


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({}, "interrupted, 20 of 31 sweeps, 15 to 45 °C"),
        ({"state": "running"}, "running, 20 of 31 sweeps, 15 to 45 °C"),
        ({"given_up": 2}, "interrupted, 20 of 31 sweeps (2 given up), 15 to 45 °C"),
        ({"state": "ended", "given_up": 11}, "ended with sweeps missing, 20 of 31 sweeps, 15 to 45 °C"),
        ({"state": "incomplete"}, "incomplete, 20 of 31 sweeps, 15 to 45 °C"),
        ({"sweeps": 1, "lowest": -0.2, "highest": -0.2}, "interrupted, 1 of 31 sweeps, 0 °C"),
    ],
)
def test_is_said_in_one_line(changes: dict[str, Any], said: str) -> None:
    extent = replace(TWENTY, **changes)
    assert extent.said == said
    assert said in extent.note


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"state": "complete"}, "one of running, interrupted, ended, incomplete wanted"),
        ({"sweeps": 31}, "31 of 31 sweeps"),
        ({"sweeps": 0}, "0 of 31 sweeps"),
        ({"given_up": 12}, "12 given up"),
        ({"given_up": -1}, "-1 given up"),
        ({"lowest": 50.0}, "from 50 to 45.2 °C"),
        ({"lowest": float("nan")}, "from nan to"),
    ],
)
def test_what_cannot_be_is_refused(changes: dict[str, Any], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        replace(TWENTY, **changes)
