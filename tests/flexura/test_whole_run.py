"""``flexura.run``: the verb as a function."""

from pathlib import Path

import pytest

import flexura
from app.files.campaign_error import CampaignFileError
from app.files.results.modes_file import load_modes
from tests.app.conftest import TinyCampaign, tiny_campaign


@pytest.fixture
def recording(tmp_path: Path) -> Path:
    made: TinyCampaign = tiny_campaign()
    return made.write(tmp_path / "tiny")


def test_stages_are_made_and_then_skipped(recording: Path, tmp_path: Path) -> None:
    options = {"identify": {"method": "peak-picking", "band": [100.0, 900.0]}}
    record = flexura.run(recording, out=tmp_path / "run", last="identify", options=options)
    assert {name: stage.state for name, stage in record.stages.items()} == {"import": "made", "identify": "made"}
    assert load_modes(tmp_path / "run" / "modes.h5").modes[0].band[1] <= 900.0
    again = flexura.run(recording, out=tmp_path / "run", last="identify", options=options)
    assert {stage.state for stage in again.stages.values()} == {"up to date"}
    assert "identify up to date" in repr(again)
    in_place = flexura.run(recording, out=tmp_path / "other", last="identify", without="import", options=options)
    assert list(in_place.stages) == ["identify"]
    assert not (tmp_path / "other-campaign").exists()


def test_what_cannot_be_run_is_refused(recording: Path, tmp_path: Path) -> None:
    with pytest.raises(CampaignFileError, match=r"options: run\.focus\.taps = 8"):
        flexura.run(recording, options={"focus": {"taps": 8}})
    with pytest.raises(ValueError, match="no stage is left"):
        flexura.run(recording, first="report", last="import")
    with pytest.raises(CampaignFileError, match="not a campaign"):
        flexura.run(tmp_path)
    assert not (tmp_path / "tiny-run").exists()
