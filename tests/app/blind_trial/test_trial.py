"""A whole trial of two campaigns on a small model of a plate, and what its folders may tell."""

import dataclasses
import json
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import pytest

from app.blind_trial.outcome import read_outcome
from app.blind_trial.plates import PlateKind
from app.blind_trial.trial import Trial, begin, run_trial
from app.commands.blind_trial import command
from app.files.bad_file import ResultFileError
from app.files.provenance import sha256
from simulation.reduction.effect_operators import EffectOperators
from simulation.reduction.reduced_model import ReducedModel

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module", autouse=True)
def small(kind: PlateKind, operators: EffectOperators, plain: ReducedModel) -> Iterator[None]:
    """Every plate is the small one; for the sake of time the twin has the specimen's own mesh."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(Trial, "plates", property(lambda trial: (kind,)))
        patch.setattr("app.blind_trial.specimen.cached_operators", lambda *_, **__: operators)
        patch.setattr("app.twins.campaign_twin.cached_operators", lambda *_, **__: operators)
        patch.setattr("app.twins.campaign_twin.cached_reduction", lambda *_, **__: plain)
        yield


def run(trial: Trial) -> list[str]:
    lines: list[str] = []
    with ThreadPoolExecutor(1) as executor:
        run_trial(trial, executor, lambda stage, share: None, lines.append)
    return lines


@pytest.fixture(scope="module")
def trial(tmp_path_factory: pytest.TempPathFactory) -> Trial:
    found = Trial(tmp_path_factory.mktemp("trial"), 2, 7, ("null", "single"), exact=True)  # one model serves all
    begin(found)
    assert len(run(found)) == 2
    return found


def test_both_campaigns_are_judged(trial: Trial):
    outcomes = [read_outcome(trial.truth(a), trial.run(a)) for a in trial.assignments]
    assert sorted(o.kind for o in outcomes if o) == ["null", "single"]
    assert all(o is not None and o.verdict != "refused" for o in outcomes)
    null = next(o for o in outcomes if o and o.kind == "null")
    assert null.verdict == "none"


def test_no_campaign_tells_what_it_hides(trial: Trial):
    """Names of effects, and every number of the truth, are looked for in all its text; only the hash is there."""
    for assignment in trial.assignments:
        folder, truth = trial.campaign(assignment), trial.truth(assignment)
        record = json.loads(truth.read_text(encoding="utf-8"))
        protocol = (folder / "protocol.json").read_text(encoding="utf-8")
        told = protocol + (folder / "events.jsonl").read_text(encoding="utf-8")
        numbers = [record["gain"], record["noise"], *record["laws"]["youngs_modulus"]]
        numbers += [value for values in record["effects"].values() for value in values.values()]
        assert not [x for x in (*record["effects"], *map(repr, numbers), "simulation") if x in told]
        assert json.loads(protocol)["source"] == {truth.name: sha256(truth)}


def test_what_is_judged_is_not_made_again(trial: Trial):
    before = {a: sha256(trial.truth(a)) for a in trial.assignments}
    assert run(trial) == []
    last = trial.assignments[-1]
    (trial.run(last) / "gap.json").unlink()  # as a kill leaves it
    assert run(trial) == [f"campaign {last.name} judged, 0 left"]
    assert {a: sha256(trial.truth(a)) for a in trial.assignments} == before


def test_a_folder_holds_one_trial_under_one_set_of_thresholds(trial: Trial):
    assert begin(trial)["inputs"]["thresholds"]
    with pytest.raises(ResultFileError, match="another seed"):
        begin(dataclasses.replace(trial, seed=8))
    file = trial.folder / "trial.json"
    kept = file.read_text(encoding="utf-8")
    record = json.loads(kept)
    file.write_text(json.dumps({**record, "inputs": {"thresholds": "moved"}}), encoding="utf-8")
    with pytest.raises(ResultFileError, match="another inputs"):
        begin(trial)
    file.write_text(kept, encoding="utf-8")


def test_the_verb_proves_what_is_there(trial: Trial, run_flexura: Any):
    kinds = ("--kind", "null", "--kind", "single", "--exact")
    words = ("blind-trial", "--count", 2, "--seed", 7, *kinds, "--out", trial.folder)
    status, out, err = run_flexura(*words, "--json")
    record = json.loads(out)
    assert status in (0, 1)
    assert status == int(any(row["met"] is False for row in record["figures"]))
    assert record == json.loads((trial.folder / "proof.json").read_text(encoding="utf-8"))
    assert [c["kind"] for c in record["campaigns"]] == [a.kind for a in trial.assignments]
    assert "2 campaigns" in err
    assert (trial.folder / "proof.png").stat().st_size > 20_000
    assert command.name == "blind-trial"
