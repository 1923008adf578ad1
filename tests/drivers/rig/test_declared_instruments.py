"""Campaigns on instruments that are declared altogether: an oven that ramps in steps, a thermometer of its own."""

from collections.abc import Callable
from typing import Any

import pytest

from drivers.rig.end_requests import RigStopped
from drivers.thermometers.thermometer import THERMOMETERS

OVENS: dict[str, dict[str, Any]] = {
    "modbus-map": {"temperature": {"at": 1}, "set_point": {"at": 2, "scale": 0.1}, "run": {"at": 3}, "step": 0.3},
    "scpi": {
        "temperature": {"query": "TEMP?"},
        "set_point": {"query": "SET?", "command": "SET {value}", "decimals": 2},
        "run": {"on": "RUN", "off": "STOP", "query": "STATE?"},
    },
}
OVENS["modbus-map"]["temperature"]["scale"] = 0.1
METER = {"kind": "scpi", "port": "none", "timeout": 0.2, "sensors": [{"query": "READ?"}, {"query": "READ2?"}]}


@pytest.fixture(params=OVENS)
def world(request: pytest.FixtureRequest, world_of: Callable[..., Any]) -> Any:
    """Return a campaign whose plate is watched through a meter of its own."""
    made = world_of()
    made.kind = request.param
    made.oven = OVENS[request.param]
    made.thermometer = THERMOMETERS.find("scpi").model_validate(METER)
    made.renew()
    return made


def test_a_campaign(world: Any) -> None:
    outcome = world.run()
    assert (outcome.finished, outcome.missing) == (world.protocol.count, 0)
    assert world.worst_error() < 0.02
    assert world.unsafe == ()
    assert world.at_rest()
    assert all(sweep.plate_temperature_start is not None for sweep in world.store.kept.values())


def test_taken_up_again_it_ends_as_if_undisturbed(world: Any) -> None:
    world.run()
    undisturbed = world.digests()
    world.store.kept.clear()
    world.store.log_lines.clear()
    world.renew()

    def end() -> None:
        if len(world.store.kept) == 1:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        world.run(end)
    assert world.at_rest()
    world.renew()
    world.run()
    assert set(world.digests()) == set(undisturbed)
    assert world.worst_error() < 0.02


def test_a_meter_that_is_lost_ends_the_campaign_at_rest(world: Any) -> None:
    _, meter = world.parts.thermometer
    world.at(200.0, lambda: setattr(meter, "answer", lambda command: ""))
    with pytest.raises(RigStopped, match="thermometer lost: no usable answer"):
        world.run()
    assert world.at_rest()
    assert world.unsafe == ()
