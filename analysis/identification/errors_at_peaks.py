"""How much more uncertain a pole is than errors of one size on all lines would make it.

The covariance of a fit takes the errors as known on every line, but for one factor. Few measured FRFs are so: what
a nonlinearity, a window or a low coherence adds is largest at the peaks, where poles are determined; and if a
structure warms up, every FRF has another pole. The residual shows both: errors at the peaks by their size there
(MacKinnon and White, J. Econometrics 29, 1985, HC2), the poles' scatter over the FRFs by what these errors do not
explain of it (DerSimonian and Laird, Controlled Clinical Trials 7, 1986).
"""

import numpy as np
from numpy.typing import NDArray

from analysis.identification.lines import Lines
from analysis.identification.pole_search import PoleFit

HALF_WIDTHS_USED = 10.0
"""Lines used, in half widths on either side of a pole: 99 % of what determines it."""

FEWEST_LINES = 8
"""Lines used at least."""

SHARE_IN_OTHER_FRFS = 0.1
"""Share of a mode outside the FRF that shows it best, from which its scatter over the FRFs is estimated."""


def variance_factors(lines: Lines, last: PoleFit, left: NDArray[np.complex128]) -> NDArray[np.float64]:
    """Return the factors, one at least, on the variances of log |pole| and log damping ratio.

    Parameters
    ----------
    lines : Lines
        All lines that the fit was made on, K FRFs.
    last : PoleFit
        Of J poles.
    left : (K, F) complex ndarray
        Residual of the fit.

    Returns
    -------
    (J, 2) ndarray
    """
    normalised = left / lines.deviation
    size = float(np.sqrt((np.abs(normalised) ** 2).mean()))
    factors = np.ones((len(last.poles), 2))
    for j, (pole, residue) in enumerate(zip(last.poles, last.projection.residues.T, strict=True)):
        away = np.abs(lines.s.imag - pole.imag)
        near = away <= max(HALF_WIDTHS_USED * -pole.real, np.sort(away)[min(FEWEST_LINES, len(away)) - 1])
        shape = 1.0 / (lines.s[near] - pole) / lines.deviation[:, near]
        if size > 0.0 and (np.abs(residue) > 0.0).all():
            factors[j] = _factors(
                shape, residue, lines.s[near] - pole, normalised[:, near] / size, lines.redundancy
            )
    return factors


def _factors(
    shape: NDArray[np.complex128],
    residue: NDArray[np.complex128],
    away: NDArray[np.complex128],
    r: NDArray[np.complex128],
    redundancy: float,
) -> NDArray[np.float64]:
    """Return the factors of one pole.

    With the pole the model changes by b = R/(s - pole)^2; c is what remains of it beside 1/(s - pole), which the
    residue takes up, both over the deviations. The residual r of an FRF moves its own pole by sum(c* r)/sum|c|^2;
    what r still is then gives the size of the errors.
    """
    a = shape / np.linalg.norm(shape, axis=1, keepdims=True)
    c = residue[:, None] * shape / away
    c -= a * (a.conj() * c).sum(axis=1, keepdims=True)
    weight = np.abs(c) ** 2
    own = weight.sum(axis=1)  # inverse variance of the pole in each FRF
    moved = (c.conj() * r).sum(axis=1) / own
    moved -= (own * moved).sum() / own.sum()
    free = np.maximum(1.0 - np.abs(a) ** 2 - weight / own[:, None], 0.1)  # a line draws the model to itself
    within = max(1.0, float((weight * np.abs(r - c * moved[:, None]) ** 2 / free).sum() / own.sum()))
    factors = np.full(2, within)
    u = np.abs(residue) ** 2 / (np.abs(residue) ** 2).sum()  # not own: the fit is drawn to FRFs that it describes
    several = 1.0 - float((u**2).sum())
    if several > SHARE_IN_OTHER_FRFS:
        moved -= (u * moved).sum()
        expected = float((u * (1.0 - u) * 0.5 * within * redundancy / own).sum())
        scatter = np.array([(u * moved.imag**2).sum(), (u * moved.real**2).sum()])
        between = np.maximum(scatter - expected, 0.0) / several
        factors += between * 2.0 * float((own**2).sum() / own.sum()) / redundancy
    return factors
