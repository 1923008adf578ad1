"""One sweep and one value are said as one."""

import numpy as np
import pytest

from app.summaries.numbers import span, sweeps


@pytest.mark.parametrize(("count", "said"), [(0, "0 sweeps"), (1, "1 sweep"), (16, "16 sweeps")])
def test_numbers_of_sweeps(count: int, said: str) -> None:
    assert sweeps(count) == said


def test_a_range_that_reads_alike_at_both_ends_is_one_value() -> None:
    assert span(np.array([60.0, -0.01, 20.0]), "z.1f") == "0.0 to 60.0"
    assert span([20.0], "z.1f") == "20.0"
    assert span([20.01, 20.04], "z.1f") == "20.0"
    assert span([7, 9], ".0f") == "7 to 9"
