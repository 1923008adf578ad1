import math

import pytest

from app.summaries.numbers import with_sigma


@pytest.mark.parametrize(
    ("value", "sigma", "unit", "words"),
    [
        (1.899, 0.0013, "GPa", "1.8990 ± 0.0013 GPa"),
        (7.4, 0.00028, "%", "7.40000 ± 0.00028 %"),
        (0.38208, 5.7e-5, "1", "0.382080 ± 0.000057"),
        (147.3, 0.27, "Hz", "147.30 ± 0.27 Hz"),
        (7.997e-4, 1.2e-6, "kg", "(7.997 ± 0.012)e-4 kg"),
        (3.0, 0.0, "1", "3"),
        (3.0, math.nan, "V", "3 V"),
        (3.0, math.inf, "V", "3 V"),
    ],
)
def test_a_value_has_the_digits_that_its_sigma_speaks_about(
    value: float, sigma: float, unit: str, words: str
) -> None:
    assert with_sigma(value, sigma, unit) == words
