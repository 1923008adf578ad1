"""Comparisons of made-up solvers whose errors are known."""

from dataclasses import replace

import numpy as np
import pytest

from tests.simulation.verification.case import (
    NotCovered,
    compare,
    compare_all,
    convergence_order,
    left_out,
    modes,
    percent,
    section,
    summary,
)
from tests.simulation.verification.cases import PUBLISHED

FV12 = next(case for case in PUBLISHED if case.name == "fv12")
FV15 = next(case for case in PUBLISHED if case.name == "fv15")


def converging(order, coarsest=1e-3, limit=0.0):
    """Return a solver whose error starts at `coarsest` and falls with `order` towards `limit`."""

    def frequencies(case, refinement):
        error = limit + coarsest * 2.0 ** (-order * refinement)
        return np.concatenate([np.zeros(case.rigid_motions), case.reference * (1 + error), [1e4]])

    return frequencies


@pytest.mark.parametrize("order", [2.0, 4.5])
def test_error_and_order_are_those_of_the_solver(order):
    done = compare(FV12, converging(order))
    assert done.frequency.shape == (3, 6)
    assert done.order == pytest.approx(order)
    assert done.worst == pytest.approx(1e-3 * 4.0**-order)
    for row in done.rows:
        assert row.order == pytest.approx(order)
        assert row.error == pytest.approx(1e-3 * 4.0**-order)
        assert row.computed == pytest.approx(row.reference * (1 + row.error))


def test_order_does_not_depend_on_an_offset_of_the_reference():
    assert compare(FV12, converging(4.0, limit=2e-4)).order == pytest.approx(4.0)


@pytest.mark.parametrize("values", [np.ones((3, 2, 4)), np.ones((2, 2, 4)) * [[[1.0]], [[2.0]]]])
def test_no_order_is_told_from_rounding_or_two_meshes(values):
    assert np.isnan(convergence_order(values)).all()


def test_a_case_passes_within_its_tolerance_only():
    assert compare(FV12, converging(4.0, coarsest=1e-3)).passed
    assert not compare(FV12, converging(4.0, coarsest=0.1)).passed


def test_too_few_frequencies_are_refused():
    with pytest.raises(ValueError, match="fv12: 5 frequencies; needed are 3 rigid and 6 others"):
        compare(FV12, lambda case, _: case.reference[:5])


def test_a_rigid_motion_that_is_none_is_refused():
    with pytest.raises(ValueError, match=r"fv12: rigid motion 3 has 0\.5 Hz"):
        compare(FV12, lambda case, _: np.concatenate([[0.0, 0.0, 0.5], case.reference]))


def test_cases_that_are_not_covered_are_named_with_the_reason():
    def frequencies(case, refinement):
        if case.name == "fv15":
            raise NotCovered("edges are oblique")
        return converging(4.0)(case, refinement)

    done, missing = compare_all([FV15, FV12], frequencies)
    assert [comparison.case.name for comparison in done] == ["fv12"]
    assert left_out([FV15, FV12], missing) == f"Not computed (edges are oblique):\n\n- {FV15.title}\n"


def test_summary_has_a_row_for_every_case_with_its_verdict():
    good, bad = compare(FV12, converging(4.0)), compare(FV15, converging(2.0, coarsest=0.08))
    rows = summary([good, bad]).splitlines()[2:]
    assert rows[0].endswith("| 0.00039 % | 0.01 % | 4.0 | met |")
    assert rows[1].endswith("| 0.5 % | 0.01 % | 2.0 | **missed** |")
    assert "(#nafems-fv12-free-square-10-x-10-x-005-m)" in rows[0]


def test_section_shows_source_pictures_and_published_values():
    text = section(compare(FV12, converging(4.0)), {"Mesh": "images/verification/fv12-mesh.png"})
    assert FV12.source in text
    assert "![Mesh](images/verification/fv12-mesh.png)" in text
    assert "| 1 | 1.61841 | 1.6184 | +0.00039 % | 4.0 | 1.622 |" in text
    assert text.startswith(f"### {FV12.title}\n")


def test_every_row_of_a_table_has_the_cells_of_its_head():
    for case in (FV12, replace(FV12, published=(1.6,)), replace(FV12, published=())):
        widths = {line.count("|") for line in modes(compare(case, converging(4.0))).splitlines()}
        assert len(widths) == 1


@pytest.mark.parametrize(
    ("share", "text"),
    [
        (1e-4, "0.01 %"),
        (1.234e-4, "0.012 %"),
        (-2.34e-3, "-0.23 %"),
        (0.0, "0 %"),
        (0.123, "12 %"),
        (1e-10, "0 %"),
    ],
)
def test_percent(share, text):
    assert percent(share) == text
