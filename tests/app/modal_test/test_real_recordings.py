"""Recordings of public projects, from file to what is published of them, with ``flexura new test`` between."""

import json
import shutil
from collections.abc import Callable
from pathlib import Path

import pytest

from app.files.bad_file import ResultFileError
from app.files.measurements.guarded import read_columns

Flexura = Callable[..., tuple[int, str, str]]
REAL = Path(__file__).resolve().parents[4] / "shared" / "data" / "real"
MODES = (76.0, 126.0, 213.8, 262.5, 346.3, 447.9)
"""Hz, found in every record of the thin plate; the first moves with the level, 75.5 to 77.6 Hz."""
RECORDS = ("0", "0_02", "0_03", "0_04", "1")

pytestmark = [
    pytest.mark.shared,
    pytest.mark.skipif(not REAL.is_dir(), reason="the measured data lie beside the checkout, and are absent"),
]


def declared(folder: Path, run_flexura: Flexura, *records: str) -> Path:
    folder.mkdir()
    names = [f"view_{record}.npz" for record in records]
    for name in names:
        shutil.copy(REAL / "plate_sweep_shaker" / name, folder)
    files = [folder / name for name in names]
    status, _, said = run_flexura("new", "test", *files, "--drive", "force=N", "--response", "acc=m/s2", "-q")
    assert status == 0, said
    return folder / "test.toml"


@pytest.mark.slow
@pytest.mark.parametrize("record", RECORDS)
def test_every_sweep_of_a_shaker_shows_the_modes_of_the_plate(
    record: str, tmp_path: Path, run_flexura: Flexura
) -> None:
    file = declared(tmp_path / "sweep", run_flexura, record)
    status, out, said = run_flexura("identify", file, "--band", 65, 480, "--json", "-q")
    assert status == 0, said
    found = [one["frequency_hz"] for one in json.loads(out)["modes"]]
    for mode in MODES:
        assert min(abs(one - mode) for one in found) < (0.025 if mode == MODES[0] else 0.012) * mode, (mode, found)


@pytest.mark.slow
def test_sweeps_of_several_levels_in_one_frf_are_noted(tmp_path: Path, run_flexura: Flexura) -> None:
    """The mode at 76 Hz moves by seven deviations from 2.5 to 5 N: an average of all hides it."""
    file = declared(tmp_path / "sweeps", run_flexura, *RECORDS)
    _, out, said = run_flexura("identify", file, "--band", 65, 480, "--json", "-q")
    notes = " ".join([*json.loads(out)["notes"], said])
    assert "not linear" in notes


def test_a_field_recorder_s_files_are_read_in_their_units_and_without_a_drive_refused(
    tmp_path: Path, run_flexura: Flexura
) -> None:
    recorder = REAL / "tdms_field_recorder"
    read = read_columns(recorder / "good_tdms_1.tdms")
    accelerations = [name for name, unit in read.units.items() if unit == "g"]
    assert len(accelerations) == 8
    assert {round(read.rates[name], 6) for name in accelerations} == {30.0}
    assert {len(read.values[name]) for name in accelerations} == {18000}
    other = read_columns(recorder / "good_tdms_2.tdms")
    assert len({len(values) for values in other.values.values()}) > 1
    for name in ("good_tdms_1.tdms", "good_tdms_2.tdms"):
        shutil.copy(recorder / name, tmp_path)
        status, _, said = run_flexura("new", "test", tmp_path / name, "-q")
        assert status == 2
        assert "drive" in said
        assert "Traceback" not in said
    with pytest.raises(ResultFileError, match="faulty_tdms_01"):
        read_columns(recorder / "faulty_tdms_01.tdms")
