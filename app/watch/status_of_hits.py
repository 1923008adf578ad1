"""How a hammer test stands: what is alive, which hits count, at which point, and what to do next."""

from typing import Any

from app.files.bad_file import quoted
from app.files.folder_lock import is_being_written
from app.watch.status import CampaignStatus, Standing, at_rest
from app.watch.watched_hits import WatchedHits
from app.watch.words import ended_by, plain
from drivers.hammer.progress import ACCEPTED, REJECTED


def status_of_hits(watched: WatchedHits, name: str, now: float) -> CampaignStatus:
    """Return how a hammer test stands.

    Somebody has to hit the plate, and may rest: no silence is too long as long as its process is there.

    Parameters
    ----------
    watched : WatchedHits
        Brought up to date by its `look`.
    name : str
        What it is called.
    now : float
        Time of day, s since 1970.
    """
    progress, temperatures = watched.progress, watched.experiment.temperatures
    total = progress.points * progress.wanted * len(temperatures)
    missing = sum(progress.missing(number) for number in range(len(temperatures)))
    skipped = len(progress.skipped)
    oven = [event for event in watched.events if event.get("event") == "oven"]
    rest, unsafe = at_rest(oven, [] if watched.simulated else watched.said)
    if watched.experiment.oven is None:
        rest = "at rest"  # nothing is heated or driven
    state, ending = _standing(watched, missing, rest, oven[-1].get("purpose", "") if oven else "")
    hits = [event for event in watched.events if event.get("event") in (ACCEPTED, REJECTED)]
    last: dict[str, Any] = next((event for event in reversed(hits) if event.get("event") == ACCEPTED), {})
    limits = watched.experiment.limits
    return CampaignStatus(
        name=name,
        folder=plain(watched.folder),
        state=state,
        kind="hits",
        problem=plain(watched.trouble),
        simulated=watched.simulated,
        stage=_stage(watched) if state == "running" else "",
        plate=last.get("temperature") if isinstance(last.get("temperature"), int | float) else None,
        set_point=temperatures[watched.set_point] if watched.experiment.oven is not None and oven else None,
        coldest=limits.coldest if limits is not None else None,
        hottest=limits.hottest if limits is not None else None,
        finished=total - missing,
        missing=_given_up(watched) if state != "complete" else missing,
        total=total,
        doubted=len(progress.doubted(watched.events)),
        rejected=progress.rejected,
        silent_for=max(now - watched.last_sign, 0.0),
        rest=rest,
        unsafe=unsafe,
        ending=plain(ending),
        next_step=_next_step(watched, state, missing, skipped),
    )


def _standing(watched: WatchedHits, missing: int, rest: str, purpose: str) -> tuple[Standing, str]:
    """Return the state, and why it was stopped."""
    if is_being_written(watched.folder):
        return "running", ""
    if not watched.events:
        return "not begun", ""
    if rest == "follows the programme":
        return "silent", ""  # its process is gone without a word, and nobody has said that the oven is at rest
    if missing == _given_up(watched):
        return "complete", ""
    return "stopped", "" if purpose == "the end" else ended_by(purpose)


def _given_up(watched: WatchedHits) -> int:
    """Hits that are missing at points that were skipped."""
    progress = watched.progress
    return sum(max(progress.wanted - len(progress.at(*place)), 0) for place in progress.skipped)


def _stage(watched: WatchedHits) -> str:
    """Say which hit is waited for."""
    number = watched.set_point
    point = watched.progress.next_point(number)
    if point is None:
        return "nothing is left"
    done = len(watched.progress.at(number, point))
    at = watched.experiment.temperatures[number]
    where = "" if at is None else f" at {at:g} °C"
    hit = f"hit {done + 1} of {watched.progress.wanted}"
    return f"{hit} at point {point + 1} of {watched.progress.points}{where}"


def _next_step(watched: WatchedHits, state: Standing, missing: int, skipped: int) -> str:
    """Say what to do."""
    if state == "running":
        return f"hit the plate: {_stage(watched)}"
    if state == "silent":
        return "look at the oven: its process is gone, and nothing says that it is at rest; then flexura safe"
    if state == "complete" and skipped and missing:
        return f"flexura acquire with --again asks for the {skipped} skipped points"
    if state == "complete":
        return f"flexura identify {quoted(watched.folder)}"
    return "the same flexura acquire goes on"
