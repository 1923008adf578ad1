"""What every driver of an oven or a thermometer has to bear, put to declared instruments.

Their simulated counterparts are put on trial, or, where that is asked for, the real ones. What a bad line may not
do to a driver that reads a temperature is the same for both.
"""

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial

import numpy as np

from drivers.checks.faulty_line import FaultyLine, LineFault
from drivers.checks.trial import Check, CheckVerdict, Failed, NotChecked, verdicts
from drivers.clock import Clock, SystemClock, VirtualClock
from drivers.ovens.error import Fault, OvenError
from drivers.ovens.line import Transport
from drivers.ovens.line_settings import LineSettings, SerialPort
from drivers.ovens.oven import Oven, OvenLimits
from drivers.ovens.registers import ROUNDED
from drivers.ovens.settings import OvenSettings
from drivers.ovens.simulated.controller import Controller, MemoryTransport
from drivers.ovens.simulated.regulated_oven import Chamber, RegulatedOven
from drivers.thermometers.thermometer import Thermometer, ThermometerSettings


@dataclass(frozen=True)
class OvenOnTrial:
    """An oven to which checks may send any query and command within its limits.

    Attributes
    ----------
    open : callable
        Opens it anew on a line.
    line : callable
        Makes such a line.
    clock : Clock
    truth : callable
        Air temperature, degrees Celsius.
    tolerance : float
        Of readings, K.
    limits : OvenLimits
    reach : float
        How far it may be sent from its present temperature, K.
    at_rest : callable
        Whether it neither heats nor cools; raises NotChecked where only the driver could say so.
    lock : callable
        Makes it take no command (True) or take them again; raises NotChecked where that cannot be.
    """

    open: Callable[[FaultyLine], Oven]
    line: Callable[[], FaultyLine]
    clock: Clock
    truth: Callable[[], float]
    tolerance: float
    limits: OvenLimits
    reach: float
    at_rest: Callable[[], bool]
    lock: Callable[[bool], None]


FAULTS = (
    (LineFault.SILENCE, math.inf, "a dead line must end a campaign, not be taken for a temperature"),
    (LineFault.GARBAGE, math.inf, "noise on the cable must never pass for a temperature"),
    (LineFault.LATE, 2, "an answer after its time-out must not be taken for the next one's"),
    (LineFault.STALE, 3, "bytes left over from an earlier question must not answer this one"),
    (LineFault.ECHO, math.inf, "many RS-485 adapters return each question before its answer"),
    (LineFault.ERROR, math.inf, "a refusal must be reported, not read as a number"),
    (LineFault.GONE, math.inf, "a pulled cable is reported, and the driver works again once it is back"),
)


@dataclass(frozen=True)
class Reader:
    """A driver on a line that can be made to fail.

    Attributes
    ----------
    read : callable
        Returns the temperature, degrees Celsius.
    truth : callable
        What it may return, degrees Celsius.
    tolerance : float
        K.
    line : FaultyLine
    clock : Clock
    """

    read: Callable[[], float]
    truth: Callable[[], float]
    tolerance: float
    line: FaultyLine
    clock: Clock

    def right(self) -> None:
        """Raise Failed unless the temperature reads right."""
        self._hold(self.read())

    def bears(self, fault: LineFault, questions: float = math.inf, times: int = 4) -> None:
        """Bring a fault on the line, read, then mend the line and read once more.

        Parameters
        ----------
        questions : float
            How many questions meet the fault; infinite: all until the line is mended.
        times : int
            Temperatures read under the fault, a second apart.

        Raises
        ------
        Failed
            If a temperature is wrong, an OvenError has no advice, a reading hides a lasting fault, or
            the fault goes on once the line is mended.
        NotChecked
            If the driver has asked nothing over this line.
        """
        if self.line.questions == 0:
            raise NotChecked("the driver does not use the line it is given")
        self.line.fail(fault, questions)
        reported = 0
        for _ in range(times):
            try:
                self._hold(self.read())
            except OvenError as error:
                reported += 1
                if not error.advice:
                    raise Failed(f"its error has no advice: {error}") from error
            self.clock.sleep(1.0)
        lasting = fault in (LineFault.SILENCE, LineFault.GARBAGE, LineFault.GONE, LineFault.ERROR)
        if math.isinf(questions) and lasting and reported < times:
            raise Failed(f"{fault} all the time, and still {times - reported} of {times} temperatures came back")
        self.line.mend()
        self.clock.sleep(2.0)
        try:
            self.right()
        except OvenError as error:
            raise Failed(f"the line works again, and it reports: {error}") from error

    def _hold(self, value: float) -> None:
        truth = self.truth()
        if not abs(value - truth) <= self.tolerance:
            raise Failed(f"it returned {value:.2f} °C; {truth:.2f} ± {self.tolerance:g} °C is true")


def oven_checks(trial: OvenOnTrial) -> list[Check]:
    """Return all checks, the plainest first; each ends with the oven brought to rest."""
    checks = [Check("opens, and moves nothing", "an oven in use may be looked at", lambda: _opens(trial))]
    checks += [Check(name, why, partial(_rested, trial, what)) for name, why, what in PLAIN]
    checks += [
        Check(str(fault), why, partial(_rested, trial, _bears, fault, questions))
        for fault, questions, why in FAULTS
    ]
    checks += [Check(name, why, partial(_rested, trial, what)) for name, why, what in COMMANDS]
    return [*checks, Check("closes twice, then reports it", "every way out closes it", lambda: _closes(trial))]


def _rested(trial: OvenOnTrial, what: Callable[..., None], *more: object) -> None:
    """Open, do it, and see the oven rest through a line that is sound again, whatever came of it."""
    line = trial.line()
    oven = trial.open(line)
    try:
        what(trial, oven, line, *more)
    finally:
        line.mend()
        try:
            _rest(trial, oven)
        finally:
            oven.close()


def _rest(trial: OvenOnTrial, oven: Oven) -> None:
    oven.safe()
    try:
        resting = trial.at_rest()
    except NotChecked:
        return  # the driver reads back what it wrote; nothing else can be known of a real oven
    if not resting:
        raise Failed("it reported no error when brought to rest, and continues")


def _opens(trial: OvenOnTrial) -> None:
    line = trial.line()
    oven = trial.open(line)
    try:
        if not trial.at_rest():
            raise Failed("opening it started it")
    finally:
        oven.close()


def _reads(trial: OvenOnTrial, oven: Oven, line: FaultyLine) -> None:
    _reader(trial, oven, line).right()
    if not oven.poll_within > 0.0:
        raise Failed(
            f"poll_within is {oven.poll_within!r}; above 0 s allowed, infinity where it need not be polled"
        )


def _ramps(trial: OvenOnTrial, oven: Oven, line: FaultyLine) -> None:
    start, rate = trial.truth(), min(1.0, trial.limits.max_rate)
    end = trial.limits.clamp_target(start + trial.reach)
    taken = oven.ramp_to(end, rate)
    if abs(taken.target - end) > 0.6 or not 0.0 < taken.rate <= 1.05 * rate:
        raise Failed(
            f"asked for {end:g} °C at {rate:g} K/min, it took {taken.target:g} °C at {taken.rate:g} K/min"
        )
    for _ in range(round(12.0 * min(abs(end - start), 4.0) / rate)):
        trial.clock.sleep(5.0)
        _reader(trial, oven, line).right()
    held = oven.hold()
    if not min(start, end) - 1.0 <= held <= max(start, end) + 1.0:
        raise Failed(f"a ramp from {start:.1f} to {end:.1f} °C was held at {held:.1f} °C")


def _rests_twice(trial: OvenOnTrial, oven: Oven, line: FaultyLine) -> None:
    oven.ramp_to(trial.truth() + trial.reach, 1.0)
    _rest(trial, oven)
    _rest(trial, oven)


def _limited(trial: OvenOnTrial, oven: Oven, line: FaultyLine) -> None:
    for asked in (trial.limits.maximum + 500.0, trial.limits.minimum - 500.0):
        taken = oven.ramp_to(asked, 1e3)
        low, high = trial.limits.minimum - 0.6, trial.limits.maximum + 0.6
        if not low <= taken.target <= high or taken.rate > 1.05 * trial.limits.max_rate:
            raise Failed(f"asked for {asked:g} °C at 1000 K/min, it took {taken.target:g} at {taken.rate:g}")


def _no_nonsense(trial: OvenOnTrial, oven: Oven, line: FaultyLine) -> None:
    for target, rate in ((math.nan, 1.0), (30.0, 0.0), (30.0, -1.0), (30.0, math.nan)):
        try:
            oven.ramp_to(target, rate)
        except ValueError:
            continue
        raise Failed(f"a ramp to {target:g} °C at {rate:g} K/min was accepted; ValueError required")


def _bears(trial: OvenOnTrial, oven: Oven, line: FaultyLine, fault: LineFault, questions: float) -> None:
    oven.ramp_to(trial.truth() + trial.reach, 1.0)  # so that a set-point taken for a temperature is seen
    _reader(trial, oven, line).bears(fault, questions)


def _one_glitch(trial: OvenOnTrial, oven: Oven, line: FaultyLine) -> None:
    _require_line(oven, line)
    end = trial.limits.clamp_target(trial.truth() + trial.reach)
    for fault in (LineFault.SILENCE, LineFault.GARBAGE):
        line.fail(fault, 1)
        try:
            taken = oven.ramp_to(end, 1.0)
        except OvenError as error:
            raise Failed(f"one answer lost to {fault}, and the ramp with it: {error}") from error
        if abs(taken.target - end) > 0.6:
            raise Failed(f"asked for {end:g} °C, it took {taken.target:g} °C")


def _refused_ramp(trial: OvenOnTrial, oven: Oven, line: FaultyLine) -> None:
    _require_line(oven, line)
    line.fail(LineFault.ERROR)
    try:
        oven.ramp_to(trial.truth() + trial.reach, 1.0)
    except OvenError:
        return
    raise Failed("every answer was a refusal, and the ramp counts as accepted")


def _locked(trial: OvenOnTrial, oven: Oven, line: FaultyLine) -> None:
    trial.lock(True)
    try:
        oven.ramp_to(trial.truth() + trial.reach, 0.5)
    except OvenError:
        return
    finally:
        trial.lock(False)
    raise Failed("the controller forgot the command, and the ramp counts as taken")


def _interrupted(trial: OvenOnTrial, oven: Oven, line: FaultyLine) -> None:
    _require_line(oven, line)
    oven.ramp_to(trial.truth() + trial.reach, 1.0)
    line.fail(LineFault.INTERRUPTED, 1)
    try:
        oven.temperature()
    except KeyboardInterrupt:
        _rest(trial, oven)
        _reader(trial, oven, line).right()
        return
    raise Failed("Ctrl-C was swallowed")


def _rests_unanswered(trial: OvenOnTrial, oven: Oven, line: FaultyLine) -> None:
    _require_line(oven, line)
    oven.ramp_to(trial.truth() + trial.reach, 1.0)
    line.fail(LineFault.SILENCE)
    try:
        oven.safe()
    except OvenError:
        if not trial.at_rest():
            raise Failed("its commands arrive, only the answers do not, and it continues") from None
        return
    raise Failed("no answer came, and it reported no error when brought to rest")


def _closes(trial: OvenOnTrial) -> None:
    oven = trial.open(trial.line())
    oven.close()
    oven.close()
    try:
        oven.temperature()
    except OvenError:
        return
    raise Failed("closed, it still returns a temperature; OvenError required")


def _require_line(oven: Oven, line: FaultyLine) -> None:
    oven.temperature()
    if line.questions == 0:
        raise NotChecked("the driver does not use the line it is given")


def _reader(trial: OvenOnTrial, oven: Oven, line: FaultyLine) -> Reader:
    return Reader(oven.temperature, trial.truth, trial.tolerance, line, trial.clock)


PLAIN = (
    ("reads the temperature", "sweeps are triggered by it", _reads),
    ("ramps, holds, and rests", "that is all a campaign asks of it", _ramps),
    ("rest may be requested twice", "every end of a campaign requests it", _rests_twice),
    ("set-points stay within limits", "a slip in a file must not heat the plate beyond them", _limited),
    ("nonsense is refused", "NaN, or a rate of 0, mean no ramp at all to many controllers", _no_nonsense),
)
COMMANDS = (
    ("one lost answer costs no set-point", "lines lose an answer now and then", _one_glitch),
    ("a refused ramp is reported", "a campaign would wait for what never comes", _refused_ramp),
    ("settings not accepted are reported", "with a locked panel the oven continues its ramp", _locked),
    ("rests after Ctrl-C in a question", "the answer still owed must not spoil the rest", _interrupted),
    ("rests without any answer", "a broken wire may still carry the commands", _rests_unanswered),
)


@dataclass(frozen=True)
class ThermometerOnTrial:
    """A thermometer that checks may ask; attributes as of `OvenOnTrial`."""

    open: Callable[[FaultyLine], Thermometer]
    line: Callable[[], FaultyLine]
    clock: Clock
    truth: Callable[[], float]
    tolerance: float


def thermometer_checks(trial: ThermometerOnTrial) -> list[Check]:
    """Return all checks, the plainest first."""
    checks = [
        Check("reads the temperature", "sweeps are triggered by it", partial(_opened, trial, _thermometer_reads))
    ]
    checks += [
        Check(str(fault), why, partial(_opened, trial, _thermometer_bears, fault, questions))
        for fault, questions, why in FAULTS
    ]
    return [
        *checks,
        Check("closes twice, then reports it", "every way out closes it", lambda: _thermometer_closes(trial)),
    ]


def _opened(trial: ThermometerOnTrial, what: Callable[..., None], *more: object) -> None:
    line = trial.line()
    thermometer = trial.open(line)

    def mean() -> float:
        readings = thermometer.temperatures()
        if readings.ndim != 1 or readings.size == 0:
            raise Failed(f"temperatures of shape {readings.shape}; (T,) with T >= 1 allowed")
        return float(np.mean(readings))

    try:
        what(Reader(mean, trial.truth, trial.tolerance, line, trial.clock), *more)
    finally:
        thermometer.close()


def _thermometer_reads(reader: Reader) -> None:
    reader.right()


def _thermometer_bears(reader: Reader, fault: LineFault, questions: float = math.inf) -> None:
    reader.bears(fault, questions)


def _thermometer_closes(trial: ThermometerOnTrial) -> None:
    thermometer = trial.open(trial.line())
    thermometer.close()
    thermometer.close()
    try:
        thermometer.temperatures()
    except OvenError:
        return
    raise Failed("closed, it still returns temperatures; ThermometerError required")


TEMPERATURE_MOVE = 15.0
"""A simulated oven is sent so far from where it is, K."""
REAL_REACH = 2.0
"""And a real one."""
READING_TOLERANCE, REAL_TOLERANCE = 1.0, 3.0
"""Of readings against the simulated temperature, and against a real instrument's own first one, K."""


class NoCounterpart(Exception):  # noqa: N818 (nothing is wrong)
    """The kind brings no simulated instrument: only the real one can be checked."""


def check_oven(settings: OvenSettings) -> Iterator[CheckVerdict]:
    """Put the driver of an oven on trial against its simulated controller, in virtual time; touches no hardware.

    Raises
    ------
    NoCounterpart
        If the kind brings none.
    """
    limits = settings.limits()
    rest_at: float | None = getattr(settings, "rest_at", None)
    start = limits.clamp_target(22.0 if rest_at is None else rest_at)
    reach = TEMPERATURE_MOVE if start + TEMPERATURE_MOVE <= limits.maximum else -TEMPERATURE_MOVE
    reach = limits.clamp_target(start + reach) - start
    clock = VirtualClock()
    body = RegulatedOven(clock, np.random.default_rng(1), Chamber(room=start))
    controller = settings.simulated(body, clock)
    if controller is None:
        raise NoCounterpart

    def lock(locked: bool) -> None:
        inner = getattr(controller, "server", controller)
        if not hasattr(inner, "locked"):
            raise NotChecked("its simulated controller cannot be locked")
        inner.locked = locked

    trial = OvenOnTrial(
        open=lambda line: settings.open(clock, line),
        line=lambda: _line(settings, MemoryTransport(controller, clock), clock),
        clock=clock,
        truth=lambda: body.measured,
        tolerance=READING_TOLERANCE,
        limits=limits,
        reach=reach,
        at_rest=lambda: not body.regulating or (rest_at is not None and abs(body.target - rest_at) < ROUNDED),
        lock=lock,
    )
    return verdicts(oven_checks(trial))


def check_real_oven(settings: OvenSettings) -> Iterator[CheckVerdict]:
    """Put the driver on trial at the oven itself, which is kept within `REAL_REACH` of its present temperature.

    Raises
    ------
    OvenError
        If it does not answer, or is not within its limits now.
    """
    clock = SystemClock()
    now = _first_reading(settings, clock)
    near = {
        "minimum": max(settings.minimum, now - REAL_REACH),
        "maximum": min(settings.maximum, now + REAL_REACH),
    }
    if near["maximum"] - near["minimum"] < 0.5 * REAL_REACH:
        limits = f"{settings.minimum:g} to {settings.maximum:g} °C"
        step = "First let it reach a temperature within them by itself."
        raise OvenError(Fault.REFUSED, f"it has {now:.1f} °C, beyond its limits of {limits}", step)
    narrow = settings.model_copy(update=near)
    reach = 0.5 * REAL_REACH if near["maximum"] >= now + 0.5 * REAL_REACH else -0.5 * REAL_REACH

    def unknown(*_: object) -> bool:
        raise NotChecked("a real oven shows this on its panel only; check there")

    def unlockable(locked: bool) -> None:
        raise NotChecked("a real oven cannot be locked by a program")

    trial = OvenOnTrial(
        open=lambda line: narrow.open(clock, line),
        line=lambda: _line(settings, _port(settings), clock),
        clock=clock,
        truth=lambda: now,
        tolerance=REAL_TOLERANCE,
        limits=narrow.limits(),
        reach=reach,
        at_rest=unknown,
        lock=unlockable,
    )
    return verdicts(oven_checks(trial))


def check_thermometer(settings: ThermometerSettings, *, real: bool = False) -> Iterator[CheckVerdict]:
    """Put the driver of a thermometer on trial; raises as `check_oven`, OvenError where a real one is silent."""
    clock: Clock = SystemClock() if real else VirtualClock()
    body = RegulatedOven(clock, np.random.default_rng(1))
    counterpart: Controller | None = None if real else settings.simulated(body, clock)
    if counterpart is None and not real:
        raise NoCounterpart
    first = 0.0
    if real:
        opened = settings.open(clock)
        try:
            first = float(np.mean(opened.temperatures()))
        finally:
            opened.close()

    def line() -> FaultyLine:
        inner = _port(settings) if counterpart is None else MemoryTransport(counterpart, clock)
        return _line(settings, inner, clock)

    trial = ThermometerOnTrial(
        open=lambda line: settings.open(clock, line),
        line=line,
        clock=clock,
        truth=(lambda: first) if real else (lambda: body.plate),
        tolerance=REAL_TOLERANCE if real else READING_TOLERANCE,
    )
    return verdicts(thermometer_checks(trial))


def _first_reading(settings: OvenSettings, clock: Clock) -> float:
    oven = settings.open(clock)
    try:
        return oven.temperature()
    finally:
        oven.close()


def _line(settings: OvenSettings | ThermometerSettings, inner: Transport, clock: Clock) -> FaultyLine:
    timeout = settings.timeout if isinstance(settings, LineSettings) else 1.0
    return FaultyLine(inner, clock, timeout)


def _port(settings: OvenSettings | ThermometerSettings) -> Transport:
    if isinstance(settings, LineSettings):
        return SerialPort(settings.port, settings.baud_rate, settings.parity, settings.stop_bits)
    return _NoLine()


class _NoLine:
    """Takes the place of the line for drivers without one: no data passes."""

    def write(self, data: bytes) -> None:
        """Go nowhere."""

    def read(self, wait: float) -> bytes:
        """Return nothing."""
        return b""

    def drain(self) -> None:
        """Hold nothing."""

    def close(self) -> None:
        """Leave nothing open."""
