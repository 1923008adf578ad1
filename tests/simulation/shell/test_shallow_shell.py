"""Shallow shells on shear diaphragms against Navier's solution (Leissa, Vibration of Shells, 1973)."""

from dataclasses import replace
from itertools import product

import numpy as np
import pytest

from analysis.experiment import Plate
from simulation.meshing.plate_mesh import MeshRecipe
from simulation.shell.assembly import assemble
from simulation.shell.rigidity import SHEAR_FACTOR, U, V
from simulation.shell.shell_model import ShellModel
from simulation.shell.unknowns import Unknowns

A, B, H, DENSITY = 0.2, 0.15, 0.002, 1000.0
E, NU = 2e9, 0.35
HARD = ({"kind": "hard-simple", "edge": "all"},)


def on_diaphragms(curvature: dict) -> ShellModel:
    """Hard simple supports that hold the displacement along each edge, too."""
    plate = Plate(length_x=A, length_y=B, thickness=H, mass=DENSITY * A * B * H, support=HARD, curvature=curvature)
    model = assemble(plate, recipe=MeshRecipe(spacing=0.08), degree=5)
    space, border = model.space, model.space.mesh.borders["outline"]
    held = np.zeros((5, space.size), bool)
    held[U] = space.on_edges(border.edge[np.isin(border.curve, (0, 2))])
    held[V] = space.on_edges(border.edge[np.isin(border.curve, (1, 3))])
    kept = np.flatnonzero(~held.ravel()[model.unknowns.chosen])
    names = ("stiffness_1", "stiffness_2", "stiffness_patch", "mass")
    parts = {name: getattr(model, name)[kept][:, kept] for name in names}
    return replace(model, unknowns=Unknowns(space, model.unknowns.chosen[kept]), **parts)


def navier(bend_x: float, bend_y: float, count: int) -> np.ndarray:
    """Lowest frequencies, Hz, with w = W sin sin, u = U cos sin, v = V sin cos and rotations alike.

    Membrane strains u,x - w bend_x and v,y - w bend_y: Marguerre's with u + Z,x w for u. The inertia of that
    difference, a share Z,x**2 of the deflection's, is left out.
    """
    c = E * H / (1 - NU**2)
    d, s, g = c * H**2 / 12, SHEAR_FACTOR * E / (2 * (1 + NU)) * H, 0.5 * (1 - NU)
    found = []
    for m, n in product(range(1, 6), repeat=2):
        p, q = m * np.pi / A, n * np.pi / B
        strain = np.array([[-p, 0, -bend_x], [0, -q, -bend_y], [q, p, 0]])  # of U, V, W
        plane = np.array([[1, NU, 0], [NU, 1, 0], [0, 0, g]])
        stiffness = np.zeros((5, 5))
        stiffness[:3, :3] = c * strain.T @ plane @ strain
        stiffness[2:, 2:] += [
            [s * (p**2 + q**2), s * p, s * q],
            [s * p, d * (p**2 + g * q**2) + s, d * (g + NU) * p * q],
            [s * q, d * (g + NU) * p * q, d * (q**2 + g * p**2) + s],
        ]
        mass = DENSITY * H * np.diag([1, 1, 1, H**2 / 12, H**2 / 12])
        found.append(np.sqrt(np.linalg.eigvals(np.linalg.solve(mass, stiffness)).real.min()) / (2 * np.pi))
    return np.sort(found)[:count]


@pytest.mark.parametrize(
    ("curvature", "bend"),
    [
        ({"radius": 4.0}, (0.25, 0.25)),
        ({"radius_x": 3.0}, (1 / 3, 0.0)),
        ({"radius_y": -3.0}, (0.0, -1 / 3)),
        ({"radius_x": 4.0, "radius_y": -4.0}, (0.25, -0.25)),
    ],
    ids=["sphere", "cylinder", "cylinder along x, downwards", "saddle"],
)
def test_frequencies_are_naviers(curvature: dict, bend: tuple[float, float]) -> None:
    found = on_diaphragms(curvature).eigenfrequencies(E, NU, 5)
    assert found == pytest.approx(navier(*bend, 5), rel=5e-4)
    assert np.abs(found / navier(0.0, 0.0, 5) - 1).max() > 0.01


def test_a_thin_sphere_stiffens_all_modes_by_its_membrane() -> None:
    """w**2 = w0**2 + E / (rho R**2) for every mode: the equation of shallow spherical shells."""
    flat, shell = navier(0.0, 0.0, 4), navier(0.25, 0.25, 4)
    assert (2 * np.pi) ** 2 * (shell**2 - flat**2) == pytest.approx(E / DENSITY * 0.25**2, rel=0.01)


def test_tilting_a_plate_as_a_whole_strains_nothing() -> None:
    """A rigid turn about y of a shell of height Z: w = x and u = -Z leave a curved plate in peace."""
    plate = Plate(length_x=A, length_y=B, thickness=H, mass=DENSITY * A * B * H, curvature={"radius": 4.0})
    model = assemble(plate, recipe=MeshRecipe(spacing=0.08), degree=4)
    found = model.eigenfrequencies(E, NU, 7)
    assert np.all(found[:6] < 1e-2 * found[6])
