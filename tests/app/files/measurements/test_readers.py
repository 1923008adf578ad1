"""Every format written by its own library, or byte by byte as its program writes it, and read."""

import gzip
import struct
from pathlib import Path

import h5py
import numpy as np
import pytest
from nptdms import ChannelObject, RootObject, TdmsWriter
from pyuff import UFF
from pyuff.datasets.dataset_58 import prepare_58
from scipy.io import savemat, wavfile

from app.files.bad_file import ResultFileError
from app.files.measurements import lvm, matlab, numpy_archive, tdms, text, uff_time, wave
from app.files.measurements.formats import FORMATS, format_of
from app.files.measurements.guarded import read_columns

RATE = 1000.0
T = np.arange(200) / RATE
FORCE = np.exp(-(((T - 0.02) / 0.002) ** 2))
ACC = np.sin(2 * np.pi * 50 * T)
SAMPLES = Path(__file__).resolve().parents[5] / "shared" / "data" / "real" / "uff58_samples"


@pytest.mark.parametrize(
    ("delimiter", "decimal", "head"),
    [
        (",", ".", "Time [s],Force [N],Acc (g)\n"),
        (";", ",", "Recorder 5; of a maker\nDate;2026-11-22\n\nTime;Force;Acc\n[s];[N];[g]\n"),
        ("\t", ",", "Time [s]\tForce [N]\tAcc [g]\n"),
        ("  ", ".", "time[s]  Force[N]  Acc[g]\n"),
    ],
)
def test_tables_of_text_of_many_dialects(tmp_path: Path, delimiter: str, decimal: str, head: str) -> None:
    rows = [
        delimiter.join(f"{v:.6f}".replace(".", decimal) for v in row) for row in zip(T, FORCE, ACC, strict=True)
    ]
    path = tmp_path / "a.csv"
    path.write_bytes((head + "\n".join(rows) + "\n").encode("latin-1"))
    read = text.read(path)
    names = list(read.values)
    assert [name.lower() for name in names] == ["time", "force", "acc"]
    assert [read.units[name] for name in names] == ["s", "N", "g"]
    np.testing.assert_allclose(read.values[names[2]], ACC, atol=1e-6)


def test_text_without_names_and_packed(tmp_path: Path) -> None:
    path = tmp_path / "a.txt.gz"
    with gzip.open(path, "wt", encoding="utf-8") as file:
        np.savetxt(file, np.column_stack([T, FORCE]))
    read = text.read(path)
    assert list(read.values) == ["1", "2"]
    np.testing.assert_allclose(read.values["2"], FORCE)


@pytest.mark.shared
@pytest.mark.skipif(not SAMPLES.is_dir(), reason="the measured beam lies beside the checkout, and is absent")
def test_a_real_analyser_s_table_of_an_frf() -> None:
    read = text.read(SAMPLES.parent / "beam_roving_hammer" / "Hxysv00001.txt.gz")
    assert list(read.values) == ["Frequency", "Real", "Imaginary"]
    assert len(read.values["Real"]) == 51201
    assert read.values["Frequency"][-1] == pytest.approx(1000.0)


def test_matlab_of_both_kinds(tmp_path: Path) -> None:
    savemat(
        tmp_path / "five.mat",
        {"force": FORCE, "fs": RATE, "test": {"acc": ACC, "note": "x"}, "H": np.eye(3, 9) * 1j},
    )
    five = matlab.read(tmp_path / "five.mat")
    assert set(five.values) == {"force", "test.acc", "H[1]", "H[2]", "H[3]"}
    assert five.scalars["fs"] == RATE
    assert five.values["H[2]"][1] == 1j
    with h5py.File(tmp_path / "seven.mat", "w", userblock_size=512) as file:
        file["force"] = FORCE[:, None]
        file["test/acc"] = ACC[:, None]
        file["fs"] = np.array([[RATE]])
        complex_type = np.dtype([("real", "f8"), ("imag", "f8")])
        file["H"] = np.array([(1.0, 2.0), (3.0, 4.0)], dtype=complex_type)
        file["note"] = np.array([[120]], dtype="u2")
        file["note"].attrs["MATLAB_class"] = b"char"
        file["elsewhere"] = h5py.ExternalLink("other.h5", "/x")
    seven = matlab.read(tmp_path / "seven.mat")
    assert set(seven.values) == {"force", "test.acc", "H"}
    np.testing.assert_array_equal(seven.values["test.acc"], ACC)
    np.testing.assert_array_equal(seven.values["H"], [1 + 2j, 3 + 4j])
    assert seven.scalars == {"fs": RATE}


@pytest.mark.parametrize(("kind", "worth"), [("i2", 2.0**-15), ("i4", 2.0**-31), ("u1", 2.0**-7), ("f4", 1e-7)])
def test_sound_files_in_shares_of_full_scale(tmp_path: Path, kind: str, worth: float) -> None:
    shares = 0.5 * np.column_stack([FORCE, ACC])
    stored = {
        "i2": np.round(shares * 2**15), "i4": np.round(shares * 2**31), "u1": np.round(shares * 128 + 128),
        "f4": shares,
    }[kind].astype(kind)  # fmt: skip
    wavfile.write(tmp_path / "a.wav", int(RATE), stored)
    read = wave.read(tmp_path / "a.wav")
    np.testing.assert_allclose(read.values["2"], shares[:, 1], atol=worth)
    assert (read.units["1"], read.rates["1"]) == ("FS", RATE)


def test_sound_of_24_bits(tmp_path: Path) -> None:
    """Byte by byte: scipy writes none of these."""
    samples = np.round(0.5 * ACC * 2**23).astype("<i4")
    data = b"".join(struct.pack("<i", int(s))[:3] for s in samples)
    head = struct.pack(
        "<4sI4s4sIHHIIHH4sI",
        b"RIFF",
        36 + len(data),
        b"WAVE",
        b"fmt ",
        16,
        1,
        1,
        1000,
        3000,
        3,
        24,
        b"data",
        len(data),
    )
    (tmp_path / "a.wav").write_bytes(head + data)
    np.testing.assert_allclose(wave.read(tmp_path / "a.wav").values["1"], 0.5 * ACC, atol=2.0**-23)


def test_archives_of_numpy_and_none_with_objects(tmp_path: Path) -> None:
    np.savez(tmp_path / "a.npz", y=np.array([FORCE, ACC]), fs=RATE)
    read = numpy_archive.read(tmp_path / "a.npz")
    np.testing.assert_array_equal(read.values["y[2]"], ACC)
    assert read.scalars == {"fs": RATE}
    np.savez(tmp_path / "b.npz", y=np.array([{}, {}], dtype=object))
    with pytest.raises(ValueError, match="Python objects"):
        numpy_archive.read(tmp_path / "b.npz")


def test_tdms_of_another_layout(tmp_path: Path) -> None:
    timing = {"wf_increment": 1 / RATE, "wf_start_offset": 0.0, "wf_samples": 200, "unit_string": "V"}
    with TdmsWriter(tmp_path / "a.tdms") as writer:
        writer.write_segment(
            [
                RootObject({}),
                ChannelObject("Log", "Hammer", FORCE, timing),
                ChannelObject("Log", "ai1", ACC),
                ChannelObject("Other", "ai1", ACC),
            ]
        )
    read = tdms.read(tmp_path / "a.tdms")
    assert list(read.values) == ["Hammer", "Log/ai1", "Other/ai1"]
    assert read.rates == {"Hammer": pytest.approx(RATE)}
    assert read.units == {"Hammer": "V"}


LVM = """LabVIEW Measurement\t
Writer_Version\t2
Reader_Version\t2
Separator\tTab
Decimal_Separator\t,
Multi_Headings\tNo
X_Columns\tOne
Time_Pref\tRelative
***End_of_Header***\t
\t
Channels\t2\t
Samples\t3\t3\t
Y_Unit_Label\tVolts\tg\t
X_Dimension\tTime\tTime\t
X0\t0,0\t0,0\t
Delta_X\t0,001000\t0,001000\t
***End_of_Header***\t\t
X_Value\tHammer\tAcc\tComment
0,000000\t0,5\t1,25\t
0,001000\t0,25\t-1,5\t
0,002000\t0,125\t3,0E-1\t
"""


def test_labview_measurement(tmp_path: Path) -> None:
    (tmp_path / "a.lvm").write_text(LVM, encoding="utf-8")
    read = lvm.read(tmp_path / "a.lvm")
    np.testing.assert_array_equal(read.values["Acc"], [1.25, -1.5, 0.3])
    assert read.units == {"Hammer": "Volts", "Acc": "g"}
    assert read.rates["Acc"] == pytest.approx(1000.0)
    (tmp_path / "cut.lvm").write_text(LVM[:-12], encoding="utf-8")
    with pytest.raises(ValueError, match="cut short"):
        lvm.read(tmp_path / "cut.lvm")


def test_time_responses_of_a_universal_file(tmp_path: Path) -> None:
    for node, signal in ((1, FORCE), (2, ACC)):
        UFF(str(tmp_path / "a.uff")).write_sets(
            prepare_58(
                binary=0, func_type=1, rsp_node=node, rsp_dir=3, ref_node=1, ref_dir=3,
                data=signal, x=T, id1="hit",
                rsp_ent_name="NONE", ref_ent_name="NONE",
                abscissa_spacing=1, abscissa_inc=1 / RATE,
                abscissa_spec_data_type=17, ordinate_spec_data_type=12, ordinate_axis_units_lab="m/s2",
                orddenom_spec_data_type=0,
            ),
            "add",
        )  # fmt: skip
    read = uff_time.read(tmp_path / "a.uff")
    assert list(read.values) == ["1:+3", "2:+3"]
    np.testing.assert_allclose(read.values["2:+3"], ACC, atol=1e-11)
    assert read.rates["2:+3"] == pytest.approx(RATE)
    assert read.units["1:+3"] == "m/s2"


@pytest.mark.shared
@pytest.mark.skipif(not SAMPLES.is_dir(), reason="the sample files lie beside the checkout, and are absent")
def test_time_responses_of_a_real_recorder() -> None:
    read = uff_time.read(SAMPLES / "MPSTD#Set001_2024_10_08_10_27_07.uff")
    assert len(read.values) == 4
    assert len({len(values) for values in read.values.values()}) == 1


def test_the_guard_hands_back_what_the_reader_read(tmp_path: Path) -> None:
    np.savez(tmp_path / "a.npz", y=np.array([FORCE, ACC]), H=FORCE * 1j, fs=RATE)
    read = read_columns(tmp_path / "a.npz")
    np.testing.assert_array_equal(read.values["H"], FORCE * 1j)
    assert read.scalars == {"fs": RATE}


@pytest.mark.parametrize(
    ("name", "content", "message"),
    [
        ("a.xyz", b"", "ending '.xyz' is none of a measurement; allowed: .csv"),
        ("a.csv", b"hello\nworld\n", "no table of numbers"),
        ("a.csv", b"1,2\n1,2\n1,2\nx,2\n", "line 4: 'x,2'; 2 numbers wanted"),
        ("a.csv", b"\0" * 100, "give the file the ending of its format"),
        ("a.mat", b"MATLAB" + b"\7" * 400, "a.mat: "),
        ("a.wav", b"RIFF", "a.wav: "),
        ("a.npz", b"PK\3\4" + b"x" * 50, "a.npz: "),
        ("a.tdms", b"TDSm" + b"\xff" * 200, "a.tdms: "),
        ("a.lvm", b"hello", "no table of numbers"),
        ("a.uff", b"hello", "a.uff: "),
    ],
)
def test_what_is_no_measurement_is_refused_in_a_sentence(
    tmp_path: Path, name: str, content: bytes, message: str
) -> None:
    (tmp_path / name).write_bytes(content)
    with pytest.raises(ResultFileError) as told:
        read_columns(tmp_path / name)
    assert message in str(told.value)
    assert "\n" not in str(told.value)


def test_every_ending_belongs_to_one_format() -> None:
    endings = [ending for one in FORMATS for ending in one.endings]
    assert len(set(endings)) == len(endings)
    assert format_of(Path("A.WAV")).name == "wav"


@pytest.mark.parametrize(
    ("name", "program"), [("scan.svd", "Polytec"), ("frfs.blk", "MEscope"), ("A.SHP", "MEscope")]
)
def test_closed_formats_are_refused_with_the_next_step(name: str, program: str, tmp_path: Path) -> None:
    (tmp_path / name).write_bytes(b"\xd0\xcf\x11\xe0 compound file")
    with pytest.raises(ResultFileError, match=f"a file of {program}, .*export as UFF 58"):
        read_columns(tmp_path / name)
