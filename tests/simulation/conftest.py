"""The paper's plate with the two patches of the recorded campaigns, and its twins."""

from collections.abc import Callable, Sequence

import pytest

from analysis.experiment import Acquisition, Attachment, Experiment, OvenDeclaration, Patch, Plate, Protocol
from analysis.material import MaterialBox
from simulation.meshing.plate_mesh import MeshRecipe
from simulation.reduction.reduced_model import ReducedModel
from simulation.reduction.vectors.reduce import reduce
from simulation.shell.assembly import assemble, assemble_for
from simulation.shell.fineness import Fineness
from simulation.shell.shell_model import ShellModel

COARSE = MeshRecipe(spacing=0.08, strip=1.5, edge_strip=1.5, growth=2.0, grading=0.0, pieces=1)
"""Few cells: for what holds on any mesh."""
BOX, BAND = MaterialBox((0.8e9, 4e9), (0.30, 0.48), (0.02, 0.12)), (100.0, 1500.0)


def patch(name: str, role: str, center: tuple[float, float], side: str = "top") -> Patch:
    return Patch(id=name, role=role, center=center, size=(0.02, 0.02), thickness=0.0005, side=side)


@pytest.fixture(scope="session")
def plate() -> Plate:
    return Plate(length_x=0.24, length_y=0.19, thickness=0.003, mass=0.12996)


@pytest.fixture(scope="session")
def patches() -> list[Patch]:
    return [patch("A1", "actuator", (0.2, 0.155)), patch("S1", "sensor", (0.04, 0.035))]


@pytest.fixture(scope="session")
def declare(plate: Plate) -> Callable[..., Experiment]:
    """Declare an experiment in which every effect can be seen: strings, a cable, two ramps, two levels."""

    def declared(
        patches: Sequence[Patch],
        band: tuple[float, float],
        strings: Sequence[tuple[float, float]] = ((0.03, 0.187),),
    ) -> Experiment:
        return Experiment(
            title="every effect",
            plate=plate,
            patch=tuple(patches),
            string=tuple(Attachment(point=point) for point in strings),
            cable=(Attachment(point=(0.058, 0.03)),),
            acquisition=Acquisition(
                module="NI-9234", sample_rate=8e3, input_resistance=305e3, input_capacitance=1.2e-10
            ),
            protocol=Protocol(
                sweep="linear",
                band=band,
                sweep_duration=2.0,
                tail=0.4,
                repeats=3,
                ramp_rate=0.4,
                temperatures=(20.0, 40.0),
                directions=("up", "down"),
                levels=(1.0, 2.0),
            ),
            oven=OvenDeclaration(room_temperature=22.0),
        )

    return declared


@pytest.fixture(scope="session")
def nominal_model(plate: Plate, patches: list[Patch]) -> ShellModel:
    return assemble_for(plate, patches, BOX, BAND, fineness=Fineness(degree=7, tolerance=1e-8))


@pytest.fixture(scope="session")
def nominal(nominal_model: ShellModel) -> ReducedModel:
    """Reduce as for the recorded campaigns: over the whole box and band."""
    return reduce(nominal_model, BOX, BAND)[0]


@pytest.fixture(scope="session")
def three_patches(patches: list[Patch]) -> list[Patch]:
    return [*patches, patch("S2", "sensor", (0.06, 0.14), side="bottom")]


@pytest.fixture(scope="session")
def coarse_mesh() -> MeshRecipe:
    return COARSE


@pytest.fixture(scope="session")
def coarse_model(plate: Plate, three_patches: list[Patch]) -> ShellModel:
    """Few unknowns: for what holds on any mesh."""
    return assemble(plate, three_patches, recipe=COARSE, degree=3)


@pytest.fixture(scope="session")
def coarse(coarse_model: ShellModel) -> ReducedModel:
    """Reduced over a small box and band, with the field at a few points."""
    points = [(0.0, 0.0), (0.24, 0.19), (0.11, 0.07), (0.03, 0.15)]
    box = MaterialBox((1.5e9, 3e9), (0.34, 0.42), (0.03, 0.1))
    return reduce(coarse_model, box, (100.0, 700.0), points=points)[0]
