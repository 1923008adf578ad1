"""Settings written as TOML and read back by Python's own reader."""

import json
import tomllib

import pytest

from analysis.declaration.plate import Plate
from app.files.settings_toml import toml_text


def test_what_is_written_is_read_back() -> None:
    table = {
        "format": "x/1",
        "empty": [],
        "words": 'quote " backslash \\ newline \n tab \t bell \x07 delete \x7f é 漢 𝄞',
        "plate": {"length": 0.24, "flag": True, "count": 3, "tiny": 1.2e-10, "huge": 1e300},
        "patch": [{"id": "A", "at": [0.1, 0.2]}, {"id": "B", "at": [0.3, 0.4]}],
        "effect": [{"name": "m", "parameter": {"mass": {"value": 1e-3, "unit": "kg"}}}],
        "long": [float(n) / 7.0 for n in range(100)],
        "keys": {"with space": 1, "ü": 2, "a.b": 3},
    }
    assert tomllib.loads(toml_text(table, "two\nlines")) == table


def test_none_is_left_out_and_comments_stand_first() -> None:
    assert toml_text({"a": None, "b": 1, "c": {"d": None, "e": "x"}}, "why") == '# why\n\nb = 1\n\n[c]\ne = "x"\n'


@pytest.mark.parametrize("value", [float("nan"), float("inf")])
def test_numbers_must_be_finite(value: float) -> None:
    with pytest.raises(ValueError, match="finite"):
        toml_text({"a": [1.0, value]})


def test_what_toml_cannot_hold_is_refused() -> None:
    with pytest.raises(ValueError, match="object"):
        toml_text({"a": object()})


def test_a_plate_of_any_shape_is_read_back_as_it_was() -> None:
    plate = Plate.model_validate(
        {
            "outline": {"kind": "polygon", "points": [(0.0, 0.0), (0.4, 0.0), (0.4, 0.3), (0.0, 0.2)]},
            "hole": [{"kind": "circle", "center": (0.1, 0.1), "radius": 0.02}],
            "zone": [{"kind": "rectangle", "center": (0.3, 0.1), "size": (0.1, 0.1), "thickness": 0.004}],
            "support": [
                {"kind": "elastic", "from": (0.1, 0.0), "to": (0.3, 0.0), "translation": 1e5},
                {"kind": "clamped", "hole": 1},
                {"kind": "elastic", "point": (0.2, 0.1), "stiffness": 1e4},
            ],
            "curvature": {"height": [[0.0, 0.001], [0.002]]},
            "dimensions_at": 23.0,
            "thickness": 0.003,
            "mass": 0.3,
        }
    )
    text = toml_text({"plate": plate.model_dump(mode="json")})
    assert "[[plate.support]]" in text
    assert "length_x" not in text
    again = Plate.model_validate_json(json.dumps(tomllib.loads(text)["plate"]), strict=True)
    assert again == plate
