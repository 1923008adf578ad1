"""Excel's workbooks and MDF files, written by their own libraries and read; what is refused, and why."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from app.files.bad_file import ResultFileError
from app.files.measurements import excel, mdf
from app.files.measurements.guarded import read_columns

openpyxl = pytest.importorskip("openpyxl")
asammdf = pytest.importorskip("asammdf")

RATE = 1024.0
T = np.arange(300) / RATE
FORCE = np.exp(-(((T - 0.02) / 0.002) ** 2))
ACC = np.sin(2 * np.pi * 50 * T)


def book(path: Path, sheets: dict[str, list[list[Any]]]) -> Path:
    made = openpyxl.Workbook()
    made.remove(made.active)
    for title, rows in sheets.items():
        sheet = made.create_sheet(title)
        for row in rows:
            sheet.append(row)
    made.save(path)
    return path


def table(*columns: np.ndarray) -> list[list[Any]]:
    return [list(map(float, row)) for row in zip(*columns, strict=True)]


def test_a_sheet_is_a_table_with_its_head(tmp_path: Path) -> None:
    rows = [["Report of 26 November"], [], ["Time [s]", "Force [N]", "Acc [g]"], *table(T, FORCE, ACC)]
    read = excel.read(book(tmp_path / "a.xlsx", {"Hit": rows, "Remarks": [["soft tip"], ["no double hits"]]}))
    assert list(read.values) == ["Time", "Force", "Acc"]
    assert read.units == {"Time": "s", "Force": "N", "Acc": "g"}
    np.testing.assert_allclose(read.values["Acc"], ACC, rtol=1e-15)  # openpyxl writes 16 digits
    assert any("sheet 'Remarks'" in note and "left out" in note for note in read.notes)


def test_sheets_with_the_same_columns_are_hits(tmp_path: Path) -> None:
    sheets = {f"hit {n}": [["Force", "Acc"], *table(FORCE, n * ACC)] for n in (1, 2, 3)}
    read = excel.read(book(tmp_path / "a.xlsx", sheets))
    assert read.groups == ("hit 1", "hit 2", "hit 3")
    np.testing.assert_allclose(read.of_group("hit 2").values["Acc"], 2 * ACC, rtol=1e-15)


def test_complex_frfs_of_a_sheet(tmp_path: Path) -> None:
    h = FORCE + 1j * ACC
    rows = [["f", "H"], *[[float(f), f"{v.real!r}{v.imag:+.17g}i"] for f, v in zip(T, h.tolist(), strict=True)]]
    read = excel.read(book(tmp_path / "a.xlsx", {"FRF": rows}))
    np.testing.assert_allclose(read.values["H"], h, rtol=1e-15)


@pytest.mark.parametrize(
    ("rows", "said"),
    [
        ([["Time", "Force"], *table(T, FORCE)[:20], [0.5, "overload"]], "row 22: .*overload.*; 2 numbers wanted"),
        ([["soft tip"], ["blue"]], "no table of numbers"),
        ([], "its sheets are empty"),
    ],
)
def test_what_is_no_table_is_said_with_sheet_and_row(tmp_path: Path, rows: list[list[Any]], said: str) -> None:
    with pytest.raises(ValueError, match=said):
        excel.read(book(tmp_path / "a.xlsx", {"One": rows}))


def test_old_and_other_files_are_refused_with_what_to_do(tmp_path: Path) -> None:
    for name, content, said in (
        ("old.xls", b"\xd0\xcf\x11\xe0" + bytes(100), "save it as .xlsx"),
        ("no.xlsx", b"Time,Force\n0,1\n", "no .xlsx file"),
        ("cut.xlsx", book(tmp_path / "a.xlsx", {"a": table(T, FORCE)}).read_bytes()[:2000], "export or copy"),
        ("no.mf4", b"not at all", "cannot be read as a MDF file"),
    ):
        (tmp_path / name).write_bytes(content)
        with pytest.raises(ResultFileError, match=said):
            read_columns(tmp_path / name)


def test_without_the_library_the_extra_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(excel, "find_spec", lambda _: None)
    monkeypatch.setattr(mdf, "find_spec", lambda _: None)
    with pytest.raises(ValueError, match=r"extra tables: pip install 'flexura\[tables\]'; or save .* as CSV"):
        excel.read(tmp_path / "a.xlsx")
    with pytest.raises(ValueError, match=r"extra mdf: pip install 'flexura\[mdf\]'"):
        mdf.read(tmp_path / "a.mf4")


def recorded(path: Path, version: str = "4.10") -> Path:
    slow = np.arange(30) / (RATE / 10.0)
    with asammdf.MDF(version=version) as file:
        hit = [
            asammdf.Signal(FORCE, T + 2.0, name="Force", unit="N"),
            asammdf.Signal(ACC.astype("f4"), T + 2.0, name="Acc", unit="m/s2"),
        ]
        file.append(hit, comment="hit")
        file.append([asammdf.Signal(20.0 + slow, slow + 2.0, name="Temperature", unit="degC")], comment="oven")
        file.save(path, overwrite=True, compression=2 if version >= "4" else 0)
    return path


@pytest.mark.parametrize("version", ["4.10", "3.30"])
def test_channels_of_mdf_have_units_rates_and_starts(tmp_path: Path, version: str) -> None:
    read = mdf.read(recorded(tmp_path / ("a.mf4" if version == "4.10" else "a.mdf"), version))
    assert list(read.values) == ["Force", "Acc", "Temperature"]
    assert read.units["Force"] == "N"
    np.testing.assert_array_equal(read.values["Force"], FORCE)
    np.testing.assert_allclose(read.values["Acc"], ACC, atol=1e-7)
    assert read.rates["Acc"] == pytest.approx(RATE, rel=1e-9)
    assert read.rates["Temperature"] == pytest.approx(RATE / 10.0, rel=1e-9)
    assert read.starts["Force"] == pytest.approx(2.0)
    assert read.doubts == {}


def test_channels_of_groups_that_are_hits(tmp_path: Path) -> None:
    with asammdf.MDF(version="4.10") as file:
        for n in (1, 2):
            file.append([asammdf.Signal(n * ACC, T, name="Acc"), asammdf.Signal(FORCE, T, name="Force")])
        file.save(tmp_path / "a.mf4", overwrite=True)
    read = mdf.read(tmp_path / "a.mf4")
    assert len(read.groups) == 2
    np.testing.assert_array_equal(read.of_group(read.groups[1]).values["Acc"], 2 * ACC)


def test_gaps_in_the_times_of_mdf_are_doubted(tmp_path: Path) -> None:
    gap = np.delete(T, slice(100, 120))
    with asammdf.MDF(version="4.10") as file:
        file.append([asammdf.Signal(np.delete(ACC, slice(100, 120)), gap, name="Acc")])
        file.save(tmp_path / "a.mf4", overwrite=True)
    assert "times of Acc" in mdf.read(tmp_path / "a.mf4").doubts["Acc"]
