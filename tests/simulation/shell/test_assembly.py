"""Assembly with the functions that answers need."""

from analysis.experiment import Patch, Plate
from analysis.material import MaterialBox
from analysis.outline import CircleOutline
from simulation.shell.assembly import assemble_for
from simulation.shell.fineness import Fineness


def test_a_round_plate_is_assembled_with_progress_from_nothing_to_all() -> None:
    """At the degree from which functions are chosen: curved triangles need a rule of order 20."""
    outline = CircleOutline(kind="circle", center=(0.3, -0.1), radius=0.06)
    plate = Plate(outline=outline, thickness=0.003, mass=0.032)
    patch = Patch(id="A1", role="actuator", center=(0.31, -0.09), diameter=0.02, thickness=5e-4)
    shares: list[float] = []
    box = MaterialBox((1e9, 3e9), (0.35, 0.43), (0.03, 0.1))
    model = assemble_for(
        plate, [patch], box, (100.0, 500.0), fineness=Fineness(tolerance=1e-7), progress=shares.append
    )
    assert shares == sorted(shares)
    assert (shares[0], shares[-1]) == (0.0, 1.0)
    assert len(shares) == 7
    assert 0 < model.size < 5 * model.shell.space.size
    assert abs(model.shell.space.dx.sum() / plate.area - 1.0) < 1e-9
