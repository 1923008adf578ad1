"""From files as laboratories send them to FRFs: ``flexura new test`` and the declaration that it writes."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from nptdms import ChannelObject, TdmsWriter
from scipy.io import savemat

from analysis.estimation.transfer import MeasuredTransfer
from app.files.bad_file import ResultFileError
from app.files.declarations.modal_test import read_modal_test
from app.files.uff.frfs import write_frfs
from app.modal_test.declared_test import declared_frfs
from app.modal_test.frf_set import FrfSet, said_of_reference
from tests.app.modal_test.conftest import RATE, Beam, blows

Flexura = Callable[..., tuple[int, str, str]]
LINES = np.arange(1.0, 401.0)


def silent(_: str, __: float) -> None:
    """Take progress."""


def read(folder: Path) -> FrfSet:
    return declared_frfs(folder / "test.toml", silent)


def near(frfs: FrfSet, beam: Beam, order: int = 2) -> float:
    """Largest error of the first FRF between 60 and 600 Hz, relative to the largest value."""
    f = frfs.frequency
    exact, inside = beam.frf(f, 0, 0, order), (f > 60.0) & (f < 600.0)
    return float(np.abs(frfs.transfers[0].h - exact)[inside].max() / np.abs(exact)[inside].max())


def hits(beam: Beam, seconds: float = 6.0, count: int = 3) -> tuple[np.ndarray, np.ndarray]:
    force = blows(np.random.default_rng(2), seconds, count)
    return force, beam.answer(force, 0, 0)


def test_channels_that_begin_at_different_times_are_aligned(
    tmp_path: Path, beam: Beam, run_flexura: Flexura
) -> None:
    force, acc = hits(beam)
    timing = {"wf_increment": 1 / RATE, "wf_start_offset": 0.0}
    with TdmsWriter(tmp_path / "a.tdms") as writer:
        late = timing | {"wf_start_offset": 8 / RATE, "unit_string": "m/s2"}
        writer.write_segment(
            [
                ChannelObject("Log", "Hammer", force[:-8], timing | {"unit_string": "N"}),
                ChannelObject("Log", "Acc", acc[8:], late),
            ]
        )
    assert run_flexura("new", "test", tmp_path / "a.tdms", "-q") == (0, "", "")
    frfs = read(tmp_path)
    assert near(frfs, beam) < 0.02
    assert any("channels begin at different times" in note for note in frfs.notes)


def test_starts_apart_by_a_part_of_a_sample_are_refused_and_may_be_declared(
    tmp_path: Path, beam: Beam, run_flexura: Flexura
) -> None:
    force, acc = hits(beam)
    with TdmsWriter(tmp_path / "a.tdms") as writer:
        for name, values, start, unit in (("Hammer", force, 0.0, "N"), ("Acc", acc, 0.4 / RATE, "m/s2")):
            timing = {"wf_increment": 1 / RATE, "wf_start_offset": start, "unit_string": unit}
            writer.write_segment([ChannelObject("Log", name, values, timing)])
    assert run_flexura("new", "test", tmp_path / "a.tdms", "-q") == (0, "", "")
    with pytest.raises(ResultFileError, match=r"by a part of a sample.* declare start = 0 of each channel"):
        read(tmp_path)
    text = (tmp_path / "test.toml").read_text(encoding="utf-8")
    (tmp_path / "test.toml").write_text(text.replace("{ role", "{ start = 0.0, role"), encoding="utf-8")
    assert near(read(tmp_path), beam) < 0.02


@pytest.mark.parametrize("words", [(), ("--unused", "Temp")])
def test_a_channel_of_another_rate_that_is_not_used_does_not_count(
    tmp_path: Path, beam: Beam, words: tuple[str, ...], run_flexura: Flexura
) -> None:
    force, acc = hits(beam)
    with TdmsWriter(tmp_path / "a.tdms") as writer:
        for name, values, step, unit in (
            ("Hammer", force, 1 / RATE, "N"), ("Acc", acc, 1 / RATE, "m/s2"), ("Temp", np.arange(6.0), 1.0, "°C")
        ):  # fmt: skip
            timing = {"wf_increment": step, "unit_string": unit}
            writer.write_segment([ChannelObject("Log", name, values, timing)])
    assert run_flexura("new", "test", tmp_path / "a.tdms", *words, "-q") == (0, "", "")
    assert read_modal_test(tmp_path / "test.toml").channels["Temp"].role == "unused"
    assert near(read(tmp_path), beam) < 0.02


def test_a_declared_rate_settles_what_a_file_leaves_open(tmp_path: Path, beam: Beam, run_flexura: Flexura) -> None:
    force, acc = hits(beam)
    with TdmsWriter(tmp_path / "a.tdms") as writer:
        for name, values, unit in (("Hammer", force, "N"), ("Acc", acc, "m/s2")):
            timing = {"wf_increment": 1.0, "unit_string": unit}
            writer.write_segment([ChannelObject("Log", name, values, timing)])
    assert run_flexura("new", "test", tmp_path / "a.tdms", "-q") == (0, "", "")
    status, _, err = run_flexura("identify", tmp_path / "test.toml")
    assert status == 2
    assert "wf_increment = 1 s is what programs write" in err
    (tmp_path / "test.toml").unlink()
    assert run_flexura("new", "test", tmp_path / "a.tdms", "--rate", RATE, "-q") == (0, "", "")
    assert near(read(tmp_path), beam) < 0.02


def test_a_declared_rate_that_the_file_contradicts_is_noted(
    tmp_path: Path, beam: Beam, run_flexura: Flexura
) -> None:
    table = np.column_stack([np.arange(len(hits(beam)[0])) / RATE, *hits(beam)])
    np.savetxt(tmp_path / "a.csv", table, "%.9g", ",", header="Time [s],Hammer [N],Acc [m/s2]", comments="")
    assert run_flexura("new", "test", tmp_path / "a.csv", "--rate", 4000.0, "-q") == (0, "", "")
    assert "sample_rate = 4000 Hz is used as declared; its times 'Time' says 4096 Hz" in " ".join(
        read(tmp_path).notes
    )


def test_a_file_s_two_rates_are_compared(tmp_path: Path, beam: Beam, run_flexura: Flexura) -> None:
    force, acc = hits(beam)
    time = np.arange(len(force)) / RATE
    words = ("--drive", "force=N", "--response", "acc=m/s2", "-q")
    for name, rate in (("same", RATE), ("kilo", RATE / 1e3), ("other", 4000.0)):
        np.savez(tmp_path / f"{name}.npz", time=time, force=force, acc=acc, fs=rate)
        target = tmp_path / name / "test.toml"
        target.parent.mkdir()
        assert run_flexura("new", "test", tmp_path / f"{name}.npz", *words, "--out", target) == (0, "", "")
    assert near(read(tmp_path / "same"), beam) < 0.02
    assert near(read(tmp_path / "kilo"), beam) < 0.02
    with pytest.raises(
        ResultFileError, match=r"two sample rates: 4096\S* Hz by its times 'time' and 4000 Hz by its num"
    ):
        read(tmp_path / "other")


def test_gaps_in_a_minute_are_refused(tmp_path: Path, beam: Beam, run_flexura: Flexura) -> None:
    force, acc = hits(beam, 8.0, 4)
    table = np.delete(np.column_stack([np.arange(len(force)) / RATE, force, acc]), np.s_[20000:20004], axis=0)
    np.savetxt(tmp_path / "a.csv", table, "%.9g", ",", header="Time [s],Hammer [N],Acc [m/s2]", comments="")
    assert run_flexura("new", "test", tmp_path / "a.csv", "-q") == (0, "", "")
    with pytest.raises(ResultFileError, match="about 4 samples are missing"):
        read(tmp_path)


@pytest.mark.parametrize(("unit", "scale"), [("lbs", 4.4482216), ("N", 1.0)])
@pytest.mark.parametrize(("name", "quantity", "per"), [("G", "acceleration", 9.80665), ("um/m", "strain", 1e-6)])
def test_units_that_sensors_are_delivered_with(
    tmp_path: Path, unit: str, scale: float, name: str, quantity: str, per: float, beam: Beam, run_flexura: Flexura
) -> None:
    force, acc = hits(beam)
    table = np.column_stack([np.arange(len(force)) / RATE, force / scale, acc / per])
    head = f"Time [s],Hammer [{unit}],Answer [{name}]"
    np.savetxt(tmp_path / "a.csv", table, "%.9g", ",", header=head, comments="")
    assert run_flexura("new", "test", tmp_path / "a.csv", "-q") == (0, "", "")
    frfs = read(tmp_path)
    assert frfs.transfers[0].quantity == quantity
    assert near(frfs, beam) < 0.02


@pytest.mark.parametrize("before", [0.0007, 0.001, 0.02])
def test_records_of_an_analyser_have_a_short_pretrigger(
    tmp_path: Path, before: float, beam: Beam, run_flexura: Flexura
) -> None:
    """A millisecond: new test reads it from the file, and identify of all files."""
    for number, ahead in enumerate((before, 2.0 * before)):
        time = np.arange(round(2.0 * RATE)) / RATE
        force = 50.0 * np.exp(-(((time - ahead - 6e-4) / 4e-4) ** 2))
        table = np.column_stack([time, force, beam.answer(force, 0, 0)])
        head = "Time [s],Hammer [N],Acc [m/s2]"
        np.savetxt(tmp_path / f"hit{number}.csv", table, "%.9g", ",", header=head, comments="")
    assert run_flexura("new", "test", *sorted(tmp_path.glob("*.csv")), "-q") == (0, "", "")
    assert near(read(tmp_path), beam) < 0.02


def test_frfs_of_files_with_one_complex_column_have_their_places(tmp_path: Path) -> None:
    for node in (1, 2):
        np.savez(tmp_path / f"p{node}.npz", f=LINES, H=node / (62.0**2 - LINES**2 + 1j * LINES))
    table = (
        'format = "flexura-test/1"\nkind = "frf"\n[channels]\nf = { role = "frequency" }\nH = { role = "frf" }\n'
    )
    table += "".join(
        f'[[record]]\nfile = "p{n}.npz"\nat = {{ response = "{n}:+x", reference = "7:+z" }}\n' for n in (1, 2)
    )
    (tmp_path / "test.toml").write_text(table, encoding="utf-8")
    assert [(one.response, one.reference) for one in read(tmp_path).transfers] == [
        ("1:+1", "7:+3"),
        ("2:+1", "7:+3"),
    ]
    two = table.replace('H = { role = "frf" }', 'H = { role = "frf" }\nG = { role = "frf" }')
    np.savez(tmp_path / "p1.npz", f=LINES, H=1j / LINES, G=1 / LINES)
    (tmp_path / "test.toml").write_text(two, encoding="utf-8")
    with pytest.raises(ResultFileError, match="one place for the response, and 2 channels have the role frf"):
        read(tmp_path)


def frf_of(kind: str) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """FRF, and the two columns that a file has of it."""
    h = 1e3 / (62.0**2 - LINES**2 + 2j * 0.01 * 62.0 * LINES)
    degrees = np.degrees(np.angle(h))
    columns = {
        "parts": (h.real, h.imag),
        "degrees": (np.abs(h), degrees),
        "radians": (np.abs(h), np.angle(h)),
        "decibels": (20 * np.log10(np.abs(h)), degrees),
    }[kind]
    return h, *columns


@pytest.mark.parametrize("kind", ["parts", "degrees", "radians"])
def test_two_columns_without_names_are_magnitude_and_phase_where_they_look_so(
    tmp_path: Path, kind: str, run_flexura: Flexura
) -> None:
    h, one, other = frf_of(kind)
    np.savetxt(tmp_path / "a.txt", np.column_stack([LINES, one, other]), "%.12g")
    assert run_flexura("new", "test", tmp_path / "a.txt", "--kind", "frf", "-q") == (0, "", "")
    np.testing.assert_allclose(read(tmp_path).transfers[0].h, h, rtol=1e-6, atol=1e-9)


def test_decibels_without_names_are_not_guessed(tmp_path: Path, run_flexura: Flexura) -> None:
    _, one, other = frf_of("decibels")
    np.savetxt(tmp_path / "a.txt", np.column_stack([LINES, one, other]), "%.12g")
    status, _, err = run_flexura("new", "test", tmp_path / "a.txt", "--kind", "frf")
    assert status == 2
    assert '"Frequency,Magnitude,Phase"' in err


@pytest.mark.parametrize("unit", ["", "deg"])
def test_roles_of_magnitude_and_phase(tmp_path: Path, unit: str) -> None:
    h, one, other = frf_of("degrees")
    np.savetxt(tmp_path / "a.txt", np.column_stack([LINES, one, other]), "%.12g")
    phase = f'{{ role = "phase", unit = "{unit}" }}' if unit else '{ role = "phase" }'
    (tmp_path / "test.toml").write_text(
        f'format = "flexura-test/1"\nkind = "frf"\n[channels]\n1 = {{ role = "frequency" }}\n'
        f'2 = {{ role = "magnitude" }}\n3 = {phase}\n[[record]]\nfile = "a.txt"\n',
        encoding="utf-8",
    )
    np.testing.assert_allclose(read(tmp_path).transfers[0].h, h, rtol=1e-6, atol=1e-9)


def test_an_analyser_s_file_of_many_frfs_is_declared(tmp_path: Path, run_flexura: Flexura) -> None:
    h = 1e3 / (62.0**2 - LINES**2 + 1j * LINES)
    savemat(tmp_path / "a.mat", {f"H1_{n}": np.column_stack([LINES + 0j, n * h]) for n in range(2, 12)})
    assert run_flexura("new", "test", tmp_path / "a.mat", "-q") == (0, "", "")
    frfs = read(tmp_path)
    assert len(frfs.transfers) == 10
    np.testing.assert_allclose(frfs.transfers[3].h, 5 * h)


@pytest.mark.parametrize("line", [0.0, 1.0])
def test_only_the_line_at_0_hz_need_not_be_finite(tmp_path: Path, line: float, run_flexura: Flexura) -> None:
    lines = np.append(0.0, LINES)
    h = np.where(lines == line, np.nan + 1j * np.inf, 1.0 / (62.0**2 - lines**2 + 1j * (lines + 1e-9)))
    np.savez(tmp_path / "a.npz", f=lines, H=h)
    assert run_flexura("new", "test", tmp_path / "a.npz", "-q") == (0, "", "")
    if line == 0.0:
        np.testing.assert_array_equal(read(tmp_path).frequency, LINES)
    else:
        with pytest.raises(ResultFileError, match="values that are not finite"):
            read(tmp_path)


def test_transmissibilities_are_said_to_be_none_of_the_structure_s_frfs(tmp_path: Path) -> None:
    h = 1.0 / (62.0**2 - LINES**2 + 1j * LINES)
    ends = {"quantity": "acceleration", "frequency": LINES, "h": h}
    moved = MeasuredTransfer("T", "2:+3", "1:+3", reference_quantity="acceleration", **ends)
    (note,) = said_of_reference([moved])
    assert "no force was measured: transmissibility to the reference 1:+3" in note
    assert said_of_reference([MeasuredTransfer("A", "2:+3", "1:+3", **ends)]) == []


def test_a_shaker_without_a_force_sensor_gets_a_note(tmp_path: Path, run_flexura: Flexura) -> None:
    h = 1.0 / (62.0**2 - LINES**2 + 1j * LINES)
    moved = MeasuredTransfer("T", "2:+3", "1:+3", "velocity", LINES, h, "velocity")
    write_frfs(tmp_path / "a.uff", [moved])
    for words in (("--shared-poles", "--out", tmp_path / "run"), ()):
        _, _, err = run_flexura("identify", tmp_path / "a.uff", *words)
        assert "no force was measured" in " ".join(err.split())


def test_hits_of_several_levels_that_differ_are_noted(tmp_path: Path, beam: Beam, run_flexura: Flexura) -> None:
    """A structure that softens: its answer to stronger hits rings lower."""
    rng = np.random.default_rng(3)
    files = []
    for number, level in enumerate((2.5, 2.7, 3.0, 4.5, 4.8, 5.0)):
        time = np.arange(round(2.0 * RATE)) / RATE
        force = level * np.exp(-(((time - 0.05) / 6e-4) ** 2)) + 1e-3 * rng.standard_normal(len(time))
        answer = beam.answer(force, 0, 0)
        slower = np.interp(time / (1.0 + 2e-3 * (level - 2.5)), time, answer) + 1e-3 * rng.standard_normal(
            len(time)
        )
        files.append(tmp_path / f"hit{number}.csv")
        table = np.column_stack([time, force, slower])
        np.savetxt(files[-1], table, "%.9g", ",", header="Time [s],Hammer [N],Acc [m/s2]", comments="")
    assert run_flexura("new", "test", *files, "-q") == (0, "", "")
    assert any("drives of 2.48 to 4.97 N" in note and "not linear" in note for note in read(tmp_path).notes)
