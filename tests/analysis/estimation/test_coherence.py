"""The variance read from a coherence against that of the noise put in."""

import numpy as np
import pytest

from analysis.estimation.estimators import coherence_variance

F = np.arange(1.0, 1001.0)
H = 1.0 / (200.0**2 - F**2 + 8j * F) + 1.0 / (640.0**2 - F**2 + 30j * F)


@pytest.mark.parametrize("given", [True, False])
def test_variance_from_coherence(given: bool) -> None:
    """Noise of 3 % of the response, averaged 20 times; with and without the number of averages."""
    rng = np.random.default_rng(0)
    noise = (0.03 * np.sqrt(np.mean(np.abs(H) ** 2))) ** 2
    coherence = np.abs(H) ** 2 / (np.abs(H) ** 2 + noise)
    spread = np.sqrt(noise / 20 / 2)
    h = H + spread * (rng.standard_normal(1000) + 1j * rng.standard_normal(1000))
    variance = coherence_variance(h, coherence, 20.0 if given else None)
    assert variance is not None
    assert np.median(variance) / (noise / 20) == pytest.approx(1.0, abs=0.15)


def test_a_coherence_that_says_nothing_gives_no_variance_and_one_that_cannot_be_is_refused() -> None:
    assert coherence_variance(H, np.ones(1000)) is None
    assert coherence_variance(0 * H, np.zeros(1000)) is None
    with pytest.raises(ValueError, match="0 to 1 allowed"):
        coherence_variance(H, np.full(1000, 1.5))
