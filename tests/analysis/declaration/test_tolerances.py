"""Tolerances of single quantities, declared where the quantity is."""

import tomllib

import pytest

from analysis.declaration.tolerances import Tolerances, without_tolerances

DECLARED = """
[plate]
length_x = 0.24
thickness = { value = 0.003, tolerance = 3e-5 }

[[patch]]
id = "S1"
center = { value = [0.04, 0.035], tolerance = 1e-3 }

[acquisition]
input_resistance = { value = 305e3, tolerance = 3e3 }

[tolerances]
length = 1e-4
"""


def test_values_stay_and_tolerances_are_collected_by_place():
    found = without_tolerances(tomllib.loads(DECLARED))
    assert found["plate"] == {"length_x": 0.24, "thickness": 0.003}
    assert found["patch"] == [{"id": "S1", "center": [0.04, 0.035]}]
    tolerances = Tolerances.model_validate(found["tolerances"])
    assert tolerances.length == 1e-4
    assert tolerances.own == {
        "plate.thickness": 3e-5,
        "patch.S1.center": 1e-3,
        "acquisition.input_resistance": 3e3,
    }
    assert tolerances.of("plate.thickness", 1.0) == 3e-5
    assert tolerances.of("plate.mass", 0.2) == 0.2


def test_a_declaration_without_any_is_what_it_was():
    table = {"plate": {"thickness": 0.003}, "patch": [{"id": "A1"}], "title": "t"}
    assert without_tolerances(table) == table


@pytest.mark.parametrize(
    ("table", "said"),
    [
        ({"plate": {"boundary": {"value": "free", "tolerance": 1.0}}}, "plate.boundary"),
        ({"plate": {"mass": {"value": 0.1, "tolerance": -1.0}}}, "-1"),
        ({"plate": {"mass": {"value": 0.1, "tolerance": "1 g"}}}, "1 g"),
        ({"plate": {"mass": {"value": 0.1, "tolerance": True}}}, "True"),
        ({"plate": {"mass": {"value": 0.1, "tolerance": float("nan")}}}, "nan"),
    ],
)
def test_what_cannot_be_a_tolerance_is_told_with_its_place(table, said):
    with pytest.raises(ValueError, match="plate") as told:
        without_tolerances(table)
    assert said in str(told.value)
