"""Picture of a declaration with a geometric error."""

from collections.abc import Mapping
from pathlib import Path

from app.files.misplaced import Misplaced


def fault_picture(wrong: Misplaced, options: Mapping[str, object]) -> str:
    """Draw the error, and return a sentence with the picture's path, beside --out or else the declaration."""
    from app.files.atomic import atomic_path
    from app.report.declared import picture
    from app.report.refused import pieces_declared

    target = _target(wrong.source, options.get("out"))
    figure = picture(pieces_declared(wrong), wrong.places)
    try:
        with atomic_path(target) as path:
            figure.savefig(path, format="png", dpi=120)
    except OSError as error:
        return f"(a picture of it is missing: {error})"
    return f"picture: {target}"


def _target(source: Path, out: object) -> Path:
    from app.files.campaign_kind import DECLARATION

    beside = source.parent if source.name == DECLARATION else source.with_suffix("")
    return (out if isinstance(out, Path) else beside).resolve().with_name(f"{beside.resolve().name}-geometry.png")
