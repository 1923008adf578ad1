"""Every byte of a Eurotherm's conversation."""

import math

import pytest

from drivers.ovens.error import Fault, OvenError
from drivers.ovens.eurotherm import MODEL_2400, MODEL_3500, Eurotherm
from drivers.ovens.modbus import ModbusUnit
from drivers.ovens.oven import OvenLimits, SetPoint

LIMITS = OvenLimits(-20.0, 80.0, 2.0)

OPEN_2400 = [
    ("01 03 02 04 00 01 c4 73", "01 03 02 00 00 b8 44"),  # degrees Celsius
    ("01 03 00 01 00 01 d5 ca", "01 03 02 ff cc f9 e1"),  # -5.2 as a scaled integer
    ("01 03 80 02 00 02 4c 0b", "01 03 04 c0 a6 66 66 8d 9a"),  # -5.2 as a float
]
OPEN_3500 = [
    ("05 03 01 21 00 01 d4 78", "05 03 02 00 d5 88 1b"),  # 21.3
    ("05 03 82 42 00 02 4d e3", "05 03 04 41 aa 66 66 20 65"),
]
RATE = [
    ("01 03 80 46 00 02 0c 1e", "01 03 04 00 00 00 00 fa 33"),
    ("01 10 80 46 00 02 04 3e cc cc cd 4f 31", "01 10 80 46 00 02 89 dd"),
    ("01 03 80 46 00 02 0c 1e", "01 03 04 3e cc cc cd a3 71"),
]
TARGET = [
    ("01 03 00 02 00 01 25 ca", "01 03 02 00 c8 b9 d2"),
    ("01 06 00 02 02 58 28 90", "01 06 00 02 02 58 28 90"),
    ("01 03 00 02 00 01 25 ca", "01 03 02 02 58 b8 de"),
]
AUTOMATIC = [
    ("01 03 01 11 00 01 d5 f3", "01 03 02 00 01 79 84"),
    ("01 06 01 11 00 00 d8 33", "01 06 01 11 00 00 d8 33"),
    ("01 03 01 11 00 01 d5 f3", "01 03 02 00 00 b8 44"),
]
IS_AUTOMATIC = ("01 03 01 11 00 01 d5 f3", "01 03 02 00 00 b8 44")


def frames(pairs):
    return [(bytes.fromhex(sent), bytes.fromhex(answered)) for sent, answered in pairs]


def eurotherm_2400(scripted, pairs, limits=LIMITS, decimals=1):
    return Eurotherm(ModbusUnit(scripted(frames(pairs)), 1), limits, MODEL_2400, decimals)


def test_temperature_is_signed(scripted):
    oven = eurotherm_2400(
        scripted,
        [
            ("01 03 01 02 00 01 24 36", "01 03 02 00 00 b8 44"),
            *OPEN_2400,
            ("01 03 00 01 00 01 d5 ca", "01 03 02 ff cc f9 e1"),
        ],
    )
    assert oven.temperature() == -5.2
    assert oven.poll_within == math.inf


def test_broken_sensor_is_an_alarm(scripted):
    oven = eurotherm_2400(scripted, [("01 03 01 02 00 01 24 36", "01 03 02 00 01 79 84")])
    with pytest.raises(OvenError, match="broken sensor") as caught:
        oven.temperature()
    assert caught.value.fault is Fault.ALARM


def test_ramp_sets_rate_then_target_then_automatic(scripted):
    oven = eurotherm_2400(scripted, [*OPEN_2400, *RATE, *TARGET, *AUTOMATIC])
    assert oven.ramp_to(60.0, 0.4) == SetPoint(60.0, 0.4)


def test_what_is_held_already_is_not_written_again(scripted):
    oven = eurotherm_2400(scripted, [*OPEN_2400, RATE[-1], TARGET[-1], IS_AUTOMATIC])
    assert oven.ramp_to(60.0, 0.4) == SetPoint(60.0, 0.4)


def test_hold_makes_the_working_set_point_the_target(scripted):
    oven = eurotherm_2400(
        scripted,
        [
            *OPEN_2400,
            IS_AUTOMATIC,
            ("01 03 00 05 00 01 94 0b", "01 03 02 ff e1 39 fc"),
            ("01 03 00 02 00 01 25 ca", "01 03 02 02 58 b8 de"),
            ("01 06 00 02 ff e1 a9 b2", "01 06 00 02 ff e1 a9 b2"),
            ("01 03 00 02 00 01 25 ca", "01 03 02 ff e1 39 fc"),
            IS_AUTOMATIC,
        ],
    )
    assert oven.hold() == -3.1


def test_hold_in_manual_is_at_the_temperature(scripted):
    oven = eurotherm_2400(
        scripted,
        [
            *OPEN_2400,
            AUTOMATIC[0],
            ("01 03 00 01 00 01 d5 ca", "01 03 02 ff e1 39 fc"),
            ("01 03 00 02 00 01 25 ca", "01 03 02 ff e1 39 fc"),
            *AUTOMATIC,
        ],
    )
    assert oven.hold() == -3.1


def test_safe_is_manual_without_output(scripted):
    oven = eurotherm_2400(
        scripted,
        [
            ("01 06 01 11 00 01 19 f3", "01 06 01 11 00 01 19 f3"),
            ("01 06 00 03 00 00 79 ca", ""),  # and an answer that is lost
            ("01 03 01 11 00 01 d5 f3", "01 03 02 00 01 79 84"),
            ("01 03 00 03 00 01 74 0a", "01 03 02 01 c7 f8 46"),
            ("01 06 00 03 00 00 79 ca", "01 06 00 03 00 00 79 ca"),
            ("01 03 00 03 00 01 74 0a", "01 03 02 00 00 b8 44"),
        ],
    )
    oven.safe()


def test_target_that_reads_back_different_is_not_taken(scripted):
    oven = eurotherm_2400(scripted, [*OPEN_2400, *RATE, *TARGET[:2], TARGET[0]])
    with pytest.raises(OvenError, match="set to 60 and reads back 20") as caught:
        oven.ramp_to(60.0, 0.4)
    assert caught.value.fault is Fault.NOT_TAKEN


def test_rate_that_reads_back_zero_is_not_taken(scripted):
    # to a Eurotherm a rate of zero is no ramp at all
    oven = eurotherm_2400(scripted, [*OPEN_2400, *RATE[:2], RATE[0]])
    with pytest.raises(OvenError, match="rate") as caught:
        oven.ramp_to(60.0, 0.4)
    assert caught.value.fault is Fault.NOT_TAKEN


def test_wrong_decimals_are_found_before_anything_is_written(scripted):
    with pytest.raises(OvenError, match=r"integer temperature is -0\.52 °C.*float says -5\.2") as caught:
        eurotherm_2400(scripted, OPEN_2400, decimals=2).ramp_to(60.0, 0.4)
    assert "decimals" in caught.value.advice


def test_3500_enables_its_rate_and_reports_alarms(scripted):
    line = scripted(
        frames(
            [
                ("05 03 27 e5 00 01 9e cd", "05 03 02 00 00 49 84"),
                *OPEN_3500,
                ("05 03 01 21 00 01 d4 78", "05 03 02 00 d5 88 1b"),
                ("05 03 80 46 00 02 0d 9a", "05 03 04 3e cc cc cd e6 b1"),
                ("05 03 00 4e 00 01 e5 99", "05 03 02 00 01 88 44"),
                ("05 06 00 4e 00 00 e8 59", "05 06 00 4e 00 00 e8 59"),
                ("05 03 00 4e 00 01 e5 99", "05 03 02 00 00 49 84"),
                ("05 03 00 02 00 01 24 4e", "05 03 02 02 58 49 1e"),
                ("05 03 01 11 00 01 d4 77", "05 03 02 00 00 49 84"),
                ("05 03 27 e5 00 01 9e cd", "05 03 02 80 04 29 87"),
            ]
        )
    )
    oven = Eurotherm(ModbusUnit(line, 5), LIMITS, MODEL_3500)
    assert oven.temperature() == 21.3
    assert oven.ramp_to(60.0, 0.4) == SetPoint(60.0, 0.4)
    with pytest.raises(OvenError, match="0x8004") as caught:
        oven.temperature()
    assert caught.value.fault is Fault.ALARM


@pytest.mark.parametrize(
    ("answer", "unit"), [("01 03 02 00 01 79 84", "degrees Fahrenheit"), ("01 03 02 00 02 39 85", "kelvin")]
)
def test_another_unit_is_refused(scripted, answer, unit):
    asked = [(OPEN_2400[0][0], answer)]
    with pytest.raises(OvenError, match=f"is set to {unit}") as caught:
        Eurotherm(ModbusUnit(scripted(frames(asked)), 1), LIMITS).hold()
    assert caught.value.fault is Fault.REFUSED
