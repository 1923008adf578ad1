"""Faults of the sensors on a plate: is a sweep kept at a wrong temperature without a note, is any told in vain.

    python benchmarks/sensor_faults.py --faults 10000 --healthy 1000

Each trial is a campaign on the simulated oven with its plate, on virtual time and without the sweeps' signals:
approach, soak and ramps, up, down or both, pauses, doors opened, one or two thermocouples, with noise, an offset
of the oven's sensor and a gradient over the plate. The judge is the one of the rig, `analysis.plate_temperature`.
A fault begins at any moment. A kept sweep is *untold* if its temperature is wrong by more than 0.5 K, and neither
its reading was in doubt nor a note at the end names it.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from analysis.plate_temperature.plate_sensors import PlateSensors
from drivers.clock import VirtualClock
from drivers.ovens.simulated.regulated_oven import Chamber, RegulatedOven, Regulator
from drivers.rig.campaign import CLOSING_READINGS

WRONG = 0.5
"""Error of a label, K."""
TOLERANCE, LOST_AFTER, STALLED = 0.4, 120.0, 1800.0
"""As `analysis.protocol` and `drivers.rig.campaign` have them, K and s."""
SWEEP = 10.0
"""Duration of one sweep with its repeats, s."""
ROOM = 22.0

Fault = Callable[[float, float, float], float]
"""True plate, air and seconds since the fault began -> reading without noise."""


class CampaignStoppedError(Exception):
    """The judge ended the campaign."""


def fault(kind: str, rng: np.random.Generator, low: float, high: float) -> Fault:
    """Return a fault of a kind, drawn at random."""
    state: dict[str, float] = {}
    sign = float(rng.choice([-1.0, 1.0]))

    def stuck(plate: float, air: float, since: float) -> float:
        return state.setdefault("value", plate)

    def fallen(plate: float, air: float, since: float) -> float:
        before, last = state.get("value", plate), state.get("time", since)
        state["time"] = since
        state["value"] = air + (before - air) * math.exp(-(since - last) / lag)
        return state["value"]

    lag, share, scale = rng.uniform(3.0, 15.0), rng.uniform(0.15, 0.9), sign * rng.uniform(0.02, 0.15)
    rate, elsewhere, cold = sign * rng.uniform(0.5, 12.0) / 3600.0, rng.uniform(low, high), rng.uniform(20.0, 30.0)
    step, slow = sign * rng.uniform(0.3, 6.0), rng.uniform(300.0, 3600.0)
    beyond = float(rng.choice([math.nan, 2300.0, -270.0, math.inf]))
    kinds: dict[str, Fault] = {
        "stuck": stuck,
        "stuck elsewhere": lambda plate, air, since: elsewhere,
        "drift": lambda plate, air, since: plate + rate * since,
        "open": lambda plate, air, since: beyond,
        "shorted": lambda plate, air, since: cold,
        "another type": lambda plate, air, since: plate + scale * (plate - ROOM),
        "half loose": lambda plate, air, since: plate + share * (air - plate),
        "loosening": lambda plate, air, since: plate + share * min(since / slow, 1.0) * (air - plate),
        "fallen off": fallen,
        "step": lambda plate, air, since: plate + step,
        "zero": lambda plate, air, since: 0.0,
    }
    return kinds[kind]


KINDS = (
    "stuck", "stuck elsewhere", "drift", "open", "shorted", "another type", "half loose", "loosening",
    "fallen off", "step", "zero",
)  # fmt: skip
NOISELESS = ("zero",)


@dataclass
class Trial:
    """One campaign, with or without a fault.

    Attributes
    ----------
    seed : int
    kind : str
        Of the fault; empty for a healthy campaign.
    labels : dict of int to (float, float, bool)
        Of every sweep kept, by step: label, true temperature of the plate, whether it was told.
    ending : str
        ``complete``, or why it was stopped.
    told : list of str
        Everything that the judge said.
    """

    seed: int
    kind: str = ""
    labels: dict[int, tuple[float, float, bool]] = field(default_factory=dict)
    ending: str = "complete"
    told: list[str] = field(default_factory=list)

    def run(self) -> "Trial":
        """Run it to its end."""
        self._draw()
        try:
            for leg, direction in enumerate(self._legs):
                self._run_leg(leg, direction)
        except CampaignStoppedError as stopped:
            self.ending = str(stopped)
        for step, why in self._judge.mislabelled().items():
            self.told.append(f"step {step}: {why}")
            if step in self.labels:
                self.labels[step] = (*self.labels[step][:2], True)
        return self

    @property
    def untold(self) -> list[tuple[float, float]]:
        """Labels that are wrong without a word, each with the true temperature, degrees Celsius."""
        return [
            (label, true) for label, true, told in self.labels.values() if abs(label - true) > WRONG and not told
        ]

    def _draw(self) -> None:
        rng = self._rng = np.random.default_rng([self.seed, len(self.kind)])
        self._tau = math.exp(rng.uniform(math.log(60.0), math.log(600.0)))
        self._noise, self._offset = rng.uniform(0.02, 0.1), rng.uniform(-0.5, 0.5)
        self._rate = math.exp(rng.uniform(math.log(0.2), math.log(2.0)))
        span = float(np.clip(self._rate * rng.uniform(25.0, 60.0), 6.0, 40.0))
        self._low = rng.uniform(-5.0, 60.0 - span)
        self._high = self._low + span
        self._every = span / float(rng.integers(3, 8))
        self._legs = [("up",), ("down",), ("up", "down"), ("down", "up")][rng.integers(4)]
        self._lead = self._rate * self._tau / 60.0 + 1.0
        self._soak = rng.uniform(300.0, 1200.0)
        self._poll = float(rng.choice([5.0, 10.0]))
        count = int(rng.integers(1, 3))
        gradient = rng.uniform(-0.15, 0.15)
        self._gradient = [gradient, -gradient] if count == 2 else [0.0]
        self._clock = VirtualClock()
        chamber = Chamber(plate_capacity=6.0 * self._tau, room=ROOM)
        regulator = Regulator(noise=rng.uniform(0.02, 0.1))
        self._oven = RegulatedOven(self._clock, np.random.default_rng(self.seed), chamber, regulator)
        self._judge = PlateSensors([f"thermocouple {number + 1}" for number in range(count)])
        estimate = 60.0 * span / self._rate * len(self._legs) + 3600.0
        self._disturbances = sorted(rng.uniform(600.0, estimate, size=int(rng.integers(0, 3))))
        self._fault = fault(self.kind, rng, self._low, self._high) if self.kind else None
        # a step before the campaign is an offset of the oven's sensor as well
        share = {"step": 0.0, "another type": 0.7, "half loose": 0.7}.get(self.kind, 0.15)
        early = rng.random() < share
        self._fault_at = 0.0 if early else rng.uniform(0.0, estimate)
        self._missing_since, self._doubt = math.inf, False

    def _read(self) -> float | None:
        """Return the label's temperature at the next point of the time grid."""
        self._clock.sleep(self._poll * (math.floor(self._clock.now() / self._poll + 1e-6) + 1) - self._clock.now())
        return self._reading()

    def _reading(self) -> float | None:
        now, air = self._clock.now(), self._oven.measured + self._offset
        readings = [self._sensor(number, gradient) for number, gradient in enumerate(self._gradient)]
        if not self._judge.fit(now, air, readings):
            readings = [self._sensor(number, gradient) for number, gradient in enumerate(self._gradient)]
        found = self._judge.judge(now, air, readings)
        self.told += [*found.left_out, *found.doubts] if len(self.told) < 20 else []
        self._doubt = self._doubt or bool(found.doubts)
        if found.temperature is None:
            self._missing_since = min(self._missing_since, now)
            if now - self._missing_since >= LOST_AFTER:
                raise CampaignStoppedError(found.why)
        else:
            self._missing_since = math.inf
        return found.temperature

    def _sensor(self, number: int, gradient: float) -> float:
        true, noise, now = self._oven.plate + gradient, self._noise, self._clock.now()
        if self._fault is not None and number == 0 and now >= self._fault_at:
            true = self._fault(true, self._oven.air, now - self._fault_at)
            noise = 0.0 if self.kind in NOISELESS or (self.kind == "stuck" and self.seed % 2) else noise
        value = true + noise * float(self._rng.standard_normal())
        return round(value, 3) if math.isfinite(value) else value

    def _run_leg(self, leg: int, direction: str) -> None:
        sign = 1.0 if direction == "up" else -1.0
        start, end = (self._low - self._lead, self._high + self._lead)[:: 1 if sign > 0 else -1]
        self._settle(start)
        self._oven.go(end, self._rate, self._oven.measured)
        count = round((self._high - self._low) / self._every)
        points = [self._low + index * self._every for index in range(count + 1)][:: 1 if sign > 0 else -1]
        mark = None
        while points:
            if self._disturb(end):
                mark = None
            self._doubt = False
            here = self._read()
            if here is None:
                continue
            middle = sign * here + 0.5 * SWEEP * self._rate / 60.0
            while points and middle > sign * points[0] + TOLERANCE:
                points.pop(0)
            if points and middle >= sign * points[0]:
                if self._sweep(points[0], leg):
                    points.pop(0)
                mark = None
                continue
            now = self._clock.now()
            if mark is None or sign * here - mark[1] >= 0.25 * self._rate * STALLED / 60.0:
                mark = (now, sign * here)
            if now - mark[0] > STALLED:
                raise CampaignStoppedError("the oven does not ramp")
        for _ in range(CLOSING_READINGS):
            self._read()

    def _sweep(self, point: float, leg: int) -> bool:
        before, true = self._reading(), self._oven.plate
        self._clock.sleep(SWEEP)
        after, true = self._reading(), 0.5 * (true + self._oven.plate)
        if before is None or after is None:
            return False
        label = 0.5 * (before + after)
        if abs(label - point) > TOLERANCE:
            return False
        step = leg * 100 + round((point - self._low) / self._every)
        self._judge.mark(step)
        self.labels[step] = (label, true, self._doubt)
        return True

    def _settle(self, target: float) -> None:
        self._oven.go(target, 3.0, self._oven.measured)
        inside, deadline = None, self._clock.now() + 20.0 * 60.0 * 4 + 14_400.0
        while True:
            here, now = self._read(), self._clock.now()
            if here is None:
                continue
            inside = None if abs(here - target) > 0.7 else now if inside is None else inside
            if inside is not None and now - inside >= self._soak:
                return
            if now > deadline:
                raise CampaignStoppedError("can the oven reach it?")

    def _disturb(self, end: float) -> bool:
        """Open the door, or pause: hold the oven, then ramp on; return whether it did."""
        if not self._disturbances or self._clock.now() < self._disturbances[0]:
            return False
        self._disturbances.pop(0)
        heat = self._oven._heat  # the door: a share of the air is the room's
        if self._rng.random() < 0.5:
            heat.air += self._rng.uniform(0.1, 0.6) * (ROOM - heat.air)
            return True
        self._oven.go(self._oven.measured, math.inf, self._oven.measured)
        until = self._clock.now() + self._rng.uniform(120.0, 1800.0)
        while self._clock.now() < until:
            self._read()
        self._oven.go(end, self._rate, self._oven.measured)
        return True
