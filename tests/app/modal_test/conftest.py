"""A free beam with five points, by its closed form, and tests of it as laboratories record them."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner, Result
from numpy.typing import NDArray
from threadpoolctl import threadpool_limits

from app.main import flexura

RATE = 4096.0
LENGTH, MASS = 1.0, 0.8
POINTS = np.array([0.0, 0.13, 0.34, 0.58, 0.83])
F = np.array([95.0, 262.0, 513.0])
ETA = np.array([0.012, 0.009, 0.01])
POLES = 2 * np.pi * F * (-ETA / 2 + 1j * np.sqrt(1 - ETA**2 / 4))


def free_beam(mode: int, x: NDArray[np.float64]) -> NDArray[np.float64]:
    """Bending shape of a free beam, of unit mean square."""
    beta = (4.730041, 7.853205, 10.995608)[mode]
    s = (np.cosh(beta) - np.cos(beta)) / (np.sinh(beta) - np.sin(beta))
    return np.asarray(np.cosh(beta * x) + np.cos(beta * x) - s * (np.sinh(beta * x) + np.sin(beta * x)))


SHAPES = np.array([free_beam(mode, POINTS / LENGTH) for mode in range(3)])


@dataclass(frozen=True)
class Beam:
    """What the beam answers."""

    def frf(self, frequency: NDArray[np.float64], i: int, j: int, order: int = 0) -> NDArray[np.complex128]:
        """Receptance (order 0), mobility or accelerance between two points."""
        s = 2j * np.pi * frequency
        h = np.zeros(len(s), dtype=complex)
        for pole, shape in zip(POLES, SHAPES, strict=True):
            residue = shape[i] * shape[j] / MASS / (2j * pole.imag)
            h += residue / (s - pole) + np.conj(residue) / (s - np.conj(pole))
        return np.asarray(h * s**order)

    def answer(self, force: NDArray[np.float64], i: int, j: int, order: int = 2) -> NDArray[np.float64]:
        """Motion at point i of a force at point j that begins at rest."""
        count = 2 * len(force)
        grid = np.fft.rfftfreq(count, 1 / RATE)
        h = self.frf(grid, i, j, order)
        return np.asarray(np.fft.irfft(np.fft.rfft(force, count) * h, count)[: len(force)])


@pytest.fixture
def beam() -> Beam:
    return Beam()


def typed(*words: object) -> Result:
    """Run flexura as a hand would; any exception but an exit is raised."""
    with threadpool_limits(1):
        result = CliRunner().invoke(flexura, [str(word) for word in words])
    if result.exception is not None and not isinstance(result.exception, SystemExit):
        raise result.exception
    return result


def blows(rng: np.random.Generator, seconds: float, count: int, width: float = 6e-4) -> NDArray[np.float64]:
    """Force of a hammer, N; the last blow ends its ring-down with the record."""
    t = np.arange(round(seconds * RATE)) / RATE
    at = 0.2 + np.arange(count) * (seconds - 0.2) / count
    return np.asarray(sum(rng.uniform(40, 80) * np.exp(-(((t - one) / width) ** 2)) for one in at))


def hammer_files(folder: Path, beam: Beam, seconds: float = 8.0, count: int = 4) -> Path:
    """Write a roving hammer's files, volts in CSV, a file for each point; return the declaration."""
    rng = np.random.default_rng(5)
    lines = []
    for j in range(5):
        force = blows(rng, seconds, count)
        acc = beam.answer(force, 0, j)
        volts = np.column_stack(
            [
                np.arange(len(force)) / RATE,
                2.25e-3 * (force + 0.02 * rng.standard_normal(len(force))),
                0.1 / 9.80665 * (acc + 1e-3 * rng.standard_normal(len(force))),
            ]
        )
        head = "Time [s],Hammer [V],Acc [V]"
        np.savetxt(folder / f"point{j + 1}.csv", volts, "%.9g", ",", header=head, comments="")
        lines.append(f'[[record]]\nfile = "point{j + 1}.csv"\nat = {{ Hammer = "{j + 1}:+z" }}\n')
    (folder / "test.toml").write_text(
        'format = "flexura-test/1"\ntitle = "beam"\nkind = "hammer"\n\n[channels]\nTime = { role = "time" }\n'
        'Hammer = { role = "drive", sensitivity = "2.25 mV/N" }\n'
        'Acc = { role = "response", sensitivity = "100 mV/g", at = "1:+z" }\n\n'
        + "\n".join(lines)
        + "\n[points]\n"
        + "".join(f"{n} = [{x}, 0.0, 0.0]\n" for n, x in enumerate(POINTS, 1)),
        encoding="utf-8",
    )
    return folder / "test.toml"
