"""The examples that come with Flexura, wherever it is installed."""

from pathlib import Path

from app.files.shipped import shipped, shipped_names


def example(name: str) -> Path:
    """Return the path of a shipped example, such as ``"pp-plate"`` or ``"hidden-effect.toml"``.

    It is for reading: ``flexura examples NAME`` copies one to work on. Raises ValueError with all names for one
    that is not there.
    """
    folder = shipped("")
    found = (folder / name).resolve()
    if not name or not found.is_relative_to(folder.resolve()) or not found.exists():
        there = ", ".join(shipped_names()) or "none, in this installation"
        raise ValueError(f"no example {name!r}; there are: {there}")
    return found
