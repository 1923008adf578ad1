"""Untrusted JSON and TOML: of bounded length and depth."""

import codecs
import json
import tomllib
from collections.abc import Callable
from pathlib import Path
from typing import Any

LARGEST_DECLARATION = 1_000_000
"""Bytes: a declaration is a page of text, and more is not one."""
BYTES_AT_ONCE = 1_000_000
"""Bytes read at once."""
DEEPEST_NESTING = 32
"""Tables in tables, lists in lists; a declaration has six."""


def read_text(path: Path, largest: int = LARGEST_DECLARATION) -> str:
    """Read a file of UTF-8 text, see `read_bytes`; UnicodeDecodeError, a ValueError, for other bytes.

    Editors of Windows put a byte order mark before it, and some write UTF-16: then a mark, or the zero byte of the
    first character, tells which.
    """
    content = read_bytes(path, largest)
    if content.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)):
        return content.decode("utf-16")
    wide = {b"\0": "utf-16-be"}.get(content[:1]) or {b"\0": "utf-16-le"}.get(content[1:2])
    return content.decode(wide or "utf-8-sig")


def read_bytes(path: Path, largest: int = LARGEST_DECLARATION) -> bytes:
    """Read a file, or no more of it than is allowed, whatever its system says of its size.

    Raises
    ------
    ValueError
        Where it is larger than `largest` bytes.
    OSError
        Where it cannot be read.
    """
    content = bytearray()
    with path.open("rb") as file:  # piece by piece: asked for all at once, Python sets memory aside for all
        while len(content) <= largest and (piece := file.read(BYTES_AT_ONCE)):
            content += piece
    if len(content) > largest:
        raise ValueError(f"{path.stat().st_size} bytes; allowed: at most {largest}")
    return bytes(content)


def parse_json(text: str | bytes) -> Any:
    """Parse JSON; ValueError where it is none, holds NaN or infinity, or is nested too deeply."""
    return _parsed(lambda: json.loads(text, parse_constant=_refused))


def parse_toml(text: str) -> dict[str, Any]:
    """Parse TOML; ValueError where it is none (TOMLDecodeError, with the place) or is nested too deeply."""
    table: dict[str, Any] = _parsed(lambda: tomllib.loads(text))
    return table


def _parsed(parse: Callable[[], Any]) -> Any:
    try:
        value = parse()
    except RecursionError as error:
        raise ValueError(f"nested more than {DEEPEST_NESTING} deep") from error
    level = [value]
    for _ in range(DEEPEST_NESTING):
        level = [part for held in level for part in _parts(held)]
        if not level:
            return value
    raise ValueError(f"nested more than {DEEPEST_NESTING} deep")


def _parts(held: Any) -> list[Any]:
    inner = held.values() if isinstance(held, dict) else held if isinstance(held, list) else ()
    return [part for part in inner if isinstance(part, dict | list)]


def _refused(name: str) -> float:
    raise ValueError(f"{name} is no number of JSON")
