"""Strains kept at points, by which spots are weighed, hold a plate's energy where its thickness changes."""

import numpy as np
import pytest

from analysis.declaration.outline import CircleOutline, CircleZone
from analysis.experiment import Patch, Plate
from simulation.meshing.plate_mesh import MeshRecipe
from simulation.reduction.effect_projection import Projector, strains
from simulation.shell.assembly import assemble
from simulation.shell.rigidity import SHEAR_FACTOR
from simulation.shell.unknowns import factorize
from simulation.state.state_matrices import FullPlate

E, NU = 2e9, 0.38


def energy(thickness: float) -> tuple[float, float]:
    """Twice the elastic energy of a disc with a thicker middle: by the strains at points, and by the matrices."""
    outline = CircleOutline(kind="circle", center=(0.2, 0.1), radius=0.1)
    zone = CircleZone(kind="circle", center=(0.22, 0.1), radius=0.05, thickness=thickness)
    plate = Plate(outline=outline, zone=(zone,), thickness=0.003, mass=0.12, boundary="clamped")
    patch = Patch(id="A1", role="actuator", center=(0.14, 0.1), diameter=0.01, thickness=5e-5)
    recipe = MeshRecipe(spacing=0.05, grading=0.0, growth=2.0)
    model = assemble(plate, [patch], recipe=recipe, degree=5)
    stiffness = model.stiffness(E, NU)
    factors, answer = factorize(stiffness), model.coupling[:, :1]
    for _ in range(8):  # towards the lowest mode, which is smooth and moves the middle
        answer = factors.solve(model.mass @ answer)
        answer /= np.abs(answer).max()
    kept = strains(Projector(FullPlate.of(model), answer))
    c1, h = E / (1.0 - NU**2), plate.thickness
    plane = c1 * np.array([[1.0, NU, 0.0], [NU, 1.0, 0.0], [0.0, 0.0, 0.5 * (1.0 - NU)]])
    rows = kept["strain"][:, :, 0]
    total = h * np.einsum("ap,ab,bp->", rows[:3], plane, rows[:3])
    total += h**3 / 12.0 * np.einsum("ap,ab,bp->", rows[3:6], plane, rows[3:6])
    total += SHEAR_FACTOR * h * 0.5 * c1 * (1.0 - NU) * (rows[6:] ** 2).sum()
    return float(kept["cell"] * total), float((answer.T @ (stiffness @ answer))[0, 0])


@pytest.mark.parametrize("thickness", [0.002, 0.003, 0.005])
def test_strains_hold_the_energy_of_the_zone(thickness: float) -> None:
    by_strains, by_matrices = energy(thickness)
    assert by_strains == pytest.approx(by_matrices, rel=0.03)
