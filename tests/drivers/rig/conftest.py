"""A campaign on the simulated rig around a plate that is a band-pass, quick enough for every fault."""

import hashlib
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.signal import butter, sosfilt, sosfreqz

from analysis.arrays import Real
from analysis.protocol.limits import Limits
from analysis.protocol.protocol import AcquisitionProtocol, Programme, Settling, SweepSetPoint
from analysis.protocol.sweep import SweepSettings
from analysis.recordings.campaign import Sweep
from analysis.recordings.h1 import h1
from drivers.ni.cards import Record, go_on
from drivers.ni.modules import NI_9211, NI_9234, NI_9260
from drivers.ni.simulated.surroundings import Module
from drivers.ni.wiring import Wiring
from drivers.ovens.settings import oven_settings
from drivers.ovens.simulated.regulated_oven import Chamber
from drivers.rig.campaign import Outcome, run_campaign
from drivers.rig.rig import Rig
from drivers.rig.session import Session
from drivers.rig.simulated import simulated_parts
from drivers.thermometers.thermometer import ThermometerSettings
from tests.drivers.ovens.served import Disturbed

LIGHT = Chamber(plate_capacity=180.0)
"""A plate that lags 30 s behind the air."""
MODULES: dict[int, Module] = {1: NI_9234, 2: NI_9260, 3: NI_9211}


class SofteningPlate:
    """A resonance that falls by 1 % a kelvin; `before` is called when a sweep is computed."""

    def __init__(self) -> None:
        self.before: Callable[[], None] = lambda: None
        self.sweeps = 0

    @staticmethod
    def sections(temperature: float, rate: float) -> Real:
        centre = 600.0 * (1.0 - 0.01 * (temperature - 20.0))
        return np.asarray(butter(1, [0.95 * centre, 1.05 * centre], btype="bandpass", fs=rate, output="sos"))

    def response(self, temperature: float, frequency: Real, rate: float) -> NDArray[np.complex128]:
        return np.asarray(0.5 * sosfreqz(self.sections(temperature, rate), worN=frequency, fs=rate)[1])

    def __call__(self, drive: Real, rate: float, temperature: Real) -> Real:
        self.sweeps += 1
        self.before()
        return np.asarray(0.5 * sosfilt(self.sections(float(temperature.mean()), rate), drive))[None]


@dataclass
class MemoryStore:
    """Keeps sweeps by step, and refuses to keep one twice."""

    kept: dict[int, Sweep] = field(default_factory=dict)
    aside: list[tuple[int, int, tuple[str, ...]]] = field(default_factory=list)
    shown: list[tuple[int, int, Record]] = field(default_factory=list)
    log_lines: list[dict[str, Any]] = field(default_factory=list)
    before_keeping: Callable[[SweepSetPoint], None] = lambda point: None

    def finished(self) -> frozenset[int]:
        return frozenset(self.kept)

    def sweeps(self) -> Iterator[Sweep]:
        return (self.kept[step] for step in sorted(self.kept))

    def keep(self, sweep: Sweep, set_point: SweepSetPoint, attempt: int) -> None:
        self.before_keeping(set_point)
        assert set_point.step not in self.kept
        self.kept[set_point.step] = sweep

    def put_aside(self, sweep: Sweep, set_point: SweepSetPoint, attempt: int, faults: Sequence[str]) -> None:
        assert (set_point.step, attempt) not in [(step, number) for step, number, _ in self.aside]
        self.aside.append((set_point.step, attempt, tuple(faults)))

    def show(self, record: Record, set_point: SweepSetPoint, repeat: int) -> None:
        self.shown.append((set_point.step, repeat, record))

    def log(self, event: Mapping[str, Any]) -> None:
        self.log_lines.append(dict(event))

    def events(self) -> list[dict[str, Any]]:
        return list(self.log_lines)

    def events_of(self, kind: str) -> list[dict[str, Any]]:
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

    def __init__(
        self,
        kind: str = "watlow-f4t",
        oven: Mapping[str, Any] | None = None,
        chassis: Mapping[str, Any] | None = None,
        **changes: Any,
    ) -> None:
        self.protocol = protocol_of(**changes)
        self.chassis = dict(chassis or {})
        self.store = MemoryStore()
        self.kind = kind
        self.oven: dict[str, Any] = dict(oven or {})
        self.thermometer: ThermometerSettings | None = None
        self.chamber = LIGHT
        self.renew()

    def request_times(self) -> list[float]:
        """Return the times at which the controller receives anything, filled as they come."""
        times: list[float] = []
        receive = self.disturbed.receive

        def noticed(data: bytes) -> Any:
            times.append(self.parts.clock.now())
            return receive(data)

        self.disturbed.receive = noticed
        return times

    def renew(self) -> None:
        """Set up a sound rig, as a new process would."""
        self.plate = SofteningPlate()
        self.wiring = Wiring(
            output="cDAQ1Mod2/ao0",
            drive_input="cDAQ1Mod1/ai0",
            responses=("cDAQ1Mod1/ai1",),
            thermocouples=() if self.thermometer else ("cDAQ1Mod3/ai0",),
            sample_rate=8500.0,
        )
        settings = oven_settings(
            {
                "kind": self.kind,
                "port": "simulated",
                "minimum": 0.0,
                "maximum": 50.0,
                "max_rate": 3.0,
                "timeout": 0.2,
                "lost_after": 30.0,
                **self.oven,
            }
        )
        self.rig_settings = settings
        self.rest_at: float | None = getattr(settings, "rest_at", None)
        parts = simulated_parts(
            self.wiring,
            settings,
            self.plate,
            modules=MODULES,
            seed=5,
            chamber=self.chamber,
            thermometer=self.thermometer,
            **self.chassis,
        )
        self.disturbed = Disturbed(parts.controller)
        self.parts = replace(parts, controller=self.disturbed)
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

    def run(self, check: Callable[[], None] = go_on, **options: Any) -> Outcome:
        """Run the campaign in a session of its own, which `session` then is."""
        self.session = Session(self.rig, self.protocol.limits, self.store.log, check)
        with self.session:
            return run_campaign(self.session, self.protocol, self.store, **options)

    @property
    def unsafe(self) -> tuple[str, ...] | None:
        """What the last session could not bring to rest."""
        return self.session.unsafe

    def digests(self) -> dict[int, str]:
        """Digest of every sweep kept."""
        return {step: digest(sweep) for step, sweep in self.store.kept.items()}

    def at_rest(self) -> bool:
        """Whether output and oven are in their safe state."""
        body = self.parts.body
        resting = not body.regulating or body.target == self.rest_at
        return self.parts.server.output_voltage() == 0.0 and resting

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


class Killed(BaseException):
    """Stands for SIGKILL: nothing runs afterwards."""


@pytest.fixture
def killed_by(monkeypatch: pytest.MonkeyPatch) -> Callable[[World, Callable[[Callable[[], None]], None]], None]:
    """Return a function that runs a world until something it has arranged kills the process."""

    def die() -> None:
        raise Killed

    def run(world: World, arrange: Callable[[Callable[[], None]], None]) -> None:
        arrange(die)
        with monkeypatch.context() as dead:
            dead.setattr(Session, "_leave", lambda self, error: self.oven.end())  # its thread dies, too
            with pytest.raises(Killed):
                world.run()

    return run


@pytest.fixture
def killed_at(
    killed_by: Callable[[World, Callable[[Callable[[], None]], None]], None],
) -> Callable[[World, float], None]:
    """Return a function that runs a world until the process is killed at a time, s."""
    return lambda world, seconds: killed_by(world, lambda die: world.at(seconds, die))


@pytest.fixture
def world_of() -> Callable[..., World]:
    return World


@pytest.fixture
def world() -> World:
    return World()
