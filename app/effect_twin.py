"""The twin of a declared experiment with a library of effects, its operators taken from the cache."""

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

from analysis.experiment import Experiment
from analysis.plate_material import material_box
from app.files.effect_cache import cached_operators
from app.progress import Report
from app.twin import plate_basis
from simulation.effects.library import library
from simulation.twin.effect_twin import EffectTwin

if TYPE_CHECKING:
    from simulation.effects.effect import Effect


def effect_twin(experiment: Experiment, report: Report, folder: Path | None = None) -> EffectTwin:
    """Twin of a campaign's plate over its band, with the project's effects and those of a user's `folder`."""
    known: Mapping[str, Effect] = library(experiment, folder)
    box = material_box(experiment.plate.material)
    operators = cached_operators(experiment, box, report, basis=lambda: plate_basis(experiment, report))
    if not operators.offset_range:
        known = {name: effect for name, effect in known.items() if name != "sensor_offset"}
    return EffectTwin(experiment, operators, known)
