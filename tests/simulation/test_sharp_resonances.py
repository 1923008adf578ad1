"""Metals: a reduced plate keeps its promise on the flanks of resonances a fraction of a hertz wide."""

import numpy as np
import pytest

from analysis.declaration.plate_material import PlateMaterial, material_box
from analysis.experiment import Patch, Plate
from simulation.meshing.plate_mesh import MeshRecipe
from simulation.reduction.damped_modes import resonance_lines, root_mean_square
from simulation.reduction.vectors.reduce import reduce
from simulation.shell.assembly import assemble

BAND = (150.0, 900.0)


@pytest.mark.parametrize(("kind", "modulus", "ratio", "density"), [("aluminium", 70e9, 0.33, 2700.0)])
def test_transfers_hold_on_the_flanks(
    patches: list[Patch], coarse_mesh: MeshRecipe, kind: str, modulus: float, ratio: float, density: float
) -> None:
    plate = Plate(length_x=0.24, length_y=0.19, thickness=0.003, mass=density * 0.24 * 0.19 * 0.003)
    model = assemble(plate, patches, recipe=coarse_mesh, degree=4)
    box = material_box(PlateMaterial(kind=kind))  # type: ignore[arg-type]
    reduced = reduce(model, box, BAND)[0]
    assert reduced.error <= 1e-4
    natural = model.eigenfrequencies(modulus, ratio, 20)
    natural = natural[(natural > BAND[0]) & (natural < BAND[1])]
    assert natural.size >= 4
    loss = 1e-3
    lines = resonance_lines(natural, loss, np.linspace(*BAND, 400))
    rms = root_mean_square(reduced.compliance(modulus, ratio, loss, lines), lines)[..., None]
    flanks = natural * (1.0 + 0.5 * loss)
    wrong = reduced.compliance(modulus, ratio, loss, flanks) - model.compliance(modulus, ratio, loss, flanks)
    assert (np.abs(wrong) / rms).max() <= 2e-4
