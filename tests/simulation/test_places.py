"""Places at which something may be attached lie all over a plate, and beside all of its edges."""

import numpy as np
import pytest

from analysis.declaration.plate import Plate
from analysis.experiment import Attachment
from simulation.reduction.places import places
from simulation.shell.points import LEAST_RADIUS, attached_discs
from simulation.state.attached import OFF_PLATE_DISTANCE

THICKNESS, SPACING, TIP = 0.004, 0.0073, 0.06
L = [(0.0, 0.0), (0.4, 0.0), (0.4, 0.14), (0.18, 0.14), (0.18, 0.3), (0.0, 0.3)]
OUTLINES = {
    "rectangle": {"length_x": 0.24, "length_y": 0.19},
    "L with a hole": {
        "outline": {"kind": "polygon", "points": L},
        "hole": [{"kind": "circle", "center": (0.3, 0.07), "radius": 0.03}],
    },
    "sliver": {"outline": {"kind": "polygon", "points": [(0.0, 0.0), (0.4, 0.0), (0.0, 0.02)]}},
}


@pytest.fixture(params=OUTLINES, ids=str)
def plate(request):
    return Plate.model_validate({"thickness": THICKNESS, "mass": 0.4, **OUTLINES[request.param]})


def test_no_part_of_the_plate_is_far_from_a_place(plate):
    found = places(plate, SPACING)
    edges = np.vstack([loop.polygon for loop in (plate.loop, *plate.hole_loops)])
    edges = edges[edges[:, 0] < 0.4 - TIP]  # further on, the sliver is too narrow for any disc
    inside = np.random.default_rng(1).uniform(*plate.bounds, (2000, 2))
    inside = inside[plate.contains(inside) & (inside[:, 0] < 0.4 - TIP)]
    for point in np.vstack([edges, inside]):
        assert np.hypot(*(found - point).T).min() < OFF_PLATE_DISTANCE * SPACING, point


def test_a_disc_fits_on_the_plate_at_every_place(plate):
    found = places(plate, SPACING)
    discs = attached_discs(plate, [Attachment(point=(float(x), float(y))) for x, y in found])
    np.testing.assert_array_equal([disc.point for disc in discs], found)  # none had to move aside
    assert min(disc.radius for disc in discs) >= LEAST_RADIUS * THICKNESS
