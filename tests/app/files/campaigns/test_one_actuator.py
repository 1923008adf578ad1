"""A recording of two actuators is one campaign, or one for each; files that do not say who drove are named."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from analysis.recordings.frf import campaign_frf, sweeps_of_actuator, sweeps_of_modes
from app.files.campaign_error import CampaignFileError
from app.files.campaigns.channels import driven_by
from app.files.campaigns.export import campaign_frfs
from app.files.campaigns.loading import load_campaign
from app.files.campaigns.recorded import read_recording
from app.files.results.modes_file import load_frf, load_modes
from tests.app.files.conftest import HAMMER


def test_each_actuator_is_a_campaign(recorded: Path, run_flexura: Callable[..., tuple[int, str, str]]) -> None:
    for actuator, label in (("A1", "S1/A1 [V/V]"), ("hammer", "S1/hammer [V/N]")):
        status, _, message = run_flexura("import", recorded, "--actuator", actuator)
        assert status == 0, message
        campaign = load_campaign(recorded.with_name(f"plate-{actuator}-campaign"))
        assert (len(campaign.sweeps), campaign.experiment.labels()[0]) == (3, label)
    assert [patch.role for patch in campaign.experiment.patch] == ["shorted", "sensor", "sensor"]


def test_both_are_one_campaign(recorded: Path, run_flexura: Callable[..., tuple[int, str, str]]) -> None:
    status, _, message = run_flexura("import", recorded)
    assert status == 0, message
    for folder in (recorded, recorded.with_name("plate-campaign")):
        campaign = load_campaign(folder)
        assert [one.id for one in campaign.experiment.inputs] == ["A1", "hammer"]
        assert sorted(sweep.source for sweep in campaign.sweeps) == [0, 0, 0, 1, 1, 1]
        frf = campaign_frf(campaign)
        assert frf.sources == ("A1", "hammer")
        assert [frf.label(0, k) for k, one in enumerate(frf.driven_by) if one][:1] == ["S1/hammer [V/N]"]
        hammer = frf.of_source(1)
        assert (hammer.label(1), hammer.unit(1)) == ("S2/hammer [V/N]", "V/N")
    chosen = sweeps_of_actuator(frf, "hammer")
    np.testing.assert_array_equal(chosen.h, hammer.h)
    assert chosen.notes[-1] == "modes of the sweeps that hammer drove, of A1, hammer: --actuator ID"
    np.testing.assert_array_equal(sweeps_of_actuator(frf, None).h, frf.of_source(0).h)
    with pytest.raises(ValueError, match="'shaker' drove no sweep; allowed: A1, hammer"):
        sweeps_of_actuator(frf, "shaker")
    alone = campaign_frf(read_recording(recorded, actuator="hammer").campaign)
    np.testing.assert_array_equal(hammer.h, alone.h)
    names = [(one.name, one.reference, one.units) for one in campaign_frfs(campaign.experiment, frf)]
    assert [one[1:] for one in names if "hammer" in one[0]] == [("4:-3", ("V", "N"))] * 6


def test_identifying_one_leaves_the_frfs_of_all_in_the_run(
    recorded: Path, run_flexura: Callable[..., tuple[int, str, str]]
) -> None:
    """Update and gap of the same run folder have sweeps of all, and whoever reads it compares them with these."""
    run = recorded.with_name("run")
    status, _, message = run_flexura("identify", recorded, "--actuator", "hammer", "--out", run)
    assert status == 0, message
    _, frf = load_frf(run / "frf.h5")
    tracked = load_modes(run / "modes.h5")
    assert sorted(frf.driven_by.tolist()) == [0, 0, 0, 1, 1, 1]
    assert len(tracked.temperature) == 3
    np.testing.assert_array_equal(sweeps_of_modes(frf, tracked) >= 0, frf.driven_by == 1)


def test_a_sweep_of_each_that_is_missing_is_told(recorded: Path) -> None:
    gone = sorted((recorded / "sweeps").glob("*.tdms"))[-1]
    gone.unlink()
    with pytest.raises(CampaignFileError, match=r"missing.*1 of the protocol's sweeps: .* N from input 2"):
        read_recording(recorded)


def test_an_actuator_that_drove_nothing_is_told(recorded: Path) -> None:
    declaration = recorded / "campaign.toml"
    text = declaration.read_text(encoding="utf-8")
    declaration.write_text(text + HAMMER.replace("hammer", "shaker"), encoding="utf-8")
    with pytest.raises(CampaignFileError, match=r"shaker drove no sweep.*remove its \[\[drive\]\]"):
        read_recording(recorded, allow_missing=True)


def test_which_one_has_to_be_known(recorded: Path) -> None:
    with pytest.raises(CampaignFileError, match=r"--actuator.*'shaker'.*A1, hammer"):
        read_recording(recorded, actuator="shaker")


def test_a_sweep_that_names_none_is_told(tiny: Any, tmp_path: Path) -> None:
    tiny.toml += HAMMER
    folder = tiny.write(tmp_path / "plate")
    for actuator in ("A1", None):
        with pytest.raises(CampaignFileError, match=r"sweeps/000.*actuator = nothing; allowed: A1 or hammer"):
            read_recording(folder, actuator=actuator)


def test_a_declaration_of_one_stays_as_it_is(tmp_path: Path) -> None:
    table = {"patch": [{"id": "A1", "role": "actuator"}, {"id": "S1", "role": "sensor"}]}
    assert driven_by(tmp_path / "campaign.toml", table, "A1") == table
    assert driven_by(tmp_path / "campaign.toml", table, None) is table


def test_what_an_older_log_notes_as_missing_in_volts_is_not_missed(
    recorded: Path, run_flexura: Callable[..., tuple[int, str, str]]
) -> None:
    sorted((recorded / "sweeps").glob("*.tdms"))[-1].unlink()
    status, _, message = run_flexura("import", recorded, "--allow-missing")
    assert status == 0, message
    folder = recorded.with_name("plate-campaign")
    log = folder / "events.jsonl"
    told = log.read_text(encoding="utf-8")
    assert " N from input 2" in told
    log.write_text(told.replace(" N from input 2", " V from input 2"), encoding="utf-8")
    assert len(load_campaign(folder).sweeps) == 5
    log.write_text("", encoding="utf-8")
    with pytest.raises(CampaignFileError, match=" N from input 2"):
        load_campaign(folder)
