"""Every oven comes to rest over a line that carries its commands and loses, or delays, all answers."""

import contextlib

import pytest

from drivers.ovens.error import OvenError
from tests.drivers.ovens.served import late, silenced, untouched


@pytest.mark.parametrize("verb", ["ramp_to", "hold"])
@pytest.mark.parametrize(
    "disturbance", [silenced, late(0.55), late(0.75), late(0.95)], ids=["lost", "1.1", "1.5", "1.9"]
)
def test_it_is_at_rest_and_says_that_this_is_not_verified(rig, verb, disturbance):
    rig.oven.ramp_to(50.0, 1.0)
    rig.wait(310.0)  # between two steps of a controller without a ramp
    if verb == "hold":
        rig.oven.hold()
    assert not rig.at_rest
    rig.disturbed.always = disturbance
    with pytest.raises(OvenError) as caught:
        rig.oven.safe()
    assert caught.value.advice
    assert rig.at_rest
    rig.clock.sleep(600.0)  # nor is it moved by what the driver repeats
    assert rig.at_rest


@pytest.mark.parametrize("answered", range(12))
def test_it_rests_wherever_in_a_command_the_answers_end(rig, answered):
    rig.oven.ramp_to(30.0, 1.0)
    rig.wait(310.0)
    rig.disturbed.disturb(*[untouched] * answered)
    rig.disturbed.always = silenced
    with contextlib.suppress(OvenError):
        rig.oven.ramp_to(55.0, 0.5)
        rig.oven.hold()
    with contextlib.suppress(OvenError):  # it is verified where answers are left for it
        rig.oven.safe()
    assert rig.at_rest
    rig.disturbed.always = untouched
    rig.oven.safe()
    assert rig.at_rest


def test_a_driver_that_has_only_opened_the_line_brings_it_to_rest(rig):
    rig.oven.ramp_to(50.0, 1.0)
    rig.wait(310.0)
    rig.oven._end_steps() if hasattr(rig.oven, "_end_steps") else None  # as the death of its process does
    rig.open()
    rig.disturbed.always = silenced
    with pytest.raises(OvenError):
        rig.oven.safe()
    assert rig.at_rest


def test_a_program_that_the_answers_leave_unknown_is_renewed_no_more(rig_of):
    for kind in ("eurotherm-2400", "watlow-f4t"):
        rig = rig_of(kind, program=3, rest_after=600.0)
        rig.oven.ramp_to(30.0, 2.0)
        rig.disturbed.always = silenced
        with pytest.raises(OvenError):
            rig.oven.safe()
        rig.disturbed.always = untouched
        for _ in range(100):
            rig.clock.sleep(60.0)
            rig.oven.renew()
            assert rig.at_rest


def test_it_is_at_rest_before_anything_is_asked(rig):
    """So that it does not depend on what happens to the first answers."""
    rig.oven.ramp_to(50.0, 1.0)
    rig.wait(310.0)
    after_each = []
    receive = rig.disturbed.receive

    def watched(data):
        answers = receive(data)
        after_each.append(rig.at_rest)
        return answers

    rig.disturbed.receive = watched
    rig.oven.safe()
    assert after_each[0]
