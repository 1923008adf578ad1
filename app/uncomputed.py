"""What a plate may declare although its twin does not compute it yet: refused before anything is built."""

from analysis.plate import Plate
from app.files.bad_file import ResultFileError


def require_computed(plate: Plate, origin: str) -> None:
    """Raise ResultFileError, naming the key, unless a twin computes all that a plate declares."""
    if plate.expansion:
        raise ResultFileError(
            f"{origin}: plate.expansion = {plate.expansion:g} 1/K: thermal expansion can be declared, but no twin "
            "computes it yet; allowed: 0 (remove it: the dimensions then hold at every temperature T, and the E "
            "that is found is 1 + expansion (T - dimensions_at) times that of the material)"
        )
