"""What the identify verb was asked for, and FRFs of universal files identified accordingly."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from analysis.frf import Frf
from analysis.identification.automatic import Settings, identify
from analysis.identification.measured import Measured
from analysis.identification.modes import Modes
from analysis.identification.peak_picking import identify_by_peaks
from analysis.identification.reading import Damping
from analysis.identification.residual_terms import EVERY_CHOICE, choices_for
from app.files.bad_file import ResultFileError
from app.files.uff58 import UffFrf
from app.mode_records import modes_record
from app.progress import Report


@dataclass(frozen=True)
class Wanted:
    """Options of the verb.

    Attributes
    ----------
    settings : Settings
        Of the search.
    damping : str
        How poles are read.
    method : str
        ``auto`` or ``peak-picking``.
    band : (float, float) or None
        Hz; None for all lines.
    """

    settings: Settings
    damping: Damping
    method: str
    band: tuple[float, float] | None

    def record(self) -> dict[str, Any]:
        """Return the options as a result file's provenance holds them."""
        return {
            "method": self.method,
            "damping": self.damping,
            "band_hz": None if self.band is None else list(self.band),
            "mains_hz": self.settings.mains,
            "start_count": self.settings.start_count,
            "most_count": self.settings.most_count,
        }

    def cut(self, frf: Frf) -> Frf:
        """Return a campaign's FRFs inside the band."""
        if self.band is None:
            return frf
        inside = (frf.frequency >= self.band[0]) & (frf.frequency <= self.band[1])
        return replace(
            frf,
            frequency=frf.frequency[inside],
            h=frf.h[:, :, inside],
            variance=frf.variance[:, :, inside],
            coherence=frf.coherence[:, :, inside],
            excluded=frf.excluded[inside],
        )

    def one_by_one(self) -> Callable[[Measured, Settings], Modes] | None:
        """Return the method that takes each sweep alone, or None where sweeps follow from one to the next."""
        return identify_by_peaks if self.method == "peak-picking" else None

    def identify(self, frfs: Sequence[UffFrf]) -> Modes:
        """Identify FRFs that share poles and lines; ValueError where there is nothing to be found."""
        quantities = {frf.quantity for frf in frfs}
        terms = choices_for(quantities.pop()) if len(quantities) == 1 else EVERY_CHOICE
        frequency = frfs[0].frequency
        low, high = self.band or (0.0, np.inf)
        inside = (frequency >= low) & (frequency <= high)
        measured = Measured(frequency[inside], np.array([frf.h[inside] for frf in frfs]))
        settings = replace(self.settings, terms=terms)
        return (self.one_by_one() or identify)(measured, settings)


def uff_records(frfs: Sequence[UffFrf], wanted: Wanted, report: Report) -> list[dict[str, Any]]:
    """Identify FRFs one by one; an FRF with nothing in it gets a note instead of modes."""
    records = []
    for done, frf in enumerate(frfs):
        report("identify", done / len(frfs))
        try:
            found = modes_record(wanted.identify([frf]), wanted.damping)
        except ValueError as error:
            found = {"residual_terms": None, "misfit": None, "modes": [], "rejected": [], "note": str(error)}
        records.append(_named(frf) | found)
    report("identify", 1.0)
    return records


def shared_records(path: Path, frfs: Sequence[UffFrf], wanted: Wanted, report: Report) -> list[dict[str, Any]]:
    """Identify all FRFs with one set of poles; the same modes for each.

    Raises ResultFileError where the FRFs differ in their lines or hold nothing to be found.
    """
    for frf in frfs[1:]:
        same = frf.frequency.shape == frfs[0].frequency.shape
        if not same or not np.allclose(frf.frequency, frfs[0].frequency, rtol=1e-6):
            raise ResultFileError(
                f"{path}: {frf.name!r} and {frfs[0].name!r} have different frequency lines: identify them one by "
                "one, without --shared-poles"
            )
    report("identify", 0.0)
    try:
        found = modes_record(wanted.identify(frfs), wanted.damping)
    except ValueError as error:
        raise ResultFileError(f"{path}: {error}") from error
    report("identify", 1.0)
    return [_named(frf) | found for frf in frfs]


def _named(frf: UffFrf) -> dict[str, Any]:
    return {"name": frf.name, "response": frf.response, "reference": frf.reference, "quantity": frf.quantity}
