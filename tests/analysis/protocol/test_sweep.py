from collections.abc import Callable
from typing import Any

import pytest
from pydantic import ValidationError

from analysis.protocol.sweep import SweepSettings


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"band": (1500.0, 100.0)}, "lower edge"),
        ({"taper": 0.6}, "at most 0.5 s"),
        ({"kind": "linear", "band": (20.0, 1500.0)}, "would begin at -"),
        ({"levels": (1.0, 2.0, 1.0)}, "name a level twice"),
        ({"levels": ()}, "at least 1"),
        ({"repeats": 0}, "greater than or equal to 1"),
        ({"duration": float("nan")}, "finite"),
        ({"tale": 0.4}, "Extra inputs"),
    ],
)
def test_nonsense_is_refused(
    sweep_of: Callable[..., SweepSettings], changes: dict[str, Any], message: str
) -> None:
    with pytest.raises(ValidationError, match=message):
        sweep_of(**changes)


def test_fades_lie_outside_the_band(sweep_of: Callable[..., SweepSettings]) -> None:
    for kind in ("linear", "logarithmic"):
        low, high = sweep_of(kind=kind, taper=0.05).frequency_range
        assert 0.0 < low < 100.0 < 1500.0 < high
