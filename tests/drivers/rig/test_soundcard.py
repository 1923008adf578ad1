"""A campaign on a sound card: lost samples are repeated, and it ends at rest."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import pytest

from drivers.rig.end_requests import RigStopped
from drivers.rig.simulated import PlateForecast
from drivers.soundcard.card import SoundCard
from drivers.soundcard.simulated import simulated_sound

CARD = SoundCard(output="out1", drive_input="in1", responses=("in2",), input_range=2.5, output_range=2.0)


@pytest.fixture
def world(world_of: Callable[..., Any]) -> Any:
    """Return a rig whose cards are a sound card; the oven is the one of all other tests."""
    world = world_of(programme={"watch": "air"})
    parts = world.parts
    forecast = PlateForecast(parts.clock, parts.body, world.chamber)
    sound = simulated_sound(CARD, world.plate, parts.clock, temperature=forecast, seed=5)
    world.parts = replace(parts, wiring=CARD, sound=sound)
    world.rig = world.parts.rig()
    return world


def test_lost_samples_cost_one_repetition(world: Any) -> None:
    world.parts.sound.xruns.append(4)  # one opens the card, one tests its loop-back
    outcome = world.run()
    assert (outcome.finished, outcome.missing) == (3, 0)
    rejected = [event["faults"] for event in world.store.events_of("rejected")]
    assert len(rejected) == 1
    assert "Samples were lost" in rejected[0][0]
    assert world.unsafe == ()
    assert world.parts.sound.voltage() == 0.0
    assert not world.parts.body.regulating


def test_a_card_that_comes_back_goes_on(world: Any) -> None:
    sound, clock = world.parts.sound, world.parts.clock

    def pulled_out() -> None:
        if world.plate.sweeps == 3:
            sound.gone = True
            world.at(clock.now() + 80.0, lambda: setattr(sound, "gone", False))

    world.plate.before = pulled_out
    outcome = world.run()
    assert (outcome.finished, outcome.missing) == (3, 0)
    assert world.store.events_of("recovered")
    assert world.unsafe == ()


def test_a_card_that_stays_away_ends_at_rest_but_for_itself(world: Any) -> None:
    def pulled_out() -> None:
        world.parts.sound.gone = world.plate.sweeps == 3

    world.plate.before = pulled_out
    with pytest.raises(RigStopped, match="the cards are lost"):
        world.run()
    assert not world.parts.body.regulating
    assert len(world.unsafe) == 1
    assert "the drive could not be brought to 0 V" in world.unsafe[0]
