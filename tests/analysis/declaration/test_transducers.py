"""Drives and sensors as declared: their inputs and outputs, names and units, and what is refused."""

from typing import Any

import pytest
from pydantic import ValidationError

from analysis.channel import Channel, Footprint, transfer_label, transfer_unit
from analysis.experiment import Experiment

PATCHES = [
    {"id": "A1", "role": "actuator", "center": (0.2, 0.155), "size": (0.02, 0.02), "thickness": 5e-4},
    {"id": "S1", "role": "sensor", "center": (0.04, 0.035), "size": (0.02, 0.02), "thickness": 5e-4},
]
HAMMER = {"id": "hammer", "kind": "force", "point": (0.05, 0.06)}
ACC = {"id": "acc1", "kind": "acceleration", "point": (0.1, 0.1), "mass": 0.001}


def declared(**changes: Any) -> Experiment:
    given: dict[str, Any] = {
        "title": "any",
        "plate": {"length_x": 0.24, "length_y": 0.19, "thickness": 0.003, "mass": 0.13},
        "acquisition": {
            "module": "NI-9234",
            "sample_rate": 8e3,
            "input_resistance": 3e5,
            "input_capacitance": 1e-10,
        },
        "protocol": {
            "sweep": "linear",
            "band": (100.0, 700.0),
            "sweep_duration": 1.0,
            "tail": 0.1,
            "repeats": 2,
            "ramp_rate": 0.4,
            "temperatures": (20.0,),
            "directions": ("up",),
            "levels": (1.0,),
        },
        "oven": {"room_temperature": 22.0},
    }
    return Experiment.model_validate(given | changes)


def test_patches_alone_are_dumped_as_before_there_were_others() -> None:
    dumped = declared(patch=PATCHES).model_dump()
    assert set(dumped) == {
        "format", "title", "plate", "patch", "string", "cable", "acquisition", "protocol", "oven",
    }  # fmt: skip
    assert set(dumped["patch"][0]) == {"id", "role", "center", "size", "thickness", "side", "material"}


def test_names_and_units_follow() -> None:
    plain = declared(patch=PATCHES)
    assert plain.labels() == ("S1/A1 [V/V]",)
    sensors = [{**PATCHES[1], "quantity": "charge"}, {**PATCHES[0], "role": "open"}]
    mixed = declared(patch=sensors, drive=[HAMMER], sensor=[ACC, {"id": "L", "kind": "velocity", "point": (0, 0)}])
    assert mixed.labels() == ("S1/hammer [C/N]", "acc1/hammer [m/s2/N]", "L/hammer [m/s/N]")
    assert [channel.quantity for channel in mixed.outputs] == ["charge", "acceleration", "velocity"]
    assert (mixed.actuator.id, [p.id for p in mixed.sensors]) == ("hammer", ["S1"])
    assert Experiment.model_validate_json(mixed.model_dump_json()) == mixed
    source, output = mixed.inputs[0], mixed.outputs[1]
    assert (transfer_unit(output, source), transfer_label(output, source)) == ("m/s2/N", "acc1/hammer [m/s2/N]")


def test_a_push_on_the_top_face_is_a_force_along_minus_z() -> None:
    mixed = declared(drive=[HAMMER], sensor=[ACC, {**ACC, "id": "below", "side": "bottom", "mass": 0.0}])
    assert mixed.footprints == (
        Footprint((0.05, 0.06), 0.002, -1.0),
        Footprint((0.1, 0.1), 0.004, 1.0, 0.001),
        Footprint((0.1, 0.1), 0.004, -1.0),
    )
    assert declared(drive=[{**HAMMER, "side": "bottom"}], sensor=[ACC]).inputs[0].footprint == Footprint(
        (0.05, 0.06), 0.002, 1.0
    )


def test_a_laser_grid_leaves_out_what_is_off_the_plate() -> None:
    grid = {"id": "L", "kind": "velocity", "grid": (3, 2), "margin": 0.01}
    on_all = declared(drive=[HAMMER], sensor=[grid]).outputs
    assert [channel.id for channel in on_all] == ["L1", "L2", "L3", "L4", "L5", "L6"]
    places = [channel.footprint.point for channel in on_all if channel.footprint]
    assert places == [pytest.approx((x, y)) for x in (0.01, 0.12, 0.23) for y in (0.01, 0.18)]
    holed = {
        "length_x": 0.24,
        "length_y": 0.19,
        "thickness": 0.003,
        "mass": 0.13,
        "hole": [{"kind": "circle", "center": (0.12, 0.15), "radius": 0.032}],
    }
    assert len(declared(plate=holed, drive=[HAMMER], sensor=[grid]).outputs) == 5


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"patch": PATCHES[1:]}, r"nothing drives"),
        ({"patch": PATCHES[:1]}, "nothing is read"),
        ({"patch": PATCHES, "sensor": [{**ACC, "id": "S1"}]}, "id 'S1' is used 2 times"),
        ({"patch": [{**PATCHES[0], "quantity": "charge"}, PATCHES[1]]}, "only sensors are read"),
        (
            {"drive": [{**HAMMER, "point": (0.3, 0.1)}], "sensor": [ACC]},
            r"'hammer': point \(0.3, 0.1\) m is off",
        ),
        ({"drive": [{**HAMMER, "point": (0.001, 0.1)}], "sensor": [ACC]}, "reaches over the edge"),
        ({"drive": [HAMMER], "sensor": [{**ACC, "points": [(0.1, 0.1)]}]}, "point and points; give one of"),
        ({"drive": [HAMMER], "sensor": [{"id": "a", "kind": "velocity"}]}, "no place; give one of"),
        ({"drive": [HAMMER], "sensor": [{**ACC, "kind": "velocity"}]}, "only accelerometers load the plate"),
        ({"drive": [HAMMER], "sensor": [{**ACC, "id": "drive"}]}, "the name of the drive's channel"),
        ({"drive": [HAMMER], "sensor": [{**ACC, "mass": 3.0}]}, "less than or equal to 1"),
    ],
)
def test_it_refuses(changes: dict[str, Any], message: str) -> None:
    with pytest.raises(ValidationError, match=message):
        declared(**changes)


@pytest.mark.parametrize(
    ("grid", "margin", "allowed"), [((3, 2), 0.1, "0.095 m"), ((3, 1), 0.12, "0.12 m"), ((5, 4), 0.2, "0.12 m")]
)
def test_a_margin_of_half_the_plate_turns_no_grid_inside_out(
    grid: tuple[int, int], margin: float, allowed: str
) -> None:
    laser = {"id": "L", "kind": "velocity", "grid": grid, "margin": margin}
    with pytest.raises(
        ValidationError, match=f"sensor 'L': margin {margin:g} m; allowed 0 to less than {allowed}"
    ):
        declared(drive=[HAMMER], sensor=[laser])
    if grid[1] == 1:  # of one point along y, the margin there does not count
        assert len(declared(drive=[HAMMER], sensor=[laser | {"margin": 0.1}]).outputs) == 3


def test_a_channel_has_one_place() -> None:
    with pytest.raises(ValueError, match="a patch or a footprint, and not both"):
        Channel("S1", "voltage")
