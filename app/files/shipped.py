"""Where the examples lie that come with the project: in a clone, or where its wheel put them."""

import sysconfig
from pathlib import Path

CLONE = Path(__file__).resolve().parents[2] / "examples"
INSTALLED = Path(sysconfig.get_path("data")) / "share" / "flexura" / "examples"


def shipped(name: str) -> Path:
    """Path of one of the examples; it need not exist in an installation that lacks them."""
    return (CLONE if CLONE.is_dir() else INSTALLED) / name
