"""A controller that somebody else commands is noticed: every kind, at any moment of a ramp and while it holds."""

import pytest

from drivers.ovens.error import OvenError
from drivers.ovens.oven import Contested
from drivers.ovens.settings import open_oven
from drivers.ovens.simulated.controller import MemoryTransport


def another(rig):
    """Return a second driver of the same controller, on a line of its own."""
    return open_oven(rig.settings, rig.clock, MemoryTransport(rig.controller, rig.clock))


def noticed(rig) -> str:
    """Return what is seen, by the comparison or, of an oven that was stopped, by its temperature."""
    try:
        rig.oven.temperature()
    except OvenError as error:
        return str(error)
    return rig.oven.changed()


def test_nobody_else_is_suspected(rig):
    assert isinstance(rig.oven, Contested)
    assert rig.oven.changed() == ""
    for target, rate in ((30.0, 1.0), (24.0, 2.0), (33.3, 0.7)):
        rig.oven.ramp_to(target, rate)
        for _ in range(90):
            assert rig.oven.changed() == ""
            rig.wait(10.0)
        rig.oven.hold()
        for _ in range(6):
            assert rig.oven.changed() == ""
            rig.wait(30.0)
    rig.oven.safe()
    assert rig.oven.changed() == ""
    rig.wait(60.0)
    assert rig.oven.changed() == ""


@pytest.mark.parametrize("held", [False, True])
def test_another_ramp_is_noticed(rig, held):
    rig.oven.ramp_to(30.0, 1.0)
    rig.wait(120.0)
    if held:
        rig.oven.hold()
        rig.wait(60.0)
    another(rig).ramp_to(10.0, 2.0)
    seen = ""
    for _ in range(100):
        rig.clock.sleep(5.0)
        seen = seen or noticed(rig)
    assert seen


def test_an_oven_that_is_stopped_is_noticed(rig):
    rig.oven.ramp_to(30.0, 1.0)
    rig.wait(120.0)
    another(rig).safe()
    rig.clock.sleep(5.0)
    assert noticed(rig)
