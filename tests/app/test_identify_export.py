"""FRFs of a campaign as a universal file, and what of it is one structure."""

import shutil
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from analysis.estimation.transfer import MeasuredTransfer
from app.files.uff.frfs import read_frfs, write_frfs
from app.modal_test.modes_of_test import load_test

Run = Callable[..., tuple[int, str, str]]
FREQUENCY = np.arange(50.0, 250.0, 0.5)
POINTS = {1: (0.05, 0.1, 0.0), 2: (0.1, 0.2, 0.0), 3: (0.02, 0.03, 0.01)}


def transfers() -> list[MeasuredTransfer]:
    """Two points of a plate with a mode at 130 Hz, and 0.1 % of noise."""
    rng, s = np.random.default_rng(4), 2j * np.pi * FREQUENCY
    h = s / (s**2 + 20.0 * s + (2 * np.pi * 130.0) ** 2)
    noise = 1e-3 * np.abs(h).max() * (rng.normal(size=(2, len(h))) + 1j * rng.normal(size=(2, len(h))))
    return [
        MeasuredTransfer(
            f"p{n}", f"{n}:+3", "3:+3", "velocity", FREQUENCY, n * h + noise[n - 1], units=("m/s", "N")
        )
        for n in (1, 2)
    ]


@pytest.fixture
def campaign(tiny: Any, tmp_path: Path) -> Path:
    folder: Path = tiny.write(tmp_path / "plate")
    return folder


def test_several_sweeps_are_no_structure(campaign: Path, tmp_path: Path, run_flexura: Run) -> None:
    words = ("identify", campaign, "--method", "peak-picking", "--out", tmp_path / "run", "--export")
    _, _, said = run_flexura(*words, tmp_path / "all.uff")
    assert "FRFs of 6 sweeps" in said
    assert "--temperature" in said
    status, _, said = run_flexura("identify", tmp_path / "all.uff", "--shared-poles")
    assert status == 2
    for part in ("all.uff: node 1:+0 answers node 3:+0 more than once", "C up 1 V", "--temperature 20"):
        assert part in said


def test_a_coherence_has_no_unit_in_pyuff(campaign: Path, tmp_path: Path, run_flexura: Run) -> None:
    """Its denominator was that of the FRF."""
    import pyuff

    file = tmp_path / "all.uff"
    run_flexura("identify", campaign, "--method", "peak-picking", "--out", tmp_path / "run", "--export", file)
    sets = [one for one in pyuff.UFF(str(file)).read_sets() if one["type"] == 58]
    of_frf, of_coherence = ([one for one in sets if one["func_type"] == kind] for kind in (4, 6))
    assert len(of_frf) == len(of_coherence) == 12
    assert {(one["ordinate_axis_units_lab"], one["orddenom_axis_units_lab"]) for one in of_frf} == {("V", "V")}
    for end in ("ordinate", "orddenom"):
        assert {(one[f"{end}_axis_units_lab"], one[f"{end}_spec_data_type"]) for one in of_coherence} == {
            ("NONE", 0)
        }
    np.testing.assert_array_equal([len(one["data"]) for one in sets], len(sets[0]["data"]))


def test_the_sweep_nearest_to_a_temperature_is_one(campaign: Path, tmp_path: Path, run_flexura: Run) -> None:
    words = ("identify", campaign, "--method", "peak-picking", "--out", tmp_path / "run", "--export")
    _, _, said = run_flexura(*words, tmp_path / "one.uff", "--temperature", "23")
    assert "one.uff: FRFs of the sweep 19.99 C up 1 V" in said
    assert [one.name for one in read_frfs(tmp_path / "one.uff")] == [
        "S1/A1 [V/V] 19.99 C up 1 V",
        "S2/A1 [V/V] 19.99 C up 1 V",
    ]
    shutil.rmtree(tmp_path / "run")
    status, _, said = run_flexura(*words, tmp_path / "none.uff", "--temperature", "300")
    assert status == 2
    assert "--temperature 300 °C; the sweeps are from 10.00 to 29.99 °C" in said
    assert not (tmp_path / "none.uff").exists()
    status, _, said = run_flexura("identify", campaign, "--temperature", "20")
    assert status == 2
    assert "add --export" in said


def test_a_campaign_s_band_is_checked_before_anything(campaign: Path, run_flexura: Run) -> None:
    """There were warnings of numpy's, and a message without band or range."""
    status, _, said = run_flexura("identify", campaign, "--band", "1600", "1700")
    assert status == 2
    assert "plate: --band 1600 1700: 0 frequency lines; at least 8 are needed. Allowed: within 100 to 1500" in said


def test_nodes_go_with_the_frfs_into_the_run_folder(tmp_path: Path, run_flexura: Run) -> None:
    write_frfs(tmp_path / "a.uff", transfers(), POINTS)
    run = tmp_path / "run"
    status, _, said = run_flexura("identify", tmp_path / "a.uff", "--shared-poles", "--out", run)
    assert status == 0, said
    assert dict(load_test(run)[0].points) == POINTS
    status, _, said = run_flexura("identify", run / "frfs.uff", "--shared-poles", "--out", tmp_path / "again")
    assert status == 0, said
    assert dict(load_test(tmp_path / "again")[0].points) == POINTS


def test_ends_that_are_not_named_are_no_copies(tmp_path: Path, run_flexura: Run) -> None:
    """Programs that know no nodes write 0."""
    write_frfs(tmp_path / "a.uff", [replace(one, response="0:+0", reference="0:+0") for one in transfers()])
    status, _, said = run_flexura("identify", tmp_path / "a.uff", "--shared-poles", "--out", tmp_path / "run")
    assert status == 0, said


def test_a_node_that_is_nowhere_is_refused(tmp_path: Path, run_flexura: Run) -> None:
    write_frfs(tmp_path / "a.uff", transfers(), POINTS | {2: (float("nan"), 0.0, 0.0)})
    status, _, said = run_flexura("identify", tmp_path / "a.uff", "--shared-poles", "--out", tmp_path / "run")
    assert status == 2
    assert "a.uff: node 2 is at (nan, 0.0, 0.0)" in said
