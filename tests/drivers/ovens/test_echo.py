"""Adapters that return what is sent: the echo is left out on every protocol, and its absence is no fault."""

import pytest

from drivers.clock import VirtualClock
from drivers.ovens.error import Fault, OvenError
from drivers.ovens.line import Line, Timing, up_to
from drivers.ovens.simulated.controller import Delivery, MemoryTransport
from drivers.thermometers.thermometer import THERMOMETERS
from tests.drivers.ovens.served import flipped, halved, late, noisy, silenced


class Echoing:
    """A controller behind such an adapter; the echo comes in so many pieces, the answer after it."""

    def __init__(self, inner, pieces=1, together=False):
        self.inner, self.pieces, self.together = inner, pieces, together
        self.on = True

    def receive(self, data):
        answers = self.inner.receive(data)
        if not self.on:
            return answers
        if self.together:
            return [Delivery(0.02, data + b"".join(answer.data for answer in answers))]
        step = -(-len(data) // self.pieces)
        echo = [Delivery(0.002 * i, data[i : i + step]) for i in range(0, len(data), step)]
        return [*echo, *(Delivery(0.002 * len(data) + answer.delay, answer.data) for answer in answers)]


def echoing(rig, **how):
    rig.transport._controller = Echoing(rig.disturbed, **how)
    return rig.open()


@pytest.fixture(params=[{}, {"pieces": 3}, {"pieces": 99}, {"together": True}], ids=str)
def how(request):
    return request.param


def test_every_oven_works_behind_it(rig, how):
    echoing(rig, **how)
    assert rig.oven.temperature() == pytest.approx(20.0, abs=0.2)
    assert rig.oven.ramp_to(30.0, 1.0).target == 30.0
    rig.wait(310.0)
    assert rig.oven.temperature() == pytest.approx(25.0, abs=0.5)
    assert rig.oven.hold() == pytest.approx(25.0, abs=0.5)
    rig.oven.safe()
    assert rig.at_rest


def test_every_oven_is_brought_to_rest_by_a_driver_that_has_asked_nothing_yet(rig, how):
    rig.oven.ramp_to(30.0, 1.0)
    rig.wait(310.0)
    getattr(rig.oven, "_end_steps", lambda: None)()  # as the death of its process does
    echoing(rig, **how)
    rig.oven.safe()
    assert rig.at_rest
    assert 22.0 < rig.oven.temperature() < 26.0


@pytest.mark.parametrize("disturbance", [silenced, halved, flipped(1), noisy(before=b"\x00\xff"), late(0.6)])
def test_bad_answers_behind_an_echo_are_asked_for_again(rig, disturbance, how):
    echoing(rig, **how)
    for verb in (rig.oven.temperature, rig.oven.hold, rig.oven.safe):
        rig.disturbed.disturb(disturbance, disturbance)
        verb()
    assert rig.at_rest
    assert rig.oven.temperature() == pytest.approx(20.0, abs=0.2)


def test_a_dead_controller_behind_an_echo_is_silent_and_nothing_counts_as_taken(rig, how):
    echoing(rig, **how)
    rig.oven.temperature()
    rig.disturbed.always = silenced
    for verb in (rig.oven.temperature, rig.oven.hold, rig.oven.safe, lambda: rig.oven.ramp_to(30.0, 1.0)):
        with pytest.raises(OvenError) as caught:
            verb()
        assert caught.value.fault is Fault.SILENT


def test_a_dead_controller_is_found_out_by_a_driver_that_has_asked_nothing_yet(rig, how):
    echoing(rig, **how)
    rig.disturbed.always = silenced
    with pytest.raises(OvenError) as caught:
        rig.oven.safe()
    assert caught.value.fault is Fault.SILENT


def test_an_adapter_may_be_exchanged_for_one_of_the_other_sort(rig):
    echoing(rig)
    for _ in range(3):
        assert rig.oven.temperature() == pytest.approx(rig.body.air, abs=0.2)
        assert rig.oven.ramp_to(30.0, 1.0).target == 30.0
        rig.oven.safe()
        assert rig.at_rest
        rig.clock.sleep(7200.0)
        rig.transport._controller.on ^= True


@pytest.mark.parametrize("kind", ["eurotherm-2400", "modbus-map in Fahrenheit over TCP", "modbus-map"])
def test_a_command_whose_answer_equals_it_is_answered_at_once_where_no_echo_is(rig_of, kind):
    rig = rig_of(kind)
    rig.oven.temperature()
    begun = rig.clock.now()
    rig.oven.ramp_to(30.0, 1.0)
    rig.oven.safe()
    assert rig.clock.now() - begun < 3.0  # the gaps; waiting for a second copy would take 0.5 s each


def test_a_text_whose_acknowledgement_is_the_command_itself(rig_of):
    rig = rig_of("scpi", acknowledge="OUTP ON")
    for how in (None, {"pieces": 2}):
        if how is not None:
            echoing(rig, **how)
        rig.oven.ramp_to(30.0, 1.0)
        assert rig.body.regulating
        rig.oven.safe()
        assert rig.at_rest


@pytest.mark.parametrize(
    "declared",
    [
        {"kind": "modbus-map", "sensors": [{"at": 3, "scale": 0.1}, {"at": 0x0203, "type": "float32"}]},
        {"kind": "scpi", "sensors": [{"query": "MEAS:TEMP? (@1)"}, {"query": "MEAS:TEMP? (@2)"}]},
    ],
    ids=lambda declared: declared["kind"],
)
def test_thermometers_work_behind_it(rig, declared, how):
    settings = THERMOMETERS.find(declared["kind"]).model_validate({**declared, "port": "none"})
    counterpart = settings.simulated(rig.body, rig.clock)
    thermometer = settings.open(rig.clock, MemoryTransport(Echoing(counterpart, **how), rig.clock))
    assert thermometer.temperatures() == pytest.approx([20.0, 20.0], abs=0.2)


def test_an_echo_of_a_command_without_an_answer_does_not_begin_the_next_answer():
    class Slow:
        def receive(self, data):
            slow = [Delivery(0.1 * (i + 1), data[i : i + 1]) for i in range(len(data))]
            return [*slow, Delivery(0.1 * len(data) + 0.01, b"23.5\n")] if b"?" in data else slow

    clock = VirtualClock()
    line = Line(MemoryTransport(Slow(), clock), clock, Timing(timeout=2.0, retries=0))
    assert line.exchange(b"T?\n", up_to(b"\n")) == b"23.5\n"
    for _ in range(3):
        line.send(b"OFF\n")
        assert line.exchange(b"T?\n", up_to(b"\n")) == b"23.5\n"
