"""Supports along edges: which functions they hold, and the energy of their springs against closed forms."""

import numpy as np
import pytest
from scipy.sparse.linalg import spsolve

from analysis.experiment import Plate
from simulation.shell.edges import held_functions, penalty, spring_blocks, supported
from simulation.shell.rigidity import THX, THY, U, V, W
from simulation.shell.shell_plate import ShellPlate
from simulation.shell.unknowns import Unknowns

RECTANGLE = {"length_x": 0.24, "length_y": 0.19, "thickness": 0.003, "mass": 0.13}
RADIUS = 0.1
DISC = {
    "outline": {"kind": "circle", "center": (0.1, 0.1), "radius": RADIUS},
    "thickness": 0.003,
    "mass": 0.0942,
}


def shell(declared, *supports):
    plate = Plate.model_validate({**declared, "support": supports})
    return plate, ShellPlate.of(plate, degree=4).space


def coefficients(space, field):
    return spsolve(space.product("0", "0").tocsc(), space.moments("0", field(space.points)))


def energy(plate, space, fields, *, damping=False):
    """Twice the energy of the springs for given fields, J (or power of dashpots)."""
    unknowns = Unknowns.of(space, np.ones((5, space.size), bool))
    x = unknowns.vector({field: coefficients(space, value) for field, value in fields.items()})
    return x @ unknowns.lines(spring_blocks(space, plate, damping=damping)) @ x


@pytest.mark.parametrize(
    ("kind", "held"),
    [
        ("free", ()),
        ("soft-simple", (W,)),
        ("hard-simple", (W, THY)),
        ("clamped", (U, V, W, THX, THY)),
    ],
)
def test_supports_hold_what_they_say(kind, held):
    plate, space = shell(RECTANGLE, {"kind": kind, "edge": "left"})
    found = held_functions(space, plate)
    along = np.stack([np.zeros(400), np.linspace(0.0, 0.19, 400)], axis=1)
    rows = space.values(along)
    free = np.random.default_rng(1).standard_normal(space.size)
    for field in range(5):
        assert found[field].any() == (field in held)
        trace = rows @ np.where(found[field], 0.0, free)
        assert np.abs(trace).max() == pytest.approx(0.0, abs=1e-12) if field in held else np.abs(trace).max() > 0.1
    # Only functions that do not vanish on the edge are held.
    if held:
        assert (np.abs(rows[:, found[W]]).max(axis=0).toarray() > 1e-6).all()


def test_a_support_of_a_part_ends_where_it_says():
    plate, space = shell(RECTANGLE, {"kind": "clamped", "from": (0.05, 0.0), "to": (0.11, 0.0)})
    (one,) = plate.supported_edges()
    ends = space.mesh.points[space.mesh.edges[supported(space, one)]]
    assert ends[..., 1] == pytest.approx(0.0, abs=1e-12)
    assert (ends[..., 0].min(), ends[..., 0].max()) == pytest.approx((0.05, 0.11))
    assert np.abs(ends[:, 1, 0] - ends[:, 0, 0]).sum() == pytest.approx(0.06)


def test_a_later_support_takes_back_an_earlier_one():
    plate, space = shell(RECTANGLE, {"kind": "clamped", "edge": "all"}, {"kind": "free", "edge": "right"})
    held = held_functions(space, plate)[W]
    middle = space.values(np.array([[0.24, 0.1], [0.0, 0.1]]))
    assert np.abs(middle[0, held].toarray()).max(initial=0.0) < 1e-9
    assert np.abs(middle[1, ~held].toarray()).max(initial=0.0) < 1e-9


def test_springs_against_the_deflection_of_an_edge():
    plate, space = shell(RECTANGLE, {"kind": "elastic", "edge": "top", "translation": 5e3, "damping": 70.0})
    fields = {W: lambda p: p[:, 0] ** 2}
    assert energy(plate, space, fields) == pytest.approx(5e3 * 0.24**5 / 5.0)
    assert energy(plate, space, fields, damping=True) == pytest.approx(70.0 * 0.24**5 / 5.0)


def test_springs_against_the_rotation_about_an_edge():
    plate, space = shell(RECTANGLE, {"kind": "elastic", "edge": "left", "rotation": 30.0, "rotation_damping": 2.0})
    fields = {THX: lambda p: p[:, 1], THY: lambda p: 5.0 + 0.0 * p[:, 0]}
    assert energy(plate, space, fields) == pytest.approx(30.0 * 0.19**3 / 3.0)
    assert energy(plate, space, fields, damping=True) == pytest.approx(2.0 * 0.19**3 / 3.0)


def test_springs_along_a_circle():
    """Springs k feel w; springs c the rotation about the edge, n_x thx + n_y thy."""
    plate, space = shell(DISC, {"kind": "elastic", "edge": "all", "translation": 1e4, "rotation": 20.0})
    assert energy(plate, space, {W: lambda p: p[:, 0] - 0.1}) == pytest.approx(1e4 * np.pi * RADIUS**3, rel=1e-8)
    only_x = energy(plate, space, {THX: lambda p: 1.0 + 0.0 * p[:, 0]})
    assert only_x == pytest.approx(20.0 * np.pi * RADIUS, rel=1e-8)
    radial = {THX: lambda p: p[:, 0] - 0.1, THY: lambda p: p[:, 1] - 0.1}
    assert energy(plate, space, radial) == pytest.approx(20.0 * 2.0 * np.pi * RADIUS**3, rel=1e-8)
    around = {THX: lambda p: 0.1 - p[:, 1], THY: lambda p: p[:, 0] - 0.1}
    assert energy(plate, space, around) == pytest.approx(0.0, abs=1e-9)


def test_a_hard_support_of_a_circle_resists_the_rotation_along_it_alone():
    plate, space = shell(DISC, {"kind": "hard-simple", "edge": "all"})
    assert held_functions(space, plate)[W].any()
    assert not held_functions(space, plate)[THX].any()
    radial = {THX: lambda p: p[:, 0] - 0.1, THY: lambda p: p[:, 1] - 0.1}
    around = {THX: lambda p: 0.1 - p[:, 1], THY: lambda p: p[:, 0] - 0.1}
    wanted = penalty(plate) * 2.0 * np.pi * RADIUS**3
    assert energy(plate, space, around) == pytest.approx(wanted, rel=1e-8)
    assert energy(plate, space, radial) == pytest.approx(0.0, abs=1e-9 * wanted)
