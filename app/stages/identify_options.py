"""Options of the identification, as typed or handed over."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any, Literal, get_args

import numpy as np

from analysis.estimation.transfer import MeasuredTransfer
from analysis.identification.automatic import identify, identify_by_peaks
from analysis.identification.judgement.confirmation import confirmed
from analysis.identification.measured import Measured
from analysis.identification.modes import Damping, Modes
from analysis.identification.pole_residue import choices_for
from analysis.identification.settings import Settings, lines_inside
from analysis.recordings.frf import Frf

Method = Literal["auto", "peak-picking"]


@dataclass(frozen=True)
class Wanted:
    """Options of the identification.

    Attributes
    ----------
    settings : Settings
        Of the search.
    damping : str
        ``hysteretic`` or ``viscous`` reading of poles.
    method : str
        ``auto`` or ``peak-picking``.
    band : (float, float) or None
        Hz; None for all lines.
    actuator : str or None
        Which actuator's sweeps are used, if several drove the plate in turn; None for the first.
    temperature : float or None
        Of the sweep whose FRFs are exported, degrees Celsius; None for all.
    """

    settings: Settings
    damping: Damping
    method: Method
    band: tuple[float, float] | None
    actuator: str | None = None
    temperature: float | None = None

    def __post_init__(self) -> None:
        for name, choices in (("damping", get_args(Damping)), ("method", get_args(Method))):
            if getattr(self, name) not in choices:
                raise ValueError(f"{name} {getattr(self, name)!r}: {' or '.join(choices)}")
        if self.band is not None and not (len(self.band) == 2 and 0.0 <= self.band[0] < self.band[1]):
            said = " to ".join(f"{edge:g}" for edge in self.band)
            raise ValueError(f"band {said} Hz: two frequencies, ascending, wanted")

    def record(self) -> dict[str, Any]:
        """Return the options in the form stored in a result file's provenance."""
        return {
            "method": self.method,
            "damping": self.damping,
            "band_hz": None if self.band is None else list(self.band),
            "mains_hz": self.settings.mains,
            "start_count": self.settings.start_count,
            "most_count": self.settings.most_count,
            **({} if self.actuator is None else {"actuator": self.actuator}),
        }

    def at_mains(self, mains: float) -> "Wanted":
        """Return the options with another mains frequency, Hz."""
        return replace(self, settings=replace(self.settings, mains=mains))

    def cut(self, frf: Frf) -> Frf:
        """Return a campaign's FRFs on the lines inside the band; ValueError where it holds too few."""
        if self.band is None:
            return frf
        inside = lines_inside(frf.frequency, self.band)
        return replace(
            frf,
            frequency=frf.frequency[inside],
            h=frf.h[:, :, inside],
            variance=frf.variance[:, :, inside],
            coherence=frf.coherence[:, :, inside],
            excluded=frf.excluded[inside],
        )

    def one_by_one(self) -> Callable[[Measured, Settings], Modes] | None:
        """Return the method that identifies each sweep alone, or None where sweeps are fitted jointly."""
        return identify_by_peaks if self.method == "peak-picking" else None

    def identify(self, frfs: Sequence[MeasuredTransfer]) -> Modes:
        """Identify FRFs with common poles and lines; ValueError if there is nothing to identify."""
        terms = choices_for({frf.quantity for frf in frfs})
        frequency = frfs[0].frequency
        inside = np.ones(len(frequency), dtype=bool) if self.band is None else lines_inside(frequency, self.band)
        known = [frf.variance[inside] for frf in frfs if frf.variance is not None]
        variance = np.array(known) if len(known) == len(frfs) else None
        measured = Measured(frequency[inside], np.array([frf.h[inside] for frf in frfs]), variance)
        settings = replace(self.settings, terms=terms)
        return confirmed(measured, (self.one_by_one() or identify)(measured, settings)).read_as(self.damping)
