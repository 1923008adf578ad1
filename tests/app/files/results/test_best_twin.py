"""Which laws and effects of a run count: one place decides, and says why others do not."""

import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from analysis.estimates import FittedLaws
from app.files.bad_file import ResultFileError
from app.files.provenance import provenance
from app.files.results.best_twin import BY_UPDATE, best_twin, gap_record_of
from app.files.results.gap_file import save_gap
from app.files.results.laws_file import TwinFrf, save_laws
from tests.app.corrected_run import (
    BEFORE,
    DECLARED,
    FACTOR,
    HASHES,
    corrected,
    figures,
    laws_of,
    record,
    write_run,
)
from tests.app.view.conftest import FREQUENCY, frf, updated

PLAIN_E = float(laws_of(updated()).at(20.0).youngs_modulus[0])


def modulus(run: Path) -> float:
    laws = best_twin(run, "test").twin.laws
    assert laws is not None
    return float(laws.at(20.0).youngs_modulus[0])


def tell(run: Path, told: dict[str, Any]) -> None:
    """Make both records of a comparison anew."""
    save_gap(run / "gap.h5", figures(), (), told, provenance(HASHES))
    (run / "gap.json").write_text(json.dumps(told), encoding="utf-8")


def remake(run: Path, name: str, found: Any, made: dict[str, Any]) -> None:
    save_laws(run / name, found, laws_of(found), TwinFrf(FREQUENCY, frf().h, 1e-4, 950.0), made)


@pytest.mark.parametrize("verdict", ["explained", "partly_explained"])
def test_after_a_gap_that_named_something_its_laws_and_effects_count(tmp_path: Path, verdict: str) -> None:
    run = write_run(tmp_path / "run", record(verdict))
    best = best_twin(run, "test")
    assert modulus(run) == pytest.approx(FACTOR * PLAIN_E, rel=1e-3)
    assert best.twin.path.name == "laws-corrected.h5"
    ((parameter,),) = best.effects.values()
    assert (parameter.name, parameter.value, parameter.unit) == ("mass", 7.997e-4, "kg")
    assert best.twin.declared == DECLARED
    assert best.uncorrected is not None
    assert best.uncorrected.laws is not None
    assert best.uncorrected.laws.at(20.0).youngs_modulus[0] == pytest.approx(PLAIN_E)
    assert best.said == "laws and twin are corrected (added mass at the cable; flexura gap): laws-corrected.h5"
    assert best.ignored == ()


def test_laws_before_are_those_of_the_comparison_without_its_effects(tmp_path: Path) -> None:
    """It weighs the data otherwise than update does, and moves what is declared: only like is set against like."""
    run = write_run(tmp_path / "run")
    best = best_twin(run, "test")
    assert best.before is not None
    assert best.before.at(20.0).youngs_modulus[0] == pytest.approx(BEFORE * PLAIN_E, rel=1e-3)
    assert best.before_said == "before"
    (run / "gap.h5").unlink()
    alone = best_twin(run, "test")
    assert alone.before is not None
    assert alone.before.at(20.0).youngs_modulus[0] == pytest.approx(PLAIN_E)
    assert alone.before_said == BY_UPDATE


def test_a_comparison_that_began_with_effects_has_no_laws_without(tmp_path: Path) -> None:
    given = {"thermal_lag": {"tau": {"value": 150.0, "sigma": 3.0, "unit": "s"}}}
    best = best_twin(write_run(tmp_path / "run", record("explained", starting_effects=given)), "test")
    assert best.before is not None
    assert best.before.at(20.0).youngs_modulus[0] == pytest.approx(PLAIN_E)
    assert best.before_said == BY_UPDATE


def test_without_corrected_laws_there_is_nothing_before(tmp_path: Path) -> None:
    run = write_run(tmp_path / "run", record("none"))
    (run / "laws-corrected.h5").unlink()
    assert best_twin(run, "test").before is None


def test_laws_before_that_cannot_be_used_are_named(tmp_path: Path) -> None:
    run, held = write_run(tmp_path / "run"), figures()
    fewer = FittedLaws(held.laws_before.temperature[:3], held.laws_before.value[:3], held.laws_before.sigma[:3])
    save_gap(run / "gap.h5", replace(held, laws_before=fewer), (), record(), provenance(HASHES))
    with pytest.raises(ResultFileError, match="flexura gap"):
        _ = best_twin(run, "test").before


def test_what_is_only_a_hint_is_not_put_into_the_twin(tmp_path: Path) -> None:
    run = write_run(tmp_path / "run", record("unknown"))
    assert modulus(run) == pytest.approx(PLAIN_E)
    (said,) = best_twin(run, "test").ignored
    assert "names no effect" in said
    (run / "laws-corrected.h5").unlink()  # as the gap stage leaves it
    assert best_twin(run, "test").notes == []


def test_effects_that_a_comparison_began_with_stay_on(tmp_path: Path) -> None:
    given = {"thermal_lag": {"tau": {"value": 150.0, "sigma": 3.0, "unit": "s"}}}
    run = write_run(tmp_path / "run", record("unknown", starting_effects=given))
    assert list(best_twin(run, "test").effects) == ["thermal_lag"]
    assert modulus(run) == pytest.approx(FACTOR * PLAIN_E, rel=1e-3)


def other_campaign(run: Path) -> None:
    remake(run, "laws.h5", updated(), provenance({**HASHES, "a.h5": "0b0b"}))


def updated_again(run: Path) -> None:
    remake(run, "laws.h5", replace(updated(), misfit=1.01 * updated().misfit), provenance(HASHES))


def gap_of_another_campaign(run: Path) -> None:
    tell(run, record(provenance=provenance({"protocol.json": "abcd"})))


def without_corrected(run: Path) -> None:
    (run / "laws-corrected.h5").unlink()


def without_gap(run: Path) -> None:
    (run / "gap.h5").unlink()
    (run / "gap.json").unlink()


def foreign_json(run: Path) -> None:
    (run / "gap.json").write_text(json.dumps(record("partly_explained")), encoding="utf-8")


def damaged_json(run: Path) -> None:
    (run / "gap.json").write_text('{"verdict": "explained"', encoding="utf-8")


def other_json(run: Path) -> None:
    (run / "gap.json").write_text('{"verdict": "explained", "effects": [3]}', encoding="utf-8")


@pytest.mark.parametrize(
    ("spoil", "said"),
    [
        (other_campaign, "other recordings, or another declaration"),
        (updated_again, "laws.h5 was made again since"),
        (gap_of_another_campaign, "gap.json is of another comparison"),
        (without_corrected, "gap.json names point_mass, but laws-corrected.h5 is not here"),
        (without_gap, "no gap.json that says which effects it holds"),
        (foreign_json, "of another comparison than gap.h5"),
        (damaged_json, "gap.json"),
        (other_json, "no record of a comparison"),
    ],
)
def test_stale_and_foreign_results_are_ignored_with_a_sentence(
    tmp_path: Path, spoil: Callable[[Path], None], said: str
) -> None:
    run = write_run(tmp_path / "run")
    spoil(run)
    best = best_twin(run, "test")
    assert modulus(run) == pytest.approx(PLAIN_E)
    assert (best.effects, best.uncorrected, best.said) == ({}, None, "")
    (sentence,) = best.ignored
    assert said in sentence
    assert "flexura gap" in sentence


def test_the_same_update_made_again_changes_nothing(tmp_path: Path) -> None:
    """A folder that was copied or unpacked has other times; what the files say counts."""
    run = write_run(tmp_path / "run")
    remake(run, "laws.h5", updated(), provenance(HASHES))
    assert best_twin(run, "test").uncorrected is not None


def test_laws_that_update_made_under_effects_are_the_best(tmp_path: Path) -> None:
    run = write_run(tmp_path / "run")
    remake(run, "laws.h5", corrected(), provenance(HASHES, {"effects": {"point_mass": {"mass": 8e-4}}}))
    best = best_twin(run, "test")
    assert (best.twin.path.name, list(best.effects), best.uncorrected) == ("laws.h5", ["point_mass"], None)
    assert "flexura update --twin" in best.said


def test_a_run_without_laws_is_refused_with_what_makes_them(tmp_path: Path) -> None:
    with pytest.raises(ResultFileError, match="flexura update"):
        best_twin(tmp_path, "test")
    assert gap_record_of(tmp_path) is None


def test_estimates_without_laws_are_no_error(tmp_path: Path) -> None:
    run = write_run(tmp_path / "run")
    save_laws(run / "laws.h5", updated(), None, TwinFrf(FREQUENCY, frf().h, 1e-4, 950.0), provenance(HASHES))
    best = best_twin(run, "test")
    assert best.uncorrected is not None
    assert best.uncorrected.laws is None
    np.testing.assert_array_equal(best.uncorrected.updated.temperature, updated().temperature)
