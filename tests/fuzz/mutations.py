"""Damage: to any bytes, and to numbers, words and lines of text as a hand or a stranger would do it."""

import json
import re
from collections.abc import Callable, Iterator, Sequence

import numpy as np

Change = Callable[[bytes, np.random.Generator], bytes]
NUMBERS = [
    *(
        "0",
        "-1",
        "1",
        "2",
        "-0.0",
        "1e-320",
        "1e308",
        "1e999",
        "-1e999",
        "nan",
        "inf",
        "-inf",
        "1e9",
        "4294967296",
    ),
    *(
        "9223372036854775808",
        "100000000",
        "0.1",
        "1e5",
        "true",
        "false",
        "[]",
        "{}",
        "''",
        '"x"',
        "[1]",
        "2026-01-01",
    ),
    *("9" * 5000, "[" * 3000, "[" * 60 + "]" * 60, "{a=" * 50 + "1" + "}" * 50),
]
TINY_AND_LARGE = ["-1e-320", "5e-324", "1e-9", "1e-5", "1e15", "1e300"]
VALUE = rb'(?<==)\s*(?:"[^"\\\n]*"|[-+]?\d[\w.+-]*|true|false)|(?<=[\[,])\s*[-+]?\d[\w.+-]*(?=\s*[,\]])'
"""Of TOML: what stands behind a key, or a number in a list."""
WORDS = ["", "\x00", "\\ud800", "a" * 3000, "../../x", "é", "-1"]


def mutated(whole: bytes, rng: np.random.Generator, text: bool) -> bytes:
    """Return a damaged copy; where `text`, mostly damaged as text."""
    changes = TEXT if text and rng.random() < 0.75 else BYTES
    damaged = whole
    for _ in range(int(rng.integers(1, 4))):
        damaged = changes[int(rng.integers(len(changes)))](damaged, rng)
    return damaged


def with_odd_values(whole: bytes) -> Iterator[bytes]:
    """Replace every value of a TOML text in turn by every odd one, all else left as it is."""
    words = [f'"{word}"' for word in ("../../x", "\\u0000", "é", "9" * 5000, "/dev/tty" + "9" * 5000, "a" * 3000)]
    for found in re.finditer(VALUE, whole):
        for value in (*NUMBERS[:-3], *TINY_AND_LARGE, *words):
            yield whole[: found.start()] + b" " + value.encode() + whole[found.end() :]


def _span(whole: bytes, rng: np.random.Generator, longest: int = 64) -> tuple[int, int]:
    begin = int(rng.integers(len(whole) + 1))
    return begin, min(begin + int(rng.integers(1, longest + 1)), len(whole))


def _flip(whole: bytes, rng: np.random.Generator) -> bytes:
    damaged = bytearray(whole)
    for _ in range(int(rng.integers(1, 9)) if damaged else 0):
        damaged[int(rng.integers(len(damaged)))] ^= 1 << int(rng.integers(8))
    return bytes(damaged)


def _overwrite(whole: bytes, rng: np.random.Generator) -> bytes:
    begin, end = _span(whole, rng)
    fill = (b"\0" * 64, b"\xff" * 64, rng.bytes(64))[int(rng.integers(3))]
    return whole[:begin] + fill[: end - begin] + whole[end:]


def _number(whole: bytes, rng: np.random.Generator) -> bytes:
    size = (2, 4, 8)[int(rng.integers(3))]
    value = (0, 1, 2 ** (8 * size - 1) - 1, 2 ** (8 * size) - 1, 2 ** (8 * size - 4), 10_000)[int(rng.integers(6))]
    begin = int(rng.integers(len(whole) + 1)) // size * size
    return whole[:begin] + (value % 2 ** (8 * size)).to_bytes(size, "little") + whole[begin + size :]


def _cut(whole: bytes, rng: np.random.Generator) -> bytes:
    return whole[: int(rng.integers(len(whole) + 1))]


def _remove(whole: bytes, rng: np.random.Generator) -> bytes:
    begin, end = _span(whole, rng, 2000)
    return whole[:begin] + whole[end:]


def _repeat(whole: bytes, rng: np.random.Generator) -> bytes:
    begin, end = _span(whole, rng, 2000)
    return whole[:end] + whole[begin:end] * int(rng.integers(1, 20)) + whole[end:]


def _append(whole: bytes, rng: np.random.Generator) -> bytes:
    return whole + rng.bytes(int(rng.integers(1, 600)))


def _lines(whole: bytes, rng: np.random.Generator) -> bytes:
    lines = whole.splitlines(keepends=True)
    if not lines:
        return whole
    here, there = (int(rng.integers(len(lines))) for _ in range(2))
    what = int(rng.integers(4))
    if what == 0:
        del lines[here]
    elif what == 1:
        lines.insert(here, lines[there])
    elif what == 2:
        lines[here], lines[there] = lines[there], lines[here]
    else:
        lines[here : here + 1] = [lines[here]] * int(rng.integers(2, 400))
    return b"".join(lines)


def _replaced(pattern: bytes, choices: Sequence[str]) -> Change:
    def change(whole: bytes, rng: np.random.Generator) -> bytes:
        found = list(re.finditer(pattern, whole))
        if not found:
            return whole
        one = found[int(rng.integers(len(found)))]
        new = choices[int(rng.integers(len(choices)))].encode("utf-8", "replace")
        return whole[: one.start()] + new + whole[one.end() :]

    return change


def _parsed(whole: bytes, rng: np.random.Generator) -> bytes:
    """Change one value of a JSON text and write it anew, so that the text itself is faultless."""
    try:
        lines = (
            [json.loads(line) for line in whole.splitlines()] if whole.count(b"\n") > 1 else [json.loads(whole)]
        )
    except (ValueError, RecursionError):  # changed before, and no longer JSON that is read
        return whole
    held = lines[int(rng.integers(len(lines)))]
    for _ in range(8):
        if not isinstance(held, dict | list) or not held:
            break
        keys = list(held) if isinstance(held, dict) else list(range(len(held)))
        key = keys[int(rng.integers(len(keys)))]
        if not isinstance(held[key], dict | list) or rng.random() < 0.3:
            values = (
                None,
                [],
                {},
                "",
                "x",
                -1,
                1e300,
                10**400,
                True,
                [[[]]],
                "2026-13-01",
                "9999-12-31",
                3.5,
                [1],
            )
            held[key] = values[int(rng.integers(len(values)))]
            break
        held = held[key]
    return "".join(json.dumps(line) + "\n" for line in lines).encode()


BYTES: tuple[Change, ...] = (_flip, _flip, _overwrite, _number, _cut, _remove, _repeat, _append)
TEXT: tuple[Change, ...] = (
    _lines,
    _replaced(rb"-?\d+\.?\d*(?:[eE][-+]?\d+)?", NUMBERS),
    _replaced(rb"-?\d+\.?\d*(?:[eE][-+]?\d+)?", NUMBERS),
    _replaced(rb"[A-Za-z_]{3,}", WORDS),
    _replaced(rb"[\[\]{}\"=,]", ["", "[", "]", "{", "}", '"', "=", ",", "\n", "'''"]),
    _parsed,
    _flip,
    _cut,
)
