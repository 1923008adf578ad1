"""What shakers play besides noise: damping is right with the segments that are chosen, or it is refused."""

from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from app.files.declarations.modal_test import read_modal_test
from app.modal_test.modes_of_test import load_test
from tests.app.modal_test.conftest import ETA, RATE, Beam, F, typed


def burst_random(count: int, seconds: float = 2.0) -> NDArray[np.float64]:
    rng = np.random.default_rng(3)
    rest = np.zeros(round(0.6 * seconds * RATE))
    return np.concatenate(
        [np.append(rng.standard_normal(round(0.4 * seconds * RATE)), rest) for _ in range(count)]
    )


def chirp(seconds: float) -> NDArray[np.float64]:
    t = np.arange(round(seconds * RATE)) / RATE
    return np.asarray(np.sin(2 * np.pi * (30.0 * t + 370.0 / seconds * t**2)))


def recorded(folder: Path, beam: Beam, force: NDArray[np.float64]) -> Path:
    acc = np.array([beam.answer(force, i, 1) for i in range(3)])
    acc += 0.003 * acc.std() * np.random.default_rng(1).standard_normal(acc.shape)
    np.savez(folder / "shaker.npz", force=force, acc=acc, fs=RATE)
    words = ("--drive", "force=N", "--response", "acc*=m/s2", "--quiet")
    result = typed("new", "test", folder / "shaker.npz", *words)
    assert result.exit_code == 0, result.output
    return folder / "test.toml"


def assert_damping(run: Path) -> None:
    _, modes, shapes = load_test(run)
    reading = modes.reading("viscous")
    np.testing.assert_allclose(reading.frequency_hz[shapes.pole], F, rtol=1e-4)
    np.testing.assert_allclose(reading.loss_factor[shapes.pole], ETA, rtol=0.01)


SWEEP = np.append(chirp(14.0), np.zeros(round(2 * RATE)))


@pytest.mark.parametrize(("force", "seconds"), [(np.tile(chirp(4.0), 4), 4.0), (SWEEP, 16.0)])
def test_whole_periods_and_sweeps_are_cut_by_no_segment(
    tmp_path: Path, beam: Beam, force: NDArray[np.float64], seconds: float
) -> None:
    """With Hann's segments of 2 s loss factors of periodic chirps were up to 29 % wrong, and said to be right."""
    declared = recorded(tmp_path, beam, force)
    segments = read_modal_test(declared).segments
    assert (segments.seconds, segments.window, segments.overlap) == (seconds, "rectangular", 0.0)
    result = typed("identify", declared, "--out", tmp_path / "run", "--band", 40, 700)
    assert result.exit_code == 0, result.output
    assert "widen" not in result.output
    assert_damping(tmp_path / "run")
    text = declared.read_text(encoding="utf-8")
    declared.write_text(text.replace(f"seconds = {seconds}", "seconds = 2.0"), encoding="utf-8")
    result = typed("identify", declared, "--out", tmp_path / "cut")
    assert result.exit_code != 0
    assert f"set segments.seconds = {seconds:g}" in " ".join(result.output.split())


def test_bursts_that_end_at_rest_have_no_leakage_to_be_taken_out(tmp_path: Path, beam: Beam) -> None:
    """Damping by leakage that was not there was subtracted: loss factors up to 11 % too small, 10 sigma."""
    declared = recorded(tmp_path, beam, burst_random(12))
    text = declared.read_text(encoding="utf-8")
    assert 'window = "hann"' in text
    declared.write_text(
        text.replace('"hann"', '"rectangular"').replace("overlap = 0.5", "overlap = 0.0"), encoding="utf-8"
    )
    result = typed("identify", declared, "--out", tmp_path / "run", "--band", 40, 700)
    assert result.exit_code == 0, result.output
    assert "widen" not in result.output
    assert_damping(tmp_path / "run")


def test_lines_too_far_apart_for_the_peaks_are_told(tmp_path: Path, beam: Beam) -> None:
    """Half-power bandwidths of 1 to 5 Hz at lines of 8 Hz: one mode of three was found, without a word."""
    declared = recorded(tmp_path, beam, np.random.default_rng(5).standard_normal(round(20 * RATE)))
    text = declared.read_text(encoding="utf-8")
    declared.write_text(text.replace("seconds = 2.0", "seconds = 0.125"), encoding="utf-8")
    told = " ".join(typed("identify", declared, "--out", tmp_path / "run", "--band", 40, 700).output.split())
    assert "% of the FRFs unexplained" in told
    assert "narrower than the 8 Hz between lines (take longer blocks or segments)" in told


def test_a_shaker_is_not_taken_for_a_hammer(tmp_path: Path, beam: Beam) -> None:
    declared = recorded(tmp_path, beam, np.random.default_rng(5).standard_normal(round(8 * RATE)))
    assert read_modal_test(declared).kind == "continuous"
