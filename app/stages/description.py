"""Description stage: what an unknown cause acts like, with the free curves and loads of the simulation."""

from concurrent.futures import Executor
from dataclasses import replace

import numpy as np

from analysis.gap.description.described import Description
from analysis.gap.description.describing import Vocabulary, describe
from analysis.gap.report import GapReport
from analysis.progress import Progress
from app.stages.compared import Compared
from simulation.effects import free_curves

OPEN = ("partly_explained", "unknown")
"""Verdicts that leave something to be described."""


def description(
    compared: Compared, found: GapReport, executor: Executor, report: Progress
) -> tuple[Description | None, tuple[str, ...]]:
    """Describe what a comparison left unexplained.

    Parameters
    ----------
    executor : Executor
        Sweeps are linearised on it.
    report : callable
        Called with a stage's name and the share of it done.

    Returns
    -------
    description : Description or None
        None where nothing is left, or where it cannot be described.
    notes : tuple of str
        Why not.
    """
    twin = compared.twin
    if found.verdict not in OPEN:  # nothing is left
        return None, ()
    free = free_curves.free_effects(compared.experiment)
    wider = replace(compared.model, twin=replace(twin, library={**twin.library, **free}))
    exact = replace(wider, released=frozenset(twin.tolerance_cards))
    claimed = {} if found.verdict == "unknown" else dict(compared.fit.state.effects)
    start = compared.fit.state.with_effects(claimed)
    band = compared.experiment.protocol.band
    smooth = free_curves.knots(band, free_curves.SMOOTH_KNOTS)
    words = Vocabulary(
        loads={name.removeprefix("load_"): name for name in free_curves.FORMS},
        load=free_curves.LOAD,
        modulus=free_curves.MODULUS,
        gain=free_curves.GAIN,
        knots={
            free_curves.LOAD: free_curves.knots(band, free_curves.KNOTS),
            free_curves.MODULUS: smooth,
            free_curves.GAIN: smooth,
        },
    )
    try:
        return describe(wider, exact, compared.sweeps, start, words, executor, report), ()
    except np.linalg.LinAlgError:  # a ValueError, and a defect
        raise
    except ValueError as error:
        return None, (f"what is missing could not be described: {error}",)
