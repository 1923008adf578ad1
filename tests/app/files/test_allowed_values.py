from typing import Annotated, Literal

import pytest
from pydantic import BaseModel, Field

from app.files.allowed_values import allowed_at, keys_at


class Inner(BaseModel):
    side: Literal["top", "bottom"]
    note: str | None = None


class Outer(BaseModel):
    length: Annotated[float, Field(ge=0.1, lt=5.0, description="m")]
    count: Annotated[int, Field(gt=0)]
    band: Annotated[tuple[float, float], Field(description="Hz")]
    steps: Annotated[
        tuple[Annotated[float, Field(le=9.0, description="V")], ...], Field(min_length=2, max_length=7)
    ]
    inner: Inner
    many: tuple[Inner, ...]
    maybe: Inner | None = None
    share: Annotated[float | None, Field(ge=0.0, le=1.0)] = None
    either: int | str | None = None


@pytest.mark.parametrize(
    ("place", "words"),
    [
        (("length",), "a number from 0.1 below 5 (m)"),
        (("count",), "an integer above 0"),
        (("band",), "a list of 2 numbers (Hz)"),
        (("steps",), "a list of numbers, at least 2, at most 7"),
        (("steps", 3), "a number to 9 (V)"),
        (("inner",), "a table with the keys side, note"),
        (("many", 1, "side"), "'top' or 'bottom'"),
        (("many", 0, "note"), "a text"),
        (("maybe",), "a table with the keys side, note"),
        (("maybe", "side"), "'top' or 'bottom'"),
        (("share",), "a number from 0 to 1"),
        (("either",), "an integer or a text"),
        (("unknown", "deeper"), "a value"),
    ],
)
def test_every_kind_of_key_in_words(place: tuple[int | str, ...], words: str) -> None:
    assert allowed_at(Outer, place) == words


def test_keys_of_tables() -> None:
    assert keys_at(Outer, ("many", 0)) == ("side", "note")
    assert keys_at(Outer, ()) == ("length", "count", "band", "steps", "inner", "many", "maybe", "share", "either")
    assert keys_at(Outer, ("maybe",)) == ("side", "note")
    assert keys_at(Outer, ("length",)) == ()
