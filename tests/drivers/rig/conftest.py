"""A campaign on the simulated rig around a plate that is a band-pass, quick enough for every fault."""

import hashlib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.signal import butter, sosfilt, sosfreqz

from analysis.campaign import Sweep
from analysis.frf import h1
from analysis.protocol.limits import Limits
from analysis.protocol.programme import Programme, Settling
from analysis.protocol.protocol import AcquisitionProtocol
from analysis.protocol.set_points import SetPoint
from analysis.protocol.sweep import SweepSettings
from drivers.ni.modules import NI_9234
from drivers.ni.output_modules import NI_9260
from drivers.ni.simulated.surroundings import Module
from drivers.ni.thermocouple_modules import NI_9211
from drivers.ni.wiring import Wiring
from drivers.ovens.settings import OvenSettings
from drivers.ovens.simulated.disturbance import Disturbed
from drivers.ovens.simulated.thermal import Chamber
from drivers.rig.campaign import Outcome, run_campaign
from drivers.rig.rig import Rig
from drivers.rig.simulated import SimulatedParts, simulated_parts

Array = NDArray[np.float64]
LIGHT = Chamber(plate_capacity=180.0)
"""A plate that lags 30 s behind the air."""
MODULES: dict[int, Module] = {1: NI_9234, 2: NI_9260, 3: NI_9211}


class SofteningPlate:
    """A resonance that falls by 1 % a kelvin; `before` is called when a sweep is computed."""

    def __init__(self) -> None:
        self.before: Callable[[], None] = lambda: None
        self.sweeps = 0

    @staticmethod
    def sections(temperature: float, rate: float) -> Array:
        centre = 600.0 * (1.0 - 0.01 * (temperature - 20.0))
        return np.asarray(butter(1, [0.95 * centre, 1.05 * centre], btype="bandpass", fs=rate, output="sos"))

    def response(self, temperature: float, frequency: Array, rate: float) -> NDArray[np.complex128]:
        return np.asarray(0.5 * sosfreqz(self.sections(temperature, rate), worN=frequency, fs=rate)[1])

    def __call__(self, drive: Array, rate: float, temperature: Array) -> Array:
        self.sweeps += 1
        self.before()
        return np.asarray(0.5 * sosfilt(self.sections(float(temperature.mean()), rate), drive))[None]


@dataclass
class MemoryStore:
    """Keeps sweeps by step, and refuses to keep one twice."""

    kept: dict[int, Sweep] = field(default_factory=dict)
    aside: list[tuple[int, int, tuple[str, ...]]] = field(default_factory=list)
    log_lines: list[dict[str, Any]] = field(default_factory=list)
    before_keeping: Callable[[SetPoint], None] = lambda point: None

    def finished(self) -> frozenset[int]:
        return frozenset(self.kept)

    def keep(self, sweep: Sweep, set_point: SetPoint, attempt: int) -> None:
        self.before_keeping(set_point)
        assert set_point.step not in self.kept
        self.kept[set_point.step] = sweep

    def put_aside(self, sweep: Sweep, set_point: SetPoint, attempt: int, faults: Sequence[str]) -> None:
        assert (set_point.step, attempt) not in [(step, number) for step, number, _ in self.aside]
        self.aside.append((set_point.step, attempt, tuple(faults)))

    def log(self, event: Mapping[str, Any]) -> None:
        self.log_lines.append(dict(event))

    def events(self) -> list[dict[str, Any]]:
        return list(self.log_lines)

    def told(self, kind: str) -> list[dict[str, Any]]:
        return [event for event in self.log_lines if event["event"] == kind]


def digest(sweep: Sweep) -> str:
    """Everything in a sweep, to the last bit."""
    parts = [repr((sweep.step, sweep.start_time, sweep.temperature, sweep.oven_temperature)).encode()]
    parts += [sweep.drive.tobytes(), sweep.responses.tobytes()]
    return hashlib.sha256(b"".join(parts)).hexdigest()


def protocol_of(
    sweep: dict[str, Any] | None = None,
    programme: dict[str, Any] | None = None,
    limits: dict[str, Any] | None = None,
) -> AcquisitionProtocol:
    return AcquisitionProtocol(
        SweepSettings(
            **{
                "kind": "logarithmic",
                "band": (200.0, 1200.0),
                "duration": 0.5,
                "taper": 0.05,
                "tail": 0.2,
                "repeats": 2,
                "levels": (1.0,),
                **(sweep or {}),
            }
        ),
        Programme(
            **{
                "lowest": 24.0,
                "highest": 28.0,
                "every": 2.0,
                "ramp_rate": 2.0,
                "approach_rate": 3.0,
                "lead": 1.5,
                "soak_before": 30.0,
                "settling": Settling(within=0.5, lasting=30.0),
                "tolerance": 0.4,
                "poll_interval": 3.0,
                **(programme or {}),
            }
        ),
        Limits(**{"coldest": 0.0, "hottest": 50.0, "patch_voltage": 100.0, "lost_after": 60.0, **(limits or {})}),
    )


class World:
    """A campaign, its store and, run by run, a simulated rig."""

    def __init__(self, kind: str = "watlow-f4t", **changes: Any) -> None:
        self.protocol = protocol_of(**changes)
        self.store = MemoryStore()
        self.kind = kind
        self.chamber = LIGHT
        self.renew()

    def renew(self) -> None:
        """Set up a sound rig, as a new process would."""
        self.plate = SofteningPlate()
        self.wiring = Wiring(
            output="cDAQ1Mod2/ao0",
            drive_input="cDAQ1Mod1/ai0",
            responses=("cDAQ1Mod1/ai1",),
            thermocouples=("cDAQ1Mod3/ai0",),
            sample_rate=8500.0,
        )
        settings = OvenSettings(
            kind=self.kind,  # type: ignore[arg-type]
            port="simulated",
            minimum=0.0,
            maximum=50.0,
            max_rate=3.0,
            timeout=0.2,
            lost_after=30.0,
        )
        parts = simulated_parts(self.wiring, settings, self.plate, modules=MODULES, seed=5, chamber=self.chamber)
        self.disturbed = Disturbed(parts.controller)
        self.parts = SimulatedParts(
            parts.clock, parts.body, self.disturbed, parts.server, parts.wiring, parts.oven
        )
        self.rig: Rig = self.parts.rig()
        self.temperatures: list[float] = []

    def at(self, seconds: float, action: Callable[[], None]) -> None:
        """Do something once, at the first reading of the clock by the campaign after `seconds`."""
        clock, sleep = self.parts.clock, self.parts.clock.sleep
        pending = [action]

        def slept(duration: float) -> None:
            sleep(duration)
            if pending and clock.now() >= seconds:
                pending.pop()()

        clock.sleep = slept  # type: ignore[method-assign]

    def run(self, **options: Any) -> Outcome:
        return run_campaign(self.rig, self.protocol, self.store, **options)

    def digests(self) -> dict[int, str]:
        """Digest of every sweep kept."""
        return {step: digest(sweep) for step, sweep in self.store.kept.items()}

    def at_rest(self) -> bool:
        """Whether output and oven are in their safe state."""
        return self.parts.server.output_voltage() == 0.0 and not self.parts.body.regulating

    def worst_error(self) -> float:
        """Largest deviation of a kept sweep's H1 from the plate at its temperature, share of the peak."""
        rate, worst = 51_200.0 / 6.0, 0.0
        for step, sweep in self.store.kept.items():
            point = next(p for leg in self.protocol.legs for p in leg.set_points if p.step == step)
            assert abs(sweep.temperature - point.temperature) <= self.protocol.programme.tolerance
            assert sweep.level == point.level
            grid = np.fft.rfftfreq(sweep.drive.shape[1], 1.0 / rate)
            inside = (grid > 250.0) & (grid < 1100.0)
            truth = self.plate.response(sweep.temperature, grid[inside], rate)
            measured = h1(sweep.drive, sweep.responses[0])[0][inside]
            worst = max(worst, float(np.abs(measured - truth).max() / np.abs(truth).max()))
        return worst


@pytest.fixture
def world_of() -> Callable[..., World]:
    return World


@pytest.fixture
def world() -> World:
    return World()


# The table of the fault campaign: what the slow test of every fault at every moment has observed.

TITLE = """\
# What faults do to a campaign

Every fault strikes a simulated campaign of five sweeps of two repeats at five moments: in, or 7 s after, its first,
second, fourth, sixth and eighth repeat. All of this is measured by `tests/drivers/rig/test_faults.py` and written by

    python3 start.py tests -m slow tests/drivers/rig/test_faults.py --fault-table docs/faults.md

*Struck* is the plate's temperature at those moments. *The run* is how the campaign ended by itself. *Unaltered* counts
the sweeps finished by then that are the same to the last bit after the campaign was taken up again on a sound rig.
*H1* is the largest error of any sweep kept, as a share of the peak, against the plate that was simulated. *Output* and
*oven* are those of the simulated hardware after the run; a card or an oven out of reach cannot be brought to rest,
and the user is *told* so, with what to do. What is given up, `flexura acquire --again` tries once more.
"""
HEADINGS = ("fault", "struck [°C]", "the run", "unaltered", "H1 [%]", "output", "oven", "taken up again")


def pytest_addoption(parser: pytest.Parser) -> None:
    """Offer the table as a file; known where this folder is named on the command line."""
    parser.addoption("--fault-table", metavar="FILE", help="write the table of the fault campaign to FILE")


def pytest_terminal_summary(terminalreporter: Any, config: pytest.Config) -> None:
    """Print the table, where the fault campaign has been run, failed cases included."""
    ended = [*terminalreporter.stats.get("passed", ()), *terminalreporter.stats.get("failed", ())]
    rows = [dict(report.user_properties).get("observed") for report in ended]
    lines = fault_table([row for row in rows if row is not None])
    if lines:
        terminalreporter.section("fault campaign")
        terminalreporter.write_line("\n".join(lines))
        file = config.getoption("--fault-table", None)
        if file:
            Path(file).write_text(TITLE + "\n".join(lines) + "\n", encoding="utf-8")


def fault_table(rows: Sequence[Mapping[str, Any]]) -> list[str]:
    """Markdown tables, one a group, one line a fault: what was observed at all its moments."""
    lines: list[str] = []
    for group in dict.fromkeys(row["group"] for row in rows):
        of_group = [row for row in rows if row["group"] == group]
        faults = dict.fromkeys(row["fault"] for row in of_group)
        lines += ["", f"## {group}: {len(faults)} faults, {len(of_group)} runs", ""]
        lines += ["| " + " | ".join(HEADINGS) + " |", "|---" * len(HEADINGS) + "|"]
        for fault in faults:
            cells = fault_row([row for row in of_group if row["fault"] == fault])
            lines.append("| " + " | ".join((fault, *cells)) + " |")
    return lines


def fault_row(seen: Sequence[Mapping[str, Any]]) -> tuple[str, ...]:
    """Sum up what one fault did at its moments."""

    def counted(answers: Sequence[str]) -> str:
        number = {answer: answers.count(answer) for answer in dict.fromkeys(answers)}
        return "; ".join(answer if len(number) == 1 else f"{times} × {answer}" for answer, times in number.items())

    def missing(count: int) -> str:
        return "every sweep made" if count == 0 else f"{count} given up"

    told = ["told" if row["unsafe"] else "NOT TOLD" for row in seen]
    return (
        ", ".join("never" if row["struck"] is None else f"{row['struck']:.1f}" for row in seen),
        counted([f"stopped: {row['error']}" if row["error"] else missing(row["missing"]) for row in seen]),
        f"{sum(row['intact'] for row in seen)} of {sum(row['finished'] for row in seen)}",
        f"{100 * max(max(row['h1_error'], row['h1_error_after']) for row in seen):.2f}",
        counted(
            [
                "0 V" if row["volts"] == 0.0 else f"{row['volts']:.2f} V, {why}"
                for row, why in zip(seen, told, strict=True)
            ]
        ),
        counted([f"on, {why}" if row["regulating"] else "at rest" for row, why in zip(seen, told, strict=True)]),
        counted([missing(row["missing_after"]) for row in seen]),
    )
