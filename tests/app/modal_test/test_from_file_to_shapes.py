"""Tests of a beam whose modes are known, from the files of a laboratory to shapes, as typed."""

import json
from pathlib import Path

import numpy as np
import pytest
import pyuff
from scipy.io import savemat, wavfile

from analysis.estimation.transfer import MeasuredTransfer
from analysis.shapes.participation import mac
from app.files.uff.frfs import read_frfs
from app.modal_test.declared_test import declared_frfs
from app.modal_test.frf_set import FrfSet
from app.modal_test.modes_of_test import load_stabilization, load_test
from app.modal_test.without_windows import rebuilt
from app.plate_frfs.plate_of_modes import modes_of_table
from tests.app.modal_test.conftest import ETA, POINTS, RATE, SHAPES, Beam, F, blows, hammer_files, typed


def found(run: Path, band: tuple[float, float] = (60.0, 700.0)) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Frequencies, loss factors and shapes of the modes of a run inside the band."""
    _, modes, shapes = load_test(run)
    reading = modes.reading("viscous")
    f = reading.frequency_hz[shapes.pole]
    inside = (f > band[0]) & (f < band[1])
    return f[inside], reading.loss_factor[shapes.pole][inside], shapes.shape[inside]


def assert_beam(run: Path, loss: float = 0.03, alike: float = 0.999) -> None:
    f, eta, shapes = found(run)
    np.testing.assert_allclose(f, F, rtol=1e-3)
    np.testing.assert_allclose(eta, ETA, rtol=loss)
    assert (mac(shapes, SHAPES.astype(complex)).diagonal() > alike).all()


def test_a_roving_hammer_in_csv(tmp_path: Path, beam: Beam) -> None:
    declared = hammer_files(tmp_path, beam)
    result = typed("identify", declared, "--out", tmp_path / "run", "--band", 40, 700, "--json")
    assert result.exit_code == 0, result.output
    assert_beam(tmp_path / "run")
    printed = json.loads(result.stdout)
    assert printed["frfs"][0]["name"] == "accelerance Acc 1:+3 / Hammer 1:+3"
    assert printed["places"] == [f"{n}:+3" for n in range(1, 6)]
    assert all(shape["mpc"] > 0.98 for shape in printed["shapes"])


def test_what_is_saved_rebuilds_what_was_fitted_and_is_read_by_other_programs(tmp_path: Path, beam: Beam) -> None:
    declared = hammer_files(tmp_path, beam)
    assert typed("identify", declared, "--out", tmp_path, "--band", 40, 700, "--quiet").exit_code == 0
    frfs, modes, shapes = load_test(tmp_path)
    fitted = rebuilt(modes, frfs.frequency, frfs)
    written = read_frfs(tmp_path / "rebuilt.uff")
    np.testing.assert_allclose([one.h for one in written], fitted, rtol=1e-12)
    from_modes = np.einsum("sk,sm,s->kms", shapes.shape, shapes.participation, modes.poles[shapes.pole] ** 2)
    np.testing.assert_allclose(from_modes[:, 0], modes.residues[:, shapes.pole], rtol=1e-9)
    sets = pyuff.UFF(str(tmp_path / "modes.uff")).read_sets()
    kinds = [int(one["type"]) for one in sets]
    assert kinds[:4] == [15, 151, 164, 2411]
    assert kinds[-len(shapes.pole) :] == [55] * len(shapes.pole)
    assert set(kinds[4 : -len(shapes.pole)]) == {82}
    sets = [one for one in sets if int(one["type"]) in (15, 55)]
    np.testing.assert_allclose(sets[0]["x"], POINTS, rtol=1e-4)
    np.testing.assert_allclose(sets[1]["r3"], shapes.shape[0], atol=1e-4)
    assert complex(sets[1]["eig"]) == pytest.approx(complex(modes.poles[shapes.pole[0]]), rel=1e-4)
    assert len((tmp_path / "modes.csv").read_text(encoding="utf-8").splitlines()) == 1 + len(shapes.pole)
    assert load_stabilization(tmp_path / "stabilization.h5").order.max() > 4


def test_modes_of_a_test_with_a_temperature_are_a_table_that_update_reads(tmp_path: Path, beam: Beam) -> None:
    declared = hammer_files(tmp_path, beam)
    text = declared.read_text(encoding="utf-8")
    for run, more, columns in (
        ("cold", "", "mode,frequency_hz,"),
        ("warm", "temperature = 21.5\n", "temperature_c,"),
    ):
        declared.write_text(more + text, encoding="utf-8")
        assert typed("identify", declared, "--out", tmp_path / run, "--band", 40, 700, "--quiet").exit_code == 0
        assert (tmp_path / run / "modes.csv").read_text(encoding="utf-8").startswith(columns)
    (at,) = modes_of_table(tmp_path / "warm" / "modes.csv")
    assert at.temperature == 21.5
    np.testing.assert_allclose(at.frequency, F, rtol=2e-2)


@pytest.mark.filterwarnings("ignore")
def test_sdynpy_reads_points_lines_shapes_and_frfs(tmp_path: Path, beam: Beam) -> None:
    pytest.importorskip("sdynpy", reason="SDynPy is in the extra bench (docs/dependencies.md)")
    from sdynpy.core.sdynpy_data import NDDataArray
    from sdynpy.core.sdynpy_geometry import Geometry
    from sdynpy.core.sdynpy_shape import ShapeArray
    from sdynpy.fileio.sdynpy_uff import readunv

    declared = hammer_files(tmp_path, beam)
    assert typed("identify", declared, "--out", tmp_path, "--band", 40, 700, "--quiet").exit_code == 0
    frfs, _, shapes = load_test(tmp_path)
    modes = readunv(str(tmp_path / "modes.uff"))
    there = Geometry.from_unv(modes)
    np.testing.assert_allclose(there.node.coordinate[:, 0], POINTS, rtol=1e-15)
    assert [sorted(line.connectivity.tolist()) for line in there.traceline] == [[1, 2, 3, 4, 5]]
    again = ShapeArray.from_unv(modes)
    np.testing.assert_allclose(again.shape_matrix[:, 2::3], shapes.shape, atol=1e-4)
    np.testing.assert_allclose(again.frequency, F, rtol=1e-3)
    read = NDDataArray.from_uff(readunv(str(tmp_path / "frfs.uff")))
    np.testing.assert_allclose(read.ordinate, [one.h for one in frfs.transfers], rtol=1e-12)


def test_short_blocks_with_an_exponential_window(tmp_path: Path, beam: Beam) -> None:
    """The lowest mode falls to a sixth within a block; without the window that is told, with it taken out."""
    declared = hammer_files(tmp_path, beam)
    text = declared.read_text(encoding="utf-8")
    short = text + "\n[hammer]\nduration = 0.5\n"
    declared.write_text(short, encoding="utf-8")
    told = typed("identify", declared, "--out", tmp_path / "short", "--band", 40, 700)
    assert "rings on" in told.output
    assert "lengthen hammer.duration" in told.output
    declared.write_text(short + "exponential = 0.001\n", encoding="utf-8")
    told = typed("identify", declared, "--out", tmp_path / "run", "--band", 40, 700)
    assert "rings on" not in told.output
    assert_beam(tmp_path / "run", loss=0.02)


def test_a_shaker_with_an_accelerometer_at_five_points_in_a_mat_file(tmp_path: Path, beam: Beam) -> None:
    rng = np.random.default_rng(1)
    force = rng.standard_normal(round(60 * RATE))
    acc = np.array([beam.answer(force, i, 1) for i in range(5)])
    savemat(
        tmp_path / "shaker.mat", {"fs": RATE, "force": force, "acc": acc + 0.01 * rng.standard_normal(acc.shape)}
    )
    channels = "".join(
        f'"acc[{i}]" = {{ role = "response", unit = "m/s2", at = "{i}:+z" }}\n' for i in range(1, 6)
    )
    (tmp_path / "test.toml").write_text(
        'format = "flexura-test/1"\nkind = "continuous"\nestimator = "hv"\nsample_rate = "fs"\n[channels]\n'
        f'force = {{ role = "drive", unit = "N", at = "2:+z" }}\n{channels}[segments]\nseconds = 4.0\n'
        '[[record]]\nfile = "shaker.mat"\n',
        encoding="utf-8",
    )
    result = typed("identify", tmp_path, "--out", tmp_path / "run", "--band", 40, 700)
    assert result.exit_code == 0, result.output
    assert_beam(tmp_path / "run", loss=0.02)
    said = " ".join(result.output.split())
    assert "segments of 4 s widen modes by more than their σ: 95.0 Hz (damping by" in said
    assert "This is corrected" in said


def test_mobilities_of_a_laser_in_an_npz(tmp_path: Path, beam: Beam) -> None:
    frequency = np.arange(0.0, 700.0, 0.5)
    rng = np.random.default_rng(2)
    h = np.array([beam.frf(frequency, i, 0, 1) for i in range(5)])
    h = 1e3 * (h + 1e-4 * np.abs(h).max() * (rng.standard_normal(h.shape) + 1j * rng.standard_normal(h.shape)))
    np.savez(tmp_path / "laser.npz", frequency=frequency, H=h)
    channels = "".join(f'"H[{i}]" = {{ role = "frf", at = "{i}:+z", reference = "1:+z" }}\n' for i in range(1, 6))
    (tmp_path / "test.toml").write_text(
        'format = "flexura-test/1"\nkind = "frf"\n[frf]\nresponse = "mm/s"\nreference = "N"\n[channels]\n'
        f'frequency = {{ role = "frequency" }}\n{channels}[[record]]\nfile = "laser.npz"\n',
        encoding="utf-8",
    )
    result = typed("identify", tmp_path / "test.toml", "--out", tmp_path / "run", "--json")
    assert result.exit_code == 0, result.output
    assert_beam(tmp_path / "run")
    frfs, _, _ = load_test(tmp_path / "run")
    assert frfs.label(0) == "mobility [m/s/N]"
    np.testing.assert_allclose(
        np.abs(frfs.h[0]), np.abs(beam.frf(frfs.frequency, 0, 0, 1)), atol=2e-3 * np.abs(frfs.h).max()
    )


@pytest.mark.parametrize("step", [1, -1])
def test_a_coherence_beside_frfs_becomes_their_variance(tmp_path: Path, beam: Beam, step: int) -> None:
    """Noise of 0.1 % of the largest mobility after averaging, its coherence for one of sixteen averages.

    A sine may be stepped up or down.
    """
    frequency = np.arange(0.5, 700.0, 0.5)
    h = beam.frf(frequency, 1, 0, 1)
    power = (0.001 * np.abs(h).max()) ** 2
    noise = np.random.default_rng(4).standard_normal((2, len(h))) * np.sqrt(power / 2)
    coherence = np.abs(h) ** 2 / (np.abs(h) ** 2 + 16 * power)
    noisy = h + noise[0] + 1j * noise[1]
    np.savez(tmp_path / "a.npz", f=frequency[::step], H=1e3 * noisy[::step], c=coherence[::step])
    (tmp_path / "test.toml").write_text(
        'format = "flexura-test/1"\nkind = "frf"\n[frf]\nresponse = "mm/s"\nreference = "N"\n[channels]\n'
        'f = { role = "frequency" }\nH = { role = "frf" }\nc = { role = "coherence" }\n[[record]]\n'
        'file = "a.npz"\n',
        encoding="utf-8",
    )
    (frf,) = declared_frfs(tmp_path, lambda *_: None).transfers
    assert frf.coherence is not None
    assert frf.variance is not None
    np.testing.assert_allclose(frf.frequency, frequency)
    np.testing.assert_allclose(frf.h, noisy)
    np.testing.assert_allclose(frf.coherence, coherence)
    assert np.median(frf.variance) == pytest.approx(power, rel=0.2)


def test_what_one_blow_alone_rings_with_is_not_confirmed(tmp_path: Path, beam: Beam) -> None:
    """A cable strikes at the third blow of every point: a tone that falls like a mode, in one blow of four."""
    declared, seconds, count = hammer_files(tmp_path, beam), 8.0, 4
    for j in range(5):
        file = tmp_path / f"point{j + 1}.csv"
        table = np.loadtxt(file, delimiter=",", skiprows=1)
        t = table[:, 0] - (0.2 + 2 * (seconds - 0.2) / count)
        ring = np.exp(-2 * np.pi * 390.0 * 0.006 * t) * np.sin(2 * np.pi * 390.0 * t)
        table[:, 2] += np.where(t > 0.0, 0.3 * np.abs(table[:, 2]).max() * ring, 0.0)
        np.savetxt(file, table, "%.9g", ",", header="Time [s],Hammer [V],Acc [V]", comments="")
    frfs = declared_frfs(declared, lambda *_: None)
    assert [one.name for one in frfs.without_hits] == ["hit 1", "hit 2", "hit 3", "hit 4"]
    assert sum(one.share for one in frfs.without_hits) == pytest.approx(3.0)
    assert typed("identify", declared, "--out", tmp_path, "--band", 40, 700, "--quiet").exit_code == 0
    _, modes, _ = load_test(tmp_path)
    f = np.abs(modes.poles) / (2 * np.pi)
    false, *true = (int(np.abs(f - one).argmin()) for one in (390.0, *F))
    assert f[false] == pytest.approx(390.0, rel=2e-3)
    assert modes.real[false]
    assert modes.confirmation[false] == "unconfirmed"
    assert "rests on hit 3 alone" in modes.reason[false]
    assert all(modes.confirmation[n] == "confirmed" for n in true)


def test_one_blow_has_no_coherence(tmp_path: Path, beam: Beam) -> None:
    several, one = (declared_frfs(hammer_files(tmp_path, beam, 2.0 * n, n), lambda *_: None) for n in (2, 1))
    assert all(frf.coherence is not None for frf in several.transfers)
    assert all(frf.coherence is None for frf in one.transfers)


@pytest.mark.parametrize(
    ("units", "label"),
    [(("", ""), "accelerance [m/s2/N]"), (("g", "N"), "accelerance [g/N]"), (("g", ""), "accelerance [g/?]")],
)
def test_an_axis_has_the_units_of_its_file(units: tuple[str, str], label: str) -> None:
    line = np.arange(1.0, 9.0)
    frf = MeasuredTransfer("a", "1:+3", "1:+3", "acceleration", line, line + 0j, units=units)
    assert FrfSet("plate", (frf,)).label(0) == label


def test_a_sound_recording_of_a_hammer_and_a_microphone(tmp_path: Path, beam: Beam) -> None:
    """Pressure in front of one point, in proportion to its acceleration; blows in the left channel."""
    rng = np.random.default_rng(3)
    force = 60.0 * sum(
        np.exp(-(((np.arange(round(8 * RATE)) / RATE - t) / 6e-4) ** 2)) for t in (0.3, 2.2, 4.1, 6.0)
    )
    pressure = 0.01 * beam.answer(force, 0, 1)
    stereo = np.column_stack([force / 100.0, pressure / 2.0]) + 1e-5 * rng.standard_normal((len(force), 2))
    wavfile.write(tmp_path / "hits.wav", int(RATE), (stereo * 2**31).astype(np.int32))
    (tmp_path / "test.toml").write_text(
        'format = "flexura-test/1"\nkind = "hammer"\n[channels]\n'
        '1 = { role = "drive", sensitivity = "0.01 FS/N" }\n'
        '2 = { role = "response", sensitivity = "0.5 FS/Pa", at = "1:+z" }\n[[record]]\nfile = "hits.wav"\n',
        encoding="utf-8",
    )
    result = typed("identify", tmp_path / "test.toml", "--out", tmp_path / "run", "--band", 40, 700)
    assert result.exit_code == 0, result.output
    f, eta, _ = found(tmp_path / "run")
    np.testing.assert_allclose(f, F, rtol=1e-3)
    np.testing.assert_allclose(eta, ETA, rtol=0.05)
    assert load_test(tmp_path / "run")[0].label(0) == "acoustic transfer function [Pa/N]"


def test_the_report_of_a_test_stands_on_its_own_files(tmp_path: Path, beam: Beam) -> None:
    declared = hammer_files(tmp_path, beam, seconds=4.0, count=2)
    text = declared.read_text(encoding="utf-8")
    head = 'operator = "A. Tester"\ndate = 2026-11-22\nkind ='
    declared.write_text(text.replace("kind =", head, 1), encoding="utf-8")
    assert typed("identify", declared, "--out", tmp_path / "run", "--band", 40, 700, "--quiet").exit_code == 0
    result = typed("report", tmp_path / "run", "--json")
    assert result.exit_code == 0, result.output
    told = json.loads(result.stdout)
    assert told["figures"] == ["frfs", "coherence", "stabilization", "shapes", "auto-mac"]
    assert told["sections"] == ["In short", "Measurement", "Modes", "Shapes", "Provenance"]
    page = (tmp_path / "run" / "report.html").read_text(encoding="utf-8")
    assert "accelerance [m/s2/N]" in page
    assert "the paper" not in page
    assert "A. Tester" in page
    assert "2026-11-22" in page
    assert "kept, confirmed" in page
    assert "data:image/svg+xml;base64," in page


def test_a_narrow_peak_at_the_mains_frequency_is_left_out_with_a_word(tmp_path: Path) -> None:
    """At 60 Hz, half as wide as the lines are apart: mode or hum, the data do not tell; it vanished silently."""
    frequency, rng = np.arange(20.0, 290.0, 1.25), np.random.default_rng(3)
    s, poles = 2j * np.pi * frequency, 2 * np.pi * np.array([[60.0], [147.0]]) * (-0.004 + 1j)
    h = np.array([[1.0, 1.0], [0.4, -1.0]]) @ (s**2 / ((s - poles) * (s - poles.conj())))
    h += 1e-3 * np.abs(h).max() * (rng.standard_normal(h.shape) + 1j * rng.standard_normal(h.shape))
    np.savez(tmp_path / "a.npz", frequency=frequency, H=h)
    assert typed("new", "test", tmp_path / "a.npz", "-q").exit_code == 0
    told = " ".join(typed("identify", tmp_path, "--out", tmp_path / "run").output.split())
    assert " Hz is left out, a line at 1 x 60 Hz mains" in told
    assert "its peak is no wider than the 1.25 Hz between lines. If it is a mode" in told


def test_an_overloaded_channel_is_called_by_its_name(tmp_path: Path, beam: Beam) -> None:
    force = blows(np.random.default_rng(3), 8.0, 3)
    acc = beam.answer(force, 0, 0)
    acc[: len(acc) // 3] = np.clip(acc, -0.4 * np.abs(acc).max(), 0.4 * np.abs(acc).max())[: len(acc) // 3]
    np.savez(tmp_path / "a.npz", force=force, tip=acc, fs=RATE)
    typed("new", "test", tmp_path / "a.npz", "--drive", "force=N", "--response", "tip=m/s2", "-q")
    told = " ".join(typed("identify", tmp_path, "--out", tmp_path / "run", "--band", 40, 700).output.split())
    assert "blow 1 of 3 left out, overload: tip was cut off; lower its gain or hit softer" in told
