"""A request is refused when it is made: its files are read, its numbers checked, before anything is computed."""

import json
from pathlib import Path
from typing import Any

import pytest

from app.files.bad_file import ResultFileError, UnsuitedOptionError
from app.files.campaign_error import CampaignFileError
from app.files.campaigns.loading import load_campaign
from app.stages.gap import GapRequest
from app.stages.update import UpdateRequest


@pytest.fixture
def campaign(tiny: Any, tmp_path: Path) -> Any:
    return load_campaign(tiny.write(tmp_path / "tiny"))


@pytest.mark.parametrize("mains", [-50.0, 0.0, 1000.0, float("nan"), float("inf")])
def test_no_mains_have_such_a_frequency(mains: float, campaign: Any) -> None:
    with pytest.raises(ValueError, match=r"mains .* Hz: 10 to 400 allowed"):
        UpdateRequest(campaign, mains=mains)


def test_files_are_read_when_it_is_made(campaign: Any, tmp_path: Path) -> None:
    no_twin = tmp_path / "twin.toml"
    no_twin.write_text('format = "recorded-campaign/1"\n', encoding="utf-8")
    with pytest.raises(CampaignFileError, match=r"twin\.toml"):
        UpdateRequest(campaign, twin=no_twin)
    (tmp_path / "effects").mkdir()
    (tmp_path / "effects" / "mine.py").write_text("EFFECT = 1\n", encoding="utf-8")
    with pytest.raises(ResultFileError, match="EFFECT"):
        GapRequest(campaign, effects=tmp_path / "effects")
    (tmp_path / "gap.json").write_text(json.dumps({"plan": {"questions": [], "next": None}}), encoding="utf-8")
    with pytest.raises(ResultFileError, match="nothing was open"):
        GapRequest(campaign, after=(campaign, tmp_path))


@pytest.mark.parametrize("given", [{"hours": {"scale": 1.0}}, {"rig": {"title": "mine"}}])
def test_what_belongs_to_a_plan_is_refused_without_one(given: Any, campaign: Any) -> None:
    with pytest.raises(UnsuitedOptionError, match="belong to --plan"):
        GapRequest(campaign, **given)


def test_hours_of_what_is_no_measurement(campaign: Any) -> None:
    with pytest.raises(UnsuitedOptionError, match="allowed: KIND=HOURS, above 0 and at most"):
        GapRequest(campaign, plan=True, hours={"scales": 1.0})
    with pytest.raises(UnsuitedOptionError, match="allowed: KIND=HOURS, above 0 and at most"):
        GapRequest(campaign, plan=True, hours={"scale": 0.0})
