"""Normal equations of a sweep, and a step along a curve."""

import numpy as np

from analysis.gap.fitting.normal_equations import WhitenedSweep


def test_a_step_of_collinear_unknowns_is_taken_along_its_curve():
    """The model is H exp(a) / (1 + b): only the sum of logarithms is told, and a little more by a second line.

    A Gauss-Newton step along a = b is far too long for first order; the residual at its end tells the curve.
    """
    lines = np.linspace(0.0, 1.0, 40)[None]
    response, little = 1000.0 * np.exp(1j * lines), 1.0 + 0.02 * lines

    def model(a, b):
        return response * np.exp(a) / (1.0 + b * little)

    def at(a, b):
        here = model(a, b)
        columns = np.array([here, -here * little / (1.0 + b * little), model(0.25, 0.28) - here])
        return WhitenedSweep(columns, here).equations(keep=True)

    begun = at(0.0, 0.0)
    step = np.linalg.solve(begun.matrix, begun.gradient)
    ended = at(*step)
    assert ended.chi2 > 0.5 * begun.chi2
    bent = begun.bent(step, ended.residual)
    assert at(*np.linalg.solve(bent.matrix, bent.gradient)).chi2 < 0.1 * ended.chi2
