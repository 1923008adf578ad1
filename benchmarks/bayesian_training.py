"""Bayesian-regularised training: the exact block-arrow algorithm against the plain dense one.

Usage: python benchmarks/bayesian_training.py [--epochs N] [--device NAME] [--results FILE]

Three cases, 13 temperatures in and 16, 64 or 512 taps out, started from the same weights. The two small ones are
followed for 30 and 10 steps and compared digit by digit; the paper's own, 1-10-512 with 5652 parameters, is
timed over a few dense epochs (each builds a 6656 x 5652 Jacobian, its normal matrix, a factorization and an
inverse) and the outputs after them are compared. Last, as many networks as `compensate` trains to leave each
temperature out: as one batch, and one after the other. With --device (torch's name, such as cuda) batches of 66,
660 and 3300 networks are trained there too, and must give the processor's outputs.
"""

import argparse
import json
import platform
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np
from threadpoolctl import threadpool_limits

sys.path.insert(0, str(Path(__file__).resolve().parent))

from dense_bayesian import network, train_dense

from analysis.compensation.bayesian import train
from analysis.compensation.linearised import predict
from analysis.compensation.settings import Training
from analysis.compensation.training import outputs_at, prepare

RESULTS = Path(__file__).resolve().parent / "results" / "bayesian_training.json"


def filters(taps: int) -> np.ndarray:
    """Taps (13, M) of ringing filters whose modes move with temperature, 0 to 60 °C."""
    t = np.arange(taps) / 44_100.0
    pitch = 420.0 * np.exp(-0.008 * np.arange(0.0, 61.0, 5.0))[:, None]
    ringing = sum(
        a * np.sin(2 * np.pi * k * pitch * t + p) * np.exp(-0.12 * k * pitch * t)
        for a, k, p in ((1.0, 0.5, 0.0), (0.7, 1.0, 0.4), (0.5, 1.35, 1.1), (0.4, 1.8, 2.0))
    )
    return np.asarray(ringing)


def case(nodes: int, taps: int, dense_epochs: int, start: str) -> dict[str, Any]:
    """Train one network both ways from the same weights and compare."""
    inputs = np.linspace(-1.0, 1.0, 13)
    targets = filters(taps)[None]
    batch = prepare(
        inputs, targets, np.ones((1, 13)), Training(nodes=nodes, start=start), np.random.default_rng(0)
    )
    scaled = (targets[0] - batch.offset[0]) / batch.scale[0]
    output = batch.start.output[0] @ batch.axes[0]

    started = time.perf_counter()
    dense = train_dense(inputs, scaled, batch.start.slope[0], batch.start.bias[0], output, dense_epochs)
    dense_seconds = (time.perf_counter() - started) / dense_epochs
    repeats = max(1, 60 // dense_epochs)
    started = time.perf_counter()
    for _ in range(repeats):
        fit = train(batch.problem, batch.start, dense_epochs, tolerance=0.0)
    arrow_seconds = (time.perf_counter() - started) / (repeats * dense_epochs)

    reached = predict(fit.weights, batch.problem.inputs)[0] @ batch.axes[0]
    expected = network(dense.parameters, inputs, nodes, taps)[0]
    return {
        "nodes": nodes,
        "taps": taps,
        "parameters": len(dense.parameters),
        "epochs": dense_epochs,
        "dense_seconds_per_epoch": dense_seconds,
        "arrow_seconds_per_epoch": arrow_seconds,
        "ratio": dense_seconds / arrow_seconds,
        "largest_difference_of_outputs": float(np.abs(reached - expected).max() / np.abs(expected).max()),
        "parameters_determined": dense.gamma,
        "difference_of_alpha": abs(fit.evidence.alpha.item() / dense.alpha - 1.0),
        "difference_of_beta": abs(fit.evidence.beta.item() / dense.beta - 1.0),
    }


def side_by_side(count: int, epochs: int) -> dict[str, Any]:
    """Train `count` networks 1-10-512 as one batch, as `compensate` does, and one after the other."""
    inputs, targets = np.linspace(-1.0, 1.0, 13), np.repeat(filters(512)[None], count, axis=0)
    settings = Training(start="random")

    def timed(members: int) -> float:
        rng = np.random.default_rng(0)
        batch = prepare(inputs, targets[:members], np.ones((members, 13)), settings, rng)
        started = time.process_time()
        train(batch.problem, batch.start, epochs, tolerance=0.0)
        return time.process_time() - started

    timed(1)
    alone, together = timed(1), timed(count)
    return {
        "networks": count,
        "seconds_alone": alone,
        "seconds_together": together,
        "ratio": count * alone / together,
    }


def on_another(device: str, count: int, epochs: int) -> dict[str, Any]:
    """Train `count` networks 1-10-512 as one batch here and on `device`; wall time, first use left out."""
    inputs, targets = np.linspace(-1.0, 1.0, 13), np.repeat(filters(512)[None], count, axis=0)
    settings, used = Training(start="random"), np.ones((count, 13))

    def trained(where: str) -> tuple[np.ndarray, float]:
        batch = prepare(inputs, targets, used, settings, np.random.default_rng(0), where)
        started = time.perf_counter()
        fit = train(batch.problem, batch.start, epochs, tolerance=0.0)
        taps = outputs_at(batch, fit.weights, inputs)
        return taps, time.perf_counter() - started

    trained(device)
    (here, here_seconds), (there, there_seconds) = trained("cpu"), trained(device)
    differences = np.abs(here - there).max(axis=(1, 2)) / np.abs(targets).max()
    return {
        "device": device,
        "networks": count,
        "seconds_on_the_processor": here_seconds,
        "seconds_on_the_device": there_seconds,
        "ratio": here_seconds / there_seconds,
        "largest_difference_of_outputs": float(differences.max()),
        "median_difference_of_outputs": float(np.median(differences)),
    }


def main() -> None:
    """Run the cases, print them, write JSON; exit 1 where results or ratio fall short."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--epochs", type=int, default=2, help="dense epochs of the full case")
    parser.add_argument("--device", help="train batches there too: torch's name, such as cuda")
    parser.add_argument("--results", type=Path, default=RESULTS)
    options = parser.parse_args()
    with threadpool_limits(1):
        cases = [
            case(4, 16, 30, "warm"),
            case(6, 64, 10, "warm"),
            # From random weights the first steps are accepted, so that the inverse of the evidence is timed.
            case(10, 512, options.epochs, "random"),
        ]
        batched = side_by_side(66, 40)
        elsewhere = [on_another(options.device, n, 40) for n in (66, 660, 3300)] if options.device else []
    print(
        f"{batched['networks']} networks as one batch: {batched['seconds_together']:.3g} s, one after the other "
        f"{batched['networks'] * batched['seconds_alone']:.3g} s, ratio {batched['ratio']:.1f}"
    )
    for found in elsewhere:
        print(
            f"{found['networks']} networks on {found['device']}: {found['seconds_on_the_device']:.3g} s, on the "
            f"processor {found['seconds_on_the_processor']:.3g} s, ratio {found['ratio']:.2g}; outputs differ by "
            f"{found['largest_difference_of_outputs']:.1e} (median {found['median_difference_of_outputs']:.1e})"
        )
    full = cases[-1]
    for found in cases:
        dense, arrow = found["dense_seconds_per_epoch"], found["arrow_seconds_per_epoch"]
        print(
            f"1-{found['nodes']}-{found['taps']}, {found['parameters']} parameters: dense {dense:.4g} s, arrow "
            f"{1e3 * arrow:.3g} ms an epoch, ratio {found['ratio']:.0f}; outputs differ by "
            f"{found['largest_difference_of_outputs']:.1e}"
        )
    differences = ("largest_difference_of_outputs", "difference_of_alpha", "difference_of_beta")
    # A gamma below the number of parameters shows that steps were accepted and the evidence re-estimated.
    good = full["ratio"] >= 1000.0 and all(
        found["parameters_determined"] < found["parameters"] and max(found[name] for name in differences) < 1e-10
        for found in cases
    )
    good = good and all(found["largest_difference_of_outputs"] < 1e-8 for found in elsewhere)
    options.results.parent.mkdir(parents=True, exist_ok=True)
    record = {
        "machine": platform.platform(),
        "numpy": np.__version__,
        "cases": cases,
        "batched": batched,
        "elsewhere": elsewhere,
        "good": good,
    }
    options.results.write_text(json.dumps(record, indent=1) + "\n")
    print(f"{'as wanted' if good else 'FALLS SHORT'}: {options.results}")
    sys.exit(0 if good else 1)


if __name__ == "__main__":
    main()
