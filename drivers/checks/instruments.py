"""Declared instruments put on trial: their simulated counterparts, or, where that is asked for, the real ones."""

from collections.abc import Iterator

import numpy as np

from drivers.checks.faulty_line import FaultyLine
from drivers.checks.instrument_checks import OvenOnTrial, ThermometerOnTrial, oven_checks, thermometer_checks
from drivers.checks.trial import CheckVerdict, NotChecked, verdicts
from drivers.clock import Clock, SystemClock, VirtualClock
from drivers.ovens.error import Fault, OvenError
from drivers.ovens.line import Transport
from drivers.ovens.line_settings import LineSettings, SerialPort
from drivers.ovens.registers import ROUNDED
from drivers.ovens.settings import OvenSettings
from drivers.ovens.simulated.controller import Controller, MemoryTransport
from drivers.ovens.simulated.regulated_oven import Chamber, RegulatedOven
from drivers.thermometers.settings import ThermometerSettings

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
