import numpy as np
import pytest

from drivers.clock import VirtualClock
from drivers.ovens.error import Fault, OvenError
from drivers.ovens.line import Line, Timing
from drivers.ovens.modbus import ModbusUnit
from drivers.ovens.simulated.controller import MemoryTransport
from drivers.ovens.simulated.f4t import SimulatedF4T
from drivers.ovens.simulated.regulated_oven import RegulatedOven

PV = bytes.fromhex("010300010001d5ca")


@pytest.mark.parametrize(
    ("answer", "fault", "told"),
    [
        ("01 83 02 c0 f1", Fault.REFUSED, "illegal data address"),
        ("01 83 06 c1 32", Fault.BUSY, "busy"),
        ("02 03 02 ff cc bd e1", Fault.GARBLED, "another unit answers instead of unit 1"),
        ("01 03 02 ff cc f9 e0", Fault.GARBLED, "damaged"),  # checksum
        ("01 03 02 ff", Fault.GARBLED, "damaged"),  # half
        ("01", Fault.GARBLED, "damaged"),
        ("01 06 00 01 00 01 19 ca", Fault.GARBLED, "damaged"),  # the answer to another function
        ("", Fault.SILENT, "does not answer"),
    ],
)
def test_answers_that_are_none(scripted, answer, fault, told):
    unit = ModbusUnit(scripted([(PV, bytes.fromhex(answer))]), 1)
    with pytest.raises(OvenError, match=told) as caught:
        unit.read(1, 1)
    assert caught.value.fault is fault
    assert caught.value.advice


def test_a_refusal_is_not_waited_for():
    # it is shorter than the answer asked for: only its second byte tells
    clock = VirtualClock()
    server = SimulatedF4T(RegulatedOven(clock, np.random.default_rng(0)))
    line = Line(MemoryTransport(server, clock), clock, Timing(timeout=1.0))
    with pytest.raises(OvenError, match="illegal data address"):
        ModbusUnit(line, 1).read_float(9)
    assert clock.now() == 0.0


def test_signed_and_unsigned(scripted):
    unit = ModbusUnit(scripted([(PV, bytes.fromhex("010302ffccf9e1"))] * 2), 1)
    assert unit.read(1, 1) == -5.2
    assert unit.read(1, 1, signed=False) == 6548.4


def test_scaled_integers_are_rounded_not_cut_off(scripted):
    # 0.29 * 100 is 28.999999999999996
    frame = bytes.fromhex("01060002001de803")
    ModbusUnit(scripted([(frame, frame)]), 1).write(2, 0.29, 2)


def test_words_of_a_float_in_both_orders(scripted):
    request = bytes.fromhex("0103800200024c0b")
    high = bytes.fromhex("010304c0a666668d9a")
    low = bytes.fromhex("0103046666c0a6d4de")
    assert ModbusUnit(scripted([(request, high)]), 1).read_float(0x8002) == -5.2
    assert ModbusUnit(scripted([(request, low)]), 1, "low word first").read_float(0x8002) == -5.2
