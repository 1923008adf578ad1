import re
import struct
from pathlib import Path

import numpy as np
import pytest
import pyuff
from pyuff.datasets.dataset_58 import prepare_58

from analysis.estimation.transfer import MeasuredTransfer
from app.files.bad_file import ResultFileError
from app.files.uff.frfs import read_frfs, write_frfs
from app.modal_test.declared_test import of_universal

SAMPLES = Path(__file__).resolve().parents[5] / "shared" / "data" / "real" / "uff58_samples"
FREQUENCY = np.arange(0.0, 50.0, 0.5)
RNG = np.random.default_rng(0)
H = RNG.normal(size=100) + 1j * RNG.normal(size=100)


def data_set(**changes: object) -> dict[str, object]:
    fields: dict[str, object] = {
        "binary": 0,
        "func_type": 4,
        "rsp_node": 7,
        "rsp_dir": -3,
        "ref_node": 2,
        "ref_dir": 1,
        "data": H,
        "x": FREQUENCY,
        "id1": "door panel",
        "rsp_ent_name": "NONE",
        "ref_ent_name": "NONE",
        "abscissa_spacing": 1,
        "abscissa_spec_data_type": 18,
        "ordinate_spec_data_type": 12,
        "orddenom_spec_data_type": 13,
    }
    prepared: dict[str, object] = prepare_58(**(fields | changes))
    return prepared


def written(path: Path, *sets: dict[str, object]) -> Path:
    pyuff.UFF(str(path)).write_sets(list(sets), "add")
    return path


@pytest.mark.filterwarnings("ignore::ResourceWarning", "ignore::pytest.PytestUnraisableExceptionWarning")
@pytest.mark.parametrize("binary", [0, 1])
def test_frfs_of_another_program_are_read(tmp_path: Path, binary: int) -> None:
    (frf,) = read_frfs(written(tmp_path / "a.uff", data_set(binary=binary)))
    assert (frf.name, frf.response, frf.reference, frf.quantity) == ("door panel", "7:-3", "2:+1", "acceleration")
    np.testing.assert_array_equal(frf.frequency, FREQUENCY[1:])
    np.testing.assert_allclose(frf.h, H[1:], rtol=1e-11)


def test_big_endian_single_precision_is_read(tmp_path: Path) -> None:
    """As written by an analyser, byte by byte: no other program has this form in its own writer."""
    lines = written(tmp_path / "a.uff", data_set()).read_bytes().splitlines(keepends=True)
    header = lines[:13]
    header[1] = f"{58:6d}b{2:6d}{2:6d}{11:12d}{800:12d}{0:6d}{0:6d}{0:12d}{0:12d}\n".encode()
    header[8] = header[8].replace(b"         6", b"         5", 1)
    values = np.column_stack([H.real, H.imag]).ravel()
    path = tmp_path / "b.uff"
    path.write_bytes(b"".join(header) + struct.pack(f">{len(values)}f", *values) + b"\n    -1\n")
    np.testing.assert_allclose(read_frfs(path)[0].h, H[1:], rtol=1e-6)


def coherence_set(values: np.ndarray, **changes: object) -> dict[str, object]:
    """Make a coherence of the same ends as `data_set`."""
    return data_set(func_type=6, data=values, ordinate_spec_data_type=0, orddenom_spec_data_type=0, **changes)


def test_a_coherence_beside_its_frf_becomes_its_variance(tmp_path: Path) -> None:
    coherence = np.clip(1.0 - 0.1 * RNG.random(100), 0.0, 1.0)
    (frf,) = read_frfs(written(tmp_path / "a.uff", data_set(), coherence_set(coherence)))
    assert frf.coherence is not None
    assert frf.variance is not None
    np.testing.assert_allclose(frf.coherence, coherence[1:], rtol=1e-6)
    ratio = frf.variance / (np.abs(H[1:]) ** 2 * (1 - coherence[1:]) / coherence[1:])
    np.testing.assert_allclose(ratio, ratio[0], rtol=1e-4)
    other = written(tmp_path / "b.uff", data_set(), coherence_set(coherence, rsp_node=9))
    assert read_frfs(other)[0].variance is None
    with pytest.raises(ResultFileError, match="0 to 1 allowed"):
        read_frfs(written(tmp_path / "c.uff", data_set(), coherence_set(2.0 * coherence)))


def test_a_coherence_of_one_throughout_gives_no_variance_and_a_note(tmp_path: Path) -> None:
    path = written(tmp_path / "a.uff", data_set(), coherence_set(np.ones(100)))
    (frf,) = read_frfs(path)
    assert frf.variance is None
    (note,) = of_universal(path, [frf]).notes
    assert "door panel: coherence 1 on every line" in note


@pytest.mark.parametrize(("unit", "said"), [(1.0, 0), (1000.0, 1)])
def test_a_structure_as_large_as_a_street_is_asked_for_its_unit(tmp_path: Path, unit: float, said: int) -> None:
    """240 mm without a data set 164 are 240 m."""
    nodes = {2: (0.0, 0.0, 0.0), 7: (0.24 * unit, 0.19 * unit, 0.0)}
    path = tmp_path / "a.uff"
    write_frfs(path, [MeasuredTransfer("a", "7:+3", "2:+3", "accelerance", FREQUENCY[1:], H[1:])], nodes)
    notes = of_universal(path, read_frfs(path)).notes
    assert sum("up to 240 m apart; if they are in mm" in one for one in notes) == said


def test_a_dead_channel_with_a_coherence_of_zero_is_left_out_with_a_note(tmp_path: Path) -> None:
    dead = [data_set(rsp_node=8, data=0.0 * H, id1="dead"), coherence_set(np.zeros(100), rsp_node=8)]
    path = written(tmp_path / "a.uff", data_set(), coherence_set(np.full(100, 0.9)), *dead)
    frfs = read_frfs(path)
    assert [frf.variance is None for frf in frfs] == [False, True]
    found = of_universal(path, frfs)
    assert [frf.name for frf in found.transfers] == ["door panel"]
    assert "dead (8:-3 / 2:+1): zero on every line" in found.notes[0]


def test_a_line_of_no_coherence_weighs_nothing_even_where_its_frf_is_zero(tmp_path: Path) -> None:
    h, coherence = H.copy(), np.full(100, 0.9)
    h[40], coherence[40] = 0.0, 0.0
    (frf,) = read_frfs(written(tmp_path / "a.uff", data_set(data=h), coherence_set(coherence)))
    assert frf.variance is not None
    assert frf.variance[39] > 1e4 * np.delete(frf.variance, 39).max()


def test_uneven_lines_are_read_and_written(tmp_path: Path) -> None:
    uneven = FREQUENCY**1.5
    (frf,) = read_frfs(written(tmp_path / "a.uff", data_set(x=uneven, abscissa_spacing=0)))
    np.testing.assert_allclose(frf.frequency, uneven[1:], rtol=1e-5)
    write_frfs(tmp_path / "b.uff", [frf])
    (again,) = read_frfs(tmp_path / "b.uff")
    np.testing.assert_allclose(again.frequency, frf.frequency, rtol=1e-9)
    np.testing.assert_allclose(again.h, frf.h, rtol=1e-12)


def test_what_we_write_we_read(tmp_path: Path) -> None:
    frfs = [
        MeasuredTransfer(f"point {n}", f"{n}:+3", "1:-2", quantity, FREQUENCY[1:], H[1:] * n)
        for n, quantity in enumerate(("displacement", "velocity", "acceleration", "unknown"), start=1)
    ]
    write_frfs(tmp_path / "a.uff", frfs)
    again = read_frfs(tmp_path / "a.uff")
    for one, other in zip(frfs, again, strict=True):
        assert (one.name, one.response, one.reference) == (other.name, other.response, other.reference)
        assert one.quantity == other.quantity
        np.testing.assert_allclose(other.h, one.h, rtol=1e-12)


@pytest.mark.parametrize("spacing", [0.01953125, 1.0 / 3.0, 44100 / 65536])
def test_lines_come_back_with_more_than_six_digits(tmp_path: Path, spacing: float) -> None:
    """As other programs write them, in 13 columns with an exponent, lines at 1000 Hz would be 3 mHz off."""
    frequency = spacing * np.arange(3000, 3100)
    write_frfs(tmp_path / "a.uff", [MeasuredTransfer("a", "1:+3", "1:+3", "velocity", frequency, H)])
    (again,) = read_frfs(tmp_path / "a.uff")
    np.testing.assert_allclose(again.frequency, frequency, rtol=1e-9)
    np.testing.assert_allclose(again.h, H, rtol=1e-12)


def test_rounding_of_the_first_two_lines_does_not_add_up_over_the_others(tmp_path: Path) -> None:
    frequency = np.round(np.arange(1, 48001) / 3.0, 8)
    h = np.full(48000, 1.0 + 1j)
    write_frfs(tmp_path / "a.uff", [MeasuredTransfer("a", "1:+3", "1:+3", "velocity", frequency, h)])
    (again,) = read_frfs(tmp_path / "a.uff")
    np.testing.assert_allclose(again.frequency, frequency, rtol=0, atol=1e-5)


@pytest.mark.filterwarnings("ignore")
def test_frfs_are_read_back_by_sdynpy(tmp_path: Path) -> None:
    read = pytest.importorskip(
        "sdynpy.fileio.sdynpy_uff", reason="SDynPy is in the extra bench (docs/dependencies.md)"
    )
    uneven = FREQUENCY[1:] ** 1.5
    frfs = [
        MeasuredTransfer("even", "7:-3", "2:+1", "acceleration", FREQUENCY[1:], H[1:]),
        MeasuredTransfer("uneven", "8:+3", "2:+1", "velocity", uneven, -H[1:]),
    ]
    write_frfs(tmp_path / "a.uff", frfs)
    sets = read.readunv(str(tmp_path / "a.uff"))[58]
    for one, other in zip(frfs, sets, strict=True):
        np.testing.assert_allclose(other.ordinate, one.h, rtol=1e-12)
        assert (other.response_node, other.reference_node) == (int(one.response[0]), 2)
    np.testing.assert_allclose(sets[1].abscissa, uneven, rtol=1e-7)  # SDynPy keeps these in single precision


def test_other_functions_are_named(tmp_path: Path) -> None:
    path = written(tmp_path / "a.uff", data_set(func_type=1, data=H.real), data_set(func_type=2, data=H.real))
    with pytest.raises(ResultFileError, match=r"58 \(auto spectrum\), 58 \(time response\)"):
        read_frfs(path)


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"data": H.real}, "real values"),
        ({"data": H[:6], "x": FREQUENCY[:6]}, "5 lines above 0 Hz"),
        ({"x": FREQUENCY[::-1].copy(), "abscissa_spacing": 0}, "ascend"),
    ],
)
def test_frfs_that_are_none_are_refused_by_name(tmp_path: Path, changes: dict[str, object], words: str) -> None:
    path = written(tmp_path / "a.uff", data_set(**changes))
    with pytest.raises(ResultFileError, match=f"FRF 1 .door panel.: .*{words}"):
        read_frfs(path)


@pytest.mark.parametrize("value", ["NaN", "Infinity"])
def test_values_that_are_not_finite_are_refused(tmp_path: Path, value: str) -> None:
    text = written(tmp_path / "a.uff", data_set()).read_text()
    number = f"{H[20].real:20.11e}"
    assert number in text
    (tmp_path / "a.uff").write_text(text.replace(number, f"{value:>20}"))
    with pytest.raises(ResultFileError, match="not finite"):
        read_frfs(tmp_path / "a.uff")


def test_a_file_cut_short_is_refused(tmp_path: Path) -> None:
    whole = written(tmp_path / "a.uff", data_set()).read_bytes()
    for share in (0.05, 0.3, 0.6, 0.95):
        (tmp_path / "cut.uff").write_bytes(whole[: int(share * len(whole))])
        with pytest.raises(ResultFileError, match="cut short"):
            read_frfs(tmp_path / "cut.uff")


@pytest.mark.filterwarnings("ignore::ResourceWarning", "ignore::pytest.PytestUnraisableExceptionWarning")
@pytest.mark.parametrize("binary", [0, 1])
def test_a_file_of_several_frfs_cut_anywhere_is_never_read_with_fewer(tmp_path: Path, binary: int) -> None:
    sets = [data_set(binary=binary, rsp_node=node) for node in (1, 2, 3)]
    whole = written(tmp_path / "a.uff", *sets).read_bytes()
    assert len(read_frfs(tmp_path / "a.uff")) == 3
    rng = np.random.default_rng(4)
    ends = [found.end() for found in re.finditer(rb"    -1[ ]*\n", whole)][1::2]
    shifts = (-8, -7, -2, 1, 3, 4, 6, 7, 8, 14)
    near = [end + shift for end in ends for shift in shifts if end + shift < len(whole) - 1]
    for length in (*near, *rng.integers(1, ends[-1] - 2, 150)):
        if any(end - 1 <= length <= end for end in ends):
            continue  # between two sets: nothing in the format tells how many there are
        (tmp_path / "cut.uff").write_bytes(whole[:length])
        with pytest.raises(ResultFileError, match=r"cut short|cut\.uff"):
            read_frfs(tmp_path / "cut.uff")


def test_a_damaged_line_between_two_frfs_is_refused(tmp_path: Path) -> None:
    whole = written(tmp_path / "a.uff", data_set(rsp_node=1), data_set(rsp_node=2)).read_bytes()
    for place in [found.start() for found in re.finditer(rb"    -1", whole)]:
        for shift in (3, 4, 5):
            damaged = bytearray(whole)
            damaged[place + shift] = ord("7")
            (tmp_path / "b.uff").write_bytes(damaged)
            with pytest.raises(ResultFileError, match=r"b\.uff"):
                read_frfs(tmp_path / "b.uff")


@pytest.mark.parametrize("content", [b"", b"\x00" * 500, b"    -1\n    58\n    -1\n", b"frequency,re,im\n1,2,3\n"])
def test_other_files_are_refused(tmp_path: Path, content: bytes) -> None:
    (tmp_path / "x.uff").write_bytes(content)
    with pytest.raises(ResultFileError, match=r"x\.uff"):
        read_frfs(tmp_path / "x.uff")
    with pytest.raises(ResultFileError, match="no such file"):
        read_frfs(tmp_path / "absent.uff")


def test_no_damage_gets_past_as_anything_but_a_refusal(tmp_path: Path) -> None:
    """Three hundred damaged copies: read, or refused in a sentence; nothing else."""
    rng = np.random.default_rng(6)
    whole = written(tmp_path / "a.uff", data_set()).read_bytes()
    refused = 0
    for _ in range(300):
        damaged = bytearray(whole)
        for _ in range(rng.integers(1, 6)):
            place = int(rng.integers(1200))
            damaged[place : place + int(rng.integers(3))] = (
                rng.integers(256, size=rng.integers(4)).astype(np.uint8).tobytes()
            )
        (tmp_path / "d.uff").write_bytes(bytes(damaged))
        try:
            read_frfs(tmp_path / "d.uff")
        except ResultFileError:
            refused += 1
    assert 0 < refused < 300


@pytest.mark.shared
@pytest.mark.skipif(not SAMPLES.is_dir(), reason="the measured samples lie beside the checkout, and are absent")
@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("MPSTD#Set001_2024_10_08_10_27_07.uff", "time response"),
        ("Sample_UFF58b_bin.uff", "time response"),
        ("sample_dataset58_psd.uff", "PSD"),
        ("non_ascii_header.uff", "5 lines above 0 Hz"),
    ],
)
def test_samples_of_other_programs(name: str, words: str) -> None:
    with pytest.raises(ResultFileError, match=words):
        read_frfs(SAMPLES / name)


def test_frfs_of_one_name_are_told_apart_by_their_ends(tmp_path: Path) -> None:
    """Also what of them is written again and read back."""
    sets = [data_set(rsp_node=node, id1=name) for name in ("door", "NONE") for node in (1, 2, 2)]
    frfs = read_frfs(written(tmp_path / "a.uff", *sets, data_set(id1="single")))
    ends = ["1:-3 / 2:+1", "2:-3 / 2:+1", "2:-3 / 2:+1 (2)"]
    assert [frf.name for frf in frfs] == [*(f"door {one}" for one in ends), *ends, "single"]
    write_frfs(tmp_path / "b.uff", frfs)
    assert [frf.name for frf in read_frfs(tmp_path / "b.uff")] == [frf.name for frf in frfs]
