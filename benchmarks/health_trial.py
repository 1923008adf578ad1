"""How often ``flexura health`` is right: simulated years of a panel, healthy and changed, by its own functions.

    python benchmarks/health_trial.py --histories 200 --named 60

The panel is a polypropylene plate with two actuators and three sensors. Its recordings come from a twin on another
mesh, of other elements, whose patches are stiffer, thicker and stronger or weaker than declared, with gains that
drift and wrong labels of temperature. The laws of the analysis are wrong by what updating leaves open.
Temperatures follow the seasons from -10 to 60 degrees Celsius, in steps of 3.5 K: at these the twin of the
analysis is linearised once for all histories. The baseline has every second of them.
"""

import argparse
import multiprocessing
import time
from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from analysis.declaration.plate_material import material_box
from analysis.experiment import Experiment
from analysis.gap.data.compression import Nodes
from analysis.health.baseline import HealthBaseline, PanelLinearisation, SelfCheck, self_check
from analysis.health.candidates import change_candidates
from analysis.health.recording import DatedRecording, ExpectedResponse, recordings_of
from analysis.health.watch import HealthDate, HealthWatch, NamedChange
from analysis.material import MaterialLaws
from analysis.recordings.frf import Frf
from analysis.recordings.sweep_point import SweepPoint
from app.blind_trial.plates import OTHER_MESH
from app.files.effect_cache import cached_operators
from app.twins.campaign_twin import effect_twin
from simulation.effects.library import library
from simulation.tolerances import tolerances
from simulation.twin.effect_plate import EffectPlate
from simulation.twin.twin import Twin

LENGTHS = (0.24, 0.19)
PATCHES = {"A1": (0.2, 0.155), "A2": (0.045, 0.12), "S1": (0.04, 0.035), "S2": (0.175, 0.055), "S3": (0.11, 0.15)}
LINES = np.arange(100.0, 1500.1, 5.0)
COLDEST, WARMEST = -10.0, 60.0
TABLE = np.linspace(COLDEST, WARMEST, 21)
BASELINE = TABLE[::2]
NOISE = 2e-3
"""Of a line, over the root mean square of its FRF: 54 dB."""
GAIN_DRIFT = 0.002
LABEL = 1.5
"""K that the recorded temperature is wrong by."""
LAW_ERROR = (0.001, 0.0005, 0.01)
"""Of log E, nu and log eta, bent over the range."""
AS_BUILT = {"patch_modulus": 0.03, "patch_thickness": 0.01, "strain_constant": 0.01}
"""Shares by which each patch is not as declared, and the analysis does not know it."""
HEALTHY_BEFORE = 6
BASELINES = 5
"""Recorded of the same panel, for histories in turn."""
KINDS = ("damage", "mass", "bond")
SIZES = {"damage": "loss", "mass": "mass"}
"""Parameter of the size of what has a place."""


def experiment() -> Experiment:
    """Declare the panel."""
    patches = [
        {
            "id": name,
            "role": "actuator" if name[0] == "A" else "sensor",
            "center": list(place),
            "size": [0.02, 0.02],
            "thickness": 0.0005,
            "side": "top",
            "material": "NCE51",
        }
        for name, place in PATCHES.items()
    ]
    protocol = {
        "sweep": "logarithmic",
        "band": [100.0, 2000.0],
        "sweep_duration": 2.0,
        "tail": 0.4,
        "repeats": 3,
        "ramp_rate": 0.0,
        "temperatures": [COLDEST, WARMEST],
        "directions": ["up"],
        "levels": [1.0],
    }
    return Experiment.model_validate(
        {
            "format": "recorded-campaign/1",
            "title": "panel that is watched",
            "plate": {"length_x": LENGTHS[0], "length_y": LENGTHS[1], "thickness": 0.003, "mass": 0.12996},
            "patch": patches,
            "string": [{"point": [0.03, 0.187]}, {"point": [0.21, 0.187]}],
            "acquisition": {
                "module": "NI-9234",
                "sample_rate": 8533.333333333334,
                "input_resistance": 305000.0,
                "input_capacitance": 1.2e-10,
            },
            "protocol": protocol,
            "oven": {"room_temperature": 22.0},
        }
    )


def laws(error: tuple[float, float, float] = (0.0, 0.0, 0.0)) -> MaterialLaws:
    """Return laws over the range, with `error` bent over it."""
    t = np.array([COLDEST, 13.3, 36.7, WARMEST])
    away, bent = t - COLDEST, np.cos(np.pi * (t - COLDEST) / (WARMEST - COLDEST))
    rows = [np.log(2.6e9) - 0.007 * away - 2e-5 * away**2, 0.345 + 6e-4 * away, np.log(0.035) + 0.008 * away]
    coefficients = np.array([row + size * bent for row, size in zip(rows, error, strict=True)])
    knots = np.array([COLDEST] * 4 + [WARMEST] * 4)
    return MaterialLaws(knots, coefficients, np.zeros((3, 4, 4)), (COLDEST, WARMEST))


class TruePanel:
    """The panel as it is; responses of the healthy one tabulated over temperature."""

    def __init__(self, declared: Experiment, rng: np.random.Generator) -> None:
        operators = cached_operators(
            declared, material_box(declared.plate.material), lambda *_: None, OTHER_MESH, exact=True
        )
        known = tolerances(declared, operators.movable, {})
        self.laws = laws()
        self.twin = Twin.of(declared, EffectPlate(operators), library(declared), known).referred(
            self.laws.local(25.0)
        )
        self.built = {
            f"{what} {name}": {"share": float(rng.normal(0.0, share))}
            for what, share in AS_BUILT.items()
            for name in PATCHES
        }
        self.table = {float(t): self.response(float(t), {}) for t in TABLE}

    def response(self, temperature: float, effects: dict[str, dict[str, float]]) -> np.ndarray:
        """Compute responses (I, K, F) with some effects."""
        on = {**self.built, **effects}
        rows = [
            self.twin.frf(self.laws.local(temperature), LINES, on, SweepPoint(temperature, 0.0, 1.0, source))
            for source in range(2)
        ]
        return np.array(rows)


class TabulatedBaseline:
    """A baseline whose twin was linearised on `TABLE`, the nearest temperature of which is taken."""

    def __init__(self, baseline: HealthBaseline, twins: list[PanelLinearisation]) -> None:
        self.baseline, self.twins = baseline, twins

    @property
    def temperature_range(self) -> tuple[float, float]:
        """That of the baseline, degrees Celsius."""
        return self.baseline.temperature_range

    def at(self, temperature: float, *, changes: bool = True) -> ExpectedResponse:
        """Return what `HealthBaseline.at` gives at the nearest temperature of the table."""
        nearest = self.twins[int(np.argmin(np.abs(TABLE - temperature)))]
        columns = nearest.by_change if changes else nearest.by_change[:0]
        return self.baseline.completed(replace(nearest, by_change=columns))


def recorded(
    response: np.ndarray, label: float, rng: np.random.Generator, name: str, nodes: Nodes
) -> DatedRecording:
    """Add noise and drift of the gains, and compress."""
    h = response * np.exp(rng.normal(0.0, GAIN_DRIFT, 2))[:, None, None]
    sigma = NOISE * np.sqrt((np.abs(h) ** 2).mean(-1, keepdims=True)) + 0.0 * np.abs(h)
    spread = rng.standard_normal(h.shape) + 1j * rng.standard_normal(h.shape)
    frf = Frf(
        np.full(2, label),
        ("up", "up"),
        np.ones(2),
        LINES,
        h + sigma / np.sqrt(2.0) * spread,
        sigma**2,
        np.ones(h.shape),
        np.zeros(LINES.size, dtype=bool),
        ("S1", "S2", "S3"),
        source=np.array([0, 1]),
        sources=("A1", "A2"),
    )
    (found,) = recordings_of(frf, nodes, np.zeros(LINES.size, dtype=bool), name, 2)
    return found


def weather(rng: np.random.Generator, weeks: int) -> np.ndarray:
    """Draw a temperature for every week."""
    season = 25.0 + 25.0 * np.sin(2.0 * np.pi * np.arange(weeks) / 52.0 + rng.uniform(0.0, 2.0 * np.pi))
    return TABLE[np.argmin(np.abs(TABLE - (season + rng.normal(0.0, 8.0, weeks))[:, None]), axis=1)]


def drawn_change(kind: str, rng: np.random.Generator) -> dict[str, dict[str, float]]:
    """Draw a change of one kind, at any place."""
    place = {
        "x": float(rng.uniform(0.015, LENGTHS[0] - 0.015)),
        "y": float(rng.uniform(0.015, LENGTHS[1] - 0.015)),
    }
    if kind == "damage":
        return {"local_damage": {"loss": 0.2, **place}}
    if kind == "mass":
        return {"mass_at_place": {"mass": 0.002, **place}}
    if rng.random() < 0.5:
        return {"bond_shear_lag": {"gamma25": 1.0 / 0.9 - 1.0, "softening": 0.0}}
    soft = str(rng.choice(list(PATCHES)))
    return {"patch_debond": {name: 0.1 * (name == soft) for name in PATCHES}}


class Trial:
    """A panel, its twin with wrong laws, and baselines of both, each made once.

    Parameters
    ----------
    seed : int
        Of all that is drawn.
    """

    def __init__(self, seed: int) -> None:
        self._seed, self._began = seed, time.perf_counter()
        declared = experiment()
        self._true = TruePanel(declared, np.random.default_rng(seed))
        scale = np.sqrt((np.abs(self._true.table[float(TABLE[12])]) ** 2).mean())
        self._model = effect_twin(declared, lambda *_: None).referred(laws(LAW_ERROR).local(25.0))
        self._nodes = Nodes.over(LINES, 1e-12, spacing=float(LINES[1] - LINES[0]))  # each line a node
        self._candidates = change_candidates(self._model.cards, {}, tuple(PATCHES))
        self.say(f"{len(self._candidates)} candidates, {self._nodes.frequency.size} nodes")
        first = self._baseline(0)
        missed = np.abs(first.discrepancy).std() / scale
        self.say(f"order {first.order}; twin wrong by {missed:.2e} of rms, noise {NOISE:g}")
        self._twins = [first.linearised(float(t)) for t in TABLE]
        self.say("table made")
        self._baselines = [self._checked(n, first if n == 0 else self._baseline(n)) for n in range(BASELINES)]

    def say(self, text: str) -> None:
        """Print a line with its time."""
        print(f"[{time.perf_counter() - self._began:7.1f} s] {text}", flush=True)

    def healthy(self, histories: int) -> None:
        """Simulate years without a change, and count alarms."""
        misfits = []
        false = judged = 0
        for number in range(histories):
            draw = np.random.default_rng([self._seed, 13, number])
            panel = self._watch(number)
            for week, t in enumerate(weather(draw, 52)):
                told = self._take(panel, week, float(t), self._true.table[float(t)], draw)
                judged, false = judged + 1, false + told.alarm
                misfits.append(abs(told.temperature - t))
            if number % 10 == 9:
                largest = max(one.z for one in panel.dates)
                self.say(
                    f"{number + 1} years: {false} false alarms in {judged} weeks; last: largest z {largest:.2f}"
                )
        off = float(np.median(misfits))
        self.say(f"false alarms: {false} in {judged} panel-weeks; own temperature off by {off:.3f} K (median)")

    def changed(self, changes: int, most_named: int) -> None:
        """Simulate changes after some healthy weeks; count those found, named and placed right."""
        tally = Tally()
        for number in range(changes):
            kind = KINDS[number % len(KINDS)]
            draw = np.random.default_rng([self._seed, 11, number])
            panel, effect, early = self._watch(number), drawn_change(kind, draw), False
            for week, t in enumerate(weather(draw, HEALTHY_BEFORE + 2)):
                changed = week >= HEALTHY_BEFORE
                h = self._true.response(float(t), effect) if changed else self._true.table[float(t)]
                told = self._take(panel, week, float(t), h, draw)
                tally.judged, tally.false = (
                    tally.judged + (not changed),
                    tally.false + (told.alarm and not changed),
                )
                early = early or (changed and told.alarm)
            line = f"{kind} {number}: found {early}, z {panel.dates[-1].z:.1f} {panel.dates[-1].strongest}"
            named = panel.named() if early and number < most_named else None
            self.say(line + tally.counted(kind, effect, named, found=early))
            if number % 15 == 14:
                early_alarms = f"early alarms {tally.false} of {tally.judged}"
                self.say(f"so far (simulated, found, named, named right): {tally.found}; {early_alarms}")
        for line in tally.lines():
            self.say(line)

    def _take(
        self, panel: HealthWatch, week: int, temperature: float, h: np.ndarray, draw: np.random.Generator
    ) -> HealthDate:
        """Record a week with a wrong label, and have it judged."""
        label = float(temperature + draw.normal(0.0, LABEL))
        return panel.take([recorded(h, label, draw, f"week {week}", self._nodes)])

    def _watch(self, number: int) -> HealthWatch:
        baseline, table, check, starts = self._baselines[number % BASELINES]
        return HealthWatch(baseline, check, 1e-3, table, starts)

    def _baseline(self, number: int) -> HealthBaseline:
        draw = np.random.default_rng([self._seed, 7, number])
        rows = [recorded(self._true.table[float(t)], float(t), draw, "baseline", self._nodes) for t in BASELINE]
        names = ("S1", "S2", "S3"), ("A1", "A2")
        return HealthBaseline.of(self._model, laws(LAW_ERROR), {}, np.ones(2), rows, self._candidates, *names)

    def _checked(
        self, number: int, baseline: HealthBaseline
    ) -> tuple[HealthBaseline, TabulatedBaseline, SelfCheck, list[ExpectedResponse]]:
        table = TabulatedBaseline(baseline, self._twins)
        at = [self._twins[int(np.argmin(np.abs(TABLE - t)))] for t in BASELINE]
        check = self_check(baseline, at)
        self.say(f"baseline {number}: order {baseline.order}, misfit {check.misfit:.2f}")
        return baseline, table, check, [baseline.completed(one) for one in at]


class Tally:
    """What came of the simulated changes."""

    def __init__(self) -> None:
        self.judged = self.false = 0
        self.found = {kind: [0, 0, 0, 0] for kind in KINDS}  # simulated, found in 2 weeks, named, named right
        self._away: dict[str, list[float]] = {kind: [] for kind in SIZES}
        self._sizes: dict[str, list[float]] = {kind: [] for kind in SIZES}

    def counted(
        self, kind: str, effect: dict[str, dict[str, float]], named: NamedChange | None, *, found: bool
    ) -> str:
        """Count a change, and say what was named."""
        self.found[kind][0] += 1
        self.found[kind][1] += found
        if named is None:
            return ""
        self.found[kind][2] += 1
        self.found[kind][3] += named.family == kind
        line = f", named {named.family} {named.probability:.3f}"
        if named.change is None:
            return line
        if named.family != kind or kind not in SIZES:
            return f"{line} ({dict(named.probabilities)}, misfit {named.change.misfit:.1f})"
        (wanted,) = effect.values()
        got, name = named.change.values, SIZES[kind]
        off = 1e3 * float(np.hypot(got["x"] - wanted["x"], got["y"] - wanted["y"]))
        self._away[kind].append(off)
        self._sizes[kind].append((got[name] - wanted[name]) / named.change.sigma[name])
        return f"{line}, {off:.1f} mm away, {name} {got[name]:.4g}"

    def lines(self) -> Iterator[str]:
        """Say all of it."""
        for kind, (count, early, named, right) in self.found.items():
            yield f"{kind}: {early} of {count} found within 2 weeks; {right} of {named} named right"
        for kind, away in self._away.items():
            if away:
                within, middle = sum(one <= 15.0 for one in away), float(np.median(away))
                near = f"{within} of {len(away)} within 15 mm"
                yield f"{kind}: {near}, median {middle:.2f} mm, worst {max(away):.1f}"
                rms = np.sqrt(np.mean(np.square(self._sizes[kind])))
                yield f"{kind}: size in standard deviations, rms {rms:.2f}"
        yield f"healthy weeks before changes: {self.false} alarms in {self.judged}"


def main() -> None:
    """Run the trial."""
    asked = argparse.ArgumentParser()
    asked.add_argument("--histories", type=int, default=200)
    asked.add_argument("--named", type=int, default=150)
    asked.add_argument("--changes", type=int, default=150)
    asked.add_argument("--seed", type=int, default=1)
    options = asked.parse_args()
    trial = Trial(options.seed)
    # both at a time, forked: they share what was computed
    context = multiprocessing.get_context("fork")
    apart = context.Process(target=trial.changed, args=(options.changes, options.named))
    apart.start()
    trial.healthy(options.histories)
    apart.join()


if __name__ == "__main__":
    main()
