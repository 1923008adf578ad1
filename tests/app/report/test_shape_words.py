"""The words under a test's shapes name nodes without a place, and how many of the shapes are drawn."""

from types import SimpleNamespace

import numpy as np
import pytest

from app.report.modal_test import _shape_words


@pytest.mark.parametrize(
    ("missing", "count", "said"),
    [
        ((), 12, "component 1; over the places of the nodes."),
        ((), 13, "nodes. The first 12 of 13 shapes; flexura view shows all."),
        ((6,), 3, "by node: the places of 1 of 16 nodes are not known (6)."),
        ((1, 2, 4, 5), 3, "by node: the places of 4 of 16 nodes are not known (1, 2, 4, ...)."),
    ],
)
def test_what_is_not_there_is_told(missing, count, said):
    frfs = SimpleNamespace(points={n: (0.0, 0.0, 0.0) for n in range(1, 17) if n not in missing})
    shapes = SimpleNamespace(places=[f"{n}:+z" for n in range(1, 17)], pole=np.arange(count))
    assert _shape_words(frfs, shapes).endswith(said)
