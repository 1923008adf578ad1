"""Where the examples lie that come with the project: in a clone, or where its wheel put them."""

import re
import sysconfig
from itertools import dropwhile, takewhile
from pathlib import Path

CLONE = Path(__file__).resolve().parents[2] / "examples"
INSTALLED = Path(sysconfig.get_path("data")) / "share" / "flexura" / "examples"


def shipped(name: str) -> Path:
    """Path of one of the examples; it need not exist in an installation that lacks them."""
    return (CLONE if CLONE.is_dir() else INSTALLED) / name


def shipped_names() -> list[str]:
    """Names of all examples, files and folders, in order; empty in an installation that lacks them."""
    folder = shipped("")
    if not folder.is_dir():
        return []
    return sorted(one.name for one in folder.iterdir() if not one.name.startswith((".", "_")))


def described(name: str) -> str:
    """Return what an example says of itself: its first sentence, or that of its README or declaration."""
    path = shipped(name)
    if path.is_dir():
        inside = sorted(path.iterdir(), key=lambda one: (one.name != "README.md", one.suffix != ".toml", one.name))
        path = next((one for one in inside if one.suffix in (".md", ".toml", ".py")), path)
    if not path.is_file():
        return ""
    lines = path.read_text(encoding="utf-8").splitlines()
    words = (line.strip().lstrip('#"%[]').strip() for line in lines if not line.startswith("# %% [markdown]"))
    said = dropwhile(lambda line: not line or line.startswith(("markdown", "format")), words)
    paragraph = " ".join(takewhile(bool, said))
    return re.split(r"(?<=\.)\s", paragraph, maxsplit=1)[0].rstrip('"')
