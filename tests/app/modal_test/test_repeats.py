"""Tests of five hits, repeated: how far modes scatter from test to test, against the deviation stated of each."""

from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

import flexura
from app.modal_test.declared_test import declared_frfs
from tests.app.modal_test.conftest import LENGTH, MASS, RATE, Beam, blows, free_beam, hammer_files

STRUCTURES, REPEATS, HITS = 6, 10, 5
SECONDS = 15.0


def response(
    force: NDArray[np.float64], f: NDArray[np.float64], zeta: NDArray[np.float64], gain: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Acceleration of viscous modes to a force, from rest."""
    count = 2 * len(force)
    w = 2.0 * np.pi * np.fft.rfftfreq(count, 1.0 / RATE)[:, None]
    w0 = 2.0 * np.pi * f
    h = (gain * -(w**2) / (w0**2 - w**2 + 2j * zeta * w0 * w)).sum(axis=1)
    return np.asarray(np.fft.irfft(np.fft.rfft(force, count) * h, count)[: len(force)])


def five_hits(folder: Path, seed: int, f: NDArray[np.float64], zeta: NDArray[np.float64]) -> Path:
    """Write one test of a beam hit near its end and read at three points; noise of each channel is its own."""
    rng = np.random.default_rng(seed)
    force = blows(rng, SECONDS, HITS)
    at = np.array([free_beam(mode, np.array([0.05, 0.3, 0.62, 0.95]) / LENGTH) for mode in range(3)])
    columns = {"Hammer": force + 0.02 * rng.standard_normal(len(force))}
    for k in (1, 2, 3):
        acc = response(force, f, zeta, at[:, 0] * at[:, k] / MASS)
        columns[f"Acc{k}"] = acc + 0.02 * np.sqrt(np.mean(acc**2)) * rng.standard_normal(len(force))
    folder.mkdir()
    np.savez(folder / "hits.npz", **columns)
    channels = "".join(f'Acc{k} = {{ role = "response", unit = "m/s2", at = "{k}:+z" }}\n' for k in (1, 2, 3))
    (folder / "test.toml").write_text(
        f'format = "flexura-test/1"\ntitle = "beam"\nkind = "hammer"\nsample_rate = {RATE}\n\n[channels]\n'
        'Hammer = { role = "drive", unit = "N", at = "4:+z" }\n'
        f'{channels}\n[[record]]\nfile = "hits.npz"\n',
        encoding="utf-8",
    )
    return folder


@pytest.mark.slow
def test_a_file_that_was_copied_is_told(tmp_path: Path, beam: Beam) -> None:
    """At its own points it is no second measurement; at others it made a shape wrong without a word."""
    file = hammer_files(tmp_path, beam, count=2, seconds=4.0)
    text = file.read_text()
    (tmp_path / "copy.csv").write_bytes((tmp_path / "point2.csv").read_bytes())
    for node, words in (
        (2, "copy.csv is left out: a copy of point2.csv"),
        (6, "copy.csv is a copy of point2.csv"),
    ):
        record = f'[[record]]\nfile = "copy.csv"\nat = {{ Hammer = "{node}:+z" }}\n\n[points]'
        file.write_text(text.replace("[points]", record))
        read = declared_frfs(file, lambda *_: None)
        assert any(note.startswith(words) for note in read.notes)
        assert len(read.transfers) == (5 if node == 2 else 6)


def test_modes_scatter_from_test_to_test_as_their_deviations_say(tmp_path: Path) -> None:
    ratios, away = [], []
    for structure in range(STRUCTURES):
        rng = np.random.default_rng(structure)
        f = np.array([95.0, 262.0, 513.0]) * rng.uniform(0.93, 1.07, 3)
        zeta = rng.uniform(0.005, 0.012, 3)
        values, sigmas = [], []
        for repeat in range(REPEATS):
            folder = five_hits(tmp_path / f"{structure}-{repeat}", 100 * structure + repeat, f, zeta)
            found = flexura.identify_test(folder, damping="viscous", band=(50.0, 700.0))
            read, real = found.modes.reading(), found.shapes.pole
            places = [real[int(np.abs(read.frequency_hz[real] - one).argmin())] for one in f]
            values.append([read.frequency_hz[places] / f, read.damping_ratio[places] / zeta])
            sigmas.append([read.sigma_frequency_hz[places] / f, read.sigma_damping_ratio[places] / zeta])
        value, sigma = np.array(values), np.array(sigmas)
        ratios.append(value.std(axis=0, ddof=1) / np.sqrt(np.mean(sigma**2, axis=0)))
        away.append((value - 1.0) / sigma)
    assert 0.9 <= np.median(ratios) <= 1.1
    assert np.quantile(ratios, 0.95) <= 2.2
    assert np.quantile(np.abs(away), 0.95) <= 2.2
