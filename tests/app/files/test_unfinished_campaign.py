"""Campaigns that are running, interrupted, ended with sweeps missing, or not complete as a recorder left them."""

import os
import shutil
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest

from analysis.recordings.campaign import Campaign, CampaignExtent, Sweep
from analysis.recordings.frf import campaign_frf
from app.files.acquisition.events import append_event
from app.files.atomic import atomic_hdf5
from app.files.bad_file import ResultFileError
from app.files.campaign_error import CampaignFileError
from app.files.campaigns import folder as campaign_folder
from app.files.campaigns.folder import Source, frozen_protocol, write_protocol, write_sweep
from app.files.campaigns.import_recording import import_joined
from app.files.campaigns.inputs import campaign_settings, has_other_sweeps, origin_of_result, said_of_more_sweeps
from app.files.campaigns.loading import load_campaign
from app.files.declarations.experiment import read_acquired_experiment
from app.files.folder_lock import folder_lock, is_being_written
from app.files.provenance import provenance, sha256, stamp

EXAMPLE = Path(__file__).resolve().parents[3] / "examples" / "simulated-rig.toml"
ASKED = 7
"""Sweeps of the example: every 10 °C from 0 to 60."""


def sweep(step: int) -> Sweep:
    rng = np.random.default_rng(step)
    drive, response = rng.standard_normal((2, 3, 8533)).astype(np.float32)
    at = 10.0 * step
    return Sweep(step, "up", 1.0, at + 1.0, at + 1.2, "2000-01-01T00:00:00+00:00", drive, response[None], at, at)


def keep(folder: Path, *steps: int) -> Path:
    for step in steps:
        name = f"{step:04d}_up_T{10.0 * step:+06.1f}.h5"
        write_sweep(folder / "sweeps" / name, sweep(step), ("S1",), Source("mine.toml", "0" * 64))
    return folder


@pytest.fixture
def begun(tmp_path: Path) -> Callable[..., Path]:
    """Return a function that makes the folder of the example's campaign with some of its sweeps."""

    def make(*steps: int, name: str = "campaign") -> Path:
        experiment = read_acquired_experiment(EXAMPLE)
        acquired = experiment.model_dump(mode="json")
        folder = tmp_path / name
        (folder / "sweeps").mkdir(parents=True)
        recorded = experiment.recorded(8533.0)
        write_protocol(folder, frozen_protocol("campaign", recorded, {"mine.toml": "0" * 64}, acquired))
        return keep(folder, *steps)

    return make


def give_up(folder: Path, *steps: int) -> None:
    for step in steps:
        date, place = "2000-01-01T00:00:00+00:00", f"{10 * step} °C up 1 V"
        append_event(folder, {"event": "missing", "date": date, "step": step, "place": place})


def extent(folder: Path) -> CampaignExtent | None:
    return load_campaign(folder).extent


def test_an_interrupted_campaign_gives_its_finished_sweeps(begun: Callable[..., Path]) -> None:
    folder = begun(0, 1, 2)
    (folder / "sweeps" / "0003_up_T+030.0.h5.part").write_bytes(b"half a sweep")
    campaign = load_campaign(folder)
    assert [one.step for one in campaign.sweeps] == [0, 1, 2]
    assert campaign.extent == CampaignExtent("interrupted", 3, ASKED, 0, 0.0, 20.0)
    assert "interrupted, 3 of 7 sweeps, 0 to 20 °C" in repr(campaign)
    assert any("interrupted, 3 of 7 sweeps, 0 to 20 °C" in note for note in campaign_frf(campaign).notes)


def test_a_campaign_under_a_writer_s_lock_is_running(begun: Callable[..., Path]) -> None:
    folder = begun(0)
    with folder_lock(folder):
        found = extent(folder)
        assert found is not None
        assert found.state == "running"
    found = extent(folder)
    assert found is not None
    assert found.state == "interrupted"


def test_a_lock_file_that_a_kill_left_behind_is_no_writer(begun: Callable[..., Path]) -> None:
    folder = begun(0)
    folder.with_name("campaign.lock").touch()
    assert not is_being_written(folder)
    with folder_lock(folder):  # and whoever looked keeps no lock
        assert is_being_written(folder)


def test_sweeps_given_up_are_not_waited_for(begun: Callable[..., Path]) -> None:
    folder = begun(*range(5))
    give_up(folder, 5)
    found = extent(folder)
    assert found is not None
    assert found.said == "interrupted, 5 of 7 sweeps (1 given up), 0 to 40 °C"
    give_up(folder, 6)
    with folder_lock(folder):  # the oven goes to rest: nothing more will come
        found = extent(folder)
    assert found is not None
    assert found.said == "ended with sweeps missing, 5 of 7 sweeps, 0 to 40 °C"


def test_a_whole_campaign_has_nothing_to_say(begun: Callable[..., Path]) -> None:
    campaign = load_campaign(begun(*range(ASKED)))
    assert campaign.extent is None
    assert campaign_settings(campaign) == {"campaign": "campaign"}
    assert not any("complete" in note for note in campaign_frf(campaign).notes)


def test_without_a_finished_sweep_it_is_said_in_one_sentence(begun: Callable[..., Path]) -> None:
    folder = begun()
    with pytest.raises(
        CampaignFileError, match=r"no sweep is finished yet, of 7: continue .* flexura acquire"
    ) as e:
        load_campaign(folder)
    assert "\n" not in str(e.value)
    with folder_lock(folder), pytest.raises(CampaignFileError, match="acquire is recording the first; try again"):
        load_campaign(folder)
    give_up(folder, *range(ASKED))
    with pytest.raises(CampaignFileError, match=r"all 7 were given up .* --again"):
        load_campaign(folder)


def test_a_folder_whose_sweeps_are_not_there_yet_is_no_traceback(begun: Callable[..., Path]) -> None:
    folder = begun()
    (folder / "sweeps").rmdir()
    with pytest.raises(CampaignFileError, match="no sweep is finished yet"):
        load_campaign(folder)


def test_a_damaged_sweep_is_not_left_out_and_the_others_are_not_to_be_deleted(begun: Callable[..., Path]) -> None:
    folder = begun(0, 1)
    path = folder / "sweeps" / "0001_up_T+010.0.h5"
    damaged = bytearray(path.read_bytes())
    damaged[-200] ^= 0xFF
    path.write_bytes(bytes(damaged))
    with pytest.raises(CampaignFileError, match="flexura acquire measures it again") as told:
        load_campaign(folder)
    assert "delete" not in str(told.value)


def test_a_sweep_that_is_finished_meanwhile_belongs_to_the_next_reading(
    begun: Callable[..., Path], monkeypatch: pytest.MonkeyPatch
) -> None:
    folder = begun(0, 1)
    read = campaign_folder.read_sweep_file

    def read_while_it_grows(path: Path, name: str) -> Any:
        keep(folder, 2 if path.name.startswith("0000") else 3)
        return read(path, name)

    monkeypatch.setattr(campaign_folder, "read_sweep_file", read_while_it_grows)
    campaign = load_campaign(folder)
    monkeypatch.undo()
    assert [one.step for one in campaign.sweeps] == [0, 1]
    names = [name for name in campaign.hashes if name.startswith("sweeps/")]
    assert names == ["sweeps/0000_up_T+000.0.h5", "sweeps/0001_up_T+010.0.h5"]
    assert all(campaign.hashes[name] == sha256(folder / name) for name in names)
    assert campaign.extent is not None
    assert campaign.extent.sweeps == 2
    assert len(load_campaign(folder).sweeps) == 4


@pytest.mark.parametrize("what", ["replaced", "moved"])
def test_a_file_that_is_not_the_one_read_is_never_vouched_for(
    begun: Callable[..., Path], monkeypatch: pytest.MonkeyPatch, what: str
) -> None:
    folder = begun(0, 1)
    other = begun(0, 1, name="other") / "sweeps" / "0001_up_T+010.0.h5"
    read = campaign_folder.read_sweep_file

    def read_then_lose(path: Path, name: str) -> Any:
        found = read(path, name)
        if path.name.startswith("0001"):
            path.unlink()
            if what == "replaced":
                os.replace(other, path)  # noqa: PTH105 (a rename over the name, as people's programs do it)
        return found

    monkeypatch.setattr(campaign_folder, "read_sweep_file", read_then_lose)
    with pytest.raises(
        CampaignFileError, match=r"0001_up_T\+010.0.h5: changed while it was read.*do the same again"
    ):
        load_campaign(folder)


def result(path: Path, campaign: Campaign) -> Path:
    path.parent.mkdir(exist_ok=True)
    with atomic_hdf5(path) as file:
        stamp(file, provenance(campaign.hashes, campaign_settings(campaign)))
    return path


def test_a_result_keeps_of_how_many_sweeps_it_is(begun: Callable[..., Path], tmp_path: Path) -> None:
    campaign = load_campaign(begun(0, 1, 2))
    origin = origin_of_result(result(tmp_path / "laws.h5", campaign), "update")
    assert origin.extent == campaign.extent
    assert origin.inputs == campaign.hashes
    with atomic_hdf5(tmp_path / "broken.h5") as file:
        stamp(file, provenance({}, {"extent": {"state": "interrupted"}}))
    with pytest.raises(ResultFileError, match=r"broken\.h5: not a readable"):
        origin_of_result(tmp_path / "broken.h5", "update")


def test_results_of_fewer_sweeps_are_known_by_their_hashes(begun: Callable[..., Path], tmp_path: Path) -> None:
    folder, run = begun(0, 1, 2), tmp_path / "campaign-run"
    before = load_campaign(folder)
    origin = origin_of_result(result(run / "laws.h5", before), "update")
    assert said_of_more_sweeps(run, origin.inputs, "update") is None
    keep(folder, 3)
    assert has_other_sweeps(origin.inputs, load_campaign(folder).hashes)
    said = said_of_more_sweeps(run, origin.inputs, "update")
    assert said == (
        "made from 3 sweeps of a campaign that has 4 finished ones now; "
        f"to take them in: flexura update {folder.resolve()}"
    )
    elsewhere = tmp_path / "elsewhere"
    assert f"{folder.resolve()} --out {elsewhere}" in str(said_of_more_sweeps(elsewhere, origin.inputs, "update"))


def test_a_sweep_measured_again_makes_results_old(begun: Callable[..., Path], tmp_path: Path) -> None:
    folder = begun(0, 1)
    before, run = load_campaign(folder), tmp_path / "campaign-run"
    path = folder / "sweeps" / "0001_up_T+010.0.h5"
    path.unlink()
    write_sweep(path, replace(sweep(1), drive=2.0 * sweep(1).drive), ("S1",), Source("mine.toml", "0" * 64))
    assert has_other_sweeps(before.hashes, load_campaign(folder).hashes)
    assert "2 finished ones now, others" in str(said_of_more_sweeps(run, before.hashes, "identify"))


def test_a_copy_that_went_another_way_is_not_the_campaign_of_a_run(
    begun: Callable[..., Path], tmp_path: Path
) -> None:
    folder = begun(0, 1)
    inputs = load_campaign(folder).hashes
    copy = shutil.copytree(folder, tmp_path / "a-copy")
    (copy / "sweeps" / "0001_up_T+010.0.h5").unlink()
    assert said_of_more_sweeps(tmp_path / "campaign-run", inputs, "update") is None
    assert said_of_more_sweeps(tmp_path / "another-run", inputs, "update") is None
    keep(copy, 1, 2)
    assert said_of_more_sweeps(tmp_path / "campaign-run", inputs, "update") is None


def test_another_campaign_s_results_are_not_taken_for_fewer_sweeps(begun: Callable[..., Path]) -> None:
    hashes = load_campaign(begun(0, 1)).hashes
    other = hashes | {"protocol.json": "0" * 64}
    assert not has_other_sweeps(other, hashes)
    assert not has_other_sweeps({}, hashes)
    assert not has_other_sweeps(hashes, dict(hashes))


def test_a_recorder_s_campaign_is_read_as_far_as_it_is_there(tiny: Any, tmp_path: Path) -> None:
    del tiny.files[next(name for name in tiny.files if "0001" in name or "1" in name)]
    found = load_campaign(tiny.write(tmp_path / "plate"))
    assert found.extent is not None
    assert found.extent.state == "incomplete"
    assert (found.extent.sweeps, found.extent.asked) == (5, 6)


def test_joined_campaigns_take_those_that_are_not_complete_and_later_the_rest(
    begun_by: Callable[..., Path], tmp_path: Path
) -> None:
    first, second = begun_by("A1", 0, 1), begun_by("A2", 0)
    out = tmp_path / "both"
    imported = import_joined([first, second], out)
    assert (imported.state, len(imported.recording.campaign.sweeps), len(imported.recording.missing)) == (
        "imported",
        3,
        2 * ASKED - 3,
    )
    found = extent(out)
    assert found is not None
    assert found.said == "ended with sweeps missing, 3 of 14 sweeps, 0 to 10 °C"
    assert import_joined([first, second], out).state == "unchanged"
    keep(first, 2)
    keep(second, 1)
    assert import_joined([first, second], out).state == "renewed"
    again = load_campaign(out)
    assert len(again.sweeps) == 5
    fresh = tmp_path / "fresh"
    import_joined([first, second], fresh)
    assert again.hashes == load_campaign(fresh).hashes
    assert not list(tmp_path.glob("*.part"))
    (first / "sweeps" / "0002_up_T+020.0.h5").unlink()
    with pytest.raises(CampaignFileError, match="imported from other files"):  # nothing that was imported is lost
        import_joined([first, second], out)
    assert load_campaign(out).hashes == again.hashes


@pytest.fixture
def begun_by(tmp_path: Path) -> Callable[..., Path]:
    """Return a function that makes a campaign of the example's plate with two patches, of which one drives."""

    def make(driven: str, *steps: int) -> Path:
        experiment = read_acquired_experiment(EXAMPLE)
        patches = [patch.model_dump(mode="json") for patch in experiment.patch]
        patches.append(
            {"id": "A2", "role": "actuator", "center": [0.05, 0.15], "size": [0.02, 0.02], "thickness": 5e-4}
        )
        for patch in patches:
            if patch["role"] == "actuator":
                patch["role"] = "actuator" if patch["id"] == driven else "shorted"
        recorded = experiment.recorded(8533.0)
        declared = type(recorded).model_validate(recorded.model_dump(mode="json") | {"patch": patches})
        folder = tmp_path / driven
        (folder / "sweeps").mkdir(parents=True)
        acquired = experiment.model_dump(mode="json")
        write_protocol(folder, frozen_protocol(driven, declared, {"mine.toml": "0" * 64}, acquired))
        return keep(folder, *steps)

    return make


def test_the_samples_read_are_those_of_the_file(begun: Callable[..., Path]) -> None:
    folder = begun(0)
    with h5py.File(folder / "sweeps" / "0000_up_T+000.0.h5") as file:
        np.testing.assert_array_equal(load_campaign(folder).sweeps[0].responses, file["responses"][()])
