"""Raw sweeps of a campaign, read back by others: nptdms and our own import, scipy, plain text."""

import csv
import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import pyuff
from scipy.io import loadmat

from app.files.campaigns.folder import digest
from app.files.campaigns.loading import load_campaign
from app.files.measurements.guarded import read_columns

Flexura = Callable[..., tuple[int, str, str]]


@pytest.fixture
def campaign(tiny: Any, tmp_path: Path) -> Path:
    return Path(tiny.write(tmp_path / "tiny"))


def test_tdms_is_a_recorded_campaign_again(campaign: Path, run_flexura: Flexura) -> None:
    out = campaign.with_name("out")
    status, said, err = run_flexura("export", campaign, "--to", "tdms", "--out", out, "--json")
    assert status == 0, err
    assert json.loads(said)["sweeps"] == 6
    before, after = load_campaign(campaign), load_campaign(out)
    assert after.experiment == before.experiment
    assert [digest(sweep) for sweep in after.sweeps] == [digest(sweep) for sweep in before.sweeps]
    assert run_flexura("import", out, "--out", campaign.with_name("imported"), "-q")[0] == 0
    status, _, err = run_flexura("export", campaign, "--to", "tdms", "--out", out)
    assert status == 2
    assert "campaign.toml: is there already; name another folder with --out" in err


def test_mat_and_its_table(campaign: Path, run_flexura: Flexura) -> None:
    assert run_flexura("export", campaign, "--to", "mat", "-q") == (0, "", "")
    folder, sweeps = campaign.with_name("tiny-mat"), load_campaign(campaign).sweeps
    with (folder / "sweeps.csv").open(encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert [(int(row["step"]), row["direction"]) for row in rows] == [(s.step, s.direction) for s in sweeps]
    for row, sweep in zip(rows, sweeps, strict=True):
        found = loadmat(folder / row["file"], squeeze_me=True)
        np.testing.assert_array_equal(found["drive"], sweep.drive)
        np.testing.assert_array_equal(found["responses"], sweep.responses)
        assert found["sample_rate"] == pytest.approx(51_200.0 / 6)
        assert found["channels"].tolist() == ["drive", "S1", "S2"]
        assert (found["oven_temperature_start"], str(found["start_time"])) == (
            sweep.oven_temperature_start,
            sweep.start_time,
        )


def test_csv_holds_every_digit(campaign: Path, run_flexura: Flexura) -> None:
    assert run_flexura("export", campaign, "--to", "csv", "-q") == (0, "", "")
    folder, sweep = campaign.with_name("tiny-csv"), load_campaign(campaign).sweeps[2]
    (file,) = folder.glob("0002_up_*.csv")
    heads = file.read_text(encoding="utf-8").splitlines()[0].split(",")
    assert heads == ["time [s]", *(f"{name} {n} [V]" for n in (1, 2) for name in ("drive", "S1", "S2"))]
    values = np.loadtxt(file, delimiter=",", skiprows=1)
    np.testing.assert_allclose(np.diff(values[:, 0]), 6.0 / 51_200.0, rtol=1e-6)
    np.testing.assert_array_equal(values[:, 1].astype(np.float32), sweep.drive[0])
    np.testing.assert_array_equal(values[:, 6].astype(np.float32), sweep.responses[1, 1])


def test_universal_files_hold_signals_that_others_read(campaign: Path, run_flexura: Flexura) -> None:
    """Read by pyuff, and by our reader of any laboratory's files: each repeat is a group of the same channels."""
    assert run_flexura("export", campaign, "--to", "uff", "-q") == (0, "", "")
    folder, loaded = campaign.with_name("tiny-uff"), load_campaign(campaign)
    sweep = loaded.sweeps[2]
    (file,) = folder.glob("0002_up_*.uff")
    theirs = pyuff.UFF(str(file))
    kinds = np.asarray(theirs.get_set_types()).astype(int).tolist()
    assert kinds[:2] == [151, 164]
    assert kinds.count(58) == 6
    last = theirs.read_sets(len(kinds) - 1)
    assert (last["func_type"], last["id1"].strip(), last["rsp_node"]) == (1, "S2", 2)
    assert last["abscissa_inc"] == pytest.approx(6.0 / 51_200.0, rel=1e-9)
    np.testing.assert_allclose(last["data"], sweep.responses[1, 1], rtol=1e-12)
    ours = read_columns(file)
    assert ours.groups == ("run 1", "run 2")
    drive = next(iter(ours.of_group("run 2").values.values()))
    np.testing.assert_allclose(drive, sweep.drive[1], rtol=1e-12)
    assert set(ours.units.values()) == {"V"}
    np.testing.assert_allclose(list(ours.rates.values()), 51_200.0 / 6, rtol=1e-9)
    assert (folder / "sweeps.csv").is_file()


def test_an_imported_campaign_and_one_without_sweeps(campaign: Path, run_flexura: Flexura) -> None:
    imported = campaign.with_name("imported")
    assert run_flexura("import", campaign, "--out", imported, "-q")[0] == 0
    assert run_flexura("export", imported, "--to", "tdms", "--out", campaign.with_name("again"), "-q")[0] == 0
    assert [digest(s) for s in load_campaign(campaign.with_name("again")).sweeps] == [
        digest(s) for s in load_campaign(campaign).sweeps
    ]


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("--to", "c"), "--to c is for filters; sweeps of a campaign: tdms, mat, csv, uff"),
        (("--to", "mat", "--temperature", "20"), "--temperature is for filters"),
        (("--to", "csv", "--number", "int16"), "--number is for filters"),
    ],
)
def test_options_of_filters_are_refused(
    campaign: Path, run_flexura: Flexura, words: tuple[str, ...], message: str
) -> None:
    status, _, err = run_flexura("export", campaign, *words)
    assert status == 2
    assert message in err


def test_a_run_has_no_sweeps(tmp_path: Path, run_flexura: Flexura) -> None:
    status, _, err = run_flexura("export", tmp_path, "--to", "tdms")
    assert status == 2
    assert "--to tdms is for the sweeps of a campaign" in err
    hits = tmp_path / "hits of a day"
    hits.mkdir()
    (hits / "hammer.json").write_text("{}")
    for form in ("uff", "csv"):
        status, _, err = run_flexura("export", hits, "--to", form)
        assert status == 2
        assert "is a hammer test, with neither filters nor sweeps" in err
        assert f"flexura identify '{hits}'" in " ".join(err.split())


def test_of_the_run_of_a_modal_test_the_files_for_other_programs_are_named(
    tmp_path: Path, run_flexura: Flexura
) -> None:
    """It was said to hold filters."""
    for name in ("transfers.h5", "frfs.uff", "modes.csv"):
        (tmp_path / name).write_text("")
    for form in ("uff", "mat", "csv"):
        status, _, err = run_flexura("export", tmp_path, "--to", form)
        assert status == 2
        assert "is the run of a modal test, with neither filters nor sweeps" in " ".join(err.split())
        assert "lie there: frfs.uff, modes.csv" in " ".join(err.split())


def test_a_sensor_on_the_plate_is_read_back(tiny: Any, tmp_path: Path, run_flexura: Flexura) -> None:
    """The air is ahead of the plate by more than half a step: the plate's temperature counts."""
    for content in tiny.files.values():
        air = content.properties["oven_temperature_start"]
        content.properties |= {"plate_temperature_start": air - 0.5, "plate_temperature_end": air - 0.4}
        ahead = 6.0 if content.properties["direction"] == "up" else -6.0
        content.properties["oven_temperature_start"] = air + ahead
        content.properties["oven_temperature_end"] = air + ahead
    recorded, out = tiny.write(tmp_path / "tiny"), tmp_path / "out"
    before = load_campaign(recorded)
    assert before.sweeps[0].plate_temperature_start == pytest.approx(9.47)
    assert run_flexura("export", recorded, "--to", "tdms", "--out", out, "-q") == (0, "", "")
    assert [digest(s) for s in load_campaign(out).sweeps] == [digest(s) for s in before.sweeps]
    first = next(iter(tiny.files.values()))
    del first.properties["plate_temperature_end"]
    status, _, err = run_flexura("import", tiny.write(tmp_path / "half"), "--out", tmp_path / "none")
    assert status == 2
    assert "plate_temperature_end = nothing" in err or "plate_temperature_end: nothing" in err
