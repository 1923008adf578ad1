"""Effects with places of their own, on plates of other outlines than a rectangle at the origin."""

from collections.abc import Sequence
from typing import Any

import numpy as np
import pytest

from analysis.declaration.outline import CircleOutline, PolygonOutline
from analysis.experiment import Experiment, Plate
from simulation.effects.library import LIBRARY, verify
from simulation.effects.local_damage import RADIUS
from simulation.effects.sensor_offset import LARGEST_OFFSET

L_SHAPE = PolygonOutline(
    kind="polygon", points=((-0.1, 0.2), (0.1, 0.2), (0.1, 0.3), (0.0, 0.3), (0.0, 0.4), (-0.1, 0.4))
)
DISC = CircleOutline(kind="circle", center=(0.0, 0.0), radius=0.1)
HOLE = CircleOutline(kind="circle", center=(0.0, 0.0), radius=0.03)
RING = Plate(outline=DISC, hole=(HOLE,), thickness=0.003, mass=0.08)
SHAPES = {"L": Plate(outline=L_SHAPE, thickness=0.003, mass=0.085), "ring": RING}
CHORDS = 6e-5
"""How far the chords by which loops are held against each other lie inside a rim of 100 mm, slantwise, m."""
PLACES = {"L": ((-0.05, 0.25), (0.06, 0.25), (-0.06, 0.36)), "ring": ((-0.06, 0.0), (0.06, 0.0), (0.0, -0.07))}


@pytest.fixture(params=sorted(SHAPES))
def shaped(request: pytest.FixtureRequest, experiment: Experiment) -> Experiment:
    """Return an experiment on a plate that is no rectangle, string and cable at one point."""
    actuator, sensor, point = PLACES[request.param]
    return on(experiment, SHAPES[request.param], (actuator, sensor), point)


def on(experiment: Experiment, plate: Plate, centers: Sequence[Any], point: Any) -> Experiment:
    patches = [p.model_copy(update={"center": c}) for p, c in zip(experiment.patch, centers, strict=True)]
    attached = [{"point": point}]
    changed = {"plate": plate, "patch": patches, "string": attached, "cable": attached}
    return Experiment(**{**{name: getattr(experiment, name) for name in Experiment.model_fields}, **changed})


@pytest.mark.parametrize("name", [name for name, effect in LIBRARY.items() if not effect.nothing_missing])
def test_every_effect_is_sound_on_every_outline(name: str, shaped: Experiment) -> None:
    assert LIBRARY[name].available(shaped)
    verify(LIBRARY[name], shaped)


def test_the_search_for_damage_starts_from_discs_wholly_on_the_plate(shaped: Experiment) -> None:
    card = LIBRARY["local_damage"].card(shaped)
    angle = np.linspace(0.0, 2.0 * np.pi, 37)
    rim = RADIUS * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    for site in (*card.sites, card.zero()):
        assert shaped.plate.contains(np.array([site["x"], site["y"]]) + 0.999 * rim).all(), site


def test_discs_cover_an_l_as_densely_as_its_box(experiment: Experiment) -> None:
    whole = Plate(length_x=0.2, length_y=0.2, thickness=0.003, mass=0.114)
    many = LIBRARY["local_damage"].card(on(experiment, whole, ((0.05, 0.05), (0.06, 0.16)), (0.1, 0.1))).sites
    some = LIBRARY["local_damage"].card(on(experiment, SHAPES["L"], PLACES["L"][:2], PLACES["L"][2])).sites
    assert len(many) == 64
    assert len(some) == 48


@pytest.mark.parametrize(
    ("place", "ranges"),
    [
        ((0.06, 0.0), ((-LARGEST_OFFSET, LARGEST_OFFSET), (-LARGEST_OFFSET, LARGEST_OFFSET))),
        # the inner corners of the patch, 10 mm off the axis, reach the hole of 30 mm at x = sqrt(30**2 - 10**2),
        # its side does at x = 30 mm
        ((0.0415, 0.0), ((-0.0015, LARGEST_OFFSET), (-LARGEST_OFFSET, LARGEST_OFFSET))),
        # the outer corners reach the rim of 100 mm at x = sqrt(100**2 - 10**2)
        ((0.088, 0.0), ((-LARGEST_OFFSET, np.sqrt(0.0099) - 0.098), (-LARGEST_OFFSET, LARGEST_OFFSET))),
        # a corner moved by d reaches the rim where (71.5 + d)**2 + 68.5**2 = 100**2
        (
            (0.0615, 0.0585),
            (
                (-LARGEST_OFFSET, np.sqrt(0.01 - 0.0685**2) - 0.0715),
                (-LARGEST_OFFSET, np.sqrt(0.01 - 0.0715**2) - 0.0685),
            ),
        ),
    ],
)
def test_a_sensor_moves_as_far_as_the_plate_goes(experiment: Experiment, place: Any, ranges: Any) -> None:
    there = on(experiment, RING, ((-0.06, 0.0), place), (0.0, -0.07))
    dx, dy = LIBRARY["sensor_offset"].card(there).parameters
    assert (dx.low, dx.high) == pytest.approx(ranges[0], abs=CHORDS)
    assert (dy.low, dy.high) == pytest.approx(ranges[1], abs=CHORDS)
