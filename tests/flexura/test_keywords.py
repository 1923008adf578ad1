"""What functions of the library refuse is told in their keywords, not in the options of the verbs."""

import inspect
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest

import flexura
from app.files.bad_file import ResultFileError, UnsuitedOptionError
from app.files.campaign_error import CampaignFileError
from app.summaries.keywords import in_keywords
from app.summaries.table import as_html, as_text
from flexura.forward_twin import ForwardTwin
from flexura.keywords import ArgumentKindError, keyworded

RUN = "no-run"


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (
            lambda: flexura.render("a.wav", RUN, temperature=20, weather="car.toml"),
            "one of temperature and weather",
        ),
        (lambda: flexura.render("a.wav", RUN, temperature=20, block=0), "block 0: allowed are "),
        (
            lambda: flexura.radiation(RUN, transfers="scan.h5", twin="twin.toml"),
            "transfers takes the place of laws",
        ),
        (lambda: flexura.thermometer(RUN), "name drive and response of a recording"),
        (
            lambda: flexura.thermometer(RUN, drive="a", response="b", largest_sigma=-1.0),
            "largest_sigma -1: allowed",
        ),
        (lambda: flexura.study("13", RUN, seed=-1), "seed -1: allowed are 0 and more"),
        (lambda: flexura.health([RUN], RUN, rate=2.0), "rate 2: allowed are "),
    ],
)
def test_a_refusal_names_keywords(call: Callable[[], object], words: str) -> None:
    with pytest.raises(UnsuitedOptionError, match=words) as raised:
        call()
    assert "--" not in str(raised.value)


def test_hours_of_a_plan_are_a_keyword(tmp_path: Path) -> None:
    with pytest.raises(UnsuitedOptionError, match=r"^experiment and hours belong to plan$"):
        flexura.gap(flexura.example("pp-plate"), hours={"point": 1.0})


@pytest.mark.parametrize(
    ("message", "said"),
    [
        ("--until gap: allowed are", "last gap: allowed are"),
        ("is there; use --out", "is there; use out"),
        (
            "make it with: flexura gap C --plan --out R; or leave --out out",
            "make it with: flexura gap C --plan --out R; or leave out out",
        ),
        ("flexura compensate --out R, or take --method stif", "flexura compensate --out R, or take method stif"),
        ("(python3 start.py --out) or --out", "(python3 start.py --out) or out"),
        ("--shared-poles is of the verb", "--shared-poles is of the verb"),
        ("a column 'x--out' stays", "a column 'x--out' stays"),
    ],
)
def test_commands_and_other_options_stay(message: str, said: str) -> None:
    assert in_keywords(message, ["last", "out", "method", "plan"]) == said


def test_an_error_stays_what_it_is() -> None:
    error = UnsuitedOptionError("--out")

    def refuses(out: str) -> None:
        raise error

    with pytest.raises(ResultFileError) as raised:
        keyworded(refuses)("x")
    assert raised.value is error
    assert str(error) == "out"


def test_every_function_is_such_a_one() -> None:
    for name in flexura.__all__:
        function = getattr(flexura, name)
        assert function is getattr(flexura, name)
        assert inspect.unwrap(function) is not function, name
        assert function.__doc__


WRONG = ("50", "", None, True, 3, -1, 2.5, float("nan"), float("inf"), [1, 2], {}, object(), b"x")
NEEDED = {
    "to": "csv",
    "figure": 13,
    "twin": ForwardTwin(None),  # type: ignore[arg-type]
    "frequency": [1.0],
    "parameters": ["loss_factor"],
    "material": (2e9, 0.4, 0.05),
}
"""Arguments that a function needs beside paths."""


def _calls() -> Iterator[tuple[str, str, object, dict[str, object]]]:
    for name in flexura.__all__:
        known = inspect.signature(getattr(flexura, name)).parameters
        needed = {one: NEEDED.get(one, "nowhere") for one, of in known.items() if of.default is of.empty}
        for keyword in known:
            for value in WRONG:
                first = {keyword: value}  # the first wrong one is told
                yield name, keyword, value, {**first, **{one: of for one, of in needed.items() if one != keyword}}


def test_no_value_of_another_kind_gets_further_than_the_keyword(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Text for numbers, numbers for text, lists, None, NaN: each function with each in turn."""
    monkeypatch.chdir(tmp_path)
    refused = set()
    for name, keyword, value, options in _calls():
        with pytest.raises((ValueError, AttributeError)) as raised:
            getattr(flexura, name)(**options)
        error, case = raised.value, (name, keyword, value, str(raised.value))
        if isinstance(error, ArgumentKindError):
            assert str(error).startswith((keyword, "value: ")), case
            refused.add((name, keyword, repr(value)))
        elif isinstance(error, AttributeError):
            assert name == "serve", case  # of a twin that is none: the arguments were taken
        elif not isinstance(error, ResultFileError | CampaignFileError):
            # of the right kind, yet not allowed, or something else is missing
            assert isinstance(value, str | int | float | None) or keyword in ("across", "temperature"), case
    for name, keyword, value in [
        ("frf", "mains", "'50'"),
        ("update", "mains", "None"),
        ("gap", "plan", "3"),
        ("focus", "temperature", "True"),
        ("compensate", "place", "2.5"),
        ("health", "rate", "nan"),
        ("thermometer", "seed", "2.5"),
        ("render", "temperature", "[1, 2]"),
        ("identify", "band", "3"),
        ("plot", "value", "3"),
        ("run", "without", "3"),
        ("identify", "out", "''"),
    ]:
        assert (name, keyword, value) in refused


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: flexura.frf(RUN, mains="50"), "mains '50': allowed is a number; write 50, without quotation"),
        (lambda: flexura.frf(RUN, mains="49,9"), "write 49.9, without"),
        (lambda: flexura.frf(RUN, mains=float("nan")), "mains nan: allowed is a number; it must be finite"),
        (lambda: flexura.gap(RUN, hours={"point": "1"}), "hours .*: allowed is a dict of a text to a number"),
        (lambda: flexura.update(RUN, mians=50.0), "update has no keyword 'mians'; did you mean mains?"),
        (lambda: flexura.health("a"), "health: missing a required argument: 'baseline'; it takes dates, baseline"),
        (lambda: flexura.run(RUN, first=2), "first 2: allowed is 'import' or 'identify'"),
    ],
)
def test_a_value_of_another_kind_is_told_with_what_is_allowed(call: Callable[[], object], words: str) -> None:
    with pytest.raises(ArgumentKindError, match=words):
        call()


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: flexura.update(RUN, mains=-50.0), "mains -50 Hz: 10 to 400 allowed"),
        (lambda: flexura.gap(RUN, mains=5), "mains 5 Hz: 10 to 400 allowed"),
        (lambda: flexura.health(RUN, RUN, mains=-50.0), "mains -50 Hz: 10 to 400 allowed"),
        (lambda: flexura.compensate(RUN, place=np.int64(3)), "place 3: allowed is 4 to 40"),
        (lambda: flexura.compensate(RUN, across=[5.0, -2.0]), "across -2 K: allowed is 0.1 to 60 K"),
    ],
)
def test_a_number_that_the_verb_refuses_is_refused_before_files_are_read(
    call: Callable[[], object], words: str
) -> None:
    with pytest.raises(ValueError, match=words):
        call()


def test_scalars_of_numpy_are_numbers() -> None:
    @keyworded
    def takes(count: int, share: float, on: bool, name: str | None = None) -> list[type]:
        return [type(count), type(share), type(on), type(name)]

    assert takes(np.int64(3), np.float32(0.5), np.bool_(True)) == [int, float, bool, type(None)]
    assert takes(np.array(3), 1, False, np.str_("x"))[:2] == [int, float]


@dataclass(frozen=True)
class NotedFrf:
    notes: tuple[str, ...]


@dataclass(frozen=True)
class NotedResult:
    frf: NotedFrf
    notes: tuple[str, ...] = ()

    def __repr__(self) -> str:
        return as_text("NotedResult", (*self.frf.notes, *self.notes))


def test_notes_of_a_result_name_keywords_and_the_panel(tmp_path: Path) -> None:
    @keyworded
    def made(actuator: str = "") -> NotedResult:
        return NotedResult(
            NotedFrf(("modes of the sweeps that A drove: --actuator ID",)),
            ("more taps, or --design field keep more", "make it with: flexura gap C --plan"),
        )

    found = made()
    assert found.frf.notes == ("modes of the sweeps that A drove: actuator ID",)
    assert found.notes[0] == "more taps, or design = field of [filters] of the panel keep more"
    assert found.notes[1] == "make it with: flexura gap C --plan"
    assert "--actuator" not in repr(found)
    assert as_html("x", [], ["take --outside-weight 3"]) == (
        "<p>x</p><p>take outside_weight = 3 of [filters] of the panel</p>"
    )
