"""What a controller, or a gateway before it, may not say the next time is asked for again like silence."""

import numpy as np
import pytest

from drivers.clock import VirtualClock
from drivers.ovens.error import Fault, OvenError
from drivers.ovens.line import PASSING, Line, Timing
from drivers.ovens.modbus import ModbusUnit, crc16
from drivers.ovens.simulated.controller import Delivery, MemoryTransport, ModbusTcp
from drivers.ovens.simulated.f4t import SimulatedF4T
from drivers.ovens.simulated.regulated_oven import RegulatedOven
from tests.drivers.ovens.served import untouched

PASSES, STAYS = (4, 5, 6, 8, 10, 11, 99), (1, 2, 3, 7)
REFUSALS = {"espec-p300": b"NA:CHB NOT READY\r\n", "votsch-ascii2": b"1\r", "scpi": b"ERR -350\n"}


def exception(code):
    """Return what makes a Modbus exception of an answer, RTU or TCP."""

    def disturb(answer):
        data = answer.data
        if crc16(data[:-2]) == data[-2:]:
            body = bytes([data[0], data[1] | 0x80, code])
            return [Delivery(answer.delay, body + crc16(body))]
        return [Delivery(answer.delay, data[:4] + bytes([0, 3, data[6], data[7] | 0x80, code]))]

    return disturb


def said_instead(rig, code=11):
    words = REFUSALS.get(rig.settings.kind)
    return exception(code) if words is None else lambda answer: [Delivery(answer.delay, words)]


@pytest.mark.parametrize("before", range(0, 24, 2))
@pytest.mark.parametrize("times", [1, 2])
def test_once_or_twice_in_any_command_it_spoils_nothing(rig, before, times):
    rig.oven.temperature()
    rig.disturbed.disturb(*[untouched] * before, *[said_instead(rig)] * times)
    assert rig.oven.ramp_to(30.0, 1.0).target == 30.0
    rig.wait(120.0)
    assert rig.oven.hold() == pytest.approx(22.0, abs=1.0)
    rig.oven.safe()
    assert rig.at_rest
    assert rig.oven.temperature() == pytest.approx(rig.body.air, abs=0.2)


def unit_that_says(code, framing, times):
    clock = VirtualClock()
    far = SimulatedF4T(RegulatedOven(clock, np.random.default_rng(0)))
    asked, left = [], [times]
    disturb = exception(code)

    class Gateway:
        def receive(self, data):
            answers = inner.receive(data)
            asked.append(data)
            left[0] -= 1
            return [said for answer in answers for said in (disturb(answer) if left[0] >= 0 else [answer])]

    inner = ModbusTcp(far) if framing == "tcp" else far
    line = Line(MemoryTransport(Gateway(), clock), clock, Timing(timeout=1.0, retries=2))
    return ModbusUnit(line, 1, framing=framing), asked


@pytest.mark.parametrize("framing", ["rtu", "tcp"])
@pytest.mark.parametrize("code", PASSES)
def test_a_code_that_may_pass(framing, code):
    unit, asked = unit_that_says(code, framing, times=2)
    assert unit.read(14080) == 15
    assert len(asked) == 3
    unit, asked = unit_that_says(code, framing, times=3)
    with pytest.raises(OvenError, match=f"exception {code}.*3 attempts|3 attempts.*exception {code}") as caught:
        unit.read(14080)
    assert caught.value.fault in PASSING
    assert caught.value.advice
    assert "label" not in caught.value.advice


@pytest.mark.parametrize("framing", ["rtu", "tcp"])
@pytest.mark.parametrize("code", STAYS)
def test_a_code_that_stays_is_a_refusal_at_once(framing, code):
    unit, asked = unit_that_says(code, framing, times=1)
    with pytest.raises(OvenError, match=f"exception {code}") as caught:
        unit.read(14080)
    assert caught.value.fault is Fault.REFUSED
    assert len(asked) == 1


@pytest.mark.parametrize("words", [b"NA:CMD ERR\r\n", b"NA:PARA ERR\r\n", b"NA:DATA OUT OF RANGE\r\n"])
def test_a_request_that_noise_has_changed_is_sent_again_where_it_has_no_checksum(rig_of, words):
    rig = rig_of("espec-p300")
    rig.disturbed.disturb(lambda answer: [Delivery(answer.delay, words)])
    assert rig.oven.temperature() == pytest.approx(20.0, abs=0.2)
    rig.disturbed.always = lambda answer: [Delivery(answer.delay, words)]
    with pytest.raises(OvenError, match=words.decode().strip()) as caught:
        rig.oven.temperature()
    assert caught.value.fault is Fault.REFUSED


def test_a_gateway_that_never_reaches_the_controller_is_lost_in_the_end(rig_of):
    rig = rig_of("eurotherm-2400", lost_after=20.0)
    rig.disturbed.always = exception(11)
    faults = []
    while Fault.LOST not in faults:
        with pytest.raises(OvenError, match="gateway") as caught:
            rig.oven.temperature()
        faults.append(caught.value.fault)
    assert set(faults) == {Fault.BUSY, Fault.LOST}
