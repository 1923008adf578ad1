"""Files as laboratories send them: what stands in them twice, beside them, or in words, is read so."""

import re
import struct
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest
from nptdms import ChannelObject, RootObject, TdmsWriter
from pyuff import UFF
from pyuff.datasets.dataset_58 import prepare_58
from scipy.io import netcdf_file, savemat

from app.files.bad_file import ResultFileError
from app.files.campaigns.channels import sweeps_of
from app.files.campaigns.tdms_file import start_of
from app.files.measurements import hdf5, lvm, matlab, numpy_archive, tdms, text, uff_time
from app.files.measurements.complex_pairs import with_complex_pairs
from app.files.measurements.guarded import read_columns
from app.files.uff.frfs import read_frfs
from app.files.uff.geometry import read_nodes

RATE = 1024.0
N = 400
T = np.arange(N) / RATE
FORCE = np.exp(-(((T - 0.02) / 0.002) ** 2))
ACC = np.sin(2 * np.pi * 50 * T)
LINES = np.arange(1.0, 129.0)
H = 1.0 / (62.0**2 - LINES**2 + 1j * LINES)


def labview(step: str, times: np.ndarray, *, more: str = "", columns: str = "One", unit: str = "m/s^2") -> str:
    head = f"LabVIEW Measurement\t\nSeparator\tTab\nX_Columns\t{columns}\n***End_of_Header***\t\n\t\n"
    head += f"Channels\t2\t\nSamples\t{N}\t{N}\t\nY_Unit_Label\tN\t{unit}\t\n{more}Delta_X\t{step}\t{step}\t\n"
    rows = (
        f"{'' if columns == 'No' else format(t, '.6f')}\t{f:.6f}\t{a:.6f}\n"
        for t, f, a in zip(times, FORCE, ACC, strict=True)
    )
    return head + "***End_of_Header***\t\t\nX_Value\tForce\tAcc\tComment\n" + "".join(rows)


@pytest.mark.parametrize("step", ["0.000977", "1.000000", "9.765625E-4"])
def test_labview_s_times_settle_its_rounded_or_default_step(tmp_path: Path, step: str) -> None:
    (tmp_path / "a.lvm").write_text(labview(step, T), encoding="utf-8")
    read = lvm.read(tmp_path / "a.lvm")
    assert read.rates["Acc"] == pytest.approx(RATE, rel=2e-6)
    assert read.doubts == {}


@pytest.mark.parametrize(
    ("step", "columns", "doubt"),
    [
        ("0.000977", "No", "Delta_X = 0.000977 has too few digits"),
        ("1.000000", "No", "Delta_X = 1 s is what programs write"),
        ("0.000500", "One", "two sample rates: 1024.* Hz by the column X_Value and 2000 Hz by Delta_X = 0.000500"),
    ],
)
def test_labview_s_step_alone_or_against_its_times_is_doubted(
    tmp_path: Path, step: str, columns: str, doubt: str
) -> None:
    (tmp_path / "a.lvm").write_text(labview(step, T, columns=columns), encoding="utf-8")
    told = lvm.read(tmp_path / "a.lvm").doubts["Acc"]
    assert re.search(doubt, told)


def test_labview_s_samples_missing_in_the_middle_are_doubted(tmp_path: Path) -> None:
    times = np.where(np.arange(N) < 200, T, T + 5 / RATE)
    (tmp_path / "a.lvm").write_text(labview("0.000977", times), encoding="utf-8")
    assert "about 5 samples are missing" in lvm.read(tmp_path / "a.lvm").doubts["Force"]


@pytest.mark.parametrize("encoding", ["cp1252", "utf-8", "utf-16"])
def test_units_in_the_code_page_of_windows(tmp_path: Path, encoding: str) -> None:
    (tmp_path / "a.lvm").write_bytes(labview("9.765625E-4", T, unit="m/s²").encode(encoding))
    assert lvm.read(tmp_path / "a.lvm").units["Acc"] == "m/s²"


@pytest.mark.parametrize(
    ("head", "rate"),
    [
        ("Sample rate: 1024 Hz", 1024.0), ("Fs [kHz];51,2", 51200.0), ("Sampling frequency\t2.048e3", 2048.0),
        ("Offsets: 12", None), ("Abtastrate (Hz): 1000", 1000.0),
    ],
)  # fmt: skip
def test_a_table_s_head_gives_its_rate(tmp_path: Path, head: str, rate: float | None) -> None:
    (tmp_path / "a.csv").write_text(f"{head}\n\nForce;Acc\n" + "1;2\n" * 20, encoding="utf-8")
    assert text.read(tmp_path / "a.csv").scalars.get("sample rate") == (
        None if rate is None else pytest.approx(rate)
    )


def test_what_a_library_warns_of_is_a_note(tmp_path: Path) -> None:
    """Of two variables of one name scipy keeps the later one, and warns."""
    for name in ("one", "two"):
        savemat(tmp_path / f"{name}.mat", {"force": FORCE, "acc": ACC})
    twice = (tmp_path / "one.mat").read_bytes() + (tmp_path / "two.mat").read_bytes()[128:]
    (tmp_path / "a.mat").write_bytes(twice)
    assert "Duplicate variable name" in read_columns(tmp_path / "a.mat").notes[0]


def test_a_slow_channel_of_labview_ends_early(tmp_path: Path) -> None:
    head = "LabVIEW Measurement\t\nSeparator\tTab\nX_Columns\tMulti\n***End_of_Header***\t\n\t\n"
    head += "Channels\t2\t\t\t\nSamples\t8\t\t3\t\nDelta_X\t0.5\t\t1.0\t\n***End_of_Header***\t\t\t\t\n"
    rows = [f"{n / 2}\t{n}.5\t{n}.0\t{20 + n}" if n < 3 else f"{n / 2}\t{n}.5" for n in range(8)]
    (tmp_path / "a.lvm").write_text(head + "X_Value\tAcc\tX_Value\tTemp\tComment\n" + "\n".join(rows) + "\n")
    read = lvm.read(tmp_path / "a.lvm")
    assert (len(read.values["Acc"]), read.values["Temp"].tolist()) == (8, [20.0, 21.0, 22.0])
    (tmp_path / "a.lvm").write_text(head.replace("\t3\t", "\t4\t") + "X\tA\tX\tT\n" + "\n".join(rows) + "\n")
    with pytest.raises(ValueError, match="3 samples up to here, and 4 are declared or follow: cut short"):
        lvm.read(tmp_path / "a.lvm")


def recorded(path: Path, step: float = 1 / RATE, more: dict[str, Any] | None = None, **of_acc: Any) -> Path:
    timing = {"wf_increment": step, "wf_start_offset": 0.0, "wf_samples": N, "unit_string": "N"}
    with TdmsWriter(path) as writer:
        writer.write_segment(
            [
                RootObject({"actuator": "A1"}),
                ChannelObject("Log", "Force", FORCE, timing | (more or {})),
                ChannelObject("Log", "Acc", ACC, timing | {"unit_string": "g"} | of_acc | (more or {})),
            ]
        )
    return path


def test_an_index_beside_a_file_is_not_believed(tmp_path: Path) -> None:
    recorded(tmp_path / "a.tdms", step=1 / 4096.0)
    with TdmsWriter(str(tmp_path / "old.tdms"), index_file=True) as writer:
        timing = {"wf_increment": 1 / 4096.0, "wf_start_offset": 0.0, "wf_samples": N, "unit_string": "N"}
        objects = [ChannelObject("Log", "Force", FORCE, timing), ChannelObject("Log", "Acc", ACC, timing)]
        writer.write_segment([RootObject({"actuator": "A2"}), *objects])
    recorded(tmp_path / "a.tdms")
    (tmp_path / "old.tdms_index").rename(tmp_path / "a.tdms_index")
    assert tdms.read(tmp_path / "a.tdms").rates["Acc"] == pytest.approx(RATE, rel=1e-9)

    class Recorder:
        @staticmethod
        def properties(_: str, root: dict[str, Any]) -> dict[str, Any]:
            return root

    chosen, problems = sweeps_of([tmp_path / "a.tdms"], "A1", ["A1", "A2"], Recorder())  # type: ignore[arg-type]
    assert (chosen, problems) == ([tmp_path / "a.tdms"], [])


@pytest.mark.parametrize("kind", ["Reciprocal", "Exponential"])
def test_a_scale_that_the_library_only_logs_is_refused(tmp_path: Path, kind: str) -> None:
    scale = {"NI_Number_Of_Scales": 1, "NI_Scaling_Status": "unscaled", "NI_Scale[0]_Scale_Type": kind}
    with pytest.raises(ValueError, match=f"Unsupported scale type: {kind}.*counts of the converter"):
        tdms.read(recorded(tmp_path / "a.tdms", more=scale))


def test_counts_without_any_scale_are_refused(tmp_path: Path) -> None:
    with TdmsWriter(tmp_path / "a.tdms") as writer:
        counts = np.arange(50, dtype=np.int16)
        writer.write_segment([ChannelObject("Log", "Acc", counts, {"NI_Scaling_Status": "unscaled"})])
    with pytest.raises(ValueError, match="'Acc' is not scaled yet"):
        tdms.read(tmp_path / "a.tdms")


def test_a_segment_of_unknown_length_is_whole_if_its_chunks_are(tmp_path: Path) -> None:
    path = recorded(tmp_path / "a.tdms")
    whole = path.read_bytes()
    unknown = whole[:12] + struct.pack("<Q", 2**64 - 1) + whole[20:]
    path.write_bytes(unknown)
    np.testing.assert_array_equal(tdms.read(path).values["Acc"], ACC)
    path.write_bytes(unknown[:-80])
    with pytest.raises(ValueError, match="cut short"):
        tdms.read(path)
    path.write_bytes(whole[:-80])
    with pytest.raises(ValueError, match="cut short"):
        tdms.read(path)


def test_starts_of_channels_are_read(tmp_path: Path) -> None:
    begun = np.datetime64("2026-01-05T10:00:00.000500", "us")
    read = tdms.read(recorded(tmp_path / "a.tdms", wf_start_offset=8 / RATE))
    assert read.starts["Acc"] - read.starts["Force"] == pytest.approx(8 / RATE)
    later = start_of({"wf_start_time": begun, "wf_start_offset": 0.25})
    earlier = start_of({"wf_start_time": begun - np.timedelta64(500, "us")})
    assert later is not None
    assert earlier is not None
    assert later - earlier == pytest.approx(0.2505, abs=1e-6)
    assert start_of({}) is None


def test_the_increment_of_programs_that_know_none_is_doubted(tmp_path: Path) -> None:
    read = tdms.read(recorded(tmp_path / "a.tdms", step=1.0))
    assert "wf_increment = 1 s is what programs write" in read.doubts["Acc"]
    read = tdms.read(recorded(tmp_path / "b.tdms", step=1000.0 / RATE, more={"wf_xunit_string": "ms"}))
    assert read.rates["Acc"] == pytest.approx(RATE)


def spectra(path: Path, more: dict[str, Any] | None = None) -> tuple[Path, np.ndarray, np.ndarray]:
    """Write an FRF over lines that are waveform properties, in kHz, as magnitude in decibels and phase."""
    f = 20.0 + 0.5 * np.arange(200)
    h = 1.0 / ((60.0**2 - f**2) + 2j * f)
    axis = {"wf_increment": 0.5e-3, "wf_start_offset": 0.02, "wf_xunit_string": "kHz"}
    parts = (
        ("Acc Magnitude", 20 * np.log10(np.abs(h)), "dB"),
        ("Acc Phase", np.angle(h, deg=True), "deg"),
    )
    channels = [
        ChannelObject("FRF", name, values, properties={**axis, "unit_string": unit})
        for name, values, unit in parts
    ]
    if more is not None:
        channels.append(ChannelObject("FRF", "Other", f, properties=more))
    with TdmsWriter(path) as writer:
        writer.write_segment(channels)
    return path, f, h


def test_spectra_are_over_the_lines_of_their_waveform_properties(tmp_path: Path) -> None:
    path, f, h = spectra(tmp_path / "frf.tdms")
    read = with_complex_pairs(tdms.read(path))
    assert list(read.values) == ["Frequency", "Acc"]
    assert not read.doubts
    np.testing.assert_allclose(read.values["Frequency"], f)
    np.testing.assert_allclose(read.values["Acc"], h)


@pytest.mark.parametrize("more", [{"wf_increment": 1e-3}, {"wf_increment": 0.25e-3, "wf_xunit_string": "kHz"}])
def test_spectra_beside_signals_or_other_lines_stay_in_doubt(tmp_path: Path, more: dict[str, Any]) -> None:
    read = tdms.read(spectra(tmp_path / "both.tdms", more)[0])
    assert "Frequency" not in read.values
    assert "it holds spectra, no signals" in read.doubts["Acc Phase"]


def response(name: str, values: np.ndarray, node: int = 0, **more: Any) -> dict[str, Any]:
    given = {
        "binary": 0, "func_type": 1, "rsp_node": node, "rsp_dir": 0, "ref_node": 0, "ref_dir": 0, "data": values,
        "x": T, "id1": name, "rsp_ent_name": "NONE", "ref_ent_name": "NONE", "abscissa_spacing": 1,
        "abscissa_inc": 1 / RATE, "abscissa_spec_data_type": 17, "ordinate_spec_data_type": 1,
        "ordinate_axis_units_lab": "V", "orddenom_spec_data_type": 0, "id2": "NONE", "id3": "NONE", "id4": "NONE",
        "id5": "NONE",
    }  # fmt: skip
    return dict(prepare_58(**(given | more)))


def written(path: Path, sets: list[dict[str, Any]]) -> Path:
    for one in sets:
        UFF(str(path)).write_sets(one, "add")
    return path


def test_channels_without_nodes_are_told_apart_by_the_head(tmp_path: Path) -> None:
    signals = {"Hammer": FORCE, "Acc 1": ACC, "Acc 2": 2 * ACC, "Acc 3": 3 * ACC}
    read = uff_time.read(written(tmp_path / "a.uff", [response(n, v) for n, v in signals.items()]))
    assert (list(read.values), read.groups) == (list(signals), ())
    np.testing.assert_allclose(read.values["Acc 2"], 2 * ACC, atol=1e-6)
    assert read.aliases["0:+0"] == "Hammer"
    twice = [response(n, v, id5=f"record {k}") for k in range(3) for n, v in signals.items()]
    runs = uff_time.read(written(tmp_path / "b.uff", twice))
    assert runs.groups == ("run 1", "run 2", "run 3")
    assert list(runs.of_group("run 2").values) == list(signals)


def test_two_channels_at_one_node_are_told_apart_by_the_head(tmp_path: Path) -> None:
    """A hammer and an accelerometer at the point hit, both in volts, hit by hit."""
    nodes = {"Hammer": 1, "Acc 1": 1, "Acc 2": 2}
    sets = [response(n, k * ACC, node, id5=f"hit {k}") for k in (1, 2, 3) for n, node in nodes.items()]
    read = uff_time.read(written(tmp_path / "a.uff", sets))
    assert read.groups == ("run 1", "run 2", "run 3")
    assert list(read.of_group("run 3").values) == ["Hammer", "Acc 1", "2:+0"]


def test_channels_that_nothing_tells_apart_are_no_runs(tmp_path: Path) -> None:
    read = uff_time.read(written(tmp_path / "a.uff", [response("rec", n * ACC) for n in range(1, 5)]))
    assert (read.groups, len(read.values)) == ((), 4)


@pytest.mark.parametrize(("unit", "scale"), [("ms", 1e3), ("s", 1.0), ("NONE", 1.0)])
def test_times_of_universal_files_have_their_unit_start_and_six_digits(
    tmp_path: Path, unit: str, scale: float
) -> None:
    uneven = response("a", ACC, abscissa_spacing=0, x=scale * T, abscissa_axis_units_lab=unit)
    late = response("b", ACC, abscissa_min=scale * 0.5, x=scale * (T + 0.5), abscissa_axis_units_lab=unit)
    late |= {"abscissa_inc": scale / RATE}
    read = uff_time.read(written(tmp_path / "a.uff", [uneven, late]))
    assert read.rates["a"] == pytest.approx(RATE, rel=2e-6)
    assert read.rates["b"] == pytest.approx(RATE, rel=2e-6)
    assert read.starts["b"] - read.starts["a"] == pytest.approx(0.5)


def frf_set(**more: Any) -> dict[str, Any]:
    given = {
        "binary": 0, "func_type": 4, "rsp_node": 1, "rsp_dir": 3, "ref_node": 1, "ref_dir": 3, "data": H,
        "x": LINES,
        "id1": "FRF", "rsp_ent_name": "NONE", "ref_ent_name": "NONE", "abscissa_spacing": 1, "abscissa_inc": 1.0,
        "abscissa_min": 1.0, "abscissa_spec_data_type": 18, "ordinate_spec_data_type": 12,
        "orddenom_spec_data_type": 13, "id2": "NONE", "id3": "NONE", "id4": "NONE", "id5": "NONE",
    }  # fmt: skip
    return dict(prepare_58(**(given | more)))


@pytest.mark.parametrize(
    ("unit", "scale"), [("rad/s", 2 * np.pi), ("kHz", 1e-3), ("RAD/S", 2 * np.pi), ("Hz", 1.0)]
)
def test_lines_of_universal_files_have_their_unit(tmp_path: Path, unit: str, scale: float) -> None:
    one = frf_set(x=scale * LINES, abscissa_min=scale, abscissa_inc=scale, abscissa_axis_units_lab=unit)
    (frf,) = read_frfs(written(tmp_path / "a.uff", [one]))
    np.testing.assert_allclose(frf.frequency, LINES, rtol=1e-5)


@pytest.mark.parametrize(
    ("more", "message"),
    [
        ({"abscissa_axis_units_lab": "furlong"}, "unit 'furlong' of its abscissa is not known"),
        ({"abscissa_spec_data_type": 19}, "is rotation, not frequency"),
    ],
)
def test_lines_of_something_else_are_refused(tmp_path: Path, more: dict[str, Any], message: str) -> None:
    with pytest.raises(ResultFileError, match=message):
        read_frfs(written(tmp_path / "a.uff", [frf_set(**more)]))


def test_fortran_s_exponents_are_read_and_names_left_alone(tmp_path: Path) -> None:
    path = written(tmp_path / "a.uff", [frf_set(id1="probe 1.0e+00")])
    lines = path.read_text().splitlines()
    changed = [line if n < 8 else line.replace("e+", "D+").replace("e-", "D-") for n, line in enumerate(lines)]
    path.write_text("\n".join(changed) + "\n")
    (frf,) = read_frfs(path)
    np.testing.assert_allclose(frf.h, H, rtol=1e-5)
    assert frf.name == "probe 1.0e+00"


def nodes_in(path: Path, code: int, factor: float, exponent: str = "D") -> Path:
    number = f"{factor:25.17e}".replace("e", exponent)
    path.write_text(
        f"    -1\n   164\n{code:10d}{'as declared':20}{2:10d}\n{number}{number}{1.0:25.17e}\n{0.0:25.17e}\n   "
        f" -1\n"
        f"    -1\n    15\n{7:10d}{0:10d}{0:10d}{11:10d}{200.0:13.5e}{0.0:13.5e}{0.0:13.5e}\n    -1\n"
    )
    return path


@pytest.mark.parametrize(
    ("code", "factor", "metres"),
    [(5, 1000.0, 0.2), (1, 1.0, 200.0), (9, 39.37007874, 5.08), (9, 100.0, 2.0)],
)
def test_nodes_have_the_unit_of_the_file(tmp_path: Path, code: int, factor: float, metres: float) -> None:
    assert read_nodes(nodes_in(tmp_path / "a.uff", code, factor))[7][0] == pytest.approx(metres, rel=1e-6)


def test_units_that_contradict_themselves_are_refused(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match=r"units code 5 means length factor 1000, and 0.001 stands there"):
        read_nodes(nodes_in(tmp_path / "a.uff", 5, 1e-3))


@pytest.mark.parametrize("swapped", [False, True])
@pytest.mark.parametrize("ending", ["npz", "mat", "h5"])
def test_the_axis_as_long_as_the_frequencies_is_theirs(tmp_path: Path, ending: str, swapped: bool) -> None:
    """More points than lines, and the other way round."""
    every = np.outer(np.arange(1, 201), H)
    array = every.T if swapped else every
    path = tmp_path / f"a.{ending}"
    if ending == "npz":
        np.savez(path, f=LINES, H=array)
    elif ending == "mat":
        savemat(path, {"f": LINES, "H": array})
    else:
        with h5py.File(path, "w") as file:
            file["f"], file["H"] = LINES, array
    read = read_columns(path).values
    np.testing.assert_allclose(read["H[200]"], 200 * H)


def test_of_as_many_points_as_lines_none_is_guessed_and_the_rest_is_read(tmp_path: Path) -> None:
    np.savez(tmp_path / "a.npz", f=LINES, H=np.outer(np.ones(128), H), H1=H)
    read = numpy_archive.read(tmp_path / "a.npz")
    assert set(read.values) == {"f", "H1"}
    assert "several axes are as long as times or frequencies" in read.notes[0]


def test_analysers_frfs_with_their_frequency_beside_them(tmp_path: Path) -> None:
    """One variable for each FRF, ``[f, H]``."""
    savemat(tmp_path / "a.mat", {f"H1_{n}": np.column_stack([LINES + 0j, n * H]) for n in range(2, 30)})
    read = matlab.read(tmp_path / "a.mat").values
    assert list(read)[:2] == ["frequency", "H1_2"]
    assert len(read) == 29
    np.testing.assert_allclose(read["H1_7"], 7 * H)
    np.testing.assert_array_equal(read["frequency"], LINES)


def test_lists_of_structures_are_hits(tmp_path: Path) -> None:
    runs = np.array(
        [(n * FORCE, np.array([ACC, n * ACC])) for n in (1.0, 2.0, 3.0)],
        dtype=[("force", object), ("acc", object)],
    )
    savemat(tmp_path / "five.mat", {"run": runs, "fs": RATE, "t": T})
    with h5py.File(tmp_path / "seven.mat", "w", userblock_size=512) as file:
        for key in ("force", "acc"):
            held = [file.create_dataset(f"#refs#/{key}{n}", data=runs[key][n].T) for n in range(3)]
            file[f"run/{key}"] = np.array([[one.ref] for one in held], dtype=h5py.ref_dtype)
        file["run"].attrs["MATLAB_class"] = np.bytes_("struct")
        file["t"] = T[:, None]
    for name in ("five", "seven"):
        read = read_columns(tmp_path / f"{name}.mat")
        assert read.groups == ("run(1)", "run(2)", "run(3)")
        part = read.of_group("run(2)")
        assert set(part.values) == {"force", "acc[1]", "acc[2]", "t"}
        np.testing.assert_allclose(part.values["force"], 2.0 * FORCE)


def test_frfs_as_sdynpy_saves_them(tmp_path: Path) -> None:
    ends = [("node", "<u8"), ("direction", "i1")]
    dtype = [
        ("abscissa", "<f8", (128,)),
        ("ordinate", "<c16", (128,)),
        ("comment1", "<U80"),
        ("coordinate", ends, (2,)),
    ]
    data = np.zeros((3, 1), dtype=dtype)
    for n in range(3):
        data[n, 0]["abscissa"], data[n, 0]["ordinate"] = LINES, (n + 1) * H
        data[n, 0]["coordinate"] = [(n + 1, -3), (7, 1)]
    np.savez(tmp_path / "a.npz", data=data, function_type=4)
    read = numpy_archive.read(tmp_path / "a.npz")
    assert list(read.values) == ["frequency", "1:-z / 7:+x", "2:-z / 7:+x", "3:-z / 7:+x"]
    assert (read.places["2:-z / 7:+x"], read.references["2:-z / 7:+x"]) == ("2:-z", "7:+x")
    np.savez(tmp_path / "b.npz", data=data, function_type=9)
    with pytest.raises(ValueError, match=r"of type 9; allowed: 1 .time response. and 4"):
        numpy_archive.read(tmp_path / "b.npz")
    np.savez(tmp_path / "c.npz", held=np.zeros(3, dtype=[("x", "f8"), ("y", "f8")]))
    with pytest.raises(ValueError, match="structured array with the fields x, y; save each field"):
        numpy_archive.read(tmp_path / "c.npz")


def test_hdf5_with_units_rates_and_groups(tmp_path: Path) -> None:
    with h5py.File(tmp_path / "a.h5", "w") as file:
        file["test/force"], file["test/acc"] = FORCE, np.array([ACC, 2 * ACC, 3 * ACC])
        file["test/force"].attrs.update({"units": "N", "fs": RATE})
        file["test/acc"].attrs.update({"Unit": np.bytes_("m/s^2"), "sampling_rate": RATE})
        file.attrs["sample_rate"] = RATE
        file["elsewhere"] = h5py.ExternalLink("other.h5", "/x")
        file["name"] = "a text"
    read = read_columns(tmp_path / "a.h5")
    assert list(read.values) == ["test/acc[1]", "test/acc[2]", "test/acc[3]", "test/force"]
    assert (read.units["test/acc[3]"], read.units["test/force"]) == ("m/s^2", "N")
    assert read.rates == dict.fromkeys(read.values, RATE)
    assert read.scalars["sample_rate"] == RATE


@pytest.mark.parametrize("transposed", [False, True])
def test_netcdf_of_labelled_arrays(tmp_path: Path, transposed: bool) -> None:
    """As xarray writes it: coordinates are dimension scales, of which one has the channels' names."""
    signals = np.array([FORCE[:6], ACC[:6], *(ACC[:6] for _ in range(6))])
    names = ["Hammer", *(f"Acc{n}" for n in range(1, 8))]
    with h5py.File(tmp_path / "a.nc", "w") as file:
        file["time"], file["channel"] = T[:6] * 1e3, np.array(names, dtype=h5py.string_dtype())
        file["time"].attrs["units"] = "ms"
        file["signal"] = signals.T if transposed else signals
        for axis, scale in enumerate(("time", "channel") if transposed else ("channel", "time")):
            file[scale].make_scale(scale)
            file["signal"].dims[axis].attach_scale(file[scale])
    read = read_columns(tmp_path / "a.nc")
    assert set(read.values) == {"time", *names}
    assert read.units["time"] == "ms"
    np.testing.assert_allclose(read.values["Acc7"], ACC[:6])


def test_netcdf_of_version_3(tmp_path: Path) -> None:
    with netcdf_file(tmp_path / "a.nc", "w") as file:
        file.createDimension("time", N)
        for name, values, unit in (("time", T, "s"), ("force", FORCE, "N"), ("acc", ACC, "g")):
            held = file.createVariable(name, "d", ("time",))
            held[:] = values
            held.units = unit
    read = read_columns(tmp_path / "a.nc")
    assert read.units == {"time": "s", "force": "N", "acc": "g"}
    np.testing.assert_array_equal(read.values["acc"], ACC)


def rattlesnake(path: Path, streams: tuple[str, ...] = ("time_data",)) -> Path:
    table = {
        "node_number": ["101", "102", "103"], "node_direction": ["Z+", "Z+", "X-"], "unit": ["N", "g", "g"],
        "comment": ["Shaker force", "", ""], "sensitivity": ["2.25", "100", "100"],
    }  # fmt: skip
    with h5py.File(path, "w") as file:
        file.attrs["sample_rate"] = RATE
        for name in streams:
            file[name] = np.array([FORCE, ACC, -ACC])
        for key, texts in table.items():
            file[f"channels/{key}"] = np.array(texts, dtype=h5py.string_dtype())
    return path


def test_rattlesnake_s_table_of_channels(tmp_path: Path) -> None:
    read = read_columns(rattlesnake(tmp_path / "a.nc4"))
    assert list(read.values) == ["Shaker force", "102Z+", "103X-"]
    assert read.units == {"Shaker force": "N", "102Z+": "g", "103X-": "g"}
    assert read.places == {"Shaker force": "101:+z", "102Z+": "102:+z", "103X-": "103:-x"}
    assert read.rates["103X-"] == RATE
    two = hdf5.read(rattlesnake(tmp_path / "b.nc4", ("time_data", "time_data_1")))
    assert two.groups == ("time_data", "time_data_1")


def test_hdf5_that_points_elsewhere_is_refused(tmp_path: Path) -> None:
    (tmp_path / "raw.bin").write_bytes(b"\0" * 800)
    with h5py.File(tmp_path / "a.h5", "w") as file:
        file.create_dataset("x", (100,), "f8", external=[(str(tmp_path / "raw.bin"), 0, 800)])
    with pytest.raises(ValueError, match="x lies in other files"):
        hdf5.read(tmp_path / "a.h5")
