"""The checks of drivers: our own pass them, and each defect that a driver may have is found by one."""

import math
import threading
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from drivers.checks import trial
from drivers.checks.instruments import NoCounterpart, check_oven, check_real_oven, check_thermometer
from drivers.checks.trial import Check, CheckVerdict, verdicts
from drivers.clock import SystemClock
from drivers.ovens.error import Fault, OvenError
from drivers.ovens.line import Line, Timing
from drivers.ovens.oven import OvenLimits, SetPoint
from drivers.ovens.settings import OvenSettings, oven_settings
from drivers.ovens.simulated.controller import LineController
from drivers.ovens.simulated.regulated_oven import RegulatedOven
from drivers.thermometers.thermometer import THERMOMETERS
from tests.drivers.ovens.served import TcpPort

GIVEN = {"port": "none", "minimum": -5.0, "maximum": 65.0, "max_rate": 3.0}
WORDS = {
    "temperature": {"query": "TEMP?"},
    "set_point": {"query": "SET?", "command": "SET {value}"},
    "run": {"on": "RUN", "off": "STOP", "query": "STATE?"},
}
REGISTERS = {"temperature": {"at": 1, "scale": 0.1}, "set_point": {"at": 2, "scale": 0.1}, "rest_at": 22.0}
KINDS: dict[str, dict[str, Any]] = {
    "eurotherm-2400": {},
    "eurotherm-3500": {},
    "votsch-ascii2": {},
    "espec-p300": {},
    "watlow-f4t": {},
    "modbus-map": REGISTERS,
    "scpi": WORDS,
}


def failures(found: Any) -> dict[str, str]:
    return {one.name: one.said for one in found if one.result == "FAILED"}


@pytest.mark.parametrize("kind", KINDS)
def test_our_own_ovens_pass(kind: str) -> None:
    found = list(check_oven(oven_settings({"kind": kind, **GIVEN, **KINDS[kind]})))
    assert [(one.name, one.said) for one in found if one.result != "passed"] == []
    assert len(found) == 19
    assert all(one.why for one in found)


@pytest.mark.parametrize("rest_at", [-5.0, 20.0, 22.3])
def test_wherever_it_rests(rest_at: float) -> None:
    floating = {"set_point": {"at": 2, "type": "float32"}, "rest_at": rest_at}
    settings = oven_settings({"kind": "modbus-map", **GIVEN, **REGISTERS, **floating})
    assert failures(check_oven(settings)) == {}


@pytest.mark.parametrize("limits", [(30.0, 65.0), (-40.0, 10.0), (21.0, 24.0)])
def test_whatever_the_limits(limits: tuple[float, float]) -> None:
    settings = oven_settings({"kind": "watlow-f4t", **GIVEN, "minimum": limits[0], "maximum": limits[1]})
    assert failures(check_oven(settings)) == {}


@pytest.mark.parametrize(
    ("kind", "sensors"), [("modbus-map", [{"at": 0, "scale": 0.1}]), ("scpi", [{"query": "T?"}, {"query": "U?"}])]
)
def test_our_own_thermometers_pass(kind: str, sensors: list[dict[str, Any]]) -> None:
    settings = THERMOMETERS.find(kind).model_validate({"kind": kind, "port": "none", "sensors": sensors})
    assert [one.result for one in check_thermometer(settings)] == ["passed"] * 9


class Chamber(LineController):
    """Understands T?, S?, S 40.0, R 1.0, ON, OFF, ?; starts at the wrong moment where told to."""

    def __init__(self, oven: RegulatedOven) -> None:
        super().__init__(b"\n")
        self.oven, self.target, self.rate, self.on, self.locked = oven, 22.0, 1.0, False, False

    def answer(self, command: str) -> str:
        match command.split():
            case ["T?"]:
                return f"{self.oven.measured:.2f}"
            case ["S?"]:
                return f"{self.target:.1f}"
            case ["?"]:
                return str(int(self.on))
            case ["S", value] if not self.locked:
                self.target = float(value)
            case ["R", value] if not self.locked:
                self.rate = float(value)
            case ["ON" | "OFF" as word] if not self.locked:
                self.on = word == "ON"
        if self.on:
            self.oven.go(self.target, self.rate)
        else:
            self.oven.stop()
        return "OK"


class Naive:
    """A driver as it is first written, with defects that can be switched on by name."""

    poll_within = math.inf

    def __init__(self, line: Line, transport: Any, limits: OvenLimits, defects: frozenset[str]) -> None:
        self.limits, self._line, self._transport, self._defects = limits, line, transport, defects
        if "starts" in defects:
            self._say("ON")

    def temperature(self) -> float:
        if "deaf" in self._defects:
            return 22.0
        try:
            answer = self._say("T?")
        except KeyboardInterrupt:
            if "swallows" in self._defects:
                return 22.0
            raise
        try:
            return float(answer)
        except ValueError as error:
            if "zero" in self._defects:
                return 0.0
            if "value error" in self._defects:
                raise
            raise OvenError(Fault.GARBLED, f"{answer!r} is no temperature", "Look at the cable.") from error

    def ramp_to(self, target: float, rate: float) -> SetPoint:
        if "no sense" not in self._defects:
            wanted = self.limits.clamp(target, rate)
            target, rate = wanted.target, wanted.rate
        if "no limits" in self._defects and math.isfinite(target):
            target = 400.0 if target == self.limits.maximum else target
        self._say(f"R {rate:.3f}")
        self._say(f"S {target:.1f}")
        self._say("ON")
        if "believes" not in self._defects and (self._say("S?") != f"{target:.1f}" or self._say("?") != "1"):
            raise OvenError(Fault.NOT_TAKEN, "the set-point was not taken", "Look at the panel.")
        return SetPoint(target, rate)

    def hold(self) -> float:
        return self.ramp_to(self.temperature(), 1.0).target

    def safe(self) -> None:
        if "asks first" in self._defects and self._say("?") == "0":
            return
        if "never rests" not in self._defects:
            self._say("OFF")

    def close(self) -> None:
        if "once" in self._defects and self._transport._closed:
            raise RuntimeError("closed already")
        if "stays open" not in self._defects:
            self._line.close()

    def _say(self, words: str) -> str:
        if "raw" in self._defects:  # no time-outs, no draining, no second attempt
            self._transport.write(words.encode() + b"\n")
            return str(self._transport.read(1.0).decode("latin-1"))
        return str(self._line.attempt(lambda: self._exchanged(words)))

    def _exchanged(self, words: str) -> str:
        answer = self._line.exchange(words.encode() + b"\n", lambda come: len(come) if b"\n" in come else None)
        text = answer.decode("latin-1").strip()
        if not text or not (text == "OK" or text.lstrip("-").replace(".", "").isascii()) or not text.isprintable():
            raise OvenError(Fault.SILENT if not text else Fault.GARBLED, f"{text!r}", "Look at the cable.")
        if words != "T?" and "?" not in words and text != "OK":
            raise OvenError(Fault.GARBLED, f"{text!r} instead of OK", "Look at the cable.")
        return text


class NaiveSettings(OvenSettings):
    defects: frozenset[str] = frozenset()

    def open(self, clock: Any, transport: Any = None) -> Any:
        return Naive(Line(transport, clock, Timing()), transport, self.limits(), self.defects)

    def simulated(self, body: Any, clock: Any) -> Any:
        return Chamber(body)


def naive(*defects: str) -> NaiveSettings:
    return NaiveSettings(kind="naive", minimum=-5.0, maximum=65.0, max_rate=3.0, defects=frozenset(defects))


def test_a_plain_driver_of_somebody_passes() -> None:
    assert failures(check_oven(naive())) == {}


@pytest.mark.parametrize(
    ("defect", "found"),
    [
        ("starts", "opens, and moves nothing"),
        ("deaf", "ramps, holds, and rests"),
        ("deaf", "silence"),
        ("never rests", "rest may be requested twice"),
        ("no limits", "set-points stay within limits"),
        ("no sense", "nonsense is refused"),
        ("zero", "error answers"),
        ("value error", "error answers"),
        ("raw", "late answers"),
        ("raw", "stale answers"),
        ("raw", "one lost answer costs no set-point"),
        ("believes", "settings not accepted are reported"),
        ("swallows", "rests after Ctrl-C in a question"),
        ("asks first", "rests without any answer"),
        ("once", "closes twice, then reports it"),
        ("stays open", "closes twice, then reports it"),
    ],
)
def test_every_defect_is_found(defect: str, found: str) -> None:
    assert found in failures(check_oven(naive(defect)))


def test_a_check_that_hangs_ends_the_others(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(trial, "CHECK_TIMEOUT", 0.05)
    over = threading.Event()
    found = list(
        verdicts([Check("first", "", lambda: over.wait(30.0) and None), Check("second", "", lambda: None)])
    )
    over.set()
    assert [one.result for one in found] == ["FAILED", "not checked"]
    assert "hangs" in found[0].said


def test_without_a_counterpart_there_is_nothing_to_check() -> None:
    class Bare(NaiveSettings):
        def simulated(self, body: Any, clock: Any) -> Any:
            return None

    with pytest.raises(NoCounterpart):
        check_oven(Bare(kind="bare", minimum=-5.0, maximum=65.0, max_rate=3.0))


@pytest.mark.slow
def test_at_a_real_port_within_two_kelvin(monkeypatch: pytest.MonkeyPatch) -> None:
    clock = SystemClock()
    body = RegulatedOven(clock, np.random.default_rng(1), air=23.0, plate=23.0)
    settings = oven_settings({"kind": "watlow-f4t", **GIVEN, "timeout": 0.2})
    sent: list[float] = []
    go: Callable[..., None] = body.go
    monkeypatch.setattr(body, "go", lambda target, *more: (sent.append(target), go(target, *more)))
    controller = settings.simulated(body, clock)
    assert controller is not None
    with TcpPort(controller) as port:
        found: list[CheckVerdict] = list(check_real_oven(settings.model_copy(update={"port": port.address})))
    assert failures(found) == {}
    assert {one.name for one in found if one.result == "not checked"} == {
        "opens, and moves nothing",
        "settings not accepted are reported",
        "rests without any answer",
    }
    assert sent
    assert all(20.9 <= target <= 25.1 for target in sent)
    assert not body.regulating
