"""The whole path of the bytes: driver, pyserial, pseudo-terminal or TCP socket, simulated controller."""

import os

import numpy as np
import pytest

from drivers.clock import VirtualClock
from drivers.ovens.error import Fault, OvenError
from drivers.ovens.line_settings import SerialPort
from drivers.ovens.settings import open_oven, oven_settings
from drivers.ovens.simulated.controller import LineController
from drivers.ovens.simulated.regulated_oven import RegulatedOven
from tests.drivers.ovens.served import (
    Disturbed,
    PtyPort,
    TcpPort,
    flipped,
    from_unit,
    halved,
    in_pieces,
    late,
    noisy,
    silenced,
)

TIMEOUT = 0.15
KINDS = ("eurotherm-2400", "votsch-ascii2", "espec-p300", "watlow-f4t")
MODBUS = ("eurotherm-2400", "watlow-f4t")

posix = pytest.mark.skipif(os.name != "posix", reason="pseudo-terminals need a POSIX system")


class Counting(Disturbed):
    """A bad line that counts what comes through."""

    requests = 0

    def receive(self, data):
        self.requests += 1
        return super().receive(data)


def simulated(kind):
    clock = VirtualClock()
    settings = oven_settings(
        {"kind": kind, "port": "later", "minimum": -5, "maximum": 65, "max_rate": 2, "timeout": TIMEOUT}
    )
    body = RegulatedOven(clock, np.random.default_rng(5), air=20.0, plate=20.0)
    return body, settings, Counting(settings.simulated(body, clock))


def opened(settings, port, **changes):
    given = {"port": port.address, "gap_after_read": 0.0, "gap_after_write": 0.0, "retries": 3, **changes}
    return open_oven(oven_settings({**settings.model_dump(), **given}))


@pytest.mark.parametrize("place", [pytest.param(PtyPort, marks=posix), TcpPort])
@pytest.mark.parametrize("kind", [*KINDS, "eurotherm-3500"])
def test_ramp_hold_safe(kind, place):
    body, settings, far = simulated(kind)
    with place(far) as port:
        oven = opened(settings, port)
        assert oven.temperature() == pytest.approx(20.0, abs=0.2)
        assert oven.ramp_to(60.0, 0.4).target == 60.0
        assert (body.regulating, body.target) == (True, 60.0)
        assert oven.hold() == pytest.approx(20.0, abs=0.2)
        assert body.target == pytest.approx(20.0, abs=0.2)
        oven.safe()
        assert not body.regulating
        oven.close()


FAULTS = {
    "checksum": (flipped(-2), Fault.GARBLED, "cable"),
    "half": (halved, Fault.GARBLED, "cable"),
    "silence": (silenced, Fault.SILENT, "switched on"),
    "noise": (noisy(before=b"\x00\xff\x80"), Fault.GARBLED, "cable"),
    "late": (late(1.5 * TIMEOUT), Fault.SILENT, "Raise timeout"),
    "wrong unit": (from_unit(9), Fault.GARBLED, "address of its own"),
}
CASES = [(kind, fault) for kind in KINDS for fault in FAULTS if fault != "wrong unit" or kind in MODBUS]


@posix
@pytest.mark.parametrize(("kind", "fault"), CASES)
def test_bad_line_is_recovered_from_or_told(kind, fault):
    disturbance, expected, advice = FAULTS[fault]
    body, settings, far = simulated(kind)
    with PtyPort(far) as port:
        oven = opened(settings, port)
        far.disturb(disturbance)
        assert oven.temperature() == pytest.approx(20.0, abs=0.2)
        oven.safe()
        oven.close()
        if fault == "late":  # with room on both sides: a busy machine may be late by itself
            oven = opened(settings, port, retries=0, timeout=2.0 * TIMEOUT)
            far.always = late(3.0 * TIMEOUT)
        else:
            oven = opened(settings, port, retries=0)
            far.always = disturbance
        with pytest.raises(OvenError) as caught:
            oven.temperature()
        oven.close()
    assert caught.value.fault is expected
    assert advice in caught.value.advice
    assert not body.regulating


@posix
@pytest.mark.parametrize("kind", KINDS)
def test_a_slow_line_is_a_sound_line(kind):
    _, settings, far = simulated(kind)
    with PtyPort(far) as port:
        oven = opened(settings, port, timeout=2.0, retries=0)
        oven.temperature()  # the first asks for more
        far.always = in_pieces(0.001)  # 9600 baud
        before = far.requests
        assert oven.temperature() == pytest.approx(20.0, abs=0.2)
        assert far.requests - before <= 2
        oven.close()


class Echo(LineController):
    def __init__(self):
        super().__init__(b"\n")

    def answer(self, command):
        return command


def answer_of(port, request):
    port.drain()
    port.write(request)
    received = b""
    while not received.endswith(b"\n"):
        came = port.read(2.0)
        if not came:
            break
        received += came
    return received


@pytest.mark.parametrize("place", [pytest.param(PtyPort, marks=posix), TcpPort])
def test_port_reads_what_comes_and_drops_what_came_before(place):
    with place(Echo()) as far:
        port = SerialPort(far.address)
        assert answer_of(port, bytes(range(32, 127)) + b"\n") == bytes(range(32, 127)) + b"\n"
        port.write(b"unread\n")
        assert port.read(2.0)[:1] == b"u"
        assert answer_of(port, b"next\n").endswith(b"next\n")
        assert port.read(0.01) == b""
        port.close()
        port.close()
        with pytest.raises(OvenError, match="was closed"):
            port.write(b"x")


@posix
def test_a_port_that_is_not_there_is_said_once():
    with pytest.raises(OvenError, match="port cannot be opened: no such file or directory") as caught:
        SerialPort("/dev/no-such-port")
    assert "Errno" not in str(caught.value)


@posix
def test_two_programs_cannot_have_one_port():
    with PtyPort(Echo()) as far:
        port = SerialPort(far.address)
        with pytest.raises(OvenError, match="cannot be opened") as caught:
            SerialPort(far.address)
        assert "no other program" in caught.value.advice
        port.close()
        SerialPort(far.address).close()


@posix
def test_a_pulled_adapter_is_a_port_that_failed():
    with PtyPort(Echo()) as far:
        port = SerialPort(far.address)
        assert answer_of(port, b"here\n") == b"here\n"
    with pytest.raises(OvenError, match=r"failed|cannot be opened") as caught:
        answer_of(port, b"gone\n")
    assert caught.value.fault is Fault.PORT
    port.close()


def test_a_gateway_that_goes_and_comes_back():
    with TcpPort(Echo()) as far:
        port = SerialPort(far.address)
        assert answer_of(port, b"here\n") == b"here\n"
        number = int(far.address.rpartition(":")[2])
    for _ in range(2):
        with pytest.raises(OvenError) as caught:
            answer_of(port, b"gone\n")
        assert caught.value.fault is Fault.PORT
    with TcpPort(Echo(), number):
        assert answer_of(port, b"again\n") == b"again\n"
        port.close()
