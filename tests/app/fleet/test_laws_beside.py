"""A fleet's laws from its run folders: scatter, outliers and predictions against what they were made from."""

import json
from pathlib import Path

import numpy as np
import pytest

from app.fleet.fleet_run import RunMember
from app.fleet.laws_beside import laws_beside
from app.fleet.page import fleet_page, fleet_record, scatter_rows, summary_of
from tests.app.fleet.conftest import piece, true_modulus

Fleet = tuple[dict[str, Path], np.ndarray]


def members_of(runs: dict[str, Path]) -> list[RunMember]:
    return [RunMember(name, run, run) for name, run in runs.items()]


def test_scatter_is_that_of_the_pieces_and_strangers_are_named(fleet: Fleet) -> None:
    runs, levels = fleet
    found = laws_beside(runs)
    assert set(found.outliers) == {"door-5", "door-9"}
    assert found.outliers["door-5"].quantity == "youngs_modulus"
    assert found.outliers["door-5"].deviation == pytest.approx(-0.2, abs=0.08)
    assert found.outliers["door-9"].quantity == "misfit"
    scatter = found.scatter["youngs_modulus"]
    assert scatter.between == pytest.approx(levels.std(ddof=1), rel=0.15)
    assert scatter.within < 0.003
    assert scatter.pieces == 10
    mean = np.log(true_modulus(found.temperature, levels.mean()))
    np.testing.assert_allclose(scatter.mean, mean, atol=0.004)
    assert found.scatter["poisson_ratio"].between < 0.002


def test_a_piece_measured_once_is_predicted_within_its_band(fleet: Fleet, tmp_path: Path) -> None:
    """Of 40 further pieces the whole true law, at all temperatures, lies within the 90 % band for 34 or more."""
    runs, _ = fleet
    rng = np.random.default_rng(12)
    levels = rng.normal(0.0, 0.03, 40)
    new = {
        f"new-{k}": piece(tmp_path / f"new-{k}", rng, level, np.array([22.0])) for k, level in enumerate(levels)
    }
    found = laws_beside({**runs, **new})
    assert len(found.predicted) == 40
    inside = []
    for one, level in zip(found.predicted, levels, strict=True):
        law, true = one.laws["youngs_modulus"], np.log(true_modulus(one.temperature, level))
        inside.append(((law.low <= true) & (true <= law.high)).all())
        assert one.measured_at == 22.0
        assert 22.0 in one.temperature
        assert (law.high - law.low).max() < 0.03  # without the measurement 0.11
    assert np.mean(inside) >= 0.85


def test_page_and_record_say_the_same(fleet: Fleet) -> None:
    runs, _ = fleet
    members = members_of(runs)
    found = laws_beside(runs)
    record = json.loads(json.dumps(fleet_record(members, found, None, {"stages": ["update"]}), allow_nan=False))
    page = fleet_page(members, found, None)
    assert {one["name"] for one in record["outliers"]} == {"door-5", "door-9"}
    for one in record["outliers"]:
        assert one["said"].replace("'", "&#x27;") in page
    assert "of another batch?" in page
    assert len(record["provenance"]["inputs"]) == 12
    assert record["laws"]["youngs_modulus"]["mean"][0] == pytest.approx(3.05e9, rel=0.05)
    band = record["laws"]["youngs_modulus"]["band"]
    assert band["low"][0] < 3.05e9 < band["high"][0]
    for row in scatter_rows(found):
        assert all(f">{cell}<" in page for cell in row[1:])
    assert 'src="http' not in page
    assert "not like the others: door-5, door-9" in summary_of(members, found).replace(
        "door-9, door-5", "door-5, door-9"
    )


def test_few_pieces_and_ranges_apart_are_said_not_guessed(tmp_path: Path) -> None:
    rng = np.random.default_rng(3)
    cold, hot = np.arange(0.0, 21.0, 5.0), np.arange(40.0, 61.0, 5.0)
    runs = {str(k): piece(tmp_path / str(k), rng, 0.0, cold if k < 2 else hot) for k in range(4)}
    for some in (dict(list(runs.items())[:2]), runs):
        found = laws_beside(some)
        assert found.scatter == {}
        assert "The pieces cannot be compared" in fleet_page(members_of(some), found, None)


def test_a_piece_whose_results_are_damaged_stops_no_other(fleet: Fleet) -> None:
    runs, _ = fleet
    (runs["door-2"] / "laws.h5").write_bytes(b"damaged")
    found = laws_beside(runs)
    assert list(found.unread) == ["door-2"]
    assert "laws.h5" in found.unread["door-2"]
    assert found.scatter["youngs_modulus"].pieces == 9
