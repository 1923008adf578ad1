"""A campaign in a recorder's own layout, its channels declared: the same campaign as in Flexura's."""

import re
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from nptdms import ChannelObject, RootObject, TdmsFile, TdmsWriter

from app.files.campaign_error import CampaignFileError
from app.files.campaigns.recorded import read_recorded_campaign

NAMES = {"drive": "cDAQ1Mod1/ai0", "S1": "Voltage_1", "S2": "Voltage_2"}
CHANNELS = """
[channels]
"cDAQ1Mod1/ai0" = { role = "drive", sensitivity = "50 mV/V" }
"Voltage_1" = { role = "response", at = "S1" }
"Voltage_2" = { role = "response", at = "S2", unit = "mV" }
"Room" = { role = "unused" }

[sweeps]
"""
Rewrite = Callable[..., Path]


@pytest.fixture
def rewritten(tiny: Any, tmp_path: Path) -> Rewrite:
    """Write the tiny campaign as FlexLogger would: one group, all repeats after each other, names of its own."""

    def write(channels: str = CHANNELS, groups: tuple[str, ...] = ("Log",)) -> Path:
        own = tiny.write(tmp_path / "own" / "plate")
        folder = tmp_path / "plate"
        shutil.copytree(own, folder)
        text = channels
        for path in sorted((own / "sweeps").iterdir()):
            file = TdmsFile.read(path)
            said = file.properties
            ends = [said["oven_temperature_start"], said["oven_temperature_end"]]
            text += (
                f'"{path.name}" = {{ temperature = {ends}, level = {said["level"]}, '
                f'direction = "{said["direction"]}", start_time = "{said["start_time"]}" }}\n'
            )
            _as_recorder(file, folder / "sweeps" / path.name, groups)
        toml = folder / "campaign.toml"
        toml.write_text(toml.read_text(encoding="utf-8") + text, encoding="utf-8")
        return folder

    return write


def _as_recorder(file: TdmsFile, path: Path, groups: tuple[str, ...]) -> None:
    objects: list[Any] = [RootObject({"Operator": "somebody"})]
    repeats = [group for group in file.groups() if group.name.startswith("repeat")]
    for number, group in enumerate(groups):
        mine = repeats if len(groups) == 1 else [repeats[number % 2]]
        for ours, theirs in NAMES.items():
            scale = {"drive": 0.05, "S1": 1.0, "S2": 1e3}[ours]
            samples = scale * np.concatenate([one[ours][:].astype(float) for one in mine])
            wave = {"wf_increment": mine[0][ours].properties["wf_increment"]}
            if ours != "S2":  # of which the recorder tells no unit
                wave["unit_string"] = "V"
            objects.append(ChannelObject(group, theirs, samples, wave))
        objects.append(ChannelObject(group, "Room", np.zeros(7), {}))
    with TdmsWriter(path) as writer:
        writer.write_segment(objects)


@pytest.mark.parametrize("groups", [("Log",), ("first", "second")])
def test_a_recorders_own_layout_is_the_same_campaign(
    rewritten: Rewrite, tmp_path: Path, groups: tuple[str, ...]
) -> None:
    found = read_recorded_campaign(rewritten(groups=groups))
    wanted = read_recorded_campaign(tmp_path / "own" / "plate")
    assert found.experiment == wanted.experiment
    for ours, theirs in zip(wanted.sweeps, found.sweeps, strict=True):
        np.testing.assert_allclose(theirs.drive, ours.drive, rtol=1e-6, atol=1e-9)
        np.testing.assert_allclose(theirs.responses, ours.responses, rtol=1e-6, atol=1e-12)
        assert (theirs.step, theirs.direction, theirs.level) == (ours.step, ours.direction, ours.level)
        assert theirs.oven_temperature_start == ours.oven_temperature_start


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ('at = "S2"', 'at = "S1"', 'both have at = "S1"'),
        ('at = "S2"', 'at = "S9"', "at has to be one of S1, S2"),
        ('"Voltage_2" = { role = "response", at = "S2", unit = "mV" }\n', "", "no channel for S2"),
        (', unit = "mV"', "", 'the file gives no unit; give unit, for example unit = "V"'),
        ('"50 mV/V"', '"50 mV/N"', "is of force, not of voltage"),
        ('"Voltage_1"', '"Voltage_7"', "correct its name"),
        ("[sweeps]\n", '[sweeps]\n"099.tdms" = { temperature = 5.0, level = 1.0 }\n', "no such file"),
        ('role = "unused"', 'role = "nothing"', "'nothing'"),
        ('"50 mV/V"', '"0 mV/V"', "a number other than 0"),
        ('"50 mV/V"', '"nan mV/V"', "a number other than 0"),
        ('"50 mV/V"', '"1e-50 mV/V"', "finite volts"),
        ('"50 mV/V"', '"50 furlong/V"', "unit 'furlong' is not known; allowed: V, mV"),
        ("[channels]", "[channel]", "did you mean channels?"),
    ],
)
def test_what_is_wrong_with_the_declaration_is_said(rewritten: Rewrite, old: str, new: str, said: str) -> None:
    assert old in CHANNELS
    with pytest.raises(CampaignFileError) as refused:
        read_recorded_campaign(rewritten(CHANNELS.replace(old, new)))
    assert said in str(refused.value)


def test_a_sensor_turned_round_has_a_sensitivity_below_zero(rewritten: Rewrite, tmp_path: Path) -> None:
    turned = CHANNELS.replace('at = "S1" }', 'at = "S1", unit = "V", sensitivity = "-1 V/V" }')
    found = read_recorded_campaign(rewritten(turned))
    wanted = read_recorded_campaign(tmp_path / "own" / "plate")
    np.testing.assert_allclose(found.sweeps[0].responses[0], -wanted.sweeps[0].responses[0], rtol=1e-6, atol=1e-9)


def test_a_file_that_no_sweep_names_is_told_where_to_be_named(rewritten: Rewrite) -> None:
    folder = rewritten()
    toml = folder / "campaign.toml"
    lines = toml.read_text(encoding="utf-8").splitlines(keepends=True)
    first = next(number for number, line in enumerate(lines) if line.startswith('"000.tdms"'))
    toml.write_text("".join(lines[:first] + lines[first + 1 :]), encoding="utf-8")
    with pytest.raises(CampaignFileError, match=r'level = nothing; .*name "000.tdms" in \[sweeps\]'):
        read_recorded_campaign(folder)


def test_a_sweep_that_is_a_copy_of_another_is_no_measurement(rewritten: Rewrite) -> None:
    """Its temperature is written beside it, so nothing in the file contradicted: laws got a point that is none."""
    folder = rewritten()
    one, other = sorted((folder / "sweeps").iterdir())[:2]
    other.write_bytes(one.read_bytes())
    with pytest.raises(CampaignFileError, match=rf"{other.name}: a copy of sweeps/{one.name}, byte for byte"):
        read_recorded_campaign(folder)


def test_a_time_that_is_nowhere_is_asked_for_in_the_sweeps(rewritten: Rewrite) -> None:
    folder = rewritten()
    toml = folder / "campaign.toml"
    toml.write_text(re.sub(r', start_time = "[^"]*"', "", toml.read_text(encoding="utf-8")), encoding="utf-8")
    with pytest.raises(CampaignFileError, match=r'start_time = nothing; .*give start_time in sweeps\."000.tdms"'):
        read_recorded_campaign(folder)


def test_channels_that_nobody_asked_for_may_be_many(rewritten: Rewrite) -> None:
    folder = rewritten()
    for path in (folder / "sweeps").iterdir():
        with TdmsWriter(path, mode="a") as writer:
            writer.write_segment([ChannelObject("Log", f"ai{n}", np.zeros(50_000)) for n in range(4)])
    assert len(read_recorded_campaign(folder).sweeps) == 6


def test_repeats_that_do_not_fill_the_file_are_told(rewritten: Rewrite) -> None:
    with pytest.raises(CampaignFileError, match=r"3 with a declared channel; .*one for each of protocol\.repeats"):
        read_recorded_campaign(rewritten(groups=("a", "b", "c")))


def test_a_channel_that_began_later_is_refused(rewritten: Rewrite) -> None:
    """Its phase would be turned; imported, the sensor looked inverted."""
    folder = rewritten()
    with TdmsWriter(folder / "sweeps" / "000.tdms", mode="a") as writer:
        starts = {"cDAQ1Mod1/ai0": 0.0, "Voltage_1": 1e-3}
        writer.write_segment(
            [ChannelObject("Log", name, np.zeros(0), {"wf_start_offset": start}) for name, start in starts.items()]
        )
    with pytest.raises(
        CampaignFileError, match=r"Log/Voltage_1 wf_start_time \+ wf_start_offset = 8\.533 samples"
    ):
        read_recorded_campaign(folder)
