"""Nodes of another program's geometry on the plate: moved, turned and tilted ones come back."""

import numpy as np
import pytest
from numpy.typing import NDArray

from app.plate_frfs.new_plate import placed_nodes

SIDES = (0.3, 0.2)
X, Y = np.meshgrid(np.linspace(0.02, 0.28, 5), np.linspace(0.03, 0.17, 4))
ON_PLATE = np.stack([X.ravel(), Y.ravel(), np.zeros(X.size)], axis=1)[:-1]  # not symmetric


def turned(degrees: float) -> NDArray[np.float64]:
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])


def named(places: NDArray[np.float64]) -> dict[str, tuple[float, ...]]:
    return {str(n): tuple(place) for n, place in enumerate(places.tolist(), start=1)}


def test_nodes_on_the_plate_stay() -> None:
    found = placed_nodes(named(ON_PLATE), SIDES)
    assert found.note == ""
    assert found.places == named(ON_PLATE)


@pytest.mark.parametrize("degrees", [0.0, 12.0, -31.0, 40.0])
def test_moved_and_turned_nodes_come_back(degrees: float) -> None:
    away = ON_PLATE @ turned(degrees).T + [-0.7, 1.3, 0.02]
    found = placed_nodes(named(away), SIDES)
    np.testing.assert_allclose(list(found.places.values()), ON_PLATE, atol=2e-6)
    assert f"turned by {0.0 - degrees:.1f} degrees" in found.note
    assert "0.02 and 0.03 m from the edges" in found.note
    assert "Check that node 1 is at 0.02, 0.03 m" in found.note


def test_an_upright_drawing_is_laid_down_and_its_warp_is_said() -> None:
    warp = 2e-4 * np.sin(40 * ON_PLATE[:, 0])
    upright = np.stack([ON_PLATE[:, 0], 2.0 + warp, 0.5 + ON_PLATE[:, 1]], axis=1)
    found = placed_nodes(named(upright), SIDES)
    np.testing.assert_allclose(np.array(list(found.places.values()))[:, :2], ON_PLATE[:, :2], atol=1e-4)
    assert "off their plane by 0.0002 m" in found.note or "off their plane by 0.0001" in found.note


@pytest.mark.parametrize(
    ("places", "said"),
    [
        (1e3 * ON_PLATE, "the nodes span 260 m x 140 m, the plate 0.3 m x 0.2 m"),
        (ON_PLATE[:5] + np.array([0.0, 1.0, 0.0]), "lie on one line"),
        (ON_PLATE[:2] - 1.0, "2 nodes that are not on the plate"),
    ],
)
def test_nodes_that_cannot_be_placed_are_refused(places: NDArray[np.float64], said: str) -> None:
    with pytest.raises(ValueError, match=said):
        placed_nodes(named(places), SIDES)
