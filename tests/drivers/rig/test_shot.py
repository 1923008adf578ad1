"""The shot before a campaign on simulated cards: what it tells, and how soon it ends."""

from dataclasses import replace
from typing import Any

import pytest

from drivers.ni.cards import DaqError
from drivers.ni.simulated.faults import Faults
from drivers.rig.shot import Shot, fire

World = Any


def shot(world: World) -> tuple[Shot, float]:
    """Return a shot, and how long it took, s."""
    cards = world.rig.open_cards()
    began = world.parts.clock.now()
    try:
        return fire(cards, world.protocol), world.parts.clock.now() - began
    finally:
        cards.close()


def test_a_sound_rig(world: World) -> None:
    told, seconds = shot(world)
    assert told.faults == ()
    assert seconds < 3.0
    drive, response = told.inputs
    assert drive.coherence == pytest.approx(1.0, abs=1e-3)
    assert drive.peak == pytest.approx(1.0 / 5.0, rel=0.1)  # 1 V of the NI 9234's 5.1
    assert response.level > 100.0 * response.noise
    assert response.noise == pytest.approx(50e-6, rel=0.5)  # of the simulated card
    assert world.parts.server.output_voltage() == 0.0
    assert not world.parts.body.regulating


@pytest.mark.parametrize(
    ("terminal", "told"), [("cDAQ1Mod1/ai0", "is not the one played"), ("cDAQ1Mod1/ai1", "response 1 is silent")]
)
def test_a_cable_that_is_off_is_told_within_three_seconds(world: World, terminal: str, told: str) -> None:
    world.parts.server.inject(Faults(dead_inputs=frozenset({terminal})))
    found, seconds = shot(world)
    assert any(told in fault for fault in found.faults)
    assert seconds < 3.0


def test_an_input_that_clips(world: World, monkeypatch: pytest.MonkeyPatch) -> None:
    kind = type(world.plate)
    answer = kind.__call__
    monkeypatch.setattr(kind, "__call__", lambda plate, *arguments: 200.0 * answer(plate, *arguments))
    found, _ = shot(world)
    assert any("response 1 is overloaded" in fault for fault in found.faults)


def test_a_response_is_named_by_its_sensor_and_terminal(world: World) -> None:
    world.parts.server.inject(Faults(dead_inputs=frozenset({"cDAQ1Mod1/ai1"})))
    cards = world.rig.open_cards()
    found = fire(cards, replace(world.protocol, responses=("L8 (cDAQ1Mod1/ai1)",)))
    cards.close()
    assert any(fault.startswith("response L8 (cDAQ1Mod1/ai1) is silent") for fault in found.faults)


def test_lost_cards_are_told_as_such(world: World) -> None:
    world.parts.server.inject(Faults(unplugged=(0.5, 1e9)))
    with pytest.raises(DaqError):
        shot(world)
