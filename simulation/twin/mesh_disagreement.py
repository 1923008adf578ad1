"""How far two computations of one plate are apart that share neither mesh nor functions nor reduction."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from analysis.gap.model import SweepPoint
from analysis.local_laws import LocalLaws
from simulation.twin.effect_twin import EffectTwin
from simulation.twin.plain_twin import Twin


def mesh_disagreement(
    plain: Twin,
    with_effects: EffectTwin,
    materials: Sequence[tuple[float, float, float]],
    frequency: NDArray[np.float64],
) -> float:
    """Largest rms difference of both transfers over all sensors and lines, no effect on, as a share of rms|H|.

    The twin of model updating lies on a thinned mesh, the twin with effects on one of higher degree: the
    difference is about the error of the coarser of both, and so bounds that of the finer.

    Parameters
    ----------
    plain : Twin
    with_effects : EffectTwin
    materials : sequence of (E [Pa], nu, eta)
        Where they are compared.
    frequency : (F,) ndarray, Hz
    """
    worst = 0.0
    for material in materials:
        laws = LocalLaws.of_material(*material)
        one = plain.frf(*material, frequency)
        other = with_effects.frf(SweepPoint(laws.reference, 0.0, 1.0), laws, {}, frequency)
        worst = max(worst, float(np.linalg.norm(other - one) / np.linalg.norm(one)))
    return worst
