"""Crystals that are off, each its own way: of the output, of the inputs, of the oven."""

from collections.abc import Callable
from typing import Any

import pytest

LONG = {
    "sweep": {"duration": 60.0},
    "programme": {"ramp_rate": 0.2, "lowest": 24.0, "highest": 25.0, "every": 1.0},
}
APART = [(-1e-4, 0.0), (1e-4, -1e-4)]
"""Errors of the inputs' clock and of the output's."""


@pytest.mark.parametrize(("errors", "routes"), [*((errors, False) for errors in APART), (APART[0], True)], ids=str)
def test_sweeps_of_a_minute_pass(world_of: Callable[..., Any], errors: tuple[float, float], routes: bool) -> None:
    """Whether the output takes the inputs' timebase, as it does where the chassis can route it, or keeps its own.

    The frequency axis is as right as the inputs' own crystal: 1e-4 of 600 Hz, on a slope, is what is left.
    """
    world = world_of(chassis={"clock_errors": errors, "routes_timebases": routes}, **LONG)
    outcome = world.run()
    assert [event["faults"] for event in world.store.events_of("rejected")] == []
    assert (outcome.finished, outcome.missing) == (2, 0)
    assert world.worst_error() < 8e-3
