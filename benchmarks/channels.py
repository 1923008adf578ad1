"""Eight sensors at four temperatures: weights of each sensor's own, against one course of noise for all.

The plate is made of closed forms: 46 modes at a constant density, as a thin plate has them, whose frequencies
follow a modulus from 3.25 to 1.0 GPa and whose loss factors rise from 4 to 7 % between 0 and 60 degrees Celsius.
The sensors have white noise, each at its own level, whose variance is known as four repeats tell it. Plain is one
factorisation per sensor and look; ours gives the sensors the mean of their courses. Both have to find the modes.

    python benchmarks/channels.py
"""

import json
import time
from contextlib import nullcontext
from pathlib import Path
from unittest.mock import patch

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import uniform_filter1d
from threadpoolctl import threadpool_limits

from analysis.identification.over_temperature.tracked_modes import TrackedModes
from analysis.identification.over_temperature.tracking import track
from analysis.recordings.frf import Frf

SENSORS, MODES, TEMPERATURES = 8, 46, np.array([0.0, 20.0, 40.0, 60.0])
FREQUENCY = np.arange(100.0, 1500.0, 0.4)
NOISE = 0.003
"""Of a sensor, in the mean of its |h|."""
AVERAGED = 82
"""Complex numbers that tell the variance of a line: four repeats with a drift between them, over 41 lines."""
RESULT = Path(__file__).parent / "results" / "channels.json"


def made(rng: np.random.Generator) -> tuple[Frf, NDArray[np.float64]]:
    """FRFs of the campaign, and the true frequencies (T, J), Hz."""
    warm = TEMPERATURES / 60.0
    modulus, loss = 3.25 - 2.25 * warm, 0.04 + 0.03 * warm
    cold = 60.0 * np.arange(1, MODES + 1) + rng.uniform(-20.0, 20.0, MODES)
    frequency = cold * np.sqrt(modulus / modulus[0])[:, None]
    poles = 2j * np.pi * frequency * np.sqrt(1.0 + 1j * loss[:, None])
    residues = -1j * rng.normal(size=(SENSORS, MODES)) * rng.normal(size=MODES)
    s = 2j * np.pi * FREQUENCY
    h = np.empty((len(TEMPERATURES), SENSORS, len(s)), dtype=complex)
    for t, row in enumerate(poles):
        shares = residues * np.abs(row)
        h[t] = shares @ (1.0 / (s - row[:, None])) + shares.conj() @ (1.0 / (s - row.conj()[:, None]))
    variance = (NOISE * np.abs(h).mean(axis=2, keepdims=True)) ** 2 * np.ones(h.shape)
    h += np.sqrt(variance / 2.0) * (rng.normal(size=h.shape) + 1j * rng.normal(size=h.shape))
    drawn = rng.chisquare(2.0 * AVERAGED / 41, size=h.shape) / (2.0 * AVERAGED / 41)
    frf = Frf(
        temperature=TEMPERATURES,
        direction=("up",) * len(TEMPERATURES),
        level=np.ones(len(TEMPERATURES)),
        frequency=FREQUENCY,
        h=h,
        variance=variance * uniform_filter1d(drawn, 41, axis=2),
        coherence=np.ones(h.shape),
        excluded=np.zeros(len(s), dtype=bool),
        channels=tuple(f"S{k}" for k in range(SENSORS)),
    )
    return frf, frequency


def against(tracked: TrackedModes, frequency: NDArray[np.float64]) -> dict[str, float]:
    """Modes well inside the band, those found within a quarter of the loss factor, and how well."""
    read = tracked.reading()
    error, standard, inside = [], [], 0
    for t, row in enumerate(frequency):
        for true in row[(row > 1.05 * FREQUENCY[0]) & (row < 0.985 * FREQUENCY[-1])]:
            inside += 1
            n = int(np.nanargmin(np.abs(read.frequency_hz[t] - true)))
            away = read.frequency_hz[t, n] / true - 1.0
            if abs(away) < 0.25 * read.loss_factor[t, n]:
                error.append(abs(away))
                standard.append(abs(away) * true / read.sigma_frequency_hz[t, n])
    return {
        "modes": inside,
        "found": len(error),
        "frequency_median_percent": 100.0 * float(np.median(error)),
        "coverage_of_95_percent": float(np.mean(np.array(standard) < 1.96)),
    }


def main() -> None:
    """Identify both ways, print and write."""
    frf, frequency = made(np.random.default_rng(0))
    own = patch("analysis.identification.measured.pooled", lambda deviation: deviation)
    found: dict[str, dict[str, float]] = {}
    for way, how in (("plain", own), ("ours", nullcontext())):
        with threadpool_limits(1), how:
            started, wall = time.process_time(), time.perf_counter()
            tracked = track(frf)
            cost = {"cpu_s": time.process_time() - started, "wall_s": time.perf_counter() - wall}
        found[way] = cost | against(tracked, frequency)
        print(way, json.dumps(found[way]), flush=True)
        missed = found[way]["modes"] - found[way]["found"]
        if missed > 0.03 * found[way]["modes"]:
            raise SystemExit(f"{way}: {missed} modes were not found")
    found["ratio"] = {"cpu": found["plain"]["cpu_s"] / found["ours"]["cpu_s"]}
    print(f"{found['ratio']['cpu']:.1f} times")
    RESULT.parent.mkdir(exist_ok=True)
    RESULT.write_text(json.dumps(found, indent=2) + "\n")


if __name__ == "__main__":
    main()
