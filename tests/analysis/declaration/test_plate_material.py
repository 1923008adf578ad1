"""What a plate is made of: the ranges of known kinds, and nonsense refused with key, value and range."""

import re
from typing import Any

import pytest
from pydantic import ValidationError

from analysis.declaration.plate_material import DENSITIES, KINDS, THERMOPLASTIC, PlateMaterial, material_box
from analysis.experiment import Plate
from analysis.material import MaterialBox

SHEET = {"length_x": 0.24, "length_y": 0.19, "thickness": 0.003, "mass": 0.13}

TABLES = {  # E at room temperature, Pa, and nu, as handbooks of mechanics state them
    "polypropylene": (1.5e9, 0.40),
    "pmma": (3.3e9, 0.37),
    "abs": (2.3e9, 0.37),
    "polycarbonate": (2.35e9, 0.38),
    "aluminium": (70e9, 0.33),
    "magnesium": (45e9, 0.29),
    "titanium": (113e9, 0.34),
    "brass": (105e9, 0.35),
    "copper": (125e9, 0.34),
    "steel": (207e9, 0.29),
    "glass": (72e9, 0.22),
}


def test_old_declarations_are_thermoplastic_and_are_written_as_they_were() -> None:
    plate = Plate(**SHEET)
    assert (
        material_box(plate.material) == THERMOPLASTIC == MaterialBox((0.8e9, 4.0e9), (0.30, 0.49), (0.005, 0.15))
    )
    assert set(plate.model_dump()) == {*SHEET, "boundary"}


@pytest.mark.parametrize("kind", TABLES)
def test_kinds_hold_what_tables_say_with_room_around_it(kind: str) -> None:
    box, (modulus, ratio) = material_box(PlateMaterial(kind=kind)), TABLES[kind]  # type: ignore[arg-type]
    assert box.youngs_modulus[0] < 0.95 * modulus < 1.05 * modulus < box.youngs_modulus[1]
    assert box.poisson_ratio[0] < ratio < box.poisson_ratio[1]


def test_every_kind_can_be_modelled() -> None:
    for box in KINDS.values():
        assert 0.0 < box.youngs_modulus[0] < box.youngs_modulus[1]
        assert 0.0 < box.poisson_ratio[0] < box.poisson_ratio[1] < 0.5
        assert 0.0 < box.loss_factor[0] < box.loss_factor[1] < 1.0


@pytest.mark.parametrize("kind", KINDS)
def test_a_density_is_that_of_the_kind_filled_or_perforated(kind: Any) -> None:
    """Half to twice the usual one: a mass in a wrong unit, or with one digit wrong, is refused."""
    volume = 0.24 * 0.19 * 0.003
    usual = DENSITIES[kind]
    for share in (0.55, 1.0, 1.9):
        Plate(**SHEET | {"mass": share * usual * volume}, material={"kind": kind})
    for share in (0.45, 2.1, 10.0):
        with pytest.raises(ValidationError, match=f"allowed {0.5 * usual:g} to {2 * usual:g} for {kind}: mass"):
            Plate(**SHEET | {"mass": share * usual * volume}, material={"kind": kind})


def test_numbers_replace_those_of_the_kind_and_survive_a_file() -> None:
    table = {"kind": "pmma", "loss_factor": [0.03, 0.09]}
    plate = Plate(**SHEET, material=table)
    box = material_box(plate.material)
    assert box.loss_factor == (0.03, 0.09)
    assert box.youngs_modulus == KINDS["pmma"].youngs_modulus
    assert Plate.model_validate_json(plate.model_dump_json()) == plate


NUMBERS = {"youngs_modulus": [1e9, 2e9], "poisson_ratio": [0.3, 0.4], "loss_factor": [0.01, 0.1]}


@pytest.mark.parametrize(
    ("table", "said"),
    [
        ({"kind": "wood"}, "kind.*'aluminium'"),
        ({**NUMBERS, "poisson_ratio": [0.3, 0.5]}, r"poisson_ratio \[0\.3, 0\.5\]: allowed 0 to below 0\.5"),
        ({**NUMBERS, "poisson_ratio": [-0.1, 0.4]}, r"poisson_ratio\.0.*greater than or equal to 0"),
        ({**NUMBERS, "loss_factor": [0.0, 0.1]}, r"loss_factor\.0.*0\.00001"),
        ({**NUMBERS, "youngs_modulus": [2e9, 1e9]}, r"youngs_modulus \[2e\+09, 1e\+09\] must ascend"),
        ({**NUMBERS, "youngs_modulus": [70.0, 80.0]}, r"youngs_modulus\.0.*1000000"),
        ({**NUMBERS, "youngs_modulus": [2e9, 200e9]}, "100 times the lower; at most 50 times"),
        ({"youngs_modulus": [1e9, 2e9]}, "poisson_ratio and loss_factor missing"),
        ({}, "name a kind, or give youngs_modulus, poisson_ratio and loss_factor"),
    ],
)
def test_nonsense_is_refused_with_key_value_and_range(table: dict[str, object], said: str) -> None:
    with pytest.raises(ValidationError) as refused:
        Plate(**SHEET, material=table)
    assert re.search(said, str(refused.value), re.DOTALL)
