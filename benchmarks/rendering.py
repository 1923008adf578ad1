"""The renderer's real-time factor, against the plain way of filtering.

Usage: python benchmarks/rendering.py [--seconds S] [--results FILE]

Six filters of 512 taps at 44.1 kHz, networks of 10 nodes, noise while the temperature runs from 20 to 45 °C: the
filters fade again and again. The plain way is scipy's lfilter through the filters of one temperature. Where
the temperature stands still both are compared. Processor time is measured, in one thread.
"""

import argparse
import json
import platform
import sys
import time
from pathlib import Path

import numpy as np
from scipy.signal import lfilter
from threadpoolctl import threadpool_limits

sys.path.insert(0, str(Path(__file__).resolve().parent))

from exported_c import RATE, shipments

from analysis.rendering.renderer import Renderer

RESULTS = Path(__file__).resolve().parent / "results" / "rendering.json"


def rendered(renderer: Renderer, signal: np.ndarray, course: np.ndarray) -> tuple[np.ndarray, float]:
    """Output (N, samples) and processor seconds, the temperature told before every block."""
    blocks = signal.reshape(-1, renderer.block)
    begun, out = time.thread_time(), []
    for samples, temperature in zip(blocks, course, strict=True):
        renderer.follow(float(temperature))
        out.append(renderer.process(samples))
    return np.hstack(out), time.thread_time() - begun


def main() -> None:
    """Time both ways, print them, write JSON; exit 1 below 20 times real time or where results differ."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seconds", type=float, default=60.0, help="of audio")
    parser.add_argument("--block", type=int, default=512)
    parser.add_argument("--results", type=Path, default=RESULTS)
    options = parser.parse_args()
    filters = shipments()["network"].filters
    blocks = round(options.seconds * RATE / options.block)
    signal = np.random.default_rng(0).standard_normal(blocks * options.block)
    seconds = len(signal) / RATE
    with threadpool_limits(1):
        moving = Renderer(filters, 20.0, options.block)
        _, taken = rendered(moving, signal, np.linspace(20.0, 45.0, blocks))
        still, _ = rendered(Renderer(filters, 31.0, options.block), signal, np.full(blocks, 31.0))
        begun = time.thread_time()
        plain = np.array([lfilter(taps, 1.0, signal) for taps in filters.taps(31.0)[0]])
        theirs = time.thread_time() - begun
    record = {
        "machine": platform.platform(),
        "seconds_of_sound": seconds,
        "block": options.block,
        "changes": moving.changes,
        "real_time_factor": seconds / taken,
        "plain_real_time_factor": seconds / theirs,
        "ratio": theirs / taken,
        "relative_energy": float(np.sum((still - plain) ** 2) / np.sum(plain**2)),
    }
    good = record["real_time_factor"] >= 20.0 and record["relative_energy"] < 1e-20
    print(
        f"{seconds:.0f} s of sound, {moving.changes} changes: {record['real_time_factor']:.0f} times "
        f"real time; plain {record['plain_real_time_factor']:.0f} times, ratio {record['ratio']:.1f}; outputs "
        f"differ by {record['relative_energy']:.1e} of energy"
    )
    options.results.parent.mkdir(parents=True, exist_ok=True)
    options.results.write_text(json.dumps(record | {"good": good}, indent=1) + "\n")
    print(f"{'as wanted' if good else 'FALLS SHORT'}: {options.results}")
    sys.exit(0 if good else 1)


if __name__ == "__main__":
    main()
