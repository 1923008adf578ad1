"""A recording of two actuators is two campaigns; files that do not say who drove are named."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from app.files.campaign import load_campaign
from app.files.campaign_error import CampaignFileError
from app.files.one_actuator import driven_by
from app.files.recorded_campaign import read_recording

HAMMER = '\n[[drive]]\nid = "hammer"\nkind = "force"\npoint = [0.12, 0.1]\n'


@pytest.fixture
def recorded(tiny: Any, tmp_path: Path) -> Path:
    """Make the way down, relabelled as up, the hammer's."""
    tiny.toml = tiny.toml.replace('["up", "down"]', '["up"]') + HAMMER
    for file in tiny.files.values():
        hammered = file.properties["direction"] == "down"
        file.properties |= {"actuator": "hammer" if hammered else "A1", "direction": "up"}
        if hammered:
            file.properties["step"] = 8 - file.properties["step"]  # warming up, as the first
        if hammered:
            for channels in file.channel_properties.values():
                channels["drive"] = {**channels["drive"], "unit_string": "N"}
    folder: Path = tiny.write(tmp_path / "plate")
    return folder


def test_each_actuator_is_a_campaign(recorded: Path, run_flexura: Callable[..., tuple[int, str, str]]) -> None:
    for actuator, label in (("A1", "S1/A1 [V/V]"), ("hammer", "S1/hammer [V/N]")):
        status, _, message = run_flexura("import", recorded, "--actuator", actuator)
        assert status == 0, message
        campaign = load_campaign(recorded.with_name(f"plate-{actuator}-campaign"))
        assert (len(campaign.sweeps), campaign.experiment.labels()[0]) == (3, label)
    assert [patch.role for patch in campaign.experiment.patch] == ["shorted", "sensor", "sensor"]


def test_which_one_has_to_be_said(recorded: Path) -> None:
    with pytest.raises(CampaignFileError, match=r"2 have the role actuator.*flexura import --actuator ID"):
        read_recording(recorded)
    with pytest.raises(CampaignFileError, match=r"--actuator.*'shaker'.*A1, hammer"):
        read_recording(recorded, actuator="shaker")


def test_a_sweep_that_names_none_is_told(tiny: Any, tmp_path: Path) -> None:
    tiny.toml += HAMMER
    with pytest.raises(CampaignFileError, match=r"sweeps/000.*actuator = nothing; allowed: A1 or hammer"):
        read_recording(tiny.write(tmp_path / "plate"), actuator="A1")


def test_a_declaration_of_one_stays_as_it_is(tmp_path: Path) -> None:
    table = {"patch": [{"id": "A1", "role": "actuator"}, {"id": "S1", "role": "sensor"}]}
    assert driven_by(tmp_path / "campaign.toml", table, "A1") == table
    assert driven_by(tmp_path / "campaign.toml", table, None) is table
