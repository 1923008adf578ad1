"""Everything that can go wrong at the rig, once: the campaign recovers, gives a sweep up, or stops to be resumed.

Whatever happens, no finished sweep is lost or altered, none is kept that is not the plate's, the drive
ends at 0 V and the oven at rest; and where that cannot be, it is said. docs/faults.md is the table of what is
measured here, and says how to print it again.
"""

import errno
import os
import signal
from collections.abc import Callable
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from drivers.ni.simulated.faults import FailingCall, Faults
from drivers.ovens import f4t
from drivers.ovens.simulated.controller import MemoryTransport
from drivers.rig.end_requests import RigStopped
from drivers.rig.rig import Rig
from tests.drivers.ovens.served import flipped, halved, instead, late, noisy, silenced, untouched

HANGUP = getattr(signal, "SIGHUP", signal.SIGTERM)
"""Windows has no such signal."""
World = Any
Inject = Callable[[World], None]


def card_fails(call: str, code: int, times: int = 1) -> Inject:
    def inject(world: World) -> None:
        world.parts.server.inject(Faults(calls=(FailingCall(call, code, 1, times),)))

    return inject


def cards(**faults: Any) -> Inject:
    return lambda world: world.parts.server.inject(Faults(**faults))


def unplugged_for(seconds: float) -> Inject:
    def inject(world: World) -> None:
        now = world.parts.clock.now()
        world.parts.server.inject(Faults(unplugged=(now + 0.1, now + 0.1 + seconds)))

    return inject


def stalled(world: World) -> None:
    world.parts.server.inject(Faults(stalled_at=world.parts.clock.now(), stalled=30.0))


class Tampered:
    """Cards whose thermocouples say something else."""

    def __init__(self, inner: Any, tamper: Callable[[], float | None]) -> None:
        self._inner, self._tamper = inner, tamper

    def __getattr__(self, name: str) -> Any:
        return getattr(self._inner, name)

    def temperatures(self) -> NDArray[np.float64]:
        true: NDArray[np.float64] = self._inner.temperatures()
        said = self._tamper()
        return true if said is None else np.full_like(true, said)


def thermocouple_says(value: float, seconds: float = float("inf")) -> Inject:
    """Must be injected before the cards are opened; begins when a sweep is about to be made."""

    def inject(world: World) -> None:
        world.thermocouple = (world.parts.clock.now(), value, seconds)

    return inject


def thermocouple_freezes(world: World) -> None:
    world.thermocouple = (world.parts.clock.now(), float(world.parts.body.plate), float("inf"))


def oven_answers(*plan: Any, always: Any = None, seconds: float = float("inf")) -> Inject:
    def inject(world: World) -> None:
        world.disturbed.disturb(*plan)
        if always is not None:
            world.disturbed.always = always
            world.at(world.parts.clock.now() + seconds, lambda: setattr(world.disturbed, "always", untouched))

    return inject


class OneCable(list[MemoryTransport]):
    """Lines that all go through one cable, those that are opened anew as well."""

    plugged = False

    def append(self, line: MemoryTransport) -> None:
        line.plugged = self.plugged
        super().append(line)

    def plug(self) -> None:
        self.plugged = True
        for line in self:
            line.plugged = True


def cable_pulled_for(seconds: float) -> Inject:
    def inject(world: World) -> None:
        cable = OneCable(world.parts.lines)
        object.__setattr__(world.parts, "lines", cable)
        for line in cable:
            line.plugged = False
        world.at(world.parts.clock.now() + seconds, cable.plug)

    return inject


def controller(**changes: Any) -> Inject:
    def inject(world: World) -> None:
        for name, value in changes.items():
            setattr(world.parts.controller._controller, name, value)

    return inject


def panel_stop(world: World) -> None:
    world.parts.controller._controller.write_words(f4t.MODE, (f4t.OFF,))


def raised(error: BaseException) -> Inject:
    def inject(_: World) -> None:
        raise error

    return inject


def signalled(number: int) -> Inject:
    return lambda world: os.kill(os.getpid(), number)


def full_disk(world: World) -> None:
    def refuse(*_: object) -> None:
        raise OSError(errno.ENOSPC, "No space left on device")

    world.store.before_keeping = refuse
    world.mended = lambda: setattr(world.store, "before_keeping", lambda point: None)


def log_refused(world: World) -> None:
    log = world.store.log

    def refuse(event: object) -> None:
        raise OSError(errno.ENOSPC, "No space left on device")

    world.store.log = refuse
    world.mended = lambda: setattr(world.store, "log", log)


def folder_hangs(seconds: float) -> Inject:
    """Let the next event take so long to be written, as on a network share that is away."""

    def inject(world: World) -> None:
        log, pending = world.store.log, [seconds]

        def hang(event: Any) -> None:
            if pending:
                world.parts.clock.sleep(pending.pop())
            log(event)

        world.store.log = hang
        world.mended = lambda: setattr(world.store, "log", log)

    return inject


@dataclass(frozen=True)
class Fault:
    """One fault and what is to come of it.

    `ends` is "recovers" (every sweep is made), "gives up" (some are not), "goes on" (either: what the ramp has
    passed in the meantime is missed), or the exception the campaign stops with.
    """

    name: str
    inject: Inject
    ends: str | type[BaseException]
    told: str = ""
    in_a_sweep: bool = True
    unsafe: str = ""


NI = (
    Fault("input overrun", card_fails("ReadAnalogF64", -200279), "recovers", "-200279"),
    Fault("input FIFO overflow", card_fails("ReadAnalogF64", -200361), "recovers", "-200361"),
    Fault("ADC overrun", card_fails("ReadAnalogF64", -200019), "recovers", "-200019"),
    Fault("output ran dry", card_fails("WaitUntilTaskDone", -200290), "recovers", "-200290"),
    Fault("DAC underflow", card_fails("WaitUntilTaskDone", -200018), "recovers", "-200018"),
    Fault("no samples once", card_fails("ReadAnalogF64", -200284), "recovers", "-200284"),
    Fault("reader stalls for 30 s", stalled, "gives up", "moved by"),
    Fault("output always dry", card_fails("WaitUntilTaskDone", -200290, 10_000), "gives up", "attempts failed"),
    Fault("overruns without end", card_fails("ReadAnalogF64", -200279, 10_000), RigStopped, "no temperature"),
    Fault("start trigger never comes", cards(stuck_trigger=True), "gives up", "attempts failed"),
    Fault("sensor's cable off", cards(dead_inputs=frozenset({"cDAQ1Mod1/ai1"})), "gives up", "silent"),
    Fault("drive's cable off", cards(dead_inputs=frozenset({"cDAQ1Mod1/ai0"})), "gives up", "not the one played"),
    Fault("chassis unplugged for 20 s", unplugged_for(20.0), "recovers", "the cards are back"),
    Fault(
        "chassis unplugged while waiting", unplugged_for(20.0), "recovers", "the cards are back", in_a_sweep=False
    ),
    Fault("chassis gone", unplugged_for(1e6), RigStopped, "cards are lost", unsafe="turn the amplifier off"),
    Fault(
        "card taken by another program", card_fails("StartTask", -50103, 10_000), RigStopped, "close the program"
    ),
    Fault("setting refused", card_fails("CfgSampClkTiming", -200077, 10_000), RigStopped, "data sheet"),
    Fault("unknown status", card_fails("StartTask", -212345, 10_000), RigStopped, "-212345"),
    Fault("thermocouple NaN for 20 s", thermocouple_says(np.nan, 20.0), "goes on", "recovered"),
    Fault("thermocouple NaN for ever", thermocouple_says(np.nan), RigStopped, "reads nan °C: open or shorted"),
    Fault("thermocouple open", thermocouple_says(2300.0), RigStopped, "reads 2300 °C: open or shorted"),
    Fault("thermocouple stuck", thermocouple_freezes, RigStopped, "is stuck at"),
    Fault("plate too hot", thermocouple_says(55.0), RigStopped, "outside limits.coldest and hottest"),
    Fault("plate reading jumps once", thermocouple_says(35.0, 1.0), "goes on"),
)

OVEN = (
    Fault("oven silent for 10 s", oven_answers(always=silenced, seconds=10.0), "goes on", "recovered"),
    Fault("oven silent for ever", oven_answers(always=silenced), RigStopped, "no usable answer", unsafe="rest"),
    Fault("noise on the line", oven_answers(noisy(b"\x00\xff"), flipped(2), halved), "recovers"),
    Fault("line garbled for ever", oven_answers(always=instead(b"?!")), RigStopped, "", unsafe="rest"),
    Fault("oven answers late", oven_answers(late(0.5), late(0.5)), "recovers"),
    Fault("oven's cable pulled for 10 s", cable_pulled_for(10.0), "goes on", "recovered"),
    Fault("oven's cable pulled for ever", cable_pulled_for(1e9), RigStopped, "unplugged", unsafe="rest"),
    Fault("oven's sensor broken", controller(sensor_broken=True), RigStopped, "no valid temperature"),
    Fault("oven stopped on its panel", panel_stop, RigStopped, "its loop was switched off"),
)

PROCESS = (
    Fault("Ctrl-C in a sweep", signalled(signal.SIGINT), KeyboardInterrupt),
    Fault("Ctrl-C while waiting", signalled(signal.SIGINT), KeyboardInterrupt, in_a_sweep=False),
    Fault("SIGTERM in a sweep", signalled(signal.SIGTERM), SystemExit),
    Fault("SIGTERM while waiting", signalled(signal.SIGTERM), SystemExit, in_a_sweep=False),
    Fault("SIGHUP in a sweep", signalled(HANGUP), SystemExit),
    Fault("SIGHUP while waiting", signalled(HANGUP), SystemExit, in_a_sweep=False),
    Fault("defect in the program", raised(ZeroDivisionError("defect")), ZeroDivisionError, in_a_sweep=False),
    Fault("out of memory", raised(MemoryError()), MemoryError, in_a_sweep=False),
)

DISK = (
    Fault("disk full for a sweep", full_disk, OSError, "No space"),
    Fault("disk full for the log", log_refused, OSError, "No space"),
    Fault("folder hangs for 30 s", folder_hangs(30.0), "goes on"),
    Fault("folder hangs for 10 min", folder_hangs(600.0), RigStopped, "has stood still for"),
)

GROUPS = {"NI": NI, "oven": OVEN, "process": PROCESS, "disk": DISK}
FAULTS = tuple(fault for faults in GROUPS.values() for fault in faults)


@pytest.fixture(autouse=True)
def _terminable() -> Any:
    """SIGTERM and SIGHUP as a program takes them that ends by an exception."""

    def leave(number: int, _: object) -> None:
        raise SystemExit(128 + number)

    before = {number: signal.signal(number, leave) for number in {signal.SIGTERM, HANGUP}}
    yield
    for number, handler in before.items():
        signal.signal(number, handler)


def arm(world: World, fault: Fault, repeat: int) -> None:
    """Let the fault strike in the given repeat of the campaign, or just after it."""
    world.thermocouple = None
    world.mended = lambda: None

    def said() -> float | None:
        if world.thermocouple is None:
            return None
        since, value, seconds = world.thermocouple
        return value if world.parts.clock.now() < since + seconds else None

    open_cards = world.rig.open_cards
    world.rig = Rig(
        lambda: Tampered(open_cards(), said),  # type: ignore[arg-type, return-value]
        world.rig.open_oven,
        world.rig.clock,
        world.rig.date,
        world.rig.restore,
    )

    def inject() -> None:
        world.struck = float(world.parts.body.plate)
        fault.inject(world)

    def strike() -> None:
        if world.plate.sweeps == repeat:
            if fault.in_a_sweep:
                inject()
            else:
                world.at(world.parts.clock.now() + 7.0, inject)

    world.struck = None
    world.plate.before = strike


@dataclass(frozen=True)
class Observed:
    """What one fault did to one campaign, and what became of the campaign when it was taken up again.

    `struck` is the plate's temperature at that moment, degrees Celsius, None if the fault never struck; `intact`
    are the sweeps finished when the run ended that are the same to the last bit after resuming.
    """

    group: str
    fault: str
    struck: float | None
    error: str
    said: str
    unsafe: tuple[str, ...]
    finished: int
    missing: int
    volts: float
    regulating: bool
    tasks_open: int
    h1_error: float
    intact: int
    finished_after: int
    missing_after: int
    at_rest_after: bool
    h1_error_after: float


def observe(world: World, fault: Fault, repeat: int) -> Observed:
    """Run a campaign into a fault, look at everything, and take it up again on a sound rig."""
    arm(world, fault, repeat)
    error: BaseException | None = None
    missing = 0
    try:
        missing = world.run().missing
    except (Exception, KeyboardInterrupt, SystemExit) as caught:  # noqa: BLE001 (whatever it is, it is reported)
        error = caught
    unsafe = world.unsafe
    said = " ".join(str(event) for event in world.store.log_lines) + str(error)
    done, h1_error = world.digests(), world.worst_error()
    server, regulating = world.parts.server, world.parts.body.regulating
    world.mended()
    world.renew()
    after = world.run()
    now = world.digests()
    return Observed(
        group=next(name for name, faults in GROUPS.items() if fault in faults),
        fault=fault.name,
        struck=world.struck,
        error=type(error).__name__ if error else "",
        said=said,
        unsafe=unsafe,
        finished=len(done),
        missing=missing,
        volts=server.output_voltage(),
        regulating=regulating,
        tasks_open=len(server.tasks_open()),
        h1_error=h1_error,
        intact=sum(now.get(step) == sweep for step, sweep in done.items()),
        finished_after=after.finished,
        missing_after=after.missing,
        at_rest_after=world.at_rest(),
        h1_error_after=world.worst_error(),
    )


def check(fault: Fault, seen: Observed, total: int) -> None:
    assert seen.struck is not None
    assert seen.error == ("" if isinstance(fault.ends, str) else fault.ends.__name__)
    assert fault.told in seen.said
    if fault.ends == "recovers":
        assert seen.missing == 0
    elif fault.ends == "gives up":
        assert seen.missing > 0
    if fault.unsafe:
        assert fault.unsafe in " ".join(seen.unsafe)
        assert seen.volts == 0.0 or "amplifier" in " ".join(seen.unsafe)
    else:
        assert seen.unsafe == ()
        assert seen.volts == 0.0
        assert not seen.regulating
        assert seen.tasks_open == 0
    assert max(seen.h1_error, seen.h1_error_after) < 0.02
    assert seen.finished_after + seen.missing_after == total
    if seen.error:
        assert seen.missing_after == 0
    assert seen.intact == seen.finished
    assert seen.at_rest_after


KIN = {
    "input FIFO overflow",
    "ADC overrun",
    "DAC underflow",
    "line garbled for ever",
    "out of memory",
    "unknown status",
}
"""Handled by the same lines as a neighbour in the table."""


@pytest.mark.parametrize(
    "fault",
    [pytest.param(f, id=f.name, marks=[pytest.mark.slow] if f.name in KIN else []) for f in FAULTS],
)
def test_fault(world: World, fault: Fault) -> None:
    check(fault, observe(world, fault, 3), world.protocol.count)


@pytest.mark.slow
@pytest.mark.parametrize("repeat", [1, 2, 4, 6, 8])
@pytest.mark.parametrize("fault", FAULTS, ids=lambda fault: fault.name)
def test_fault_at_another_moment(
    world_of: Callable[..., World],
    fault: Fault,
    repeat: int,
    record_property: Callable[[str, object], None],
) -> None:
    """Ten repeats of five sweeps: in the first and the second of a sweep, early and late."""
    world = world_of(programme={"highest": 32.0})
    seen = observe(world, fault, repeat)
    record_property("observed", {**asdict(seen), "in_a_sweep": fault.in_a_sweep})
    check(fault, seen, world.protocol.count)
