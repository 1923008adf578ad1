"""Functions chosen by solutions, against all functions."""

from itertools import pairwise

import numpy as np
import pytest

from analysis.channel import Footprint
from analysis.experiment import Patch, Plate
from analysis.material import MaterialBox
from simulation.meshing.plate_mesh import MeshRecipe
from simulation.shell.assembly import assemble, assemble_for
from simulation.shell.fineness import Fineness
from simulation.shell.shell_model import ShellModel
from simulation.shell.unknowns import factorize

PLATE = Plate(length_x=0.12, length_y=0.1, thickness=0.003, mass=0.0342)
PATCHES = [
    Patch(id="A", role="actuator", center=(0.035, 0.03), size=(0.018, 0.014), thickness=0.0005),
    Patch(id="S", role="sensor", center=(0.09, 0.06), size=(0.016, 0.016), thickness=0.0005, side="bottom"),
]
BOX, BAND = MaterialBox((1.5e9, 3e9), (0.34, 0.42), (0.03, 0.1)), (100.0, 1000.0)
MESH = MeshRecipe(spacing=0.08, growth=2.0, grading=0.0, pieces=1)
DEGREE = 5
MATERIAL, LINES = (2.1e9, 0.37, 0.06), [230.0, 905.0]
FORCE = Footprint((0.1, 0.02), 0.003)


def chosen(tolerance: float, footprints: tuple[Footprint, ...] = ()) -> ShellModel:
    return assemble_for(
        PLATE, PATCHES, BOX, BAND, footprints=footprints, fineness=Fineness(MESH, DEGREE, tolerance)
    )


@pytest.fixture(scope="module")
def everything() -> ShellModel:
    return assemble(PLATE, PATCHES, recipe=MESH, degree=DEGREE)


@pytest.fixture(scope="module")
def ladder() -> list[ShellModel]:
    return [chosen(tolerance) for tolerance in (1e-5, 1e-6, 1e-7)]


def test_errors_fall_with_the_tolerance(everything: ShellModel, ladder: list[ShellModel]) -> None:
    exact = everything.compliance(*MATERIAL, LINES)
    rms = np.sqrt(np.mean(np.abs(exact) ** 2, axis=-1))
    errors = [(np.abs(model.compliance(*MATERIAL, LINES) - exact).max(axis=-1) / rms).max() for model in ladder]
    assert all(after < 0.5 * before for before, after in pairwise(errors))
    assert errors[-1] < 5e-3
    sizes = [model.size for model in (*ladder, everything)]
    assert sizes == sorted(sizes)
    assert ladder[-1].size < 0.6 * everything.size


def test_the_energy_dropped_is_told_and_falls(ladder: list[ShellModel]) -> None:
    dropped = [model.dropped for model in ladder]
    assert all(0.0 < after < before for before, after in pairwise(dropped))
    assert all(model.dropped > t for model, t in zip(ladder, (1e-5, 1e-6, 1e-7), strict=True))


def test_chosen_matrices_are_parts_of_those_of_all_functions(
    everything: ShellModel, ladder: list[ShellModel]
) -> None:
    few = ladder[1]
    place = everything.unknowns.number.ravel()[few.unknowns.chosen]
    assert (place >= 0).all()
    for name in ("stiffness_1", "stiffness_patch", "mass"):
        whole, part = getattr(everything, name)[place][:, place], getattr(few, name)
        assert abs(whole - part).max() < 1e-12 * abs(part).max()
    np.testing.assert_allclose(few.coupling, everything.coupling[place])


def test_without_tolerance_all_functions_stay(everything: ShellModel) -> None:
    model = chosen(0.0)
    assert (model.size, model.dropped) == (everything.size, 0.0)


def test_functions_of_points_stay_and_rigid_motions_with_them(ladder: list[ShellModel]) -> None:
    model = ladder[0]
    points = len(model.space.mesh.points)
    assert (model.unknowns.number[:, :points] >= 0).all()
    found = model.eigenfrequencies(2e9, 0.38, 7)
    assert (found[:6] < 1e-3 * found[6]).all()


def test_a_force_at_a_point_asks_for_functions_around_it(everything: ShellModel, ladder: list[ShellModel]) -> None:
    """Its driving point compliance is farther off with functions chosen for patches alone."""
    aware = chosen(1e-6, (FORCE,))

    def compliance(model: ShellModel) -> complex:
        row = model.footprint_rows([FORCE])[0]
        stiffness = model.stiffness(*MATERIAL) - (2 * np.pi * 905.0) ** 2 * model.mass
        return complex(row @ factorize(stiffness).solve(row.astype(complex)))

    exact = compliance(everything)
    with_it, without = (abs(compliance(model) - exact) / abs(exact) for model in (aware, ladder[1]))
    assert with_it < 0.8 * without
    assert aware.size > ladder[1].size


def test_a_clamped_plate_keeps_no_held_function() -> None:
    plate = PLATE.model_copy(update={"boundary": "clamped"})
    model = assemble_for(plate, PATCHES, BOX, BAND, fineness=Fineness(MESH, 4, 1e-6))
    assert not (model.unknowns.number >= 0)[model.shell.held].any()
    found, free = (
        m.eigenfrequencies(2e9, 0.38, 1)[0] for m in (model, assemble(plate, PATCHES, recipe=MESH, degree=4))
    )
    assert found == pytest.approx(free, rel=3e-3)


def test_discs_of_effects_select_functions_but_are_not_counted_as_error() -> None:
    """The force on a disc within a large cell has energy in functions of any degree, unlike that of patches."""
    plate, small = Plate(length_x=0.3, length_y=0.25, thickness=0.003, mass=0.21), Footprint((0.21, 0.17), 0.002)
    without, attached, acting = (
        assemble_for(plate, PATCHES, BOX, BAND, **discs)
        for discs in ({}, {"attached": [small]}, {"footprints": [small]})
    )
    assert np.array_equal(attached.unknowns.kept, acting.unknowns.kept)
    assert without.size < attached.size
    assert attached.dropped < 1.01 * without.dropped < 0.95 * acting.dropped
