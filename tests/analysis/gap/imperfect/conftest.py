"""Toy campaigns of plates whose resonances scatter about those of the twin."""

import numpy as np
import pytest

from analysis.gap.data.preparation import prepare
from analysis.gap.fitting.state import starting_state
from analysis.gap.search.context import SearchContext

TEMPERATURES = (2.0, 12.0, 22.0, 32.0)


@pytest.fixture(scope="session")
def scattered(toy, pool):
    """Make the context and the baseline of a campaign whose modes are off by a `frequency` and an `amplitude`."""

    def made(seed, frequency, amplitude=0.0, effects=None, left_out=()):
        rng = np.random.default_rng(1000 + seed)
        ideal = toy.Plate(2).modes()
        shifts = rng.normal(0.0, frequency, ideal[0].size), rng.normal(0.0, amplitude, ideal[1].shape)

        class Real(toy.Plate):
            def modes(self):
                f0, residue, by_nu, patterns = ideal
                return f0 * (1.0 + shifts[0]), residue * (1.0 + shifts[1]), by_nu, patterns

        frf, rig = toy.record(
            effects, plate=Real(2), temperatures=TEMPERATURES, directions=("up",), spacing=2.0, seed=seed
        )
        updated = toy.updated(frf)
        sweeps, noise = prepare(frf, rig, updated)
        context = SearchContext(toy.Plate(2, left_out), sweeps, noise, pool)
        return context, context.fit(starting_state(updated, sweeps.groups), ())

    return made
