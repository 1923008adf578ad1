"""One of our modules as a process of its own: its command, and what it needs of the surroundings."""

import os
import sys
from pathlib import Path

PROGRAM = Path(__file__).resolve().parents[1]
"""Where our packages lie."""


def module_command(module: str, *arguments: str) -> list[str]:
    """Return the command that runs one of our modules, by its dotted name."""
    return [sys.executable, "-P", "-m", module, *arguments]


def own_surroundings() -> dict[str, str]:
    """Return the environment in which it finds our packages, and the installed ones.

    Not those of the current folder, which may be untrusted: a package there would be run in the place of ours.
    """
    others = [entry for entry in sys.path if Path(entry).resolve() != Path.cwd().resolve()]
    return os.environ | {"PYTHONPATH": os.pathsep.join([str(PROGRAM), *others])}
