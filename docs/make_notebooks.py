"""Make the notebooks of examples/notebooks from the scripts beside them: python docs/make_notebooks.py.

A cell begins with ``# %%``, one of words with ``# %% [markdown]``. Two things differ in a notebook, which shows
the last value of a cell by itself: a last line ``print(value)`` becomes ``value``, and of
``flexura.plot(...).savefig(...)`` the figure stays. The same script gives the same bytes.
"""

import hashlib
import json
import re
from pathlib import Path
from typing import Any

NOTEBOOKS = Path(__file__).resolve().parents[1] / "examples" / "notebooks"
SHOWN = ((re.compile(r"print\((\w+)\)"), r"\1"), (re.compile(r"(flexura\.plot\(.*\))\.savefig\(.*\)"), r"\1"))
"""Last lines of a cell, and what they become."""


def cells(script: str) -> list[dict[str, Any]]:
    """Return a script's cells as a notebook holds them."""
    found = []
    for number, part in enumerate(re.split(r"^# %%", script, flags=re.MULTILINE)[1:]):
        head, _, text = part.partition("\n")
        words = head.strip() == "[markdown]"
        lines = text.strip().split("\n")
        if words:
            lines = [line.removeprefix("#").removeprefix(" ") for line in lines]
        else:
            for pattern, shown in SHOWN:
                if pattern.fullmatch(lines[-1]):
                    lines[-1] = pattern.sub(shown, lines[-1])
        source = [f"{line}\n" for line in lines[:-1]] + lines[-1:]
        name = hashlib.sha256(f"{number} {source}".encode()).hexdigest()[:8]
        cell: dict[str, Any] = {"cell_type": "markdown" if words else "code", "id": name, "metadata": {}}
        found.append(cell | {"source": source} | ({} if words else {"execution_count": None, "outputs": []}))
    return found


def notebook(script: Path) -> str:
    """Return the notebook of a script."""
    kernel = {"display_name": "Python 3", "language": "python", "name": "python3"}
    whole = {
        "cells": cells(script.read_text(encoding="utf-8")),
        "metadata": {"kernelspec": kernel, "language_info": {"name": "python"}},
        "nbformat": 4,
        "nbformat_minor": 5,
    }
    return json.dumps(whole, indent=1, ensure_ascii=False) + "\n"


def main() -> None:
    """Write them all."""
    for script in sorted(NOTEBOOKS.glob("*.py")):
        script.with_suffix(".ipynb").write_text(notebook(script), encoding="utf-8")


if __name__ == "__main__":
    main()
