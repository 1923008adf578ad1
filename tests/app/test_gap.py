"""``flexura gap`` as typed: refusals in a sentence, and the shipped recording from end to end."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner, Result
from threadpoolctl import threadpool_limits

from analysis.gap.plan.measurement import OVEN_FIXED
from app.files.results.gap_file import load_gap
from app.files.results.laws_file import load_laws, load_updated
from app.files.results.twin_file import read_twin
from app.main import flexura
from app.stages.comparison.plan import open_before
from app.stages.gap import missing_words, roughness

Run = Callable[..., tuple[int, str, str]]
Cut = Callable[[Path, tuple[int, ...]], None]
TEMPERATURES = (0, 12, 24, 36, 48, 60)


def refused(run: Run, campaign: Path, *words: object) -> str:
    """Type a comparison that must be refused; what it said, with nothing on stdout and nothing left behind."""
    status, out, err = run("gap", campaign, "--json", *words)
    assert (status, out) == (2, "")
    assert "Traceback" not in err
    left = campaign.with_name(campaign.name + "-run")
    assert not left.is_dir() or not any(left.iterdir())
    return err


def test_a_folder_that_is_no_campaign(tmp_path: Path, run_flexura: Run) -> None:
    assert "not a campaign" in refused(run_flexura, tmp_path)


def test_a_twin_that_is_not_there_or_no_twin(tiny: Any, tmp_path: Path, run_flexura: Run) -> None:
    campaign = tiny.write(tmp_path / "tiny")
    assert "absent.toml: does not exist" in refused(run_flexura, campaign, "--twin", tmp_path / "absent.toml")
    said = refused(run_flexura, campaign, "--twin", campaign / "campaign.toml")
    assert "campaign.toml: format = 'recorded-campaign/1'; allowed: 'flexura-twin/1'" in said


@pytest.mark.parametrize(
    ("content", "said"),
    [
        (None, "effects: does not exist; allowed: a folder of *.py"),
        ("EFFECT = 1\n", "an EFFECT that is a int"),
        ("import absent_package\n", "ModuleNotFoundError"),
        ("def (:\n", "SyntaxError"),
    ],
)
def test_effects_that_cannot_be_loaded(
    tiny: Any, tmp_path: Path, run_flexura: Run, content: str | None, said: str
) -> None:
    campaign, folder = tiny.write(tmp_path / "tiny"), tmp_path / "effects"
    if content is not None:
        folder.mkdir()
        (folder / "mine.py").write_text(content, encoding="utf-8")
    assert said in refused(run_flexura, campaign, "--effects", folder)


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("--hours", "scale=1"), "--experiment and --hours belong to --plan"),
        (
            ("--plan", "--hours", "microscope=1"),
            "'microscope=1'; allowed: KIND=HOURS, above 0 and at most 10000, KIND one of both_ramps",
        ),
        (("--plan", "--hours", "scale=none"), "'scale=none'; allowed: KIND=HOURS"),
        (("--plan", "--hours", "scale=0"), "'scale=0'; allowed: KIND=HOURS, above 0"),
    ],
)
def test_hours_of_a_plan_are_checked_first(
    tiny: Any, tmp_path: Path, run_flexura: Run, words: tuple[str, ...], said: str
) -> None:
    campaign = tiny.write(tmp_path / "tiny")
    assert said in " ".join(refused(run_flexura, campaign, *words).split())


def test_the_file_of_the_rig_must_be_an_experiment(tiny: Any, tmp_path: Path, run_flexura: Run) -> None:
    campaign = tiny.write(tmp_path / "tiny")
    said = refused(run_flexura, campaign, "--plan", "--experiment", campaign / "campaign.toml")
    assert "declares a recorded campaign" in said


@pytest.mark.parametrize(
    ("content", "said"),
    [
        (None, "holds no plan; make it with: flexura gap CAMPAIGN --out"),
        ("{", "holds no plan"),
        ('{"plan": null}', "holds no plan"),
        ('{"plan": {"questions": [], "next": null}}', "has no questions"),
    ],
)
def test_an_earlier_campaign_without_a_plan_is_refused(
    tiny: Any, tmp_path: Path, run_flexura: Run, content: str | None, said: str
) -> None:
    campaign, run = tiny.write(tmp_path / "tiny"), tmp_path / "earlier-run"
    run.mkdir()
    if content is not None:
        (run / "gap.json").write_text(content, encoding="utf-8")
    assert said in refused(run_flexura, campaign, "--after", campaign, run)


def test_what_was_open_is_read_from_the_plan(tmp_path: Path) -> None:
    questions = [
        {"effect": "draught_gradient", "rival": "thickness_taper"},
        {"effect": "annealing", "rival": None},
    ]
    for key, turned in (("turned_plate", OVEN_FIXED), ("both_ramps", ())):
        plan = {"questions": questions, "next": {"key": key}}
        (tmp_path / "gap.json").write_text(json.dumps({"plan": plan}), encoding="utf-8")
        assert open_before(tmp_path) == (("draught_gradient", "thickness_taper", "annealing"), turned)


def test_what_the_analysis_refuses_is_told_in_one_message(
    tiny: Any, tmp_path: Path, run_flexura: Run, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A ValueError is about the data; a matrix that cannot be inverted is a defect and keeps its traceback."""

    def raising(error: Exception) -> Callable[..., None]:
        def raise_it(*_: object, **__: object) -> None:
            raise error

        return raise_it

    campaign = tiny.write(tmp_path / "tiny")
    monkeypatch.setattr("app.stages.update.campaign_frf", raising(ValueError("channel S1: too loud")))
    assert "tiny: cannot be judged: channel S1: too loud" in refused(run_flexura, campaign)
    monkeypatch.setattr("app.stages.update.campaign_frf", raising(np.linalg.LinAlgError("singular")))
    with pytest.raises(np.linalg.LinAlgError):
        run_flexura("gap", campaign)


def test_an_effect_that_cannot_be_tried_is_told_of_with_what_it_needs() -> None:
    assert missing_words({"drying": "both ramps"}) == ("drying was not tried: for it, declare both ramps",)


def test_a_plate_that_is_computed_less_exactly_than_usual_is_told_of() -> None:
    assert roughness(1.5e-3) == ()
    (note,) = roughness(4e-3)
    assert "0.4 % of its peak" in note
    assert "below 0.2 %" in note


def test_copies_of_one_repeat_are_refused(tiny: Any, tmp_path: Path, run_flexura: Run) -> None:
    """No two recordings agree to the last digit; weighed by their scatter each line would count for ever."""
    for file in tiny.files.values():
        file.groups["repeat 2"] = file.groups["repeat 1"]
    campaign = tiny.write(tmp_path / "copied")
    said = refused(run_flexura, campaign)
    assert "copied: cannot be judged: channel S1 at 10.0 °C (up): lines without variance" in said
    assert "copies of one recording" in said
    assert run_flexura("update", campaign)[::2] == (2, said)


def typed(*words: object) -> Result:
    with threadpool_limits(1):
        result = CliRunner().invoke(flexura, [str(word) for word in words])
    if result.exception is not None and not isinstance(result.exception, SystemExit):
        raise result.exception
    return result


@pytest.fixture(scope="module")
def recording(tmp_path_factory: pytest.TempPathFactory, cut_recording: Cut) -> Path:
    """Cut a few sweeps out of the shipped recording."""
    folder = tmp_path_factory.mktemp("gap") / "few"
    cut_recording(folder, TEMPERATURES)
    return folder


@pytest.fixture(scope="module")
def compared(recording: Path) -> tuple[Result, Path]:
    run = recording.with_name("run")
    return typed("gap", recording, "--out", run, "--json"), run


@pytest.mark.slow
def test_the_shipped_recording_has_no_gap(compared: tuple[Result, Path]) -> None:
    """It was computed by an independent solver from a plate without any effect."""
    result, run = compared
    printed = json.loads(result.stdout)
    assert printed == json.loads((run / "gap.json").read_text(encoding="utf-8"))
    assert result.exit_code == 0
    assert (printed["verdict"], printed["effects"]) == ("none", [])
    assert "thermal_lag" in printed["not_observable"]
    assert printed["gap"]["baseline"]["chi2_per_dof"] == pytest.approx(1.0, abs=0.05)
    figures, record = load_gap(run / "gap.h5")
    assert record == printed
    assert figures.before.sigma.shape[:2] == (len(TEMPERATURES), 1)
    assert not (run / "laws-corrected.h5").exists()
    assert load_laws(run / "laws.h5").temperature_range == pytest.approx((0.0, 60.0), abs=0.2)


@pytest.mark.slow
def test_the_same_input_gives_the_same_answer(recording: Path, compared: tuple[Result, Path]) -> None:
    again = recording.with_name("again")
    typed("gap", recording, "--out", again)
    first, second = (json.loads((run / "gap.json").read_text(encoding="utf-8")) for run in (compared[1], again))
    assert {**first, "seconds": 0.0} == {**second, "seconds": 0.0}
    assert (again / "twin.toml").read_bytes() == (compared[1] / "twin.toml").read_bytes()


@pytest.mark.slow
def test_other_verbs_go_on_from_the_twin(recording: Path, compared: tuple[Result, Path]) -> None:
    """A gram put onto the twin's cable by hand: update sees its inertia missing from the plate's response.

    E does not show it: places of patches and of the cable, within whose tolerances the plate is known, take it up.
    """
    run = compared[1]
    twin = read_twin(run / "twin.toml")
    text = (run / "twin.toml").read_text(encoding="utf-8").replace("effect = []\n", "")
    mass = '[[effect]]\nname = "point_mass"\n\n[effect.parameter.mass]\nvalue = 0.001\nsigma = 0.0\nunit = "kg"\n'
    (run / "heavy.toml").write_text(text + mass, encoding="utf-8")
    plain, heavy = recording.with_name("plain"), recording.with_name("heavy")
    unloaded = typed("update", recording, "--twin", run / "twin.toml", "--out", plain)
    assert unloaded.exit_code == 0
    assert "the declaration is doubtful" not in unloaded.stderr
    told = typed("update", recording, "--twin", run / "heavy.toml", "--out", heavy)
    assert told.exit_code == 0
    assert "the declaration is doubtful: place of cable" in told.stderr
    assert "the twin lacks an effect that the plate has" in told.stderr
    reference, _ = load_updated(run / "laws.h5")
    same, _ = load_updated(plain / "laws.h5")
    np.testing.assert_allclose(same.material.youngs_modulus, reference.material.youngs_modulus, rtol=2e-4)
    np.testing.assert_allclose(same.gain, twin.gain.value, rtol=1e-6)
    loaded, _ = load_updated(heavy / "laws.h5")
    replaced = typed("update", recording, "--out", heavy)
    assert "held the laws under point_mass; they are replaced" in replaced.stderr
    assert "are replaced" not in typed("update", recording, "--out", heavy).stderr
    typed("update", recording, "--twin", run / "heavy.toml", "--out", heavy)
    assert (loaded.misfit > 5.0 * same.misfit).all()
    focused = typed("focus", run, "--twin", run / "heavy.toml", "--temperature", "20", "--json")
    assert focused.exit_code == 0
    assert "with_uncorrected_laws" in json.loads(focused.stdout)
    under_effects = typed("focus", heavy, "--twin", run / "heavy.toml", "--temperature", "20", "--json")
    assert under_effects.exit_code == 0
    assert "with_uncorrected_laws" not in json.loads(under_effects.stdout)
