"""Files cut short, empty or of another ending: refused in a sentence with the next step, never read in part."""

import shutil
import struct
import zipfile
from pathlib import Path

import numpy as np
import pytest
from nptdms import ChannelObject, TdmsWriter
from scipy.io import savemat, wavfile

from app.files.bad_file import ResultFileError
from app.files.measurements.formats import FORMATS
from app.files.measurements.guarded import read_columns, read_each

SIGNAL = np.sin(np.arange(1000.0))


def refused(path: Path) -> str:
    with pytest.raises(ResultFileError) as told:
        read_columns(path)
    assert str(told.value).startswith(f"{path}: ")
    assert "\n" not in str(told.value)
    return str(told.value)


def sound(folder: Path) -> Path:
    wavfile.write(folder / "a.wav", 1000, np.round(3e4 * np.column_stack([SIGNAL, SIGNAL])).astype("i2"))
    return folder / "a.wav"


@pytest.mark.parametrize("left", [400, 403, 60, 30])
def test_a_sound_file_cut_short_is_not_read_in_part(tmp_path: Path, left: int) -> None:
    path = sound(tmp_path)
    path.write_bytes(path.read_bytes()[:left])
    assert "cut short" in refused(path)


@pytest.mark.parametrize("declared", [0xFFFFFFFF, 0x7FFFFFDA])
def test_a_size_that_a_recorder_did_not_know_is_no_damage(tmp_path: Path, declared: int) -> None:
    path = sound(tmp_path)
    content = bytearray(path.read_bytes())
    content[40:44] = struct.pack("<I", declared)
    path.write_bytes(content)
    assert len(read_columns(path).values["2"]) == 1000


def test_a_tdms_file_whose_last_segment_was_cut_is_not_read_in_part(tmp_path: Path) -> None:
    with TdmsWriter(tmp_path / "a.tdms") as writer:
        for _ in range(3):
            writer.write_segment([ChannelObject("Log", "Acc", SIGNAL)])
    path = tmp_path / "a.tdms"
    path.write_bytes(path.read_bytes()[:-2000])
    assert "its last segment is cut short; copy it again" in refused(path)


@pytest.mark.parametrize("ending", [one.endings[0] for one in FORMATS])
def test_an_empty_file_and_a_folder_are_called_that(tmp_path: Path, ending: str) -> None:
    (tmp_path / f"a{ending}").touch()
    assert "an empty file; export or copy it again" in refused(tmp_path / f"a{ending}")
    (tmp_path / f"b{ending}").mkdir()
    assert "a folder; name the files in it" in refused(tmp_path / f"b{ending}")


@pytest.mark.parametrize("wrong", [".csv", ".mat", ".tdms", ".uff", ".lvm", ".wav"])
def test_the_right_ending_is_named(tmp_path: Path, wrong: str) -> None:
    np.savez(tmp_path / "a.npz", y=SIGNAL)
    shutil.copy(tmp_path / "a.npz", tmp_path / f"a{wrong}")
    assert "begins as a .npz file does; give it that ending" in refused(tmp_path / f"a{wrong}")


def test_a_spreadsheet_is_no_archive_of_numpy(tmp_path: Path) -> None:
    with zipfile.ZipFile(tmp_path / "a.xlsx", "w") as archive:
        archive.writestr("[Content_Types].xml", "<Types/>")
    assert "cannot be read as an EXCEL file" in refused(tmp_path / "a.xlsx")


def test_what_libraries_say_is_completed_by_the_next_step(tmp_path: Path) -> None:
    savemat(tmp_path / "a.mat", {"y": SIGNAL})
    np.savez(tmp_path / "a.npz", y=SIGNAL)
    for name in ("a.mat", "a.npz"):
        path = tmp_path / name
        path.write_bytes(path.read_bytes()[:3000])
        told = refused(path)
        assert f"cannot be read as a {name[2:].upper()} file (" in told
        assert "cut short or damaged? export or copy it again" in told


def test_an_archive_that_declares_more_than_there_is_is_refused(tmp_path: Path) -> None:
    header = np.lib.format.magic(1, 0)
    text = f"{{'descr': '<f8', 'fortran_order': False, 'shape': ({10**12},), }}\n".encode()
    with zipfile.ZipFile(tmp_path / "a.npz", "w") as archive:
        archive.writestr("y.npy", header + struct.pack("<H", len(text)) + text + b"\0" * 1000)
    refused(tmp_path / "a.npz")


def test_many_small_files_are_read_in_order_and_the_damaged_one_is_named(tmp_path: Path) -> None:
    """A few processes for all of them; what stands before the damaged one is read."""
    paths = [tmp_path / f"{number}.csv" for number in range(130)]
    for number, path in enumerate(paths):
        path.write_text("Time,Acc\n" + f"{number},1\n" * 20, encoding="utf-8")
    assert [columns.values["Time"][0] for columns in read_each(paths)] == list(range(130))
    paths[7].write_text("nothing\n", encoding="utf-8")
    each = read_each(paths)
    assert [next(each).values["Time"][0] for _ in range(7)] == list(range(7))
    with pytest.raises(ResultFileError, match=r"7\.csv: no table of numbers"):
        next(each)
    (tmp_path / "8.csv").unlink()
    with pytest.raises(ResultFileError, match=r"8\.csv: no such file"):
        next(read_each(paths[8:]))
