"""Temperatures of a plate in a room: open sensors left out, several compared."""

import math

import numpy as np
import pytest

from drivers.hammer.judged_hit import declared, in_a_room


@pytest.mark.parametrize(
    ("readings", "value", "said"),
    [
        ((21.0,), 21.0, ""),
        ((21.0, 21.4), 21.2, ""),
        ((21.0, 22.0), 21.5, "1.0 K apart"),
        ((21.0, 2300.0), 21.0, "two reads 2300 °C: open or shorted"),
        ((21.0, math.nan), 21.0, "two reads nan °C"),
        ((math.nan,), math.nan, "one reads nan °C"),
    ],
)
def test_in_a_room(readings: tuple[float, ...], value: float, said: str) -> None:
    found = in_a_room(lambda: np.array(readings), ("one", "two")[: len(readings)])()
    assert found.value == pytest.approx(value, nan_ok=True)
    assert said in found.doubt
    assert bool(said) == bool(found.doubt)


def test_declared() -> None:
    assert declared(21.0)().value == 21.0
