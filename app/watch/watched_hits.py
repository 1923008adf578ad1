"""A hammer test's folder as it grows: read-only, and never stopped by what is damaged in it."""

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from analysis.checked_fields import check_shapes
from app.files.acquisition.events import NAME as EVENTS
from app.files.acquisition.events import Tail, read_events
from app.files.acquisition.hammer_folder import HITS, REJECTED, begun_with
from app.files.campaign_error import CampaignFileError
from app.files.campaigns.kind import HAMMER_TEST
from app.files.declarations.hammer_experiment import HammerExperiment, hammer_model
from app.files.folder_lock import is_being_written
from app.files.hdf5_file import Hdf5FileError, opened_hdf5
from app.files.settings_toml import checked
from app.watch.watched import WATCHDOG, told_by_watchdog
from drivers.hammer.judged_hit import ACCEPTED, HammerProgress, KeptHit
from drivers.hammer.judged_hit import REJECTED as REFUSED


@dataclass(frozen=True)
class HeardHit:
    """The hit that was recorded last.

    Attributes
    ----------
    step : int
        Its number in the campaign, from 0.
    point : int
        From 0.
    rejected : str
        Why it does not count; empty where it does.
    peak : float
        N.
    coherence : float or None
        Of all hits at its point, where it was told.
    time : (N,) ndarray, s
        From the largest force on.
    signals : (C, N) ndarray
        Force, then the responses, SI; empty where the file cannot be read.
    """

    step: int
    point: int
    rejected: str
    peak: float
    coherence: float | None
    time: NDArray[np.float64]
    signals: NDArray[np.float64]

    def __post_init__(self) -> None:
        check_shapes(self, time="N", signals="C N")


@dataclass
class WatchedHits:
    """What is known of a hammer test; `look` brings it up to date.

    Attributes
    ----------
    folder : Path
    experiment : HammerExperiment
    events : list of dict
    progress : HammerProgress
    latest : HeardHit or None
    trouble : str
        What cannot be read.
    said : list of (str, str)
        What the watchdog said: date, ISO 8601, and sentence.
    simulated : bool
        Whether its rig is simulated.
    """

    folder: Path
    experiment: HammerExperiment = field(init=False)
    events: list[dict[str, Any]] = field(init=False, default_factory=list)
    progress: HammerProgress = field(init=False)
    latest: HeardHit | None = field(init=False, default=None)
    trouble: str = field(init=False, default="")
    said: list[tuple[str, str]] = field(init=False, default_factory=list)
    simulated: bool = field(init=False)
    _seen: tuple[int, int] = field(init=False, default=(-1, -1))

    def __post_init__(self) -> None:
        """Read what does not change; CampaignFileError where it cannot be read."""
        begun = begun_with(self.folder)
        self.simulated = begun.get("rig") == "simulated"
        self._watchdog = Tail(self.folder / WATCHDOG)
        # what is simulated is not all written into the folder, and nothing here depends on it
        table = {name: part for name, part in begun.items() if name != "simulation"} | {"rig": "real"}
        self.experiment = checked(self.folder / HAMMER_TEST, table, hammer_model(table))
        self._count()

    @property
    def running(self) -> bool:
        """Whether a process records hits into the folder."""
        return is_being_written(self.folder)

    @property
    def set_point(self) -> int:
        """The set-point at which hits are wanted next, or the last one."""
        temperatures = self.experiment.temperatures
        left = (n for n in range(len(temperatures)) if self.progress.next_point(n) is not None)
        return next(left, len(temperatures) - 1)

    @property
    def last_sign(self) -> float:
        """Time of the last event, s since 1970; that of the folder before there is one."""
        for name in (EVENTS, HAMMER_TEST):
            try:
                return (self.folder / name).stat().st_mtime
            except OSError:
                continue
        return 0.0

    def look(self) -> bool:
        """Read what is new; return whether anything is."""
        told = [one for one in map(told_by_watchdog, self._watchdog.lines()) if one is not None]
        self.said += told
        return self._look_at_events() or bool(told)

    def _look_at_events(self) -> bool:
        log = self.folder / EVENTS
        try:
            state = log.stat()
        except OSError:
            return False
        if (state.st_size, state.st_mtime_ns) == self._seen:
            return False
        self._seen = state.st_size, state.st_mtime_ns
        try:
            self.events, self.trouble = read_events(self.folder), ""
        except CampaignFileError as error:
            self.trouble = str(error)
            return True
        self._count()
        last = next((e for e in reversed(self.events) if e["event"] in (ACCEPTED, REFUSED)), None)
        if last is not None and (self.latest is None or self.latest.step != last.get("step")):
            self.latest = self._heard(last)
        return True

    def _count(self) -> None:
        kept = [
            KeptHit(event["step"], event["set_point"], event["point"])
            for event in self.events
            if event["event"] == ACCEPTED and None not in (event.get(n) for n in ("step", "set_point", "point"))
        ]
        points, wanted = len(self.experiment.mallet.places), self.experiment.hammer.hits
        self.progress = HammerProgress.of(points, wanted, kept, self.events)

    def _heard(self, event: dict[str, Any]) -> HeardHit:
        step, rejected = int(event.get("step", 0)), event["event"] == REFUSED
        time, signals = np.empty(0), np.empty((len(self.experiment.channels), 0))
        where = self.folder / (REJECTED if rejected else HITS)
        for path in where.glob(f"{step:05d}_*.h5"):
            try:
                with opened_hdf5(path) as file:
                    read = [np.asarray(file[name][()], dtype=float) for name in self.experiment.channels]
                    rate = float(file.attrs["sample_rate"])
                signals = np.array(read)
                time = (np.arange(signals.shape[1]) - int(np.abs(signals[0]).argmax())) / rate
            except Hdf5FileError as error:
                self.trouble = f"{path.name}: {error}"
        coherence, peak = event.get("coherence"), event.get("peak")
        return HeardHit(
            step,
            int(event.get("point", 0)),
            str(event.get("why", "rejected")) if rejected else "",
            float(peak) if isinstance(peak, int | float) else float("nan"),
            float(coherence) if isinstance(coherence, int | float) else None,
            time,
            signals,
        )
