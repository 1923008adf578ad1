"""R10 twenty times over: accuracy and speed of the identification, against plain ways of doing the same.

    python benchmarks/identification.py [--draws 20] [--noise 0.01] [--cases] [--peers] [--campaign FOLDER]

`--cases` runs what real lines have besides: noise that lines share, ripple, near pairs, forty modes. On the same
FRFs it prints what is missed where the true poles are told (`identification_bound.py`): by BIC, and where noise is
white by the Cramér-Rao bound alone. `--peers` runs other packages, where they are installed
(docs/dependencies.md). Errors of one FRF go together, so "+-" is the standard error of the coverage over FRFs.

`--campaign` takes a recorded campaign: its sweeps fitted together against sweeps taken one by one.

Two plain ways. Vector fitting alone: as many pole pairs as it starts with, those kept whose residue stands out of
the noise; this is what it costs to stop there. Variable projection the plain way: SciPy's least squares on all
lines over the poles, residues eliminated at each step, Jacobian by finite differences, from the same start as our
warm refinement; the poles must agree.
"""

import argparse
import json
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
from identification_bound import told_all, told_the_poles, too_far
from identification_peers import PEERS
from numpy.typing import NDArray
from scipy.optimize import least_squares, linear_sum_assignment
from threadpoolctl import threadpool_limits

from analysis.identification.automatic import identify, refine
from analysis.identification.lines import Lines
from analysis.identification.measured import Measured
from analysis.identification.modes import Modes
from analysis.identification.pole_residue import (
    COMPLEX_E_F_G,
    ResidualTerms,
    pole_columns,
    to_parameters,
    to_poles,
)
from analysis.identification.pole_search import project
from analysis.identification.vector_fitting import start_poles
from tests.synthetic_frf import SyntheticFrf, crowded, pairs, r10, rippled, shared_noise

ROOT = Path(__file__).resolve().parents[1]
WHITE = ("R10", "pairs", "forty modes")
"""Cases whose lines have independent errors of one size."""

Found = tuple[NDArray[np.complex128], NDArray[np.float64] | None]


def ours(case: SyntheticFrf) -> Found:
    """Poles of the modes that were kept, and the standard deviations of log |pole| and log damping ratio."""
    modes = identify(Measured(case.frequency, case.h[None]))
    kept = np.array([status == "kept" for status in modes.status])
    return modes.poles[kept], np.sqrt(np.diagonal(modes.covariance[kept], axis1=1, axis2=2))


def vector_fitting_alone(case: SyntheticFrf) -> Found:
    """Poles of 24 pairs inside the band whose peak stands four standard deviations out of the noise."""
    lines = Lines(case.frequency, case.h[None], np.full((1, len(case.h)), case.deviation))
    poles = start_poles(lines, 24, COMPLEX_E_F_G)
    residues = project(lines, poles, COMPLEX_E_F_G).residues[0]
    place, zeta = poles.imag / (2 * np.pi), -poles.real / np.abs(poles)
    seen = np.abs(residues) / -poles.real > 4.0 * case.deviation
    return poles[seen & (place > case.frequency[0]) & (place < case.frequency[-1]) & (zeta < 0.2)], None


def plain_refinement(
    case: SyntheticFrf, start: NDArray[np.complex128], terms: ResidualTerms
) -> NDArray[np.complex128]:
    """Least squares over the poles with a finite-difference Jacobian."""
    s = 2j * np.pi * case.frequency
    scale = float(2 * np.pi * np.sqrt(case.frequency[0] * case.frequency[-1]))
    y = np.concatenate([case.h.real, case.h.imag]) / case.deviation

    def left(x: NDArray[np.float64]) -> NDArray[np.float64]:
        columns = np.concatenate([pole_columns(s, to_poles(x.reshape(-1, 2))), terms.columns(s, scale)])
        a = np.concatenate([columns.real, columns.imag], axis=1).T
        rest: NDArray[np.float64] = y - a @ np.linalg.lstsq(a, y, rcond=None)[0]
        return rest

    solved = least_squares(left, to_parameters(start).ravel(), x_scale="jac", method="lm", xtol=1e-10)
    return to_poles(solved.x.reshape(-1, 2))


def score(cases: list[SyntheticFrf], way: Callable[[SyntheticFrf], Found]) -> dict[str, float]:
    """Missed, spurious, errors in per cent, coverage of 95 % intervals, and CPU seconds per FRF."""
    missed = spurious = 0
    errors, covered, seconds = [], [], []
    for case in cases:
        started = time.process_time()
        poles, sigma = way(case)
        seconds.append(time.process_time() - started)
        matched = set()
        standardised = []
        away = np.abs(np.log(np.abs(case.poles)[:, None] / np.abs(poles)))
        rows, columns = linear_sum_assignment(np.minimum(away, 0.2))
        missed += len(case.poles) - len(rows)
        for pole, j in zip(case.poles[rows], columns.tolist(), strict=True):
            zeta, other = -pole.real / abs(pole), -poles[j].real / abs(poles[j])
            error = np.array([abs(poles[j]) / abs(pole) - 1.0, other / zeta - 1.0])
            if abs(error[0]) < zeta and abs(error[1]) < 0.5 and j not in matched:
                matched.add(j)
                errors.append(error)
                if sigma is not None:
                    standardised += list(error / sigma[j])
            else:
                missed += 1
        spurious += len(poles) - len(matched)
        if standardised:
            covered.append(np.mean(np.abs(standardised) < 1.96))
    percent = 100 * np.abs(np.array(errors).reshape(-1, 2))
    result = {
        "missed": missed,
        "spurious_per_frf": spurious / len(cases),
        "frequency_median_percent": float(np.median(percent[:, 0])),
        "frequency_rms_percent": float(np.sqrt((percent[:, 0] ** 2).mean())),
        "damping_median_percent": float(np.median(percent[:, 1])),
        "damping_rms_percent": float(np.sqrt((percent[:, 1] ** 2).mean())),
        "seconds_per_frf": float(np.mean(seconds)),
    }
    if covered:
        result["coverage_of_95_percent"] = float(np.mean(covered))
        result["coverage_standard_error"] = float(np.std(covered) / np.sqrt(max(len(covered) - 1, 1)))
    return result


def table(draws: int, noise: float, every: bool, peers: bool) -> None:
    """Print missed, spurious, error, coverage and CPU time of every way on every case."""
    ways: dict[str, Callable[[SyntheticFrf], Found]] = {"Flexura": ours} | (PEERS if peers else {})
    if every:
        ways |= {"BIC, told the true poles": told_the_poles, "least squares from all of them": told_all}
    made: dict[str, Callable[[np.random.Generator], SyntheticFrf]] = {"R10": lambda rng: r10(rng, noise=noise)}
    if every:
        made |= {"shared noise": shared_noise, "ripple": rippled, "pairs": pairs, "forty modes": crowded}
    print("case            way                               missed %  spurious  df/f %    covered %        s")
    for name, make in made.items():
        cases = [make(np.random.default_rng(1000 + n)) for n in range(draws)]
        modes = sum(len(case.poles) for case in cases)
        for way, run in ways.items():
            try:
                found = score(cases, run)
            except ImportError as error:
                print(f"{name:15} {way:33} not installed ({error})")
                continue
            covered, error = (
                100 * found.get(key, np.nan) for key in ("coverage_of_95_percent", "coverage_standard_error")
            )
            print(
                f"{name:15} {way:33} {100 * found['missed'] / modes:7.1f} {found['spurious_per_frf']:9.2f} "
                f"{found['frequency_median_percent']:9.4f} {covered:9.1f} +- {error:3.1f} "
                f"{found['seconds_per_frf']:7.2f}",
                flush=True,
            )
        if every and name in WHITE:
            far = sum(too_far(case) for case in cases)
            print(f"{name:15} {'Cramér-Rao bound':33} {100 * far / modes:7.1f}", flush=True)


def together(folder: Path) -> None:
    """CPU time of a campaign's sweeps fitted together, and of every fourth sweep identified alone."""
    from analysis.identification.over_temperature.tracking import sweep_measured, track
    from analysis.recordings.frf import campaign_frf
    from app.files.campaigns.loading import load_campaign

    frf = campaign_frf(load_campaign(folder), mains=50.0)
    count = len(frf.temperature)
    started = time.process_time()
    track(frf)
    joint = (time.process_time() - started) / count
    some = range(0, count, 4)
    started = time.process_time()
    for t in some:
        identify(sweep_measured(frf, t))
    alone = (time.process_time() - started) / len(some)
    print(f"{count} sweeps together: {joint:.2f} s a sweep, alone {alone:.2f} s: {alone / joint:.1f} times faster")


def warm(cases: list[SyntheticFrf]) -> dict[str, float]:
    """Refine from poles two per mille off, our way and plainly."""
    rng = np.random.default_rng(0)
    seconds = np.zeros(2)
    apart = 0.0
    for case in cases:
        measured = Measured(case.frequency, case.h[None], np.full((1, len(case.h)), case.deviation**2))
        first = identify(measured)
        start = first.poles * np.exp(2e-3 * rng.normal(size=len(first.poles)))
        moved = Modes(**{**vars(first), "poles": start})
        started = time.process_time()
        mine = refine(measured, moved)
        seconds[0] += time.process_time() - started
        started = time.process_time()
        plain = plain_refinement(case, start, first.terms)
        seconds[1] += time.process_time() - started
        sigma = np.sqrt(np.diagonal(mine.covariance, axis1=1, axis2=2))
        apart = max(apart, float(np.abs((to_parameters(mine.poles) - to_parameters(plain)) / sigma).max()))
    seconds /= len(cases)
    return {
        "seconds_per_frf": float(seconds[0]),
        "plain_seconds_per_frf": float(seconds[1]),
        "ratio": float(seconds[1] / seconds[0]),
        "largest_difference_sigma": apart,
    }


def main() -> None:
    """Run, print, write JSON; fail where the two refinements disagree."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--draws", type=int, default=20)
    parser.add_argument("--noise", type=float, default=0.01)
    parser.add_argument("--cases", action="store_true", help="all cases, not R10 alone")
    parser.add_argument("--peers", action="store_true", help="other packages, too")
    parser.add_argument("--campaign", type=Path, help="sweeps of a recorded campaign, together and one by one")
    options = parser.parse_args()
    if options.campaign:
        with threadpool_limits(1):
            together(options.campaign)
        return
    if options.cases or options.peers:
        with threadpool_limits(1):
            table(options.draws, options.noise, options.cases, options.peers)
        return
    cases = [r10(np.random.default_rng(1000 + n), noise=options.noise) for n in range(options.draws)]
    with threadpool_limits(1):
        result = {
            "draws": options.draws,
            "noise": options.noise,
            "ours": score(cases, ours),
            "vector_fitting_alone": score(cases, vector_fitting_alone),
            "warm_start": warm(cases),
        }
    for way in ("ours", "vector_fitting_alone"):
        print(f"{way}:", ", ".join(f"{name} {value:.4g}" for name, value in result[way].items()))
    start = result["warm_start"]
    print(
        f"warm start: {start['seconds_per_frf']:.3f} s, plainly {start['plain_seconds_per_frf']:.3f} s: "
        f"{start['ratio']:.0f} times faster, poles at most {start['largest_difference_sigma']:.2g} sigma apart"
    )
    target = ROOT / "benchmarks" / "results" / "identification.json"
    target.parent.mkdir(exist_ok=True)
    target.write_text(json.dumps(result, indent=1) + "\n", encoding="utf-8")
    if start["largest_difference_sigma"] > 0.2:
        raise SystemExit("the two refinements disagree")


if __name__ == "__main__":
    main()
