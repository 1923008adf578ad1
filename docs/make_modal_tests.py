"""Make the files of ``examples/modal-tests``: a beam and a plate of known modes, as laboratories record them.

    python docs/make_modal_tests.py

Computed in closed form, with noise; no laboratory has measured them.
"""

import gzip
from pathlib import Path

import numpy as np
from scipy.io import savemat, wavfile

TARGET = Path(__file__).resolve().parents[1] / "examples" / "modal-tests"
RATE = 2048.0
BEAM = np.array([0.0, 0.13, 0.34, 0.58, 0.83])
"""Points of the beam, shares of its length of 1 m."""
ROOTS = (4.730041, 7.853205, 10.995608)
"""cos x cosh x = 1."""
BEAM_HZ, BEAM_ETA = np.array([95.0, 262.0, 513.0]), np.array([0.024, 0.02, 0.018])
PLATE_HZ = {(1, 1): 80.0, (2, 1): 171.0, (1, 2): 215.0, (2, 2): 306.0, (3, 1): 322.0}
"""Natural frequencies of the plate on soft supports along its edges, by half waves along x and y."""


def beam_shapes() -> np.ndarray:
    """Bending shapes of a free beam at its points, (3, 5)."""
    shapes = []
    for beta in ROOTS:
        s = (np.cosh(beta) - np.cos(beta)) / (np.sinh(beta) - np.sin(beta))
        x = beta * BEAM
        shapes.append(np.cosh(x) + np.cos(x) - s * (np.sinh(x) + np.sin(x)))
    return np.array(shapes)


def poles(frequency: np.ndarray, eta: np.ndarray) -> np.ndarray:
    """Poles of modes with loss factors, rad/s."""
    return np.asarray(2 * np.pi * frequency * (-eta / 2 + 1j * np.sqrt(1 - eta**2 / 4)))


def frf(lines: np.ndarray, pole: np.ndarray, left: np.ndarray, right: np.ndarray, order: int) -> np.ndarray:
    """Receptance, mobility or accelerance at `lines` Hz of modes of 0.8 kg."""
    s = 2j * np.pi * lines
    residue = left * right / 0.8 / (2j * pole.imag)
    h = (residue[:, None] / (s - pole[:, None]) + residue.conj()[:, None] / (s - pole.conj()[:, None])).sum(0)
    return np.asarray(h * s**order)


def answer(force: np.ndarray, i: int, j: int) -> np.ndarray:
    """Acceleration at point i of the beam to a force at point j."""
    count = 2 * len(force)
    shapes = beam_shapes()
    h = frf(np.fft.rfftfreq(count, 1 / RATE), poles(BEAM_HZ, BEAM_ETA), shapes[:, i], shapes[:, j], 2)
    return np.asarray(np.fft.irfft(np.fft.rfft(force, count) * h, count)[: len(force)])


def blows(rng: np.random.Generator, count: int, apart: float = 1.5) -> np.ndarray:
    """Force of `count` blows `apart` seconds, N."""
    t = np.arange(round(count * apart * RATE)) / RATE
    return np.asarray(
        sum(rng.uniform(40, 80) * np.exp(-(((t - 0.1 - n * apart) / 8e-4) ** 2)) for n in range(count))
    )


def hammer(rng: np.random.Generator) -> None:
    """Roving hammer over the beam, accelerometer at point 1: volts, a packed CSV file for each point."""
    for point in range(5):
        force = blows(rng, 2)
        acc = answer(force, 0, point)
        volts = np.column_stack(
            [
                2.25e-3 * (force + 0.02 * rng.standard_normal(len(force))),
                0.1 / 9.80665 * (acc + 2e-3 * rng.standard_normal(len(force))),
            ]
        )
        lines = ["Time [s],Hammer [V],Acc [V]"]
        lines += [f"{n / RATE:.7f},{one[0]:.4e},{one[1]:.4e}" for n, one in enumerate(volts)]
        packed = gzip.compress(("\n".join(lines) + "\n").encode(), 9, mtime=0)
        (TARGET / "hammer" / f"point{point + 1}.csv.gz").write_bytes(packed)


def shaker(rng: np.random.Generator) -> None:
    """Random force at point 2 of the beam, accelerations at all five, in a MAT file."""
    force = rng.standard_normal(round(12 * RATE))
    acc = np.array([answer(force, i, 1) for i in range(5)])
    acc += 0.01 * acc.std() * rng.standard_normal(acc.shape)
    held = {"fs": RATE, "force": force.astype("f4"), "acc": acc.astype("f4")}
    savemat(TARGET / "shaker" / "shaker.mat", held, do_compression=True)


def laser(rng: np.random.Generator) -> None:
    """Mobilities of a plate of 0.5 m by 0.4 m over a grid of 6 by 5 points, mm/s/N, in an NPZ archive."""
    lines = np.arange(40.0, 360.5, 0.5)
    x, y = (part.ravel() for part in np.meshgrid(np.arange(1, 7) / 7, np.arange(1, 6) / 6, indexing="ij"))
    shapes = np.array([2 * np.sin(m * np.pi * x) * np.sin(n * np.pi * y) for m, n in PLATE_HZ])
    pole = poles(np.array(list(PLATE_HZ.values())), np.full(len(PLATE_HZ), 0.012))
    h = 1e3 * np.array([frf(lines, pole, shapes[:, k], shapes[:, 6], 1) for k in range(30)])
    h += 2e-3 * np.abs(h).max() * (rng.standard_normal(h.shape) + 1j * rng.standard_normal(h.shape))
    np.savez_compressed(TARGET / "laser" / "laser.npz", frequency=lines, H=h.astype("c8"))
    rows = [f"{k},{0.5 * a:.4f},{0.4 * b:.4f},0" for k, (a, b) in enumerate(zip(x, y, strict=True), 1)]
    (TARGET / "laser" / "points.csv").write_text("node,x,y,z\n" + "\n".join(rows) + "\n", encoding="utf-8")


def sound(rng: np.random.Generator) -> None:
    """Blows at point 1 of the beam, in a WAV file of four channels: hammer, microphones before points 1, 3, 5."""
    force = blows(rng, 4)
    responses = [5e-4 * answer(force, i, 0) for i in (0, 2, 4)]
    samples = np.column_stack([force / 100.0, *responses]) + 1e-5 * rng.standard_normal((len(force), 4))
    wavfile.write(TARGET / "sound" / "blows.wav", int(RATE), np.round(samples * 2**15).astype(np.int16))


if __name__ == "__main__":
    for name, make in (("hammer", hammer), ("shaker", shaker), ("laser", laser), ("sound", sound)):
        (TARGET / name).mkdir(parents=True, exist_ok=True)
        make(np.random.default_rng(7))
        print(TARGET / name)
