"""Updating a campaign: analytic sensitivities and a warm start against plain least squares with differences.

    python benchmarks/updating.py [CAMPAIGN] [--plain-sweeps 4]

The plain way fits every sweep on its own with scipy's least_squares, its Jacobian by finite differences, all
lines, from the same start; it is timed on a few sweeps and scaled to all. Both must agree within a
fifth of a standard deviation of the noise.
"""

import argparse
import json
import time
from pathlib import Path

import numpy as np
from scipy.optimize import least_squares
from threadpoolctl import threadpool_limits

from analysis.material import LocalLaws
from analysis.recordings.frf import Frf, campaign_frf
from analysis.updated import Updated
from analysis.updating.normal_equations import SweepData
from analysis.updating.start import start_material
from analysis.updating.update import update
from app.files.campaigns.loading import load_campaign
from app.terminal.progress import progress
from app.twins.campaign_twin import campaign_twin
from simulation.twin.twin import Twin

ROOT = Path(__file__).resolve().parents[1]


def plain_fit(twin: Twin, frf: Frf, sweep: int, gain: float) -> np.ndarray:
    """E, nu, eta of one sweep at a known gain, by finite differences from the start."""
    data = SweepData.of(frf, sweep)
    start = start_material(twin, SweepData.of(frf, sweep, 8))
    scale = np.sqrt(2.0 * data.weight)
    box = np.array([twin.box.youngs_modulus, twin.box.poisson_ratio, twin.box.loss_factor])

    def residual(x: np.ndarray) -> np.ndarray:
        rest = ((data.h - gain * twin.frf(LocalLaws.of_material(*(x * start)), data.frequency)) * scale).ravel()
        return np.concatenate([rest.real, rest.imag])

    bounds = (box[:, 0] / start, box[:, 1] / start)
    result: np.ndarray = least_squares(residual, np.ones(3), bounds=bounds, xtol=1e-10).x * start
    return result


def compare(twin: Twin, frf: Frf, count: int) -> dict[str, float | int]:
    """Time both ways and say how far apart they are, in standard deviations."""
    started = time.perf_counter()
    ours: Updated = update(frf, twin)
    seconds = time.perf_counter() - started
    sweeps = np.linspace(0, len(frf.temperature) - 1, count).astype(int)
    started = time.perf_counter()
    plain = np.array([plain_fit(twin, frf, int(t), ours.gain) for t in sweeps])
    plain_seconds = (time.perf_counter() - started) / count * len(frf.temperature)
    names = ("youngs_modulus", "poisson_ratio", "loss_factor")
    value = np.array([getattr(ours.material, n)[sweeps] for n in names]).T
    sigma = np.array([getattr(ours.sigma, n)[sweeps] for n in names]).T
    return {
        "sweeps": len(frf.temperature),
        "lines": len(frf.frequency),
        "seconds": seconds,
        "plain_seconds": plain_seconds,
        "ratio": plain_seconds / seconds,
        "largest_difference_sigma": float(np.abs((plain - value) / sigma).max()),
    }


def main() -> None:
    """Run, print, write JSON; fail where the two disagree."""
    words = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    words.add_argument("campaign", nargs="?", type=Path, default=ROOT / "examples" / "pp-plate")
    words.add_argument("--plain-sweeps", type=int, default=4)
    given = words.parse_args()
    campaign = load_campaign(given.campaign)
    with threadpool_limits(1), progress() as report:
        result = compare(campaign_twin(campaign.experiment, report), campaign_frf(campaign), given.plain_sweeps)
    print(
        f"{result['sweeps']} sweeps x {result['lines']} lines: {result['seconds']:.2f} s; plain "
        f"{result['plain_seconds']:.1f} s (scaled); ratio {result['ratio']:.1f}; "
        f"largest difference {result['largest_difference_sigma']:.3f} sigma"
    )
    folder = ROOT / "benchmarks" / "results"
    folder.mkdir(exist_ok=True)
    (folder / "updating.json").write_text(json.dumps(result, indent=1) + "\n")
    assert result["largest_difference_sigma"] < 0.2, "the two ways disagree"  # noqa: S101


if __name__ == "__main__":
    main()
