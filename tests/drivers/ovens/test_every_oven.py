"""What every oven promises, kept by each kind against its simulated counterpart."""

import pytest

from drivers.ovens.error import Fault, OvenError
from drivers.ovens.oven import Oven, OvenLimits
from tests.drivers.ovens.served import flipped, halved, late, noisy, silenced


def test_is_an_oven(rig):
    oven: Oven = rig.oven
    assert oven.limits == OvenLimits(-5.0, 65.0, 2.0)
    assert oven.poll_within >= 30.0


def test_opening_changes_nothing(rig):
    assert rig.at_rest
    assert rig.oven.temperature() == pytest.approx(20.0, abs=0.2)
    assert rig.at_rest


def test_ramps_by_itself_up_and_down(rig):
    taken = rig.oven.ramp_to(26.0, 0.4)
    assert (taken.target, taken.rate) == (26.0, pytest.approx(0.4))
    begun, start = rig.clock.now(), rig.body.measured
    rig.wait(600.0)  # asks for temperatures only
    minutes = (rig.clock.now() - begun) / 60.0
    assert rig.body.working == pytest.approx(start + 0.4 * minutes, abs=0.15)
    assert rig.oven.temperature() == pytest.approx(rig.body.working, abs=0.3)
    rig.wait(1200.0)
    assert rig.oven.temperature() == pytest.approx(26.0, abs=0.2)
    assert rig.oven.ramp_to(21.0, 1.0).target == 21.0
    rig.wait(150.0)
    assert rig.body.working == pytest.approx(23.5, abs=0.3)
    rig.wait(900.0)
    assert rig.oven.temperature() == pytest.approx(21.0, abs=0.2)


def test_below_zero(rig):
    assert rig.oven.ramp_to(-5.0, 2.0).target == -5.0
    rig.wait(2400.0)
    assert rig.oven.temperature() == pytest.approx(-5.0, abs=0.2)
    assert rig.body.air == pytest.approx(-5.0, abs=0.2)


def test_asked_again_it_changes_its_mind(rig):
    rig.oven.ramp_to(40.0, 1.0)
    rig.wait(300.0)
    rig.oven.ramp_to(22.0, 0.5)
    rig.wait(1800.0)
    assert rig.oven.temperature() == pytest.approx(22.0, abs=0.2)


def test_limits_are_kept(rig):
    taken = rig.oven.ramp_to(400.0, 50.0)
    assert taken.target == 65.0
    assert 1.9 < taken.rate <= 2.0
    rig.wait(1500.0)  # steps of a controller without a ramp come to its end, too
    assert rig.body.target == 65.0
    assert rig.oven.ramp_to(-90.0, 1.0).target == -5.0


@pytest.mark.parametrize(("target", "rate"), [(float("nan"), 1.0), (30.0, 0.0), (30.0, -1.0)])
def test_nonsense_is_refused_and_nothing_sent(rig, target, rate):
    with pytest.raises(ValueError, match=r"target|rate"):
        rig.oven.ramp_to(target, rate)
    assert rig.at_rest


def test_hold_stops_the_ramp(rig):
    rig.oven.ramp_to(60.0, 0.6)
    rig.wait(1200.0)
    held = rig.oven.hold()
    assert held == pytest.approx(rig.body.air, abs=0.4)
    assert 30.0 < held < 34.0
    rig.wait(1800.0)
    assert rig.oven.temperature() == pytest.approx(held, abs=0.2)


def test_hold_of_a_resting_oven_keeps_its_temperature(rig):
    assert rig.oven.hold() == pytest.approx(20.0, abs=0.2)
    rig.wait(1800.0)
    assert rig.body.regulating
    assert rig.oven.temperature() == pytest.approx(20.0, abs=0.2)


def test_safe_neither_heats_nor_cools(rig):
    rig.oven.ramp_to(60.0, 1.0)
    rig.wait(600.0)
    assert rig.body.output != 0.0
    rig.oven.safe()
    assert rig.at_rest
    rig.oven.safe()  # again, at will
    assert rig.rest_at is not None or rig.body.output == 0.0
    rig.wait(3600.0)
    assert rig.at_rest
    assert rig.body.output == 0.0 if rig.rest_at is None else rig.body.air == pytest.approx(rig.rest_at, abs=0.2)
    rig.oven.ramp_to(25.0, 1.0)  # and back to work
    rig.wait(900.0)
    assert rig.oven.temperature() == pytest.approx(25.0, abs=0.2)


@pytest.mark.parametrize(
    ("kind", "trouble"),
    [
        ("eurotherm-2400", {"sensor_broken": True}),
        ("eurotherm-2400", {"unit": 1}),
        ("eurotherm-3500", {"alarms": 4}),
        ("espec-p300", {"alarms": (1,)}),
        ("watlow-f4t", {"sensor_broken": True}),
        ("modbus-map", {"alarm": True}),
        ("scpi", {"alarm": True}),
    ],
)
def test_left_ramping_and_in_trouble_it_is_opened_and_told_to_rest(rig_of, kind, trouble):
    rig = rig_of(kind)
    rig.oven.ramp_to(40.0, 1.0)
    vars(rig.controller).update(trouble)
    rig.open()
    with pytest.raises(OvenError):
        rig.oven.temperature()
    rig.oven.safe()
    assert rig.at_rest


@pytest.mark.parametrize("verb", ["ramp_to", "safe", "hold"])
def test_a_controller_that_takes_nothing_is_found_out(rig, verb):
    rig.oven.ramp_to(40.0, 1.0)
    rig.wait(310.0)
    getattr(rig.controller, "server", rig.controller).locked = True  # between two steps
    arguments = (55.0, 0.5) if verb == "ramp_to" else ()

    def told():
        getattr(rig.oven, verb)(*arguments)
        rig.wait(60.0)  # a ramp in steps is found out at the first

    with pytest.raises(OvenError, match="reads back") as caught:
        told()
    assert caught.value.fault is Fault.NOT_TAKEN
    assert caught.value.advice


@pytest.mark.parametrize("disturbance", [silenced, halved, flipped(1), noisy(before=b"\x00\xff"), late(0.6)])
def test_bad_answers_are_asked_for_again(rig, disturbance):
    for verb in (rig.oven.temperature, rig.oven.hold, rig.oven.safe):
        rig.disturbed.disturb(disturbance, disturbance)
        verb()
    assert rig.at_rest


def test_one_bad_answer_in_three_spoils_nothing(rig):
    rig.oven.ramp_to(30.0, 1.0)
    bad = [silenced, halved, flipped(2), noisy(before=b"\x7f"), late(0.6)]
    for i in range(60):
        rig.clock.sleep(10.0)
        rig.disturbed.disturb(bad[i % len(bad)])
        assert rig.oven.temperature() == pytest.approx(rig.body.air, abs=0.2)


def test_a_lost_oven_is_told(rig):
    rig.oven.ramp_to(30.0, 1.0)
    rig.disturbed.always = silenced
    faults = set()
    for _ in range(40):
        with pytest.raises(OvenError) as caught:
            rig.oven.temperature()
        faults.add(caught.value.fault)
        if caught.value.fault is Fault.LOST:
            break
    assert faults == {Fault.SILENT, Fault.LOST}


def test_closed_it_goes_on_and_answers_no_more(rig):
    rig.oven.ramp_to(30.0, 1.0)
    rig.oven.close()
    assert rig.body.regulating
    with pytest.raises(OvenError, match="closed") as caught:
        rig.oven.temperature()
    assert caught.value.fault is Fault.PORT
