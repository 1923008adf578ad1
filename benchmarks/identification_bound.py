"""How many modes of a crowded FRF can be found at all: forty modes, damping 2.5 %, 1 % noise.

    python benchmarks/identification_bound.py [--draws 30]

Two ways of being told the true poles, so that nothing is missed but what the data do not hold. The Cramér-Rao
deviations at the truth say how many modes end more than half a half-power bandwidth, or half their damping, away,
which counts as missed in `benchmarks/identification.py`. And the order settled by BIC from the true poles says how
many more modes are not paid for.
"""

import argparse

import numpy as np
from identification import score
from numpy.typing import NDArray
from scipy.special import ndtr
from threadpoolctl import threadpool_limits

from analysis.identification.averaging import averaged
from analysis.identification.finishing import finish, settle
from analysis.identification.lines import Lines
from analysis.identification.measured import Measured
from analysis.identification.pole_search import fit
from analysis.identification.residual_terms import COMPLEX_E_F
from analysis.identification.settings import Settings
from analysis.identification.synthetic import SyntheticFrf, crowded
from analysis.identification.variable_projection import project

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


def told_the_poles(case: SyntheticFrf) -> Found:
    """Modes kept where the order is settled from the true poles."""
    measured, settings = Measured(case.frequency, case.h[None]), Settings()
    lines = measured.lines()
    found = settle(measured, lines, fit(averaged(lines), case.poles, COMPLEX_E_F), settings)
    modes, _ = finish(measured, lines, found, settings)
    kept = np.array([status == "kept" for status in modes.status])
    return modes.poles[kept], np.sqrt(np.diagonal(modes.covariance[kept], axis1=1, axis2=2))


def main() -> None:
    """Run and print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--draws", type=int, default=30)
    options = parser.parse_args()
    cases = [crowded(np.random.default_rng(1000 + n)) for n in range(options.draws)]
    modes = sum(len(case.poles) for case in cases)
    with threadpool_limits(1):
        far = sum(too_far(case) for case in cases)
        told = score(cases, told_the_poles)
    print(
        f"{modes} modes of {len(cases)} draws: {100 * far / modes:.1f} % missed by the Cramér-Rao bound alone; "
        f"with the order settled from the true poles {100 * told['missed'] / modes:.1f} %, and "
        f"{told['spurious_per_frf']:.2f} spurious per FRF"
    )


if __name__ == "__main__":
    main()
