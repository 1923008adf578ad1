"""What functions of the library refuse is told in their keywords, not in the options of the verbs."""

import inspect
from collections.abc import Callable
from pathlib import Path

import pytest

import flexura
from app.files.bad_file import ResultFileError, UnsuitedOptionError
from flexura.keywords import in_keywords, keyworded

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
