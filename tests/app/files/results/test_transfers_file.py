"""Measured transfers from universal files and HDF5: what is read, and what is refused."""

from dataclasses import replace

import h5py
import numpy as np
import pytest
import pyuff
from pyuff.datasets.dataset_58 import prepare_58

from analysis.estimation.transfer import MeasuredTransfer
from analysis.focusing.measured import MeasuredTransfers
from app.files.bad_file import ResultFileError
from app.files.results.transfers_file import read_transfers, transfer_files, write_transfers
from app.files.uff.frfs import write_frfs

FREQUENCY = np.arange(40.0, 400.0, 5.0)
POINTS = np.array([[0.05, 0.1], [0.1, 0.1], [0.2, 0.05]])
BAND = (60.0, 360.0)


def answer(node, source):
    return (1.0 + node + 10j * source) * 1e-6 / (1.0 + 1j * FREQUENCY / 200.0)


def frf(node, source, response="+3", quantity="displacement"):
    times = {"displacement": 0, "velocity": 1, "acceleration": 2}[quantity]
    h = answer(node, source) * (2j * np.pi * FREQUENCY) ** times
    return MeasuredTransfer("", f"{node}:{response}", f"{source}:+3", quantity, FREQUENCY, h)


def scan(path, frfs):
    write_frfs(path, frfs)
    none = np.zeros(3, dtype=int)
    nodes = pyuff.prepare_2411(np.arange(1, 4), none, none, none, *POINTS.T, np.zeros(3))
    pyuff.UFF(str(path)).write_sets(nodes | {"type": 2411}, "add")
    return path


def every(**changes):
    return [frf(node, source, **changes) for source in (8, 9) for node in (1, 2, 3)]


@pytest.mark.parametrize("quantity", ["displacement", "velocity", "acceleration"])
def test_motions_of_any_kind_become_displacements(tmp_path, quantity):
    read = read_transfers(scan(tmp_path / "scan.uff", every(quantity=quantity)), BAND, 21.5)
    expected = [[[answer(node, source) for node in (1, 2, 3)] for source in (8, 9)]]
    np.testing.assert_allclose(read.transfer, np.swapaxes(expected, 2, 3), rtol=1e-9)
    np.testing.assert_array_equal(read.points, POINTS)
    assert read.temperature.tolist() == [21.5]
    assert not read.variance.any()


def test_a_sensor_that_points_the_other_way_is_turned_round(tmp_path):
    turned = [replace(one, response="2:-3", h=-one.h) if one.response == "2:+3" else one for one in every()]
    straight = read_transfers(scan(tmp_path / "straight.uff", every()), BAND, 20.0)
    found = read_transfers(scan(tmp_path / "turned.uff", turned), BAND, 20.0)
    np.testing.assert_allclose(found.transfer, straight.transfer, rtol=1e-12)


def test_a_node_that_answers_in_two_directions_is_refused(tmp_path):
    frfs = [*every(), frf(2, 9, "+1")]
    with pytest.raises(ResultFileError, match=r"node 2 answers node 9 twice, as 2:\+3 and 2:\+1; keep one FRF"):
        read_transfers(scan(tmp_path / "scan.uff", frfs), BAND, 20.0)


def test_several_temperatures_in_one_file_are_refused_with_the_way_to_split_them(tmp_path):
    path = scan(tmp_path / "scan.uff", every() + every())
    wanted = r"node 1 answers node 8 more than once as 1:\+3; .* Write one file for each, named by it .*folder"
    with pytest.raises(ResultFileError, match=wanted):
        read_transfers(path, BAND, 20.0)


def test_what_macos_leaves_in_a_folder_is_not_read(tmp_path):
    for temperature in (20, 30):
        scan(tmp_path / f"scan_{temperature}C.uff", every())
        (tmp_path / f"._scan_{temperature}C.uff").write_bytes(b"\0\5\x16\7")
    (tmp_path / ".DS_Store").write_bytes(b"\0\0\0\1Bud1")
    assert [one.name for one in transfer_files(tmp_path)] == ["scan_20C.uff", "scan_30C.uff"]
    assert read_transfers(tmp_path, BAND, 20.0).temperature.tolist() == [20.0, 30.0]


def test_a_damaged_coordinate_is_refused_in_a_sentence(tmp_path):
    """The library meets it with a plain Exception."""
    path = scan(tmp_path / "scan.uff", every())
    head, kind, points = path.read_text().rpartition("  2411")
    path.write_text(head + kind + points.replace("e-02", "p-02", 1))
    with pytest.raises(ResultFileError, match=r"data set of points \(2411\) cannot be read; damaged"):
        read_transfers(path, BAND, 20.0)


def test_coherence_in_the_file_gives_the_variance(tmp_path):
    """Of an acceleration: over the fourth power of the circular frequency. Its course is known from theory."""
    path = scan(tmp_path / "scan.uff", every(quantity="acceleration"))
    coherence = 1.0 - 0.2 * FREQUENCY / FREQUENCY[-1]
    ends = {"rsp_node": 2, "rsp_dir": 3, "ref_node": 9, "ref_dir": 3, "rsp_ent_name": "", "ref_ent_name": ""}
    added = prepare_58(
        binary=0, func_type=6, data=coherence, x=FREQUENCY, id1="coherence", abscissa_spacing=1,
        abscissa_min=40.0, abscissa_inc=5.0, abscissa_spec_data_type=18, ordinate_spec_data_type=0,
        ordinate_axis_units_lab="", orddenom_spec_data_type=0, orddenom_axis_units_lab="", **ends,
    )  # fmt: skip
    pyuff.UFF(str(path)).write_sets(added, "add")
    read = read_transfers(path, BAND, 20.0)
    found = read.variance[0, 1, :, 1]
    expected = np.abs(answer(2, 9)) ** 2 * (1.0 - coherence) / coherence
    assert found.min() > 0.0
    np.testing.assert_allclose(found / found[0], expected / expected[0], rtol=1e-6)
    assert np.count_nonzero(read.variance) == len(FREQUENCY)


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"temperature": [np.nan]}, r"temperature \[nan\]: allowed are finite numbers"),
        ({"transfer": np.ones(5)}, r"transfer \(5,\) and variance \(5,\) must be"),
        ({"frequency": 50.0}, r"frequency \(\) and points"),
        ({"frequency": [50.0], "transfer": np.ones((2, 1, 3))}, "with 2 lines or more"),
        ({"frequency": np.zeros(0), "transfer": np.ones((2, 0, 3))}, "with 2 lines or more"),
        ({"points": np.ones((3, 3))}, r"points \(3, 3\) must be"),
        ({"temperature": [20.0, 30.0]}, r"must be \(T, N, F, K\) with T 2"),
        ({"temperature": "warm"}, "'temperature' is of type"),
    ],
)
def test_datasets_of_other_shapes_are_refused_in_a_sentence(tmp_path, changes, said):
    parts = {
        "temperature": [20.0],
        "points": POINTS,
        "frequency": FREQUENCY,
        "transfer": np.ones((2, len(FREQUENCY), 3)),
    }
    with h5py.File(tmp_path / "scan.h5", "w") as file:
        for name, value in (parts | changes).items():
            file[name] = value
    with pytest.raises(ResultFileError, match=said):
        read_transfers(tmp_path / "scan.h5", BAND, 20.0)


def test_a_bit_changed_in_a_file_of_ours_is_refused(tmp_path):
    """The file carries the digest of its bytes: transfers that were changed design other filters, unseen."""
    path = tmp_path / "scan.h5"
    h = np.ones((1, 2, len(FREQUENCY), 3), dtype=complex)
    write_transfers(path, MeasuredTransfers(np.array([20.0]), POINTS, FREQUENCY, h, np.zeros(h.shape)))
    whole = path.read_bytes()
    place = whole.index(np.array([1.0 + 0j] * 8).tobytes()) + 7
    path.write_bytes(whole[:place] + bytes([whole[place] ^ 0x10]) + whole[place + 1 :])
    with pytest.raises(ResultFileError, match=r"not a readable HDF5 file \(damaged, cut short or edited"):
        read_transfers(path, BAND, 20.0)


def test_a_damaged_file_of_others_is_refused_in_a_sentence(tmp_path):
    """HDF5 meets some damage with RuntimeError, and some without an end: it is tried in a process of its own."""
    with h5py.File(tmp_path / "scan.h5", "w") as file:
        file["transfer"] = np.ones((2, len(FREQUENCY), 3))
    whole = (tmp_path / "scan.h5").read_bytes()
    (tmp_path / "scan.h5").write_bytes(whole.replace(b"HEAP", b"heap"))
    with pytest.raises(ResultFileError, match=r"scan\.h5: not a readable HDF5 file \(damaged: "):
        read_transfers(tmp_path / "scan.h5", BAND, 20.0)


def at(factor):
    return [replace(one, h=factor * one.h) for one in every()]


@pytest.fixture
def scans(tmp_path):
    folder = tmp_path / "scans"
    folder.mkdir()
    for name, factor in (("scan_20C", 1.0), ("scan_-5.5C", 2.0), ("warm 40 °C", 3.0)):
        scan(folder / f"{name}.uff", at(factor))
    return folder


def test_a_folder_holds_one_universal_file_a_temperature(scans):
    read, one = read_transfers(scans, BAND, 99.0), read_transfers(scans / "scan_20C.uff", BAND, 20.0)
    assert read.temperature.tolist() == [-5.5, 20.0, 40.0]
    np.testing.assert_allclose(read.transfer, one.transfer * np.array([2.0, 1.0, 3.0])[:, None, None, None])
    np.testing.assert_array_equal(read.points, POINTS)
    assert [path.name for path in transfer_files(scans)] == ["scan_-5.5C.uff", "scan_20C.uff", "warm 40 °C.uff"]


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("scan-30C", r"scan-30C.uff has no temperature in its name; name it as scan_21.5C.uff"),
        ("again_20C", r"again_20C.uff and scan_20C.uff are both of 20 °C; keep one of them"),
    ],
)
def test_files_of_a_folder_that_are_of_no_one_temperature(scans, name, message):
    scan(scans / f"{name}.uff", every())
    with pytest.raises(ResultFileError, match=message):
        read_transfers(scans, BAND, 20.0)


def test_files_of_a_folder_that_measured_different_things(scans):
    scan(scans / "x_50C.uff", [one for one in every() if one.reference == "8:+3"])
    with pytest.raises(
        ResultFileError, match=r"x_50C.uff and scan_-5.5C.uff differ in their actuators; export all"
    ):
        read_transfers(scans, BAND, 20.0)


def test_files_of_a_folder_that_were_driven_elsewhere(scans):
    """As many actuators, at other nodes: the filters of one would be played on another."""
    scan(scans / "x_50C.uff", [frf(node, source) for source in (8, 10) for node in (1, 2, 3)])
    with pytest.raises(ResultFileError, match=r"x_50C.uff and scan_-5.5C.uff differ in their actuators"):
        read_transfers(scans, BAND, 20.0)


@pytest.mark.parametrize(
    ("frfs", "message"),
    [
        ([*every(), frf(4, 8)], "scans: x_50C.uff: node 4 has no coordinates"),
        (every()[1:], "scans: x_50C.uff: 1 of 6 transfers are missing"),
    ],
)
def test_what_is_wrong_in_a_folder_is_told_of_the_file(scans, frfs, message):
    scan(scans / "x_50C.uff", frfs)
    with pytest.raises(ResultFileError, match=message):
        read_transfers(scans, BAND, 20.0)


def test_a_folder_without_universal_files(tmp_path):
    with pytest.raises(ResultFileError, match="a folder without universal files"):
        read_transfers(tmp_path, BAND, 20.0)
