"""One gain over all sweeps: the normal equations are an arrow, solved by eliminating its blocks.

Each sweep has its own (log E, nu, log eta); log gain is common. With A_t the 3 x 3 block of sweep t, c_t its
coupling to the gain and d_t the gain's own term, the gain's step is
(sum d - sum c'A^-1 c)^-1 (sum g - sum c'A^-1 b) and each block follows from it.
"""

from collections.abc import Sequence
from concurrent.futures import Executor

import numpy as np
from numpy.typing import NDArray

from analysis.updating.model import TransferModel
from analysis.updating.normal_equations import NormalEquations, SweepData, moved, normal_equations
from analysis.updating.sweep_fit import SETTLED

ROUNDS = 4


def fit_common_gain(
    model: TransferModel, data: Sequence[SweepData], points: Sequence[NormalEquations], executor: Executor
) -> tuple[list[NormalEquations], float]:
    """Tie the gains of fitted sweeps into one and settle all materials with it.

    Returns the sweeps' normal equations at the solution and the standard deviation of log gain.
    """
    information = np.array([1.0 / np.linalg.inv(p.matrix)[3, 3] for p in points])
    log_gain = float((information * np.log([p.gain for p in points])).sum() / information.sum())
    # each material follows its gain to first order before anything is evaluated again
    materials = [model.box.clip(moved(p.material, p.following(log_gain - float(np.log(p.gain))))) for p in points]
    for _ in range(ROUNDS):
        gain = float(np.exp(log_gain))
        jobs = [executor.submit(normal_equations, model, d, m, gain) for d, m in zip(data, materials, strict=True)]
        points = [job.result() for job in jobs]
        steps, gain_step, sigma = arrow_step(points)
        promised = sum(float(p.gradient[:3] @ s) for p, s in zip(points, steps, strict=True))
        if promised < SETTLED * sum(p.excess for p in points):
            break
        log_gain += gain_step
        materials = [model.box.clip(moved(p.material, s)) for p, s in zip(points, steps, strict=True)]
    return list(points), sigma


def arrow_step(points: Sequence[NormalEquations]) -> tuple[list[NDArray[np.float64]], float, float]:
    """Gauss-Newton step of every material, that of log gain, and the latter's standard deviation."""
    curvature = gradient = 0.0
    for p in points:
        eliminated = np.linalg.solve(p.matrix[:3, :3], np.stack([p.matrix[:3, 3], p.gradient[:3]], axis=1))
        curvature += float(p.matrix[3, 3] - p.matrix[3, :3] @ eliminated[:, 0])
        gradient += float(p.gradient[3] - p.matrix[3, :3] @ eliminated[:, 1])
    gain_step = gradient / curvature
    return [p.following(gain_step) for p in points], gain_step, float(curvature**-0.5)
