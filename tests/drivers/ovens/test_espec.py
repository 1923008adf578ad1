"""Every byte of a conversation with an Espec chamber."""

import pytest

from drivers.ovens.error import Fault, OvenError
from drivers.ovens.espec import Espec
from drivers.ovens.oven import OvenLimits, SetPoint
from drivers.ovens.simulated.controller import Delivery

AT_20 = (b"TEMP?\r\n", b"20.0,25.0,150.0,-40.0\r\n")
PROGRAM = (b"RUN PRGM, TEMP20.0 GOTEMP60.0 TIME1:40\r\n", b"OK:RUN PRGM, TEMP20.0 GOTEMP60.0 TIME1:40\r\n")
PROGRAM_READ = (b"RUN PRGM?\r\n", b"TEMP20.0 GOTEMP60.0 TIME1:40 REF9\r\n")
RUNS = (b"MODE?\r\n", b"RUN\r\n")
CONSTANT = [(b"MODE, CONSTANT\r\n", b"OK:MODE, CONSTANT\r\n"), (b"MODE?\r\n", b"CONSTANT\r\n")]
STANDBY = [(b"MODE, STANDBY\r\n", b"OK:MODE, STANDBY\r\n"), (b"MODE?\r\n", b"STANDBY\r\n")]


TIMER = [
    (b"TIMER WRITE, NO0, 1:05, STANDBY\r\n", b"OK:TIMER WRITE, NO0, 1:05, STANDBY\r\n"),
    (b"TIMER, ON, 0\r\n", b"OK:TIMER, ON, 0\r\n"),
    (b"TIMER LIST?, 0\r\n", b"STANDBY,1:05\r\n"),
    (b"TIMER ON?\r\n", b"1,0\r\n"),
]


def espec(scripted, *pairs, rest_after=0.0):
    return Espec(scripted(list(pairs)), OvenLimits(-20.0, 80.0, 2.0), rest_after)


def test_temperature(scripted):
    assert espec(scripted, (b"MON?\r\n", b"-5.2,STANDBY,0\r\n")).temperature() == -5.2


def test_alarms_are_named(scripted):
    oven = espec(scripted, (b"MON?\r\n", b"85.2,STANDBY,1\r\n"), (b"ALARM?\r\n", b"1,7\r\n"))
    with pytest.raises(OvenError, match="says 1,7") as caught:
        oven.temperature()
    assert caught.value.fault is Fault.ALARM


def test_ramp_is_a_program_the_chamber_runs(scripted):
    oven = espec(scripted, AT_20, PROGRAM, PROGRAM_READ, RUNS)
    assert oven.ramp_to(60.0, 0.4) == SetPoint(60.0, 0.4)


def test_ramp_takes_whole_minutes_and_is_never_steeper_than_asked(scripted):
    sent = b"RUN PRGM, TEMP20.0 GOTEMP21.0 TIME0:03\r\n"
    read = (b"RUN PRGM?\r\n", b"TEMP20.0 GOTEMP21.0 TIME0:03 REF9\r\n")
    taken = espec(scripted, AT_20, (sent, b"OK\r\n"), read, RUNS).ramp_to(21.0, 0.45)
    assert taken == SetPoint(21.0, pytest.approx(1.0 / 3.0))


def test_ramp_to_where_it_is_becomes_constant(scripted):
    set_20 = (b"TEMP, S20.0\r\n", b"OK:TEMP, S20.0\r\n")
    read = (b"TEMP?\r\n", b"20.0,20.0,150.0,-40.0\r\n")
    assert espec(scripted, AT_20, set_20, *CONSTANT, read).ramp_to(20.0, 0.4).target == 20.0


def test_hold_where_the_program_is(scripted):
    midway = (b"TEMP?\r\n", b"39.6,40.1,150.0,-40.0\r\n")
    kept = (b"TEMP?\r\n", b"39.6,40.1,150.0,-40.0\r\n")
    oven = espec(scripted, midway, RUNS, (b"TEMP, S40.1\r\n", b"OK\r\n"), *CONSTANT, kept)
    assert oven.hold() == 40.1


def test_hold_of_a_resting_chamber_is_at_its_temperature(scripted):
    kept = (b"TEMP?\r\n", b"20.0,20.0,150.0,-40.0\r\n")
    oven = espec(scripted, AT_20, STANDBY[1], (b"TEMP, S20.0\r\n", b"OK\r\n"), *CONSTANT, kept)
    assert oven.hold() == 20.0


def test_safe_is_standby(scripted):
    espec(scripted, *STANDBY).safe()


def test_program_that_reads_back_different_is_not_taken(scripted):
    read = (b"RUN PRGM?\r\n", b"TEMP20.0 GOTEMP55.0 TIME1:40 REF9\r\n")
    with pytest.raises(OvenError, match=r"end=60\.0.*reads back.*end=55\.0") as caught:
        espec(scripted, AT_20, PROGRAM, read, read).ramp_to(60.0, 0.4)
    assert caught.value.fault is Fault.NOT_TAKEN


def test_protection_is_a_refusal(scripted):
    with pytest.raises(OvenError, match="PROTECT ON") as caught:
        espec(scripted, AT_20, (PROGRAM[0], b"NA:PROTECT ON\r\n")).ramp_to(60.0, 0.4)
    assert caught.value.fault is Fault.REFUSED


def test_ramp_longer_than_a_program(scripted):
    with pytest.raises(ValueError, match="at most 5999 min"):
        espec(scripted, AT_20).ramp_to(60.0, 0.005)


def test_a_chamber_that_stopped_by_itself_is_an_alarm(scripted):
    oven = espec(scripted, AT_20, PROGRAM, PROGRAM_READ, RUNS, (b"MON?\r\n", b"24.0,STANDBY,0\r\n"))
    oven.ramp_to(60.0, 0.4)
    with pytest.raises(OvenError, match="stopped by itself") as caught:
        oven.temperature()
    assert caught.value.fault is Fault.ALARM


def test_the_quick_timer_is_set_before_the_ramp_and_stopped_after_standby(scripted):
    oven = espec(
        scripted,
        AT_20,
        *TIMER,
        PROGRAM,
        PROGRAM_READ,
        RUNS,
        *STANDBY,
        (b"TIMER, OFF, 0\r\n", b"NA:CONT NOT READY-1\r\n"),
        rest_after=3880.0,
    )
    oven.renew()  # nothing to renew yet
    oven.ramp_to(60.0, 0.4)
    oven.renew()  # nothing due yet
    oven.safe()  # at rest, whatever becomes of its timer


@pytest.mark.parametrize(
    ("listed", "on"),
    [(b"STANDBY,1:05", b"0"), (b"OFF,1:05", b"1,0"), (b"STANDBY,0:05", b"1,0"), (b"STANDBY,1:05", b"1,1")],
)
def test_a_timer_that_reads_back_different_starts_nothing(scripted, listed, on):
    oven = espec(
        scripted,
        AT_20,
        *TIMER[:2],
        *2 * ((TIMER[2][0], listed + b"\r\n"), (TIMER[3][0], on + b"\r\n")),
        rest_after=3900.0,
    )
    with pytest.raises(OvenError, match="quick timer") as caught:
        oven.ramp_to(60.0, 0.4)
    assert caught.value.fault is Fault.NOT_TAKEN


def damaged(rig, start, wrong, times):
    """Let the next answers that begin with `start` arrive as `wrong`."""
    left = [wrong] * times

    def disturb(answer):
        return [Delivery(answer.delay, left.pop())] if left and answer.data.startswith(start) else [answer]

    rig.disturbed.always = disturb
    return left


@pytest.mark.parametrize(
    ("start", "wrong"),
    [
        (b"TEMP2", b"TEMP20.0 GOTEMP55.0 TIME1:40 REF9\r\n"),
        (b"RUN", b"CONSTANT\r\n"),
        (b"STANDBY,0", b"STANDBY,0:80\r\n"),
        (b"1,0", b"1,1\r\n"),
    ],
)
def test_one_wrong_digit_read_back_ends_no_ramp(rig_of, start, wrong):
    rig = rig_of("espec-p300", rest_after=1800)
    left = damaged(rig, start, wrong, 1)
    assert rig.oven.ramp_to(60.0, 0.4).target == 60.0
    assert not left


def test_a_timer_not_known_to_run_anew_is_set_again_at_the_next_look(rig_of):
    rig = rig_of("espec-p300", rest_after=1800)
    rig.oven.ramp_to(60.0, 0.4)
    for _ in range(45):
        rig.clock.sleep(20.0)
        rig.oven.temperature()
    left = damaged(rig, b"1,0", b"0\r\n", 2)
    with pytest.raises(OvenError, match="quick timer") as caught:
        rig.oven.renew()
    assert caught.value.fault is Fault.NOT_TAKEN
    assert not left
    left = damaged(rig, b"1,0", b"1,0\r\n", 1)
    rig.oven.renew()
    assert not left, "it was not asked"
