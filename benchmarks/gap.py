"""A gap of 31 temperatures x 3 channels, every effect: the whole workflow, and its screen against refitting all.

    python benchmarks/gap.py [--hidden point_mass] [--noise 0.01]

The recorded plate with two more sensors is simulated with one effect hidden in it, by the twin that then looks for
it: what counts here is time, memory, and whether the short way gives the long way's answer. The plain way fits
every effect, from absent, until it settles; screen and fits are compared on the same eight temperatures. So is one
fit that computes all derivatives in every pass with one that keeps those by declared quantities while they hold.
The first run builds the plate's operators, some minutes; they are kept in the cache and not counted.
"""

import argparse
import json
import resource
import time
from concurrent.futures import Executor, ThreadPoolExecutor
from dataclasses import replace
from pathlib import Path
from typing import Any
from unittest.mock import patch

import numpy as np
from threadpoolctl import threadpool_limits

from analysis.experiment import Experiment, Patch
from analysis.gap.data.preparation import prepare
from analysis.gap.data.sweeps import GapSweeps
from analysis.gap.fitting import fit as fit_module
from analysis.gap.fitting.fit import fit_gap
from analysis.gap.fitting.state import GapState, starting_state
from analysis.gap.gap import find_gap
from analysis.gap.search.context import SearchContext
from analysis.gap.search.refit import absent
from analysis.material import LocalLaws
from analysis.recordings.frf import Frf
from analysis.recordings.sweep_point import SweepPoint
from analysis.updated import Updated
from analysis.updating.update import update
from app.files.campaigns.loading import load_campaign
from app.terminal.progress import progress
from app.twins.campaign_twin import OFFSET, WORKERS, campaign_twin, effect_twin, offset_wanted, referred
from simulation.twin.effect_plate import EffectPlate
from simulation.twin.twin import Twin

ROOT = Path(__file__).resolve().parents[1]
SENSORS = {"S2": (0.2, 0.035), "S3": (0.04, 0.115)}
LAWS = LocalLaws(25.0, np.array([np.log(2.3e9), 0.37, np.log(0.07)]), np.array([-0.01, 6e-4, 0.01]), np.zeros(3))
TEMPERATURES = np.arange(0.0, 60.5, 2.0)
GAIN = 15.0
SIZE = 0.5
"""Of the hidden effect, in standard deviations of its prior."""
SAME = 0.1
"""Standard deviations up to which laws of two fits are the same."""
BEST = 3
"""Places at the top of both rankings that are compared."""


def declared() -> Experiment:
    """Return the recorded experiment with two more sensors."""
    recorded = load_campaign(ROOT / "examples" / "pp-plate").experiment
    more = [
        Patch(id=name, role="sensor", center=place, size=(0.02, 0.02), thickness=0.0005)
        for name, place in SENSORS.items()
    ]
    return recorded.model_copy(update={"patch": (*recorded.patch, *more)})


def simulated(twin: Twin[EffectPlate], hidden: str, noise: float) -> Frf:
    """FRFs of every temperature with an effect on, and white noise of a share of their rms."""
    protocol, rng = twin.experiment.protocol, np.random.default_rng(1)
    spacing = 1.0 / (protocol.sweep_duration + protocol.tail)
    low, high = protocol.band
    frequency = np.arange(np.ceil(low / spacing), np.floor(high / spacing) + 1) * spacing
    on = {hidden: {p.name: p.typical if p.shape else SIZE * p.sigma for p in twin.cards[hidden].parameters}}
    temperature = TEMPERATURES
    h = np.array(
        [GAIN * twin.frf(LAWS, frequency, on, SweepPoint(t, protocol.ramp_rate / 60.0, 1.0)) for t in temperature]
    )
    variance = np.broadcast_to(noise**2 * (np.abs(h) ** 2).mean(-1, keepdims=True), h.shape)
    h = h + np.sqrt(0.5 * variance) * (rng.standard_normal(h.shape) + 1j * rng.standard_normal(h.shape))
    sensors = tuple(p.id for p in twin.experiment.patch if p.role == "sensor")
    flat = np.ones(len(temperature))
    return Frf(
        temperature=temperature,
        direction=("up",) * len(temperature),
        level=flat,
        frequency=frequency,
        h=h,
        variance=variance.copy(),
        coherence=np.ones(h.shape),
        excluded=np.zeros(frequency.size, dtype=bool),
        channels=sensors,
    )


def workflow(frf: Frf, updated: Updated, twin: Twin[EffectPlate], executor: Executor) -> dict[str, Any]:
    """Time the comparison from FRFs to the report."""
    wall, cpu = time.perf_counter(), time.process_time()
    found = find_gap(frf, updated, twin, twin.experiment.protocol, executor)
    return {
        "verdict": found.verdict,
        "effects": [e.name for e in found.effects],
        "chi2_per_dof": found.final.chi2_per_dof,
        "seconds": time.perf_counter() - wall,
        "cpu_seconds": time.process_time() - cpu,
    }


def rankings(context: SearchContext, sweeps: GapSweeps, start: GapState) -> dict[str, Any]:
    """Screen every effect and fit every effect, on the same sweeps."""
    baseline = context.fit(start, ())
    started = time.process_time()
    screening = context.score_test(baseline)
    candidates = screening.candidates()
    screened = time.process_time() - started
    started = time.process_time()
    gains = {}
    for candidate in candidates:
        without = replace(baseline.state, effects=absent(context, screening, candidate))
        fit = fit_gap(context.model, sweeps, without, candidate.effects, context.executor)
        gains[candidate.effects[0]] = fit.log_evidence - baseline.log_evidence
    refitted = time.process_time() - started
    by_screen = [c.effects[0] for c in candidates]
    by_fit = sorted(gains, key=lambda name: -gains[name])
    return {
        "temperatures": sweeps.count,
        "effects": len(candidates),
        "screen_cpu_seconds": screened,
        "refit_cpu_seconds": refitted,
        "ratio": refitted / screened,
        "screen_nats": {c.effects[0]: c.gain for c in candidates},
        "refit_nats": gains,
        "best_by_screen": by_screen[:BEST],
        "best_by_refit": by_fit[:BEST],
        "same_winner": by_screen[0] == by_fit[0],
    }


def passes(context: SearchContext, start: GapState, hidden: str) -> dict[str, Any]:
    """Fit the hidden effect with all derivatives computed in every pass, and with known ones."""
    begun = start.with_effects({hidden: context.model.cards[hidden].zero()})
    fits, seconds = [], []
    for near in (-1.0, fit_module.NEAR):  # no derivative changes by less than nothing
        started = time.process_time()
        with patch.object(fit_module, "NEAR", near):
            fits.append(fit_gap(context.model, context.sweeps, begun, (hidden,), context.executor))
        seconds.append(time.process_time() - started)
    plain, known = fits
    apart = np.abs(known.state.laws - plain.state.laws) / plain.stated.laws
    return {
        "plain_cpu_seconds": seconds[0],
        "known_cpu_seconds": seconds[1],
        "ratio": seconds[0] / seconds[1],
        "chi2_apart": known.total - plain.total,
        "laws_apart_sigma": float(apart.max()),
    }


def main() -> int:
    """Run, print, write JSON; status 1 where the hidden effect is not found or the two ways disagree on it."""
    words = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    words.add_argument("--hidden", default="point_mass", help="effect of the library (default: point_mass)")
    words.add_argument("--noise", type=float, default=0.01, help="share of each FRF's rms (default: 0.01)")
    given = words.parse_args()
    experiment = declared()
    with threadpool_limits(1), progress() as report, ThreadPoolExecutor(WORKERS) as executor:
        offset = given.hidden == OFFSET or offset_wanted(experiment)
        whole = effect_twin(experiment, report, offset=offset)
        frf = simulated(whole.referred(LAWS), given.hidden, given.noise)
        plain = campaign_twin(experiment, report)
        started = time.perf_counter(), time.process_time()
        updated = update(frf, plain)
        model = referred(whole, updated)
        before = [
            now - then for now, then in zip((time.perf_counter(), time.process_time()), started, strict=True)
        ]
        result = workflow(frf, updated, model, executor)
        peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0
        sweeps, noise = prepare(frf, experiment.protocol, updated)
        groups = SearchContext(model, sweeps, noise, executor).some_groups()
        few = sweeps.only_groups(groups)
        start = starting_state(updated, sweeps.groups).restricted(sweeps, few)
        kept = passes(SearchContext(model, few, noise, executor), start, given.hidden)
        compared = rankings(SearchContext(model, few, noise, executor), few, start)
    result |= {
        "sweeps": len(frf.temperature),
        "channels": len(frf.channels),
        "lines": frf.frequency.size,
        "nodes": sweeps.nodes.frequency.size,
        "update_seconds": before[0],
        "update_cpu_seconds": before[1],
        "peak_memory_mib": peak,
        "screen": compared,
        "known_derivatives": kept,
    }
    target = ROOT / "benchmarks" / "results" / "gap.json"
    target.parent.mkdir(exist_ok=True)
    target.write_text(json.dumps(result, indent=1) + "\n", encoding="utf-8")
    print(
        f"{len(frf.temperature)} sweeps x {len(frf.channels)} channels x {frf.frequency.size} lines, "
        f"{compared['effects']} effects: {result['verdict']}, {', '.join(result['effects'])}, in "
        f"{result['seconds']:.1f} s (CPU {result['cpu_seconds']:.1f} s), after {before[0]:.1f} s (CPU "
        f"{before[1]:.1f} s) of updating; {peak:.0f} MiB"
    )
    print(
        f"screening every effect {compared['screen_cpu_seconds']:.2f} s of CPU, fitting each "
        f"{compared['refit_cpu_seconds']:.1f} s: ratio {compared['ratio']:.0f}; best by screen "
        f"{', '.join(compared['best_by_screen'])}, by fits {', '.join(compared['best_by_refit'])}; {target}"
    )
    print(
        f"one fit with all derivatives in every pass {kept['plain_cpu_seconds']:.1f} s of CPU, with known ones "
        f"{kept['known_cpu_seconds']:.1f} s: ratio {kept['ratio']:.1f}; chi2 {kept['chi2_apart']:+.2f}, laws up "
        f"to {kept['laws_apart_sigma']:.3f} sigma apart"
    )
    good = result["effects"] == [given.hidden] and compared["same_winner"] and kept["laws_apart_sigma"] < SAME
    return 0 if good else 1


if __name__ == "__main__":
    raise SystemExit(main())
