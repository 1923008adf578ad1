"""A disk that takes no readings ends no campaign."""

from pathlib import Path

import pytest

from app.files.acquisition.events import READINGS
from app.stages.acquire import WatchedCampaign
from drivers.rig.campaign import Moment
from drivers.rig.readings import Reading

MOMENT = Moment("up to 20 °C", 18.0, 1, 7, 600.0, "2026-11-29T15:00:00+00:00", Reading(19.0, 18.0))


def test_a_disk_that_takes_no_readings_is_told_once(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    watched = WatchedCampaign(tmp_path)
    (tmp_path / READINGS).mkdir()  # no file can be opened there
    for _ in range(5):
        watched.observe(MOMENT)
    (said,) = caplog.messages
    assert said.startswith("readings cannot be written, and the campaign goes on: ")
    assert "Errno" not in said
    (tmp_path / READINGS).rmdir()
    watched.observe(MOMENT)
    assert len((tmp_path / READINGS).read_text().splitlines()) == 2
    (tmp_path / READINGS).unlink()
    (tmp_path / READINGS).mkdir()
    watched.observe(MOMENT)
    assert len(caplog.messages) == 2
