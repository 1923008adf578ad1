"""What ``flexura new`` takes from the heads, units and groups of files."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from nptdms import ChannelObject, TdmsWriter
from pyuff import UFF
from pyuff.datasets.dataset_58 import prepare_58

from app.files.bad_file import ResultFileError
from app.files.declarations.modal_test import read_modal_test
from app.modal_test.declared_test import declared_frfs
from app.modal_test.new_declaration import points_of_table
from tests.app.modal_test.conftest import RATE, Beam, blows

Flexura = Callable[..., tuple[int, str, str]]


def silent(_: str, __: float) -> None:
    """Take progress."""


def three_blows(beam: Beam) -> np.ndarray:
    """Time, force and acceleration, (N, 3)."""
    force = blows(np.random.default_rng(2), 6.0, 3)
    return np.column_stack([np.arange(len(force)) / RATE, force, beam.answer(force, 0, 0)])


@pytest.mark.parametrize(
    ("head", "scale", "words"),
    [
        ("Time [ms],Hammer [N],Acc [m/s2]", 1e3, ()),
        ("Time,Hammer,Acc\nms,N,m/s2", 1e3, ()),
        ("time_ms,Hammer [N],Acc [m/s2]", 1e3, ()),
        ("t/ms,Hammer [N],Acc [m/s2]", 1e3, ()),
        ("Time us,Hammer [N],Acc [m/s2]", 1e6, ()),
        ("", 1.0, ("--drive", "2=N", "--response", "*=m/s2")),
    ],
)
def test_times_have_their_unit(
    tmp_path: Path, beam: Beam, head: str, scale: float, words: tuple[str, ...], run_flexura: Flexura
) -> None:
    table = three_blows(beam) * [scale, 1.0, 1.0]
    np.savetxt(tmp_path / "a.csv", table, "%.12g", ",", header=head, comments="")
    if not head:
        (tmp_path / "a.csv").write_text((tmp_path / "a.csv").read_text().lstrip("\n"))
    assert run_flexura("new", "test", tmp_path / "a.csv", *words, "-q") == (0, "", "")
    frequency = declared_frfs(tmp_path / "test.toml", silent).frequency
    assert frequency[-1] == pytest.approx(RATE / 2, rel=1e-3)


@pytest.mark.parametrize(
    ("unit", "factor", "message"),
    [("kHz", 1.0, ""), ("rad/s", 2e3 * np.pi, ""), ("rounds", 1.0, "one of Hz, kHz")],
)
def test_frequencies_have_their_unit(
    tmp_path: Path, unit: str, factor: float, message: str, run_flexura: Flexura
) -> None:
    lines = np.arange(1.0, 201.0)
    h = 1.0 / (50.0**2 - lines**2 + 2j * lines)
    table = np.column_stack([1e-3 * factor * lines, h.real, h.imag])
    np.savetxt(tmp_path / "a.csv", table, "%.12g", ";", header=f"Freq [{unit}];Real [g/N];Imag [g/N]", comments="")
    assert run_flexura("new", "test", tmp_path / "a.csv", "-q") == (0, "", "")
    assert read_modal_test(tmp_path / "test.toml").frf.response == "g"
    if message:
        status, _, err = run_flexura("identify", tmp_path / "test.toml")
        assert status == 2
        assert message in err
        return
    frfs = declared_frfs(tmp_path / "test.toml", silent)
    np.testing.assert_allclose(frfs.frequency, lines, rtol=1e-9)
    np.testing.assert_allclose(frfs.h[0], 9.80665 * h, rtol=1e-9)


@pytest.mark.parametrize(
    ("name", "factor"),
    [("f_kHz", 1e-3), ("omega", 2.0 * np.pi), ("freq_rad_s", 2.0 * np.pi), ("f", 1.0), ("f_Hz", 1.0)],
)
def test_a_unit_in_a_name_without_brackets_counts(
    tmp_path: Path, name: str, factor: float, run_flexura: Flexura
) -> None:
    """Variables of MATLAB and numpy can have no brackets in their names."""
    lines = np.arange(1.0, 201.0)
    arrays = {name: factor * lines, "H": 1.0 / (50.0**2 - lines**2 + 2j * lines)}
    np.savez(tmp_path / "a.npz", **arrays)
    assert run_flexura("new", "test", tmp_path / "a.npz", "-q") == (0, "", "")
    np.testing.assert_allclose(declared_frfs(tmp_path / "test.toml", silent).frequency, lines, rtol=1e-9)


def test_a_rate_in_kilohertz_counts_as_such(tmp_path: Path, beam: Beam, run_flexura: Flexura) -> None:
    _, force, answer = three_blows(beam).T
    np.savez(tmp_path / "a.npz", force=force, acc=answer, fs_kHz=RATE / 1e3)
    words = ("--drive", "force=N", "--response", "acc=m/s2", "-q")
    assert run_flexura("new", "test", tmp_path / "a.npz", *words) == (0, "", "")
    assert declared_frfs(tmp_path / "test.toml", silent).frequency[-1] == pytest.approx(RATE / 2, rel=1e-3)


@pytest.mark.parametrize(
    ("head", "order", "scale"),
    [
        ("node,x [mm],y [mm],z [mm]", (0, 1, 2, 3), 1e3),
        ("Node;X_mm;Y_mm;Z_mm", (0, 1, 2, 3), 1e3),
        ("x,y,z,node", (1, 2, 3, 0), 1.0),
        ("node,x,y,z", (0, 1, 2, 3), 1.0),
        ("", (0, 1, 2, 3), 1.0),
    ],
)
def test_places_have_the_unit_and_the_order_of_their_columns(
    tmp_path: Path, head: str, order: tuple[int, ...], scale: float
) -> None:
    places = np.array([[1.0, 0.1, 0.2, 0.0], [7.0, 0.3, 0.05, 0.01]]) * [1.0, scale, scale, scale]
    split = ";" if ";" in head else ","
    np.savetxt(tmp_path / "p.csv", places[:, order], "%.6g", split, header=head, comments="")
    found = points_of_table(tmp_path / "p.csv")
    assert list(found) == ["1", "7"]
    np.testing.assert_allclose([*found.values()], [[0.1, 0.2, 0.0], [0.3, 0.05, 0.01]])


def test_places_in_another_quantity_are_refused(tmp_path: Path) -> None:
    (tmp_path / "p.csv").write_text("node,x [N],y [N],z [N]\n1,0,0,0\n2,1,1,0\n3,1,0,0\n")
    with pytest.raises(ResultFileError, match=r"'x' is in N; allowed: m, cm, mm"):
        points_of_table(tmp_path / "p.csv")


def test_groups_with_the_same_channels_are_hits(tmp_path: Path, beam: Beam, run_flexura: Flexura) -> None:
    """A file of three hits in groups gives the FRF of the three averaged."""
    _, force, acc = three_blows(beam).T
    samples = len(force) // 3
    timing = {"wf_increment": 1.0 / RATE}
    with TdmsWriter(tmp_path / "a.tdms") as writer:
        for hit in range(3):
            part = slice(hit * samples, (hit + 1) * samples)
            channels = (("Dev1/ai0", force, "Newtons"), ("Acc", acc, "m/s^2"))
            objects = [
                ChannelObject(f"Hit {hit}", n, v[part], timing | {"unit_string": u}) for n, v, u in channels
            ]
            writer.write_segment(objects)
    status, _, err = run_flexura("new", "test", tmp_path / "a.tdms")
    assert status == 0
    assert "3 groups of channels, each a [[record]]: delete in" in err
    test = read_modal_test(tmp_path / "test.toml")
    assert [record.group for record in test.record] == ["Hit 0", "Hit 1", "Hit 2"]
    assert {name: one.role for name, one in test.channels.items()} == {"Dev1/ai0": "drive", "Acc": "response"}
    (frf,) = declared_frfs(tmp_path / "test.toml", silent).transfers
    assert frf.name == "accelerance Acc 1:+3 / Dev1/ai0 1:+3"
    assert frf.coherence is not None
    exact = beam.frf(frf.frequency, 0, 0, 2)
    near = (frf.frequency > 60.0) & (frf.frequency < 600.0)
    assert np.abs(frf.h - exact)[near].max() < 0.02 * np.abs(exact)[near].max()


def test_another_file_without_groups_is_named(tmp_path: Path, run_flexura: Flexura) -> None:
    for name, groups in (("a.tdms", ("1", "2")), ("b.tdms", ("1",))):
        with TdmsWriter(tmp_path / name) as writer:
            writer.write_segment([ChannelObject(g, c, np.arange(99.0)) for g in groups for c in ("Force", "Acc")])
    status, _, err = run_flexura("new", "test", tmp_path / "a.tdms", tmp_path / "b.tdms")
    assert status == 2
    assert "b.tdms: its channels are not in groups, as in the first file (1, 2); make a test of each" in err


def test_columns_beside_frfs_are_unused_and_not_asked_for(tmp_path: Path, run_flexura: Flexura) -> None:
    lines = np.arange(1.0, 50.0)
    np.savez(tmp_path / "a.npz", freq=lines, H=np.ones(49) * 1j, psd=lines, force_psd=lines)
    assert run_flexura("new", "test", tmp_path / "a.npz", "-q") == (0, "", "")
    roles = [one.role for one in read_modal_test(tmp_path / "test.toml").channels.values()]
    assert roles == ["frequency", "frf", "unused", "unused"]


def test_cross_spectra_beside_an_frf_are_not_frfs(tmp_path: Path, run_flexura: Flexura) -> None:
    """An analyser's record, named as case 2 of vibration_toolbox: its cross spectrum became a second response."""
    complex_values = {
        name: np.ones(49) * 1j for name in ("Hf_chan_2", "Lin_Spec_1", "Hf_Cross_Spec_chan_2", "Gxy")
    }
    np.savez(tmp_path / "a.npz", Freq_domain=np.arange(1.0, 50.0), **complex_values)
    assert run_flexura("new", "test", tmp_path / "a.npz", "-q") == (0, "", "")
    roles = {name: one.role for name, one in read_modal_test(tmp_path / "test.toml").channels.items()}
    assert [name for name, role in roles.items() if role == "frf"] == ["Hf_chan_2"]
    np.savez(tmp_path / "b.npz", Freq=np.arange(1.0, 50.0), FRF_spectrum=np.ones(49) * 1j)
    assert run_flexura("new", "test", tmp_path / "b.npz", "--out", tmp_path / "b.toml", "-q")[0] == 0
    assert read_modal_test(tmp_path / "b.toml").channels["FRF_spectrum"].role == "frf"


def test_a_channel_called_f_is_no_frf(tmp_path: Path, run_flexura: Flexura) -> None:
    np.savez(tmp_path / "a.npz", x=np.ones(99), f=np.ones(99), fs=100.0)
    status, _, err = run_flexura("new", "test", tmp_path / "a.npz")
    assert status == 2
    assert "name it with --drive NAME=SENSITIVITY. It holds: x, f" in err


@pytest.mark.parametrize(
    ("head", "lacks"),
    [
        ("t [s],F [N],a", "'a' has no unit in the file, and volts are assumed: give its unit, or its sensitivity"),
        ("t [s],F [N],a [V]", "'a' is in volts: give its sensitivity, for example"),
        ("t [s],F [N],a [furlongs]", "'a' has the unit 'furlongs', which is not known: give unit, for example"),
    ],
)
def test_what_a_channel_lacks_is_said_as_it_is(
    tmp_path: Path, head: str, lacks: str, run_flexura: Flexura
) -> None:
    np.savetxt(
        tmp_path / "a.csv", np.random.default_rng(0).random((9, 3)), delimiter=",", header=head, comments=""
    )
    status, _, err = run_flexura("new", "test", tmp_path / "a.csv")
    assert status == 0
    assert f"note: channel {lacks}" in err


def test_a_column_that_numbers_the_samples_is_unused(tmp_path: Path, beam: Beam, run_flexura: Flexura) -> None:
    rows = three_blows(beam)
    numbered = np.column_stack([np.arange(len(rows)), rows])
    np.savetxt(tmp_path / "a.csv", numbered, "%.9g", ",", header="Index,Time (s),Force (N),Acc (g)", comments="")
    assert run_flexura("new", "test", tmp_path / "a.csv", "-q") == (0, "", "")
    channels = read_modal_test(tmp_path / "test.toml").channels
    assert [one.role for one in channels.values()] == ["unused", "time", "drive", "response"]


def test_blows_one_after_the_other_in_a_universal_file_are_records(
    tmp_path: Path, beam: Beam, run_flexura: Flexura
) -> None:
    """The force of each blow, and the responses to it, were taken for further channels of one recording."""
    rows, sets = three_blows(beam), UFF(str(tmp_path / "a.uff"))
    for part in np.array_split(rows, 3):
        for node, signal, kind, unit in ((1, part[:, 1], 13, "N"), (1, part[:, 2], 12, "m/s2")):
            sets.write_sets(
                prepare_58(
                    binary=0, func_type=1, rsp_node=node, rsp_dir=3, ref_node=0, ref_dir=0,
                    data=signal, x=np.arange(len(part)) / RATE, id1="blow",
                    rsp_ent_name="NONE", ref_ent_name="NONE",
                    abscissa_spacing=1, abscissa_inc=1 / RATE,
                    abscissa_spec_data_type=17, ordinate_spec_data_type=kind, ordinate_axis_units_lab=unit,
                    orddenom_spec_data_type=0,
                ),
                "add",
            )  # fmt: skip
    assert run_flexura("new", "test", tmp_path / "a.uff", "-q")[0] == 0
    test = read_modal_test(tmp_path / "test.toml")
    assert [record.group for record in test.record] == ["run 1", "run 2", "run 3"]
    assert [(one.role, one.at) for one in test.channels.values()] == [("drive", "1:+z"), ("response", "1:+z")]
    (transfer,) = declared_frfs(tmp_path, silent).transfers
    true = beam.frf(transfer.frequency, 0, 0, 2)
    band = (transfer.frequency > 50) & (transfer.frequency < 600)
    assert np.abs(transfer.h - true)[band].max() < 0.02 * np.abs(true[band]).max()


def test_nodes_and_directions_of_a_universal_file_are_declared(tmp_path: Path, run_flexura: Flexura) -> None:
    """Responses were numbered in their order, so that shapes stood at the wrong nodes."""
    time = np.arange(64) / 1000.0
    for node, direction, unit in ((7, -3, "N"), (12, 1, "m/s2"), (3, 3, "m/s2"), (0, 0, "m/s2")):
        UFF(str(tmp_path / "a.uff")).write_sets(
            prepare_58(
                binary=0, func_type=1, rsp_node=node, rsp_dir=direction, ref_node=1, ref_dir=3,
                data=np.sin(300.0 * time), x=time, id1="run",
                rsp_ent_name="NONE", ref_ent_name="NONE",
                abscissa_spacing=1, abscissa_inc=1e-3,
                abscissa_spec_data_type=17, ordinate_spec_data_type=12, ordinate_axis_units_lab=unit,
                orddenom_spec_data_type=0,
            ),
            "add",
        )  # fmt: skip
    status, _, err = run_flexura("new", "test", tmp_path / "a.uff", "-q")
    assert status == 0, err
    channels = read_modal_test(tmp_path / "test.toml").channels
    assert [one.at for one in channels.values()] == ["7:-z", "12:+x", "3:+z", "1:+z"]
