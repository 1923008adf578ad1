"""Every byte of a Watlow F4T's conversation."""

import pytest

from drivers.ovens.error import Fault, OvenError
from drivers.ovens.f4t import F4T
from drivers.ovens.modbus import ModbusUnit
from drivers.ovens.oven import OvenLimits, SetPoint

OPEN = [
    ("01 03 37 00 00 01 8a 7e", "01 03 02 00 0f f8 40"),  # degrees Celsius
    ("01 03 0a d6 00 02 26 2b", "01 03 04 00 00 c2 20 aa 8b"),  # -40, low word first
    ("01 03 0a d8 00 02 47 e8", "01 03 04 00 00 43 34 ca d4"),  # 180
]
AUTO = ("01 03 0a aa 00 01 a7 f2", "01 03 02 00 0a 38 43")
OFF = ("01 03 0a aa 00 01 a7 f2", "01 03 02 00 3e 39 94")
SET_POINT_60 = ("01 03 0a de 00 02 a7 e9", "01 03 04 00 00 42 70 cb 77")


def f4t(scripted, pairs, limits=None):
    line = scripted([(bytes.fromhex(sent), bytes.fromhex(answered)) for sent, answered in pairs])
    return F4T(ModbusUnit(line, 1, "low word first"), limits or OvenLimits(-20.0, 80.0, 2.0))


def test_temperature(scripted):
    oven = f4t(
        scripted,
        [
            *OPEN,
            ("01 03 0b 04 00 02 87 ee", "01 03 04 66 66 c0 a6 d4 de"),
            ("01 03 0b 04 00 02 87 ee", "01 03 04 00 00 7f c0 da 53"),
        ],
    )
    assert oven.temperature() == -5.2
    with pytest.raises(OvenError, match="no valid temperature") as caught:
        oven.temperature()
    assert caught.value.fault is Fault.ALARM


def test_ramp_says_how_before_where_to(scripted):
    oven = f4t(
        scripted,
        [
            *OPEN,
            ("01 03 0a ec 00 01 46 27", "01 03 02 00 27 f8 5e"),  # ramp scale: hours
            ("01 06 0a ec 00 39 8b f5", "01 06 0a ec 00 39 8b f5"),
            ("01 03 0a ec 00 01 46 27", "01 03 02 00 39 78 56"),
            ("01 03 0a ee 00 02 a7 e6", "01 03 04 00 00 00 00 fa 33"),
            ("01 10 0a ee 00 02 04 cc cd 3e cc bc 51", "01 10 0a ee 00 02 22 25"),
            ("01 03 0a ee 00 02 a7 e6", "01 03 04 cc cd 3e cc 44 a9"),
            ("01 03 0a ea 00 01 a6 26", "01 03 02 00 3e 39 94"),  # ramp action: off
            ("01 06 0a ea 00 55 6b d9", "01 06 0a ea 00 55 6b d9"),
            ("01 03 0a ea 00 01 a6 26", "01 03 02 00 55 78 7b"),
            ("01 03 0a de 00 02 a7 e9", "01 03 04 00 00 41 a0 ca 1b"),
            ("01 10 0a de 00 02 04 00 00 42 70 30 9b", "01 10 0a de 00 02 22 2a"),
            SET_POINT_60,
            OFF,
            ("01 06 0a aa 00 0a 2a 35", "01 06 0a aa 00 0a 2a 35"),
            AUTO,
        ],
    )
    assert oven.ramp_to(60.0, 0.4) == SetPoint(60.0, 0.4)


def test_hold_at_the_working_set_point(scripted):
    oven = f4t(
        scripted,
        [
            *OPEN,
            AUTO,
            ("01 03 0a fa 00 02 e7 e2", "01 03 04 00 00 42 26 4b 49"),
            SET_POINT_60,
            ("01 10 0a de 00 02 04 00 00 42 26 b0 a5", "01 10 0a de 00 02 22 2a"),
            ("01 03 0a de 00 02 a7 e9", "01 03 04 00 00 42 26 4b 49"),
            AUTO,
        ],
    )
    assert oven.hold() == 41.5


def test_hold_of_a_loop_that_is_off_is_at_its_temperature(scripted):
    oven = f4t(
        scripted,
        [
            *OPEN,
            OFF,
            ("01 03 0b 04 00 02 87 ee", "01 03 04 00 00 42 26 4b 49"),
            SET_POINT_60,
            ("01 10 0a de 00 02 04 00 00 42 26 b0 a5", "01 10 0a de 00 02 22 2a"),
            ("01 03 0a de 00 02 a7 e9", "01 03 04 00 00 42 26 4b 49"),
            OFF,
            ("01 06 0a aa 00 0a 2a 35", "01 06 0a aa 00 0a 2a 35"),
            AUTO,
        ],
    )
    assert oven.hold() == 41.5


def test_safe_is_off(scripted):
    f4t(scripted, [("01 06 0a aa 00 3e 2b e2", "01 06 0a aa 00 3e 2b e2"), OFF]).safe()


def test_limits_beyond_the_controllers_own_are_refused(scripted):
    with pytest.raises(OvenError, match="end at -40 and 180") as caught:
        f4t(scripted, OPEN, OvenLimits(212.0, 356.0, 2.0)).ramp_to(250.0, 1.0)
    assert caught.value.fault is Fault.REFUSED


def test_degrees_fahrenheit_are_refused(scripted):
    with pytest.raises(OvenError, match="degrees Fahrenheit") as caught:
        f4t(scripted, [(OPEN[0][0], "01 03 02 00 1e 38 4c")]).temperature()
    assert caught.value.fault is Fault.REFUSED
