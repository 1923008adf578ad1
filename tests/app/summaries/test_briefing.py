"""A run in words, for every verdict, and effects in units that people use."""

from pathlib import Path
from typing import Any

import pytest

from analysis.effect_card import EffectCard, Parameter
from analysis.experiment import Attachment
from app.files.results.best_twin import BestTwin, best_twin
from app.files.results.gap_json import _effect
from app.summaries.briefing import Briefing, Worth, briefing
from app.summaries.gap import found_words, in_words, told
from app.summaries.numbers import FIXED, roughly
from simulation.effects.library import LIBRARY
from tests.app.corrected_run import effect, record, region, write_run
from tests.app.test_gap_report import explained  # noqa: F401 - a fixture
from tests.app.view.conftest import experiment


def brief(tmp_path: Path, verdict: str, worth: Worth | None = None, **changes: Any) -> Briefing:
    told = record(verdict, **changes)
    run = write_run(tmp_path / verdict, told)
    if verdict in ("none", "unknown"):
        (run / "laws-corrected.h5").unlink()
    return briefing(best_twin(run, "test"), told, "plate", worth)


def words(found: Briefing) -> str:
    return "\n".join(found.lines()).replace(FIXED, " ")


def test_a_gap_that_is_explained(tmp_path: Path) -> None:
    found = brief(tmp_path, "explained", Worth(0.012, 60.0))
    said = words(found)
    assert found.settled
    assert said.splitlines()[0] == (
        "What the twin lacked: an added mass of 0.800 ± 0.002 g at the cable. "
        "With it, twin and plate agree to the noise of the measurement."
    )
    assert [heading for heading, _ in found.parts] == [
        "The plate",
        "How sure",
        "What it is worth",
        "What is left",
        "How well known",
        "Next",
    ]
    for wanted in (
        "At 20 °C: E 2.5",
        "95 %",
        "E changes by +2.9 % of itself (most at",
        " GPa before), ν by +0.010, η by +10.0 % of itself.",
        "E is Young's modulus (stiffness), ν Poisson's ratio, η the loss factor (damping).",
        "99.99 % of the gap is explained; of data that were not fitted, 99.99 %.",
        "Filters gain up to 0.012 of contrast (at 60 °C) over those from the laws by update, before the gap was",
        "Nothing beyond the noise.",
        "Nothing that was declared is found beyond its tolerance",
        "Not told by the data, and taken as declared: mass of the plate. Where one of them is off by more",
        "Cannot be seen with this campaign: plate that lags behind the oven; it needs two ramps.",
        "To confirm it: weigh cable and glue.",
    ):
        assert wanted in said
    assert "point_mass" not in said
    assert "chi2" not in said


@pytest.mark.parametrize("gain", [0.0, 0.0004, -0.002])
def test_filters_that_gain_nothing_are_said_to_gain_nothing(tmp_path: Path, gain: float) -> None:
    said = words(brief(tmp_path, "explained", Worth(gain, 45.0)))
    assert "Filters gain nothing over those from the laws by update, before the gap was looked for." in said
    assert "0.00" not in said.partition("What it is worth")[2].partition("What is left")[0]


def test_what_is_left_of_a_gap_that_is_nearly_explained_is_no_contradiction(tmp_path: Path) -> None:
    """It said "this explains 100 % of the gap; the rest is still missing"."""
    nearly = {"share": 0.00004, "where": []}
    said = words(brief(tmp_path, "partly_explained", effects=[effect()], unexplained=nearly))
    assert "This explains all but 0.004 % of the gap; the rest is still missing." in said
    assert "All but 0.004 % of the gap is explained" in said
    assert "0.004 % of the gap." in said


def test_a_gap_that_is_explained_in_part_says_what_is_left_and_where(tmp_path: Path) -> None:
    found = brief(tmp_path, "partly_explained", effects=[{**effect(), "equivalent": ["thermal_lag"]}])
    said = words(found)
    assert not found.settled
    assert "This explains 93 % of the gap; the rest is still missing." in said
    assert "7 % of the gap." in said
    assert "60 % of it at S1, 900 to 1100 Hz, 30 °C." in said
    assert "cannot tell it from: plate that lags behind the oven" in said
    assert "To tell them apart: weigh cable and glue." in said
    assert "their true errors are larger" in said


def test_what_is_unknown_is_what_is_seen_and_where(tmp_path: Path) -> None:
    found = brief(tmp_path, "unknown")
    said = words(found)
    assert not found.settled
    assert found.headline.startswith("Something is missing in the twin, and no effect of the library explains it")
    assert "misses 6.6 % of the response, in places 31 times the noise." in said
    assert "60 % of it at S1, 900 to 1100 Hz, 30 °C." in said
    assert "added mass" not in said  # a hint is no finding


def test_nothing_missing(tmp_path: Path) -> None:
    found = brief(tmp_path, "none")
    assert found.settled
    assert found.headline == "Nothing is missing: the twin agrees with the plate to the noise of the measurement."
    assert dict(found.parts)["Next"] == (
        "Use E, ν and η as they are: nothing has to be corrected.",
        "Where the rest matters, ask what would show it: flexura gap plate --plan",
    )


def test_no_fit_stands_before_all_else_and_gives_no_numbers(tmp_path: Path) -> None:
    pairing = {"fit": False, "said": "this is no fit: 3 of 9 modes", "likely_reason": "S1 stands at 0.1, 0.2 m"}
    found = brief(tmp_path, "unknown", pairing=pairing)
    assert found.headline.startswith("This is no fit")
    assert found.first == ("this is no fit: 3 of 9 modes", "S1 stands at 0.1, 0.2 m")
    assert [heading for heading, _ in found.parts] == ["Next"]
    assert "GPa" not in words(found)


def test_before_a_comparison_the_plate_is_described_and_the_next_step_named(tmp_path: Path) -> None:
    run = write_run(tmp_path / "run")
    best = BestTwin(best_twin(run, "test").twin)
    found = briefing(best, None, "plate")
    assert "Ask what the twin lacks: flexura gap plate" in words(found)
    assert found.settled  # it misses no more than the noise
    plain = best_twin(run, "test").uncorrected
    assert plain is not None
    assert "it lacks something that the plate has" in briefing(BestTwin(plain), None, "plate").headline


def test_at_too_few_temperatures_for_laws_the_estimates_are_said(tmp_path: Path) -> None:
    run = write_run(tmp_path / "run")
    best = BestTwin(best_twin(run, "test").twin)
    best.twin.__dict__["laws"] = None
    found, said = best.twin.updated, words(briefing(best, None, "plate"))
    for n in range(3):
        modulus = f"At {found.temperature[n]:.0f} °C: E {found.material.youngs_modulus[n] / 1e9:.2f}"
        assert modulus in said
    assert "Laws of E, ν and η over temperature need estimates at 3 temperatures or more." in said


def test_doubtful_declarations_are_among_what_is_known(tmp_path: Path) -> None:
    from dataclasses import replace

    run = write_run(tmp_path / "run")
    best = best_twin(run, "test")
    (thickness, *others) = best.twin.declared
    far = replace(best.twin.updated, declared=(replace(thickness, value=0.03), *others))
    best.twin.__dict__["_estimates"] = (far, best.twin.answers)
    said = words(briefing(best, record(), "plate"))
    assert "The declaration is doubtful: thickness of the plate: +3 ± 0.1 % from its declaration" in said
    assert "confirmed" not in said


def test_regions_are_named_up_to_three(tmp_path: Path) -> None:
    told = record("partly_explained")
    told["unexplained"]["where"] = [region(share) for share in (0.4, 0.3, 0.2, 0.1)]
    assert words(brief(tmp_path, "partly_explained", unexplained=told["unexplained"])).count("% of it at S1") == 3


@pytest.mark.parametrize("name", LIBRARY)
def test_every_effect_is_said_for_people(name: str, explained: Any) -> None:  # noqa: F811
    """With its own title, its phrase with a value for every parameter, and no unit that people do not use."""
    declared = experiment().model_copy(update={"cable": (Attachment(point=(0.1, 0.1)),)})
    card = LIBRARY[name].card(declared)
    assert card.title
    assert "_" not in card.title
    values = {p.name: {"value": 0.5 * p.high, "sigma": 0.01 * p.high, "unit": p.unit} for p in card.parameters}
    shown = {p.name: p.shown for p in card.parameters if p.shown}
    told = {"name": name, "parameters": values, "title": card.title, "phrase": card.phrase, "shown_units": shown}
    said = in_words(told).replace(FIXED, " ")
    assert said.count("±") == len(card.parameters)
    assert "{" not in said
    for unit in (" kg", " m,", " m ", " 1/K", "e-"):
        assert unit not in f"{said} "


def test_the_record_of_an_effect_holds_what_its_words_need(explained: Any) -> None:  # noqa: F811
    from dataclasses import replace

    named = replace(explained.effects[0], title="added mass", phrase="{mass} more", shown={"mass": "g"})
    told = _effect(named)
    assert in_words(told).replace(FIXED, " ") == "0.790 ± 0.010 g more"
    assert found_words(told, {"suspension": "stiff strings"}).endswith(
        "(or, not to be told from it: stiff strings)"
    )


def test_a_user_s_own_effect_needs_no_words() -> None:
    parameter = {"value": 2e-3, "sigma": 1e-4, "unit": "m"}
    told = {"name": "my_gap", "parameters": {"wide": parameter}, "equivalent": []}
    assert in_words(told).replace(FIXED, " ") == "my gap: wide 2.00 ± 0.10 mm"
    card = EffectCard("my_gap", "a gap", (Parameter("wide", "m", 0.0, 0.01, 1e-3),), "modes", "a gauge")
    assert (card.said, card.phrase) == ("my gap", "")


@pytest.mark.parametrize(
    ("shown", "phrase", "said"),
    [("furlong", "", "shown in 'furlong'; allowed for 'm': mm"), ("mm", "{tall} high", "its phrase gives")],
)
def test_words_that_cannot_be_are_refused(shown: str, phrase: str, said: str) -> None:
    with pytest.raises(ValueError, match=said):
        EffectCard(
            "own",
            "a gap",
            (Parameter("wide", "m", 0.0, 1.0, 0.1, shown=shown),),
            "modes",
            "a gauge",
            phrase=phrase,
        )


@pytest.mark.parametrize(
    ("value", "sigma", "unit", "said"),
    [
        (0.7997, 0.0022, "g", "0.800 ± 0.002 g"),
        (2.3055, 0.0216, "GPa", "2.31 ± 0.02 GPa"),
        (1.1441, 0.0104, "GPa", "1.144 ± 0.010 GPa"),
        (239.2, 13.0, "s", "239 ± 13 s"),
        (0.3671, 0.0, "1", "0.367"),
        (5.0, 0.096, "%", "5.00 ± 0.10 %"),
    ],
)
def test_numbers_for_a_reader_in_a_hurry(value: float, sigma: float, unit: str, said: str) -> None:
    assert roughly(value, sigma, unit).replace(FIXED, " ") == said


def test_other_effects_in_a_sentence_have_their_names_for_people() -> None:
    titles = {"local_damage": "spot that has lost stiffness", "amplitude_softening": "softening with amplitude"}
    assert told("weigh it; a local_damage lowers others", titles) == (
        "weigh it; “spot that has lost stiffness” lowers others"
    )
    assert told("an amplitude_softening moves resonances", titles).startswith("“softening with amplitude” moves")
    assert told("declare plate_shear", titles) == "declare plate_shear"
