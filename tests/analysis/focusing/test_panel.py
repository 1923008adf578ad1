import numpy as np
import pytest
from pydantic import ValidationError

from analysis.focusing.panel import Filters, Panel, Target


def test_lines_are_those_of_the_fine_transform():
    settings = Filters()
    frequency = settings.frequency
    spacing = 44_100.0 / 16_384
    np.testing.assert_allclose(np.diff(frequency), spacing)
    assert frequency[0] - spacing < 20.0 <= frequency[0]
    assert frequency[-1] <= 900.0 < frequency[-1] + spacing


@pytest.mark.parametrize(
    ("settings", "words"),
    [
        ({"band": (100.0, 950.0)}, "must enclose"),
        ({"edges": (20.0, 30_000.0)}, "20000"),
        ({"sample_rate": 1_500.0}, "half of sample_rate"),
        ({"transform_length": 600}, "twice taps"),
        ({"sample_rate": 48_000.0, "taps": 64, "transform_length": 512}, "93.8 Hz.*; allowed: 1024 and more"),
        ({"delay": 512}, "inside the 512 taps"),
        ({"tolerance": 0.0}, "tolerance"),
        ({"taps": 512.5}, "taps"),
        ({"window": 3}, "window"),
    ],
)
def test_filters_that_cannot_be_are_refused(settings, words):
    with pytest.raises(ValidationError, match=words):
        Filters(**settings)


def test_a_target_off_the_plate_is_refused():
    with pytest.raises(ValidationError, match="along y; allowed 0 to 1"):
        Target(center=(0.5, 0.9), size=(0.2, 0.3))


RECTANGLE = {"center": (0.2, 0.5), "size": (0.2, 0.3)}


@pytest.mark.parametrize(
    ("target", "words"),
    [
        ({}, "target is empty; give center and size"),
        (RECTANGLE | {"polygon": ((0.1, 0.1), (0.2, 0.1), (0.2, 0.2))}, "keep one of them"),
        ({"polygon": ((0.1, 0.1), (0.2, 0.1))}, "give at least 3"),
        ({"polygon": ((0.1, 0.1), (0.4, 0.4), (0.4, 0.1), (0.1, 0.4))}, "crosses itself at"),
        ({"polygon": ((0.1, 0.1), (0.1001, 0.1), (0.1, 0.1001))}, "encloses 5e-09 of the area of the box"),
        ({"center": (0.5, 0.5), "size": (5e-324, 0.2)}, "greater than or equal to 0.0001"),
        ({"spot": (RECTANGLE, RECTANGLE | {"center": (0.3, 0.5)})}, "spots 1 and 2 overlap; move them apart"),
        (RECTANGLE | {"spot": (RECTANGLE,)}, "and a shape of its own"),
        ({"spot": (RECTANGLE, {"shape": "ellipse"})}, "spot 2 is empty"),
    ],
)
def test_targets_that_cannot_be_are_refused(target, words):
    with pytest.raises(ValidationError, match=words):
        Target.model_validate(target)


@pytest.mark.parametrize("center", [(0.9, 0.9), (0.5, 0.5)])
def test_a_target_off_the_outline_or_over_a_hole_is_refused(center):
    declared = {
        "title": "disc",
        "plate": {
            "outline": {"kind": "circle", "center": (0.0, 0.0), "radius": 0.15},
            "hole": ({"kind": "circle", "center": (0.0, 0.0), "radius": 0.02},),
            "thickness": 0.003,
            "mass": 0.2,
        },
        "patch": ({"id": "A1", "role": "actuator", "center": (0.0, 0.1), "diameter": 0.02, "thickness": 5e-4},),
    }
    with pytest.raises(ValidationError, match="target reaches over the plate's edge at"):
        Panel.model_validate(declared | {"target": {"center": center, "size": (0.1, 0.1)}})
    found = Panel.model_validate(declared | {"target": {"center": (0.3, 0.4), "size": (0.1, 0.2)}})
    assert found.target_center == pytest.approx((-0.06, -0.03))
    assert found.target_loops[0].area == pytest.approx(0.03 * 0.06)


def test_actuators_are_of_one_kind(supported):
    declared = supported.panel.model_dump()
    assert "drive" not in declared
    shakers = [{"id": "F1", "point": supported.panel.patch[0].center, "radius": 0.001}]
    found = Panel.model_validate(declared | {"patch": [], "drive": shakers})
    assert found.centers == (supported.panel.patch[0].center,)
    for patches, drives in (([], []), (declared["patch"], shakers)):
        with pytest.raises(ValidationError, match=r"at least one actuator, and actuators of one kind"):
            Panel.model_validate(declared | {"patch": patches, "drive": drives})


def test_a_sensor_or_overlapping_patches_are_refused(supported):
    declared = supported.panel.model_dump()
    declared["patch"][2]["role"] = "sensor"
    with pytest.raises(ValidationError, match="actuators only"):
        Panel(**declared)
    declared = supported.panel.model_dump()
    declared["patch"][1]["center"] = declared["patch"][0]["center"]
    with pytest.raises(ValidationError, match="overlap"):
        Panel(**declared)


def test_an_illustration_that_was_not_declared_follows_the_ranges_of_the_twin(supported):
    """Its defaults are a plastic's: a panel of metal was refused for a table that its file does not have."""
    declared = supported.panel.model_dump(exclude={"twin", "illustration"})
    metal = {**declared["plate"], "material": {"kind": "aluminium"}, "mass": 2700.0 * supported.panel.plate.volume}
    found = Panel(**{**declared, "plate": metal})
    low, high = found.box.youngs_modulus
    assert low <= found.illustration.youngs_modulus <= high
    assert Panel.model_validate_json(found.model_dump_json()) == found
    with pytest.raises(ValidationError, match="illustration lies outside the ranges of twin"):
        Panel(**{**declared, "plate": metal, "illustration": {"youngs_modulus": 2e9}})
