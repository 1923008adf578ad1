"""The table of estimates: which sweep is whose, and what is no estimate."""

import numpy as np

from analysis.material import Material, MaterialSigma
from analysis.updated import Updated
from app.summaries.update import tables_of


def updated(sigma: float) -> Updated:
    ones, e = np.ones(2), np.full(2, 2e9)
    return Updated(
        temperature=np.array([20.0, 20.0]),
        material=Material(e, 0.4 * ones, 0.05 * ones),
        sigma=MaterialSigma(sigma * e, 1e-3 * ones, 0.05 * sigma * ones),
        correlation=np.tile(np.eye(4), (2, 1, 1)),
        gain=1.0,
        sigma_gain=1e-3,
        misfit=0.01 * ones,
        misfit_start=0.01 * ones,
        noise_floor=0.01 * ones,
        chi2_per_dof=ones,
        settled=ones.astype(bool),
    )


def test_of_several_inputs_the_table_says_which_drove_a_sweep() -> None:
    """Two drives at one temperature were the same line twice."""
    (alone,) = tables_of(updated(0.01))
    (table,) = tables_of(updated(0.01), ("D1", "D2"))
    assert [row[0] for row in table.rows] == ["20.00 D1", "20.00 D2"]
    assert [row[1:] for row in table.rows] == [row[1:] for row in alone.rows]


def test_a_standard_deviation_of_what_is_no_estimate_does_not_cut_the_others() -> None:
    (table,) = tables_of(updated(1.1e4))
    assert table.rows[0][2] == table.rows[0][6] == "1e+06"
    assert tables_of(updated(0.012))[0].rows[0][2] == "1.2000"
