"""A campaign's truth and verdict as their files hold them, whole and damaged."""

import json
from pathlib import Path
from typing import Any

import pytest

from app.blind_trial.outcome import read_outcome
from app.files.bad_file import ResultFileError

TRUTH: dict[str, Any] = {
    "number": 3,
    "kind": "single",
    "effects": {"point_mass": {"mass": 1.2e-3}},
    "prior_sigma": {"point_mass": {"mass": 1e-3}},
    "size_sigma": {"point_mass": 80.0},
    "cosine": None,
    "imitations": {},
    "legs": ["up"],
    "scatter": 0.003,
    "laws": {
        "temperature": [-20.0, 0.0, 20.0, 40.0, 80.0],
        "youngs_modulus": [3e9, 2.8e9, 2.4e9, 2.0e9, 1.6e9],
        "poisson_ratio": [0.35, 0.36, 0.37, 0.38, 0.39],
        "loss_factor": [0.04, 0.05, 0.06, 0.05, 0.04],
    },
}
VERDICT: dict[str, Any] = {
    "verdict": "explained",
    "effects": [
        {
            "name": "point_mass",
            "equivalent": ["thickness_taper"],
            "probability": 0.98,
            "against": {"nothing": 900.0},
            "parameters": {"mass": {"value": 1.1e-3, "sigma": 2e-5, "unit": "kg"}},
        }
    ],
    "gap": {"held_out": {"closure": 0.93}, "held_out_also": [{"closure": 0.9}, {"closure": None}]},
    "laws": {
        "final": {
            "temperature_c": [0.0, 20.0],
            "youngs_modulus_pa": [2.82e9, 2.38e9],
            "poisson_ratio": [0.362, 0.37],
            "loss_factor": [0.05, 0.066],
            "sigma_youngs_modulus_pa": [1e7, 2e7],
            "sigma_poisson_ratio": [0.001, 0.001],
            "sigma_loss_factor": [0.002, 0.002],
        }
    },
    "not_observable": ["high_pass"],
    "seconds": 31,
}


def read(folder: Path, truth: str, verdict: str | None = None) -> Any:
    (folder / "truth.json").write_text(truth, encoding="utf-8")
    if verdict is not None:
        (folder / "gap.json").write_text(verdict, encoding="utf-8")
    return read_outcome(folder / "truth.json", folder)


def test_a_truth_beside_its_verdict(tmp_path: Path) -> None:
    found = read(tmp_path, json.dumps(TRUTH), json.dumps(VERDICT))
    assert found.named[0].members == {"point_mass", "thickness_taper"}
    assert found.named[0].parameters == {"mass": (1.1e-3, 2e-5)}
    assert (found.closure, found.closure_also, found.one_ramp) == (0.93, (0.9,), True)
    assert found.size == {"point_mass": 80.0}
    assert found.scatter == 0.003
    assert found.law_errors == {
        "youngs_modulus": pytest.approx((2.0, -1.0)),
        "poisson_ratio": pytest.approx((2.0, 0.0)),
        "loss_factor": pytest.approx((0.0, 3.0)),
    }


def test_without_a_verdict_there_is_no_outcome(tmp_path: Path) -> None:
    assert read(tmp_path, json.dumps(TRUTH)) is None


@pytest.mark.parametrize(
    ("truth", "verdict", "told"),
    [
        ("{", VERDICT, r"truth\.json: unreadable"),
        ("[]", VERDICT, r"truth\.json: holds no table"),
        ({**TRUTH, "size_sigma": 3}, VERDICT, "size"),
        ({name: value for name, value in TRUTH.items() if name != "effects"}, VERDICT, "'effects'"),
        (TRUTH, {**VERDICT, "effects": 7}, "not what this trial wrote"),
        (TRUTH, {**VERDICT, "gap": [[]]}, "not what this trial wrote"),
        (TRUTH, {**VERDICT, "seconds": "long"}, "seconds"),
        (TRUTH, {**VERDICT, "laws": {"final": {"temperature_c": [20.0]}}}, "youngs_modulus"),
        (TRUTH, "\x00", r"gap\.json: unreadable"),
    ],
)
def test_a_damaged_file_is_named_with_what_is_wrong(tmp_path: Path, truth: Any, verdict: Any, told: str) -> None:
    texts = [held if isinstance(held, str) else json.dumps(held) for held in (truth, verdict)]
    with pytest.raises(ResultFileError, match=told):
        read(tmp_path, *texts)
