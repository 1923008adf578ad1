"""Notes on filters: what is advised can still be done."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from app.terminal.focusing import notes


def lossy(design: str) -> tuple[Any, Any]:
    """Return filters whose taps lose 0.3 of contrast on the worst line."""
    panel = SimpleNamespace(
        filters=SimpleNamespace(reference_temperature=20.0, design=design), limits=np.array([np.inf])
    )
    focusing = SimpleNamespace(
        reference_temperature=20.0,
        rank_changes=np.zeros(0),
        regularisation="tikhonov",
        temperature=np.array([20.0]),
        uncut=SimpleNamespace(contrast=np.array([[0.8, 0.7]])),
        direct=SimpleNamespace(contrast=np.array([[0.8, 0.4]])),
        bank=SimpleNamespace(taps=np.zeros((1, 1, 8))),
    )
    return panel, focusing


@pytest.mark.parametrize(
    ("design", "advice"),
    [("field", "; more taps or another delay keep more"), ("inverse-fft", ", or --design field keep more")],
)
def test_taps_that_lose_contrast(design: str, advice: str) -> None:
    (said,) = notes(*lossy(design))
    assert said.startswith("the taps lose 0.30 of contrast on the worst line at 20 °C")
    assert said.endswith(advice)
