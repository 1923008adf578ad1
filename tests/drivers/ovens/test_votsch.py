"""Every byte of a conversation in ASCII-2."""

import pytest

from drivers.ovens.error import Fault, OvenError
from drivers.ovens.oven import OvenLimits, SetPoint
from drivers.ovens.votsch import Votsch

DESCRIPTION = (
    b"$01?\r",
    b"E-STRING\r\nCV01  value min:  -77.0   Value max:  182.0   Temperature\r\n"
    b"CV02  value min:    0.0   Value max:  100.0   Humidity\r\nDO00  unused\r\nDO01  Start\r\nDO02  Humidity\r\n",
)
REST = (b"$01I\r", b"0020.0 0021.3 0050.0 0043.2 001\r")
RAMPING = (b"$01I\r", b"0060.0 0021.3 0050.0 0043.2 011\r")
GRADIENTS = (b"$01U 0000.4 0000.0 0000.0 0000.0\r", b"0\r")
START = (b"$01E 0060.0 0050.0 011\r", b"0\r")


def votsch(scripted, *pairs, opened=REST):
    return Votsch(scripted([DESCRIPTION, opened, *pairs]), 1, OvenLimits(-20.0, 80.0, 2.0))


def test_temperature_is_the_actual_one(scripted):
    assert votsch(scripted, REST).temperature() == 21.3


def test_ramp_changes_temperature_and_start_and_nothing_else(scripted):
    assert votsch(scripted, REST, GRADIENTS, REST, START, RAMPING).ramp_to(60.0, 0.4) == SetPoint(60.0, 0.4)


def test_what_is_so_already_is_not_written_again(scripted):
    assert votsch(scripted, RAMPING, GRADIENTS, RAMPING, RAMPING).ramp_to(60.0, 0.4) == SetPoint(60.0, 0.4)


def test_hold_at_the_temperature_measured(scripted):
    held = (b"$01I\r", b"0021.3 0021.3 0050.0 0043.2 011\r")
    oven = votsch(scripted, RAMPING, RAMPING, (b"$01E 0021.3 0050.0 011\r", b"0\r"), held)
    assert oven.hold() == 21.3


def test_safe_takes_start_away_and_nothing_else(scripted):
    stopped = (b"$01I\r", b"0060.0 0021.3 0050.0 0043.2 001\r")
    votsch(scripted, (b"$01E 0060.0 0050.0 001\r", b"0\r"), stopped, stopped, opened=RAMPING).safe()


def test_what_was_not_read_at_opening_is_read_before_safe_writes_it(scripted):
    stopped = (b"$01I\r", b"0060.0 0021.3 0050.0 0043.2 001\r")
    oven = votsch(scripted, RAMPING, (b"$01E 0060.0 0050.0 001\r", b"0\r"), stopped, opened=(REST[0], b""))
    oven.safe()


def test_write_that_reads_back_different_is_not_taken(scripted):
    oven = votsch(scripted, REST, GRADIENTS, REST, START, REST)
    with pytest.raises(
        OvenError, match=r"set to 60\.0 50\.0 011, the chamber reads back 20\.0 50\.0 001"
    ) as caught:
        oven.ramp_to(60.0, 0.4)
    assert caught.value.fault is Fault.NOT_TAKEN


def test_refusal(scripted):
    oven = votsch(scripted, REST, GRADIENTS, REST, (START[0], b"2\r"))
    with pytest.raises(OvenError, match="says 2") as caught:
        oven.ramp_to(60.0, 0.4)
    assert caught.value.fault is Fault.REFUSED


def test_rate_below_the_protocols_step(scripted):
    with pytest.raises(ValueError, match=r"0\.1 K/min"):
        votsch(scripted).ramp_to(60.0, 0.04)


@pytest.mark.parametrize("target", [40.0, 5.0])
def test_a_chamber_that_reports_where_its_ramp_is_takes_it(rig_of, target):
    rig = rig_of("votsch-ascii2")
    rig.controller.tells_ramp = True
    for end in (target, 20.0):  # from rest, and while it runs already
        assert rig.oven.ramp_to(end, 2.0) == SetPoint(end, 2.0)
        rig.wait(600.0)
        assert abs(rig.oven.temperature() - end) < abs(20.0 - target)
    rig.oven.safe()
    assert not rig.body.regulating


def test_a_chamber_that_reports_where_its_ramp_is_is_found_locked(rig_of):
    rig = rig_of("votsch-ascii2")
    rig.controller.tells_ramp = True
    rig.oven.ramp_to(30.0, 2.0)
    rig.wait(900.0)
    rig.controller.locked = True
    with pytest.raises(OvenError, match="reads back") as caught:
        rig.oven.ramp_to(50.0, 2.0)
    assert caught.value.fault is Fault.NOT_TAKEN
