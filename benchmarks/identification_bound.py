"""How many modes of an FRF can be found at all, for `identification.py --cases` to print.

Ways of being told the true poles, so that nothing is missed but what the data do not hold. The Cramér-Rao
deviations at the truth say how many modes end more than half a half-power bandwidth, or half their damping, away,
which counts as missed. Least squares from all true poles, with no order to find, says the same where deviations
are too large for a linear bound. And the order settled by BIC from the true poles says how many more modes are not
paid for.
"""

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtr

from analysis.identification.averaging import averaged
from analysis.identification.finishing import finish, settle
from analysis.identification.lines import Lines
from analysis.identification.measured import Measured
from analysis.identification.pole_residue import COMPLEX_E_F, REAL_E_F
from analysis.identification.pole_search import fit, project
from analysis.identification.settings import Settings
from tests.synthetic_frf import SyntheticFrf

Found = tuple[NDArray[np.complex128], NDArray[np.float64] | None]


def too_far(case: SyntheticFrf) -> float:
    """Modes expected to end too far from the truth, from their Cramér-Rao deviations."""
    lines = Lines(case.frequency, case.clean[None], np.full((1, len(case.h)), case.deviation))
    # the deviation is of a complex number: half its variance for each part
    bound = 0.5 * np.linalg.inv(project(lines, case.poles, COMPLEX_E_F).hessian)
    spread = np.sqrt(np.diag(bound)).reshape(-1, 2)
    zeta = -case.poles.real / np.abs(case.poles)
    near = (2.0 * ndtr(zeta / spread[:, 0]) - 1.0) * (2.0 * ndtr(0.5 / spread[:, 1]) - 1.0)
    return float((1.0 - near).sum())


def told_all(case: SyntheticFrf) -> Found:
    """Least squares from all true poles, none dropped and none added."""
    lines = averaged(Measured(case.frequency, case.h[None], np.full((1, len(case.h)), case.deviation**2)).lines())
    return fit(lines, case.poles, REAL_E_F, tolerance=1e-9, max_iterations=200).poles, None


def told_the_poles(case: SyntheticFrf) -> Found:
    """Modes kept where the order is settled from the true poles."""
    measured, settings = Measured(case.frequency, case.h[None]), Settings()
    lines = measured.lines()
    found = settle(measured, lines, fit(averaged(lines), case.poles, COMPLEX_E_F), settings)
    modes, _ = finish(measured, lines, found, settings)
    kept = np.array([status == "kept" for status in modes.status])
    return modes.poles[kept], np.sqrt(np.diagonal(modes.covariance[kept], axis1=1, axis2=2))
