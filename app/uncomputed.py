"""What a plate may declare although its twin does not compute it yet: refused before anything is built."""

from analysis.plate import Plate
from app.files.bad_file import ResultFileError

DASHPOTS = ("damping", "rotation_damping")


def require_computed(plate: Plate, origin: str) -> None:
    """Raise ResultFileError, naming every key, unless a twin computes all that a plate declares."""
    found = [
        f"plate.support[{number}].{name} = {getattr(support, name):g}"
        for number, support in enumerate(plate.support)
        for name in DASHPOTS
        if getattr(support, name) > 0.0
    ]
    if found:
        raise ResultFileError(
            f"{origin}: {', '.join(found)}: dashpots of supports can be declared, but no twin computes them yet; "
            f"allowed: 0 (remove {'it' if len(found) == 1 else 'them'}: loss in the supports then counts in the "
            "plate's loss factor)"
        )
