"""What a run holds, each file read when it is first looked at, and FRFs to be laid over those measured."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Complex, Real
from analysis.compensation.outcome import Compensation
from analysis.experiment import Experiment
from analysis.focusing.methods import MethodComparison
from analysis.focusing.over_temperature import Focusing
from analysis.focusing.panel import Panel
from analysis.focusing.pareto import ParetoCurve
from analysis.identification.over_temperature.tracked_modes import TrackedModes
from analysis.material import MaterialLaws
from analysis.recordings.campaign import CampaignExtent
from analysis.recordings.frf import Frf, campaign_frf, sweeps_of_modes
from analysis.recordings.frf_campaign import AnyCampaign
from analysis.updated import Updated
from app.files.bad_file import ResultFileError
from app.files.campaign_error import CampaignFileError
from app.files.campaigns.inputs import OF_CAMPAIGN, origin_of_result, said_of_more_sweeps
from app.files.campaigns.loading import load_campaign
from app.files.results.best_twin import CORRECTED, PLAIN, BestTwin, TwinOfRun, best_twin
from app.files.results.laws_file import TwinFrf, load_pairing
from app.files.results.modes_file import load_frf, load_modes
from app.files.results.panel_files import load_compensation, load_focusing, load_pareto
from app.files.results.run_folder import MADE_BY
from app.view.folder import Viewed
from app.view.frf_plots import POINTS_OF_CIRCLE
from app.view.recorded.fields import made_with_corrected_laws

if TYPE_CHECKING:
    from app.files.results.gap_file import GapFigures, Signatures

Value = TypeVar("Value")


class Results:
    """Everything that may be looked at; what is not there, or cannot be read, is None.

    Parameters
    ----------
    viewed : Viewed

    Attributes
    ----------
    viewed : Viewed
    problems : dict of str to str
        What is wrong with a file, by its name; filled as files are read.
    """

    def __init__(self, viewed: Viewed) -> None:
        self.viewed = viewed
        self.problems: dict[str, str] = {}

    def has(self, name: str) -> bool:
        """Whether a file of results is there, readable or not."""
        return self.viewed.run is not None and (self.viewed.run / name).is_file()

    @cached_property
    def measured(self) -> tuple[Experiment, Frf] | None:
        """FRFs of the run, or estimated here and now where no verb has done so yet."""
        if self.has("frf.h5"):
            return self._read("frf.h5", load_frf)
        campaign = self._campaign
        if campaign is None:
            return None
        try:
            return campaign.experiment, campaign_frf(campaign)
        except ValueError as error:
            self.problems[campaign.name] = str(error)
            return None

    @cached_property
    def extent(self) -> CampaignExtent | None:
        """How complete the campaign was when its FRFs were estimated; None where it was, or that is unknown."""
        if not self.has("frf.h5"):
            return None if self._campaign is None else self._campaign.extent
        found = self._read("frf.h5", lambda path: origin_of_result(path, "update"))
        return None if found is None else found.extent

    @cached_property
    def outdated(self) -> dict[str, str]:
        """Which results are of other sweeps than their campaign has now, by file: what to say of each."""
        said: dict[str, str] = {}
        run = self.viewed.run
        if run is None:
            return said
        for name in filter(self.has, OF_CAMPAIGN):
            verb = MADE_BY[name].split()[0]
            found = self._read(name, lambda path, verb=verb: origin_of_result(path, verb))
            more = None if found is None else said_of_more_sweeps(run, found.inputs, verb)
            if more is not None:
                said[name] = more
        return said

    @cached_property
    def _campaign(self) -> AnyCampaign | None:
        """The campaign itself, which is read where no verb has estimated its FRFs yet."""
        if self.viewed.campaign is None:
            return None
        try:
            return load_campaign(self.viewed.campaign)
        except CampaignFileError as error:
            self.problems[self.viewed.campaign.name] = str(error)
            return None

    @cached_property
    def modes(self) -> TrackedModes | None:
        """What was identified."""
        return self._read("modes.h5", load_modes)

    @cached_property
    def best(self) -> BestTwin | None:
        """The best twin; what of the comparison is not used is among the problems."""
        found = self._read(PLAIN, _whole)
        if found is not None and found.ignored:
            self.problems[CORRECTED] = " ".join(found.ignored)
        return found

    @property
    def plain(self) -> TwinOfRun | None:
        """The twin of flexura update."""
        return None if self.best is None else self.best.uncorrected or self.best.twin

    @property
    def corrected(self) -> tuple[Updated, TwinFrf] | None:
        """The same under the effects that were found; None where the best twin is the plain one."""
        if self.best is None or self.best.uncorrected is None:
            return None
        return self.best.twin.updated, self.best.twin.answers

    @property
    def updated(self) -> tuple[Updated, TwinFrf] | None:
        """Estimates per sweep, and what the updated twin answers."""
        return None if self.plain is None else (self.plain.updated, self.plain.answers)

    @property
    def laws(self) -> MaterialLaws | None:
        """Laws through them; None for too few temperatures."""
        return None if self.plain is None else self.plain.laws

    @property
    def corrected_laws(self) -> MaterialLaws | None:
        """Laws under the effects that were found."""
        return None if self.best is None or self.best.uncorrected is None else self.best.twin.laws

    @cached_property
    def focusing(self) -> tuple[Panel, Focusing, MethodComparison] | None:
        """Filters and what they reach."""
        return self._read("filters.h5", load_focusing)

    @cached_property
    def pareto(self) -> ParetoCurve | None:
        """Contrast against evenness of the sound; None where the aim is the field."""
        return self._read("filters.h5", load_pareto)

    @cached_property
    def compensation(self) -> Compensation | None:
        """Networks and what they reach."""
        found = self._read("compensation.h5", load_compensation)
        return None if found is None else found[1]

    @cached_property
    def gap(self) -> "tuple[GapFigures, dict[str, Any]] | None":
        """Where twin and data disagree."""
        from app.files.results.gap_file import load_gap

        return self._read("gap.h5", load_gap)

    @cached_property
    def signatures(self) -> "Signatures | None":
        """What each effect alone would explain of it."""
        from app.files.results.gap_file import load_signatures

        return self._read("gap.h5", load_signatures)

    @cached_property
    def pairing(self) -> dict[str, Any] | None:
        """Measured modes beside those of the best twin; None where there is no record of them."""
        if self.corrected is not None and self.gap is not None:
            found = self.gap[1].get("pairing")
            return found if isinstance(found, dict) else None
        return self._read(PLAIN, load_pairing)

    @property
    def panel_laws(self) -> MaterialLaws | None:
        """Laws the filters were designed with."""
        if self.focusing is None or self.viewed.run is None:
            return None
        return self.corrected_laws if made_with_corrected_laws(self.viewed.run / "filters.h5") else self.laws

    def _read(self, name: str, load: Callable[..., Value]) -> Value | None:
        if self.viewed.run is None or not self.has(name):
            return None
        try:
            return load(self.viewed.run / name)
        except (OSError, KeyError, TypeError, ValueError) as error:  # whatever a damaged file may lead to
            self.problems[name] = str(error)
            return None


def _whole(path: Path) -> BestTwin:
    """Read the best twin beside laws.h5, all that pages ask of it now: what cannot be read is a problem."""
    best = best_twin(path.parent, "view")
    for one in filter(None, (best.twin, best.uncorrected)):
        one.laws, one.updated  # noqa: B018 - read here to report errors
    try:
        best.before  # noqa: B018 - as above
    except ResultFileError as error:
        return replace(best, compared=None, ignored=(*best.ignored, str(error)))
    return best


UNMENTIONED_SHARE = 0.02
"""Share of lines outside an identified band that is not mentioned: mains lines at its ends are never fitted."""


@dataclass(frozen=True)
class Computed:
    """FRFs that are there: `h` (T, K, F) at `frequency` (F,), Hz."""

    frequency: Real
    h: Complex

    def __len__(self) -> int:
        """Sweeps."""
        return len(self.h)

    def sweep(self, row: int) -> Complex:
        """One sweep, (K, F)."""
        return np.asarray(self.h[row])

    def between(self, row: int, band: tuple[float, float]) -> Complex:
        """One sweep inside a band, Hz: (K, n)."""
        return np.asarray(self.h[row][:, (self.frequency >= band[0]) & (self.frequency <= band[1])])

    def line(self, rows: NDArray[np.intp], frequency: float) -> Complex:
        """Several sweeps at the nearest line, (R, K)."""
        return np.asarray(self.h[rows, :, int(np.abs(self.frequency - frequency).argmin())])


@dataclass(frozen=True)
class Identified:
    """FRFs rebuilt from poles and residues where they are looked at: all of a long campaign would take seconds.

    NaN outside the band that was identified, where they hold no longer.
    """

    frequency: Real
    modes: TrackedModes
    places: NDArray[np.int_]
    """Of every sweep among those of `modes`, -1 where it is none of them: there is nothing to draw."""

    def __len__(self) -> int:
        """Sweeps."""
        return len(self.places)

    def sweep(self, row: int) -> Complex:
        """One sweep, (K, F)."""
        return self._rebuilt(row, self.frequency)

    def between(self, row: int, band: tuple[float, float]) -> Complex:
        """One sweep inside a band, Hz, finer than its lines: (K, n)."""
        return self._rebuilt(row, np.linspace(*band, POINTS_OF_CIRCLE))

    def line(self, rows: NDArray[np.intp], frequency: float) -> Complex:
        """Several sweeps at one frequency, (R, K)."""
        return np.array([self._rebuilt(int(row), np.array([frequency]))[:, 0] for row in rows])

    def narrower(self, row: int) -> tuple[float, float] | None:
        """Band of a sweep that was identified, Hz, if more than a few lines at the ends are outside."""
        if self.places[row] < 0:
            return None
        low, high = self.modes.modes[int(self.places[row])].band
        return (
            (low, high) if ((self.frequency < low) | (self.frequency > high)).mean() > UNMENTIONED_SHARE else None
        )

    def _rebuilt(self, row: int, frequency: Real) -> Complex:
        if self.places[row] < 0:
            return np.full((len(self.modes.channels), len(frequency)), complex(np.nan, np.nan))
        modes = self.modes.modes[int(self.places[row])]
        inside = (frequency >= modes.band[0]) & (frequency <= modes.band[1])
        return np.where(inside, modes.synthesis(frequency), complex(np.nan, np.nan))


Answer = Identified | Computed


def answers(frf: Frf, results: Results) -> dict[str, Answer]:
    """All that may be laid over the FRFs measured, by name."""
    found: dict[str, Answer] = {}
    places = None if results.modes is None else sweeps_of_modes(frf, results.modes)
    if results.modes is not None and places is not None and (places >= 0).any():
        found["from poles and residues"] = Identified(frf.frequency, results.modes, places)
    for name, held in (("updated twin", results.updated), ("corrected twin", results.corrected)):
        if held is not None:
            found[name] = Computed(held[1].frequency, held[1].h)
    return {name: answer for name, answer in found.items() if len(answer) == len(frf.h)}
