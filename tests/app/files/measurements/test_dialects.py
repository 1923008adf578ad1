"""Heads and layouts that recorders and analysers write beside the plain ones."""

from pathlib import Path

import h5py
import numpy as np
import pytest
from nptdms import ChannelObject, TdmsWriter
from scipy.io import savemat

from app.files.measurements import lvm, matlab, numpy_archive, tdms, text
from app.files.measurements.guarded import read_columns

ROWS = [(0.0, 1.5, -2.0), (0.5, 2.5, 3.0), (1.0, -0.5, 4.0), (1.5, 0.25, 5.0)]


def table(delimiter: str, form: str = "{}") -> str:
    return "".join(delimiter.join(form.format(value) for value in row) + "\n" for row in ROWS)


@pytest.mark.parametrize(
    ("content", "names", "units"),
    [
        ("Time,Hammer,Acc\ns,N,m/s2\n" + table(","), ["Time", "Hammer", "Acc"], ["s", "N", "m/s2"]),
        ("Time,Hammer,Acc\n,N,g\n" + table(","), ["Time", "Hammer", "Acc"], ["", "N", "g"]),
        ('"Time (s)","Acc, left (g)","Acc (g)"\n' + table(","), ["Time", "Acc, left", "Acc"], ["s", "g", "g"]),
        ("Time (ms);F (N);A (g)\n" + table(";", '"{}"'), ["Time", "F", "A"], ["ms", "N", "g"]),
        ("% t  Hammer  Acc\n" + table("  "), ["t", "Hammer", "Acc"], ["", "", ""]),
        ("# t [s]\tF [N]\ta [(m/s2)]\n" + table("\t"), ["t", "F", "a"], ["s", "N", "(m/s2)"]),
        ("Time|Hammer|Acc\n" + table("|"), ["Time", "Hammer", "Acc"], ["", "", ""]),
    ],
)
def test_heads_of_tables(tmp_path: Path, content: str, names: list[str], units: list[str]) -> None:
    (tmp_path / "a.csv").write_text(content, encoding="utf-8")
    read = text.read(tmp_path / "a.csv")
    assert list(read.values) == names
    assert [read.units.get(name, "") for name in names] == units
    np.testing.assert_array_equal(np.column_stack(list(read.values.values())), ROWS)


def test_quoted_decimal_commas_between_commas(tmp_path: Path) -> None:
    (tmp_path / "a.csv").write_text("t,F,a\n" + table(",", '"{}"').replace(".", ","), encoding="utf-8")
    np.testing.assert_array_equal(text.read(tmp_path / "a.csv").values["F"], [row[1] for row in ROWS])


@pytest.mark.parametrize("delimiter", [";", "\t", " "])
def test_decimal_commas_that_begin_after_whole_numbers(tmp_path: Path, delimiter: str) -> None:
    """Excel writes 0,000 as 0: four lines of zeros made the first 0,5 an error."""
    rows = [*((n, 0) for n in range(4)), (4, 0.5), (5, -0.25)]
    lines = [delimiter.join(f"{value:g}".replace(".", ",") for value in row) for row in rows]
    (tmp_path / "a.csv").write_text("\n".join(lines), encoding="utf-8")
    np.testing.assert_array_equal(text.read(tmp_path / "a.csv").values["2"], [0, 0, 0, 0, 0.5, -0.25])


@pytest.mark.parametrize("written", ["{r}{i:+}j", "({r}+{i}j)", "{r} {i:+}i", "{r}{i:+}i"])
@pytest.mark.parametrize("delimiter", [",", ";", "\t"])
def test_complex_numbers_as_programs_write_them(tmp_path: Path, delimiter: str, written: str) -> None:
    rows = [f"{f}{delimiter}{written.format(r=re, i=im)}" for f, re, im in ROWS]
    (tmp_path / "a.csv").write_text(f"f{delimiter}H\n" + "\n".join(rows), encoding="utf-8")
    read = text.read(tmp_path / "a.csv").values
    assert read["f"].dtype == float
    np.testing.assert_array_equal(read["H"], [re + 1j * im for _, re, im in ROWS])


def test_complex_numbers_of_numpy_s_savetxt(tmp_path: Path) -> None:
    h = np.array([1.5 - 2.0j, 2.5 + 3.0j, -0.5 + 4.0j])
    np.savetxt(tmp_path / "a.txt", np.column_stack([np.arange(3.0), h]))
    np.testing.assert_array_equal(text.read(tmp_path / "a.txt").values["2"], h)


def test_cells_and_lists_of_structures_of_matlab(tmp_path: Path) -> None:
    cells = np.empty(3, dtype=object)
    cells[:] = [np.arange(4.0), 1j * np.arange(5.0), "text"]
    runs = np.array([(np.arange(4.0),), (np.arange(6.0),)], dtype=[("force", object)])
    savemat(tmp_path / "five.mat", {"H": cells, "run": runs})
    five = matlab.read(tmp_path / "five.mat").values
    assert {name: len(values) for name, values in five.items()} == {
        "H{1}": 4, "H{2}": 5, "run(1).force": 4, "run(2).force": 6
    }  # fmt: skip
    with h5py.File(tmp_path / "seven.mat", "w", userblock_size=512) as file:
        file["#refs#/a"] = np.arange(4.0)[:, None]
        file["#refs#/b"] = np.arange(5.0)[:, None]
        file["H"] = np.array([[file["#refs#/a"].ref], [file["#refs#/b"].ref]], dtype=h5py.ref_dtype)
        file["H"].attrs["MATLAB_class"] = np.bytes_("cell")
    seven = matlab.read(tmp_path / "seven.mat").values
    assert {name: len(values) for name, values in seven.items()} == {"H{1}": 4, "H{2}": 5}


def test_frfs_of_three_axes_are_responses_by_references(tmp_path: Path) -> None:
    """(responses, references, lines), (lines, responses, references), and by version 7.3 turned round."""
    h = (np.arange(60.0) + 1j).reshape(3, 2, 10)
    np.savez(tmp_path / "a.npz", H=h)
    savemat(tmp_path / "five.mat", {"H": np.moveaxis(h, 2, 0)})
    with h5py.File(tmp_path / "seven.mat", "w", userblock_size=512) as file:
        file["H"] = _real_and_imag(h.T)
    for read in (numpy_archive.read(tmp_path / "a.npz"), *map(matlab.read, sorted(tmp_path.glob("*.mat")))):
        assert list(read.values) == [f"H[{k},{m}]" for k in (1, 2, 3) for m in (1, 2)]
        np.testing.assert_array_equal(read.values["H[3,1]"], h[2, 0])
    np.savez(tmp_path / "a.npz", y=h.real)
    with pytest.raises(ValueError, match="y has 3 axes; allowed: 1 or 2"):
        numpy_archive.read(tmp_path / "a.npz")


@pytest.mark.parametrize("kind", ["mat", "h5", "npz"])
def test_one_response_before_several_references_is_one_sensor(tmp_path: Path, kind: str) -> None:
    """(1, 2, N) became H[1] and H[2], two sensors of one drive, and was no fit."""
    rng = np.random.default_rng(3)
    h = rng.normal(size=(1, 2, 50)) + 1j * rng.normal(size=(1, 2, 50))
    file, f = tmp_path / f"one.{kind}", np.linspace(10.0, 500.0, 50)
    if kind == "mat":
        savemat(file, {"H": h, "f": f})
    elif kind == "npz":
        np.savez(file, H=h, f=f)
    else:
        with h5py.File(file, "w") as made:
            made["H"], made["f"] = h, f
    read = read_columns(file)
    assert {name for name in read.values if name != "f"} == {"H[1,1]", "H[1,2]"}
    np.testing.assert_array_equal(read.values["H[1,2]"], h[0, 1])


def test_several_responses_of_one_reference_are_numbered(tmp_path: Path) -> None:
    savemat(tmp_path / "one.mat", {"H": np.ones((2, 1, 50)) * np.exp(1j * np.arange(50)), "f": np.arange(50.0)})
    assert {"H[1]", "H[2]"} <= set(read_columns(tmp_path / "one.mat").values)


def _real_and_imag(h: np.ndarray) -> np.ndarray:
    held = np.empty(h.shape, dtype=[("real", "f8"), ("imag", "f8")])
    held["real"], held["imag"] = h.real, h.imag
    return held


@pytest.mark.parametrize(
    ("content", "message"),
    [
        ("t;F\n1;1,234\n2;1.5\n3;0,25\n4;1,234.5\n", "line 5: '4;1,234.5'; 2 numbers wanted"),
        ("t,F\n1,2\n\n2,3\n3,4\nEnd of data\n", "line 6: 'End of data'; 2 numbers wanted, .*: complete or remove"),
        ("t,F\n2026-01-01 10:00:00.5,2\n" * 3, "export time in seconds .no dates.*commas, | or spaces"),
    ],
)
def test_what_is_no_table_names_the_way_on(tmp_path: Path, content: str, message: str) -> None:
    (tmp_path / "a.csv").write_text(content, encoding="utf-8")
    with pytest.raises(ValueError, match=message):
        text.read(tmp_path / "a.csv")


def labview(separator: str, name: str, x_columns: str, titles: str, rows: list[str], *, parts: int = 1) -> str:
    """Write a file as LabVIEW does, its fields separated by commas here."""
    head = f"LabVIEW Measurement,\nSeparator,{name}\nX_Columns,{x_columns}\n***End_of_Header***,\n,\n"
    gap = "," if x_columns == "Multi" else ""
    units = ("Newtons,", "", "m/s^2") if gap == "" else ("Newtons,", ",", "m/s^2")
    part = (
        f"Notes,as recorded\nChannels,3\nSamples,4,{gap}0,{gap}4\n"
        f"Y_Unit_Label,{units[0]}{units[1]},{gap}{units[2]}\n"
        f"Delta_X,0.5,{gap}1.0,{gap}0.5\n***End_of_Header***,\n{titles}\n" + "\n".join(rows) + "\n\n"
    )
    return (head + parts * part).replace(",", separator)


@pytest.mark.parametrize(("separator", "name"), [("\t", "Tab"), (",", "Comma")])
@pytest.mark.parametrize("x_columns", ["One", "No", "Multi"])
def test_labview_s_layouts(tmp_path: Path, separator: str, name: str, x_columns: str) -> None:
    """A channel without samples, as LabVIEW leaves it, is left out."""
    if x_columns == "Multi":
        titles = "X_Value,Force,X_Value,Off,X_Value,Acc,Comment"
        rows = [f"{t},{f},,,{t},{a},first" if t == 0.0 else f"{t},{f},,,{t},{a}" for t, f, a in ROWS]
    else:
        titles = "X_Value,Force,Off,Acc,Comment"
        rows = [f"{t if x_columns == 'One' else ''},{f},,{a}" for t, f, a in ROWS]
    (tmp_path / "a.lvm").write_text(labview(separator, name, x_columns, titles, rows), encoding="utf-8")
    read = lvm.read(tmp_path / "a.lvm")
    np.testing.assert_array_equal(
        np.column_stack([read.values["Force"], read.values["Acc"]]), np.array(ROWS)[:, 1:]
    )
    assert list(read.values) == ["Force", "Acc"]
    assert (read.units, read.rates) == ({"Force": "Newtons", "Acc": "m/s^2"}, {"Force": 2.0, "Acc": 2.0})
    assert read.groups == ()


def test_labview_s_files_without_heads_are_tables(tmp_path: Path) -> None:
    (tmp_path / "a.lvm").write_text(table("\t"), encoding="utf-8")
    np.testing.assert_array_equal(np.column_stack(list(lvm.read(tmp_path / "a.lvm").values.values())), ROWS)


def test_units_behind_names_are_those_of_channels_without(tmp_path: Path) -> None:
    """As LabVIEW's own writer of TDMS leaves them; numbers of channels are no units."""
    with TdmsWriter(tmp_path / "a.tdms") as writer:
        names = {
            "Force (N)": {},
            "Acc [m/s²]": {},
            "Mic (Pa)": {"unit_string": "V"},
            "Acc (left)": {},
            "Acc[1]": {},
        }
        writer.write_segment([ChannelObject("Log", name, np.arange(9.0), unit) for name, unit in names.items()])
    read = read_columns(tmp_path / "a.tdms")
    assert list(read.values) == list(names)
    assert read.units == {"Force (N)": "N", "Acc [m/s²]": "m/s²", "Mic (Pa)": "V"}


def test_segments_of_labview_are_groups(tmp_path: Path) -> None:
    rows = [f"{t},{f},,{a}" for t, f, a in ROWS]
    whole = labview("\t", "Tab", "One", "X_Value,Force,Off,Acc,Comment", rows, parts=3)
    (tmp_path / "a.lvm").write_text(whole, encoding="utf-8")
    read = lvm.read(tmp_path / "a.lvm")
    assert read.groups == ("segment 1", "segment 2", "segment 3")
    part = read.of_group("segment 2")
    assert (list(part.values), part.units["Force"], part.rates["Acc"]) == (["Force", "Acc"], "Newtons", 2.0)
    np.testing.assert_array_equal(part.values["Acc"], [row[2] for row in ROWS])
    with pytest.raises(ValueError, match="no group 'x'; it holds: segment 1, segment 2, segment 3"):
        read.of_group("x")


def test_groups_of_tdms_are_those_with_the_same_channels(tmp_path: Path) -> None:
    def written(name: str, groups: dict[str, list[str]]) -> tuple[str, ...]:
        with TdmsWriter(tmp_path / name) as writer:
            writer.write_segment(
                [ChannelObject(group, one, np.arange(9.0)) for group, names in groups.items() for one in names]
            )
        return tdms.read(tmp_path / name).groups

    assert written("a.tdms", {"Hit 1": ["Dev1/ai0", "Acc"], "Hit 2": ["Dev1/ai0", "Acc"]}) == ("Hit 1", "Hit 2")
    assert written("b.tdms", {"Hit 1": ["F", "Acc"], "Hit 2": ["F"]}) == ()
    assert written("c.tdms", {"Log": ["F", "Acc"]}) == ()


def test_objects_of_python_are_refused_with_the_way_on(tmp_path: Path) -> None:
    np.savez(tmp_path / "a.npz", y=np.arange(9.0), note=np.array([{}], dtype=object))
    with pytest.raises(ValueError, match="Python objects, which are not read; save arrays of numbers only"):
        numpy_archive.read(tmp_path / "a.npz")


@pytest.mark.parametrize(
    ("rows", "said"),
    [
        (
            ["0,0000,1,10", "0,0001,1,12", "0,0002,1,15", "0,0003,1,17"],
            "4 numbers below 2 names; if its commas",
        ),
        (["0,1,1,10", "0,2,1,12", "0,3,1,15", "0,4,2"], "4 numbers wanted.*; if its commas are decimal marks"),
    ],
)
def test_decimal_commas_between_commas_are_told(tmp_path: Path, rows: list[str], said: str) -> None:
    """A table of 2 columns was read as one of 4, whose names were lost."""
    path = tmp_path / "x.csv"
    names = "Time,Acc" if len(rows[-1]) > 6 else "t,a,b,c"
    path.write_text("\n".join([names, *rows]), encoding="utf-8")
    with pytest.raises(ValueError, match=said):
        text.read(path)
