from typing import Annotated, Literal

import pytest
from pydantic import BaseModel, Field

from app.files.allowed_values import allowed_at, key_at, keys_at


class Inner(BaseModel):
    side: Literal["top", "bottom"]
    note: str | None = None


class Round(BaseModel):
    kind: Literal["round"]
    radius: Annotated[float, Field(gt=0.0, description="m")]


class Square(BaseModel):
    kind: Literal["square"]
    side: Annotated[float, Field(gt=0.0, alias="from")]


class Outer(BaseModel):
    length: Annotated[float, Field(ge=0.1, lt=5.0, description="m")]
    count: Annotated[int, Field(gt=0)]
    band: Annotated[tuple[float, float], Field(description="Hz")]
    steps: Annotated[
        tuple[Annotated[float, Field(le=9.0, description="V")], ...], Field(min_length=2, max_length=7)
    ]
    points: Annotated[tuple[tuple[float, float], ...], Field(min_length=3, description="m")]
    inner: Inner
    many: tuple[Inner, ...]
    maybe: Inner | None = None
    legs: Annotated[tuple[Literal["down", "up"], ...], Field(min_length=1, max_length=2)] = ("up",)
    share: Annotated[float | None, Field(ge=0.0, le=1.0)] = None
    either: int | str | None = None
    number: int | Literal["all"] | None = None
    edge: Annotated[int, Field(ge=1)] | Literal["left", "right"] | None = None
    shape: Annotated[Round | Square, Field(discriminator="kind")] | None = None


@pytest.mark.parametrize(
    ("place", "words"),
    [
        (("length",), "a number from 0.1 below 5 (m)"),
        (("count",), "an integer above 0"),
        (("band",), "a list of 2 numbers (Hz)"),
        (("steps",), "a list of numbers, at least 2, at most 7"),
        (("points",), "a list of lists of 2 numbers, at least 3 (m)"),
        (("steps", 3), "a number to 9 (V)"),
        (("inner",), "a table with the keys side, note"),
        (("many", 1, "side"), "'top' or 'bottom'"),
        (("many", 0, "note"), "a text"),
        (("maybe",), "a table with the keys side, note"),
        (("maybe", "side"), "'top' or 'bottom'"),
        (("legs",), "a list of 'down' or 'up', at least 1, at most 2"),
        (("share",), "a number from 0 to 1"),
        (("either",), "an integer or a text"),
        (("unknown", "deeper"), "a value"),
        (("number",), "an integer or 'all'"),
        (("edge",), "an integer from 1 or 'left' or 'right'"),
        (("number", "literal['all']"), "an integer or 'all'"),
        (("shape",), "a table"),
        (("shape", "kind"), "'round' or 'square'"),
        (("shape", "round", "radius"), "a number above 0 (m)"),
        (("shape", "square"), "a table with the keys kind, from"),
        (("shape", "square", "from"), "a number above 0"),
    ],
)
def test_every_kind_of_key_in_words(place: tuple[int | str, ...], words: str) -> None:
    assert allowed_at(Outer, place) == words


def test_keys_of_tables() -> None:
    assert keys_at(Outer, ("many", 0)) == ("side", "note")
    assert keys_at(Outer, ())[:4] == ("length", "count", "band", "steps")
    assert keys_at(Outer, ("shape", "square")) == ("kind", "from")
    assert keys_at(Outer, ("maybe",)) == ("side", "note")
    assert keys_at(Outer, ("length",)) == ()


def test_keys_are_those_of_the_file() -> None:
    assert key_at(Outer, ("many", 1, "side")) == "many[1].side"
    assert key_at(Outer, ("shape", "round", "radius")) == "shape.radius"
    assert key_at(Outer, ("number", "int")) == "number"
    assert key_at(Outer, ("shape", "kind")) == "shape.kind"
    assert key_at(Outer, ()) == ""
