"""The small plate in every process of a trial, workers too, its models coarse and rough: a campaign in seconds."""

from functools import cache
from typing import Any

import numpy as np

BAND = (100.0, 250.0)


def shrink() -> None:
    """Put the small plate, and models that take seconds, into this process for good."""
    from dataclasses import replace

    import app.twins.campaign_twin as twins
    import simulation.reduction.effect_reduction as reduction
    from analysis.material import MaterialBox
    from app.blind_trial.plates import draw_plate
    from app.blind_trial.trial import Trial
    from simulation.meshing.recipe import MeshRecipe
    from simulation.reduction.basis_training import BasisTraining
    from simulation.reduction.reduce import reduce
    from simulation.shell.assembly import assemble_for
    from simulation.shell.fineness import Fineness

    mesh = MeshRecipe(spacing=0.08, strip=1.7, edge_strip=1.7, growth=2.0, grading=0.0, pieces=1)
    coarse = Fineness(mesh, degree=3, tolerance=0.0)
    rough = BasisTraining(tolerance=1e-3, lines=60)
    box = MaterialBox((0.9e9, 3.6e9), (0.32, 0.46), (0.02, 0.12))
    drawn = draw_plate(np.random.default_rng(3))
    kind = replace(drawn, band=BAND, patches=drawn.patches[:2])
    whole, departures = reduction.reduce_with_effects, reduction.reduce_with_departures
    if hasattr(whole, "whole"):
        return  # done in this process before

    def quick(experiment: Any, box: Any, **asked: Any) -> Any:
        return whole(experiment, box, **asked | {"fineness": coarse, "training": rough, "basis": None})

    def quick_departures(experiment: Any, box: Any, **asked: Any) -> Any:
        return departures(experiment, box, **asked | {"fineness": coarse, "basis": None})

    @cache
    def plain() -> Any:
        model = assemble_for(kind.plate, kind.patches, box, BAND, fineness=coarse)
        return reduce(model, box, BAND, training=rough)[0]

    quick.whole = whole  # type: ignore[attr-defined]
    Trial.plates = property(lambda _: (kind,))  # type: ignore[assignment, method-assign]
    reduction.reduce_with_effects = quick
    reduction.reduce_with_departures = quick_departures
    twins.cached_reduction = lambda **_: plain()
    twins.plate_basis = lambda *_: None
