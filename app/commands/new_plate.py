"""``flexura new plate``: which plate the FRFs of other programs are of."""

from pathlib import Path

from app.commands.output import Output
from app.files.bad_file import quoted


def write_plate(
    files: tuple[Path, ...],
    plate: tuple[float, float, float, float] | None,
    units: tuple[str, str] | None,
    points: Path | None,
    title: str,
    folder: Path,
    output: Output,
) -> None:
    """Write the declaration of a plate and print what is to be completed in it.

    Parameters
    ----------
    plate : (float, float, float, float) or None
    units : (str, str) or None
    title : str
        These four as in `app.plate_frfs.new_plate.SaidOfPlate`.
    folder : Path
        Or the declaration's name.
    """
    from app.plate_frfs.new_plate import SaidOfPlate, new_plate

    declaration, missing, notes = new_plate(files, SaidOfPlate(plate, units, points, title), folder)
    output.result(lambda: {"declaration": str(declaration), "missing": missing, "notes": notes})
    named = declaration.parent if declaration.name == "plate.toml" else declaration
    for note in notes:
        output.note(note)
    if missing:
        output.note(f"to be completed, each a line that begins with #: {', '.join(missing)}")
    first = "complete it" if missing else "check it"
    output.summary(f"{declaration}: {first}, then: flexura update {quoted(named)}")
