"""What happened to a campaign that people want to be told: from how it stood before and how it stands now."""

import math
import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal, get_args

from app.summaries.numbers import duration
from app.watch.status import UNDER_WAY, CampaignStatus

Kind = Literal["finished", "stopped", "not at rest", "sweep given up", "limit approached", "silent"]
KINDS: tuple[Kind, ...] = get_args(Kind)
MESSAGES_AT_ONCE = 3
"""Messages of a kind about a campaign that are told at once."""
THEN_EVERY = 600.0
"""Seconds to the next one, doubled each time: a fault that comes and goes all night makes some ten messages."""
QUIET_INTERVALS = 6.0
"""Intervals `THEN_EVERY` without a message of the kind after which the count begins anew."""

OVER: dict[str, Kind] = {"complete": "finished", "stopped": "stopped"}
"""What is told of a state in which nothing more comes."""
GOES_ON = ("running", "pausing", "paused")
OF_AN_END = ("state", "ending", "finished", "missing", "rejected", "read")
"""Fields that differ between two ends of one campaign."""


@dataclass(frozen=True)
class News:
    """One message.

    Attributes
    ----------
    kind : str
    campaign : str
        Its folder.
    title : str
        A few words.
    text : str
        One sentence or more.
    """

    kind: Kind
    campaign: str
    title: str
    text: str


class NewsOfCampaign:
    """Compares how a campaign stands with how it stood.

    What happened before the watcher began is no news, but what is wrong now is: NOT AT REST, silent.
    """

    def __init__(self) -> None:
        self._before: CampaignStatus | None = None
        self._lost = self._away = self._near = False
        self._ended: CampaignStatus | None = None

    def of(self, now: CampaignStatus) -> list[News]:
        """Return what is new; of a folder that was away for a while, since it was last read."""
        before, ended = self._before, self._ended
        told: list[tuple[Kind, str]] = []
        if now.unsafe and (before is None or set(now.unsafe) - set(before.unsafe)):
            told.append(("not at rest", f"{'; '.join(now.unsafe)}."))
        lost, self._lost = self._lost, now.state in ("silent", "gone")
        if self._lost and not lost:
            told.append(("silent", _silent(now)))
        away, self._away = self._away, now.state == "gone"
        if self._away:  # nothing else is known: it stands as when it was last read
            return [_news(now, *one) for one in told]
        if now.state in OVER:
            self._ended = now
        elif now.state in GOES_ON:  # not where it only looks silent or not begun: a folder that is copied back
            self._ended = None
        self._before = now
        if before is not None:
            if now.state in OVER and (away or now.state != before.state) and not _same_end(now, ended):
                said = now.state == "complete" or "continues it" in now.line
                more = "" if said else ". The same flexura acquire continues it."
                told.append((OVER[now.state], now.line + more))
            if now.missing > before.missing:
                new, one = now.missing - before.missing, now.missing - before.missing == 1
                what = f"{now.kind[:-1]} was" if one else f"{now.kind} were"
                why = f" ({now.given_up})" if now.given_up else ""
                told.append(("sweep given up", f"{new} {what} given up{why}; {now.line}"))
        near = self._approached(now)
        if near and not self._near:
            told.append(("limit approached", near))
        self._near = bool(near)
        return [_news(now, *one) for one in told]

    def _approached(self, now: CampaignStatus) -> str:
        """Say which limit air or plate are closer to than to the end of the programme; empty where to none.

        The programme itself may go close to a limit: half of the way from its own end to the limit counts. Once
        told, a quarter of it.
        """
        if now.state not in UNDER_WAY or now.coldest is None or now.hottest is None:
            return ""
        if now.lowest is None or now.highest is None:
            return ""
        share = 0.25 if self._near else 0.5
        for what, value in (("air", now.air), ("plate", now.plate)):
            if value is None:
                continue
            for limit, end, name in ((now.hottest, now.highest, "hottest"), (now.coldest, now.lowest, "coldest")):
                room = abs(limit - end)
                if (room and abs(value - limit) <= (1.0 - share) * room) or _beyond(value, limit, end):
                    return f"{what} {value:.1f} °C, limits.{name} {limit:g} °C, programme to {end:g} °C."
        return ""


class BoundedNews:
    """Lets messages pass, those of one kind about one campaign ever more rarely; what waits is told as one.

    Parameters
    ----------
    clock : callable
        Seconds that never run backwards.
    """

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        self._clock = clock
        self._told: dict[tuple[str, Kind], tuple[int, float]] = {}
        self._waiting: dict[tuple[str, Kind], list[News]] = {}

    def take(self, news: News) -> None:
        """Take a message."""
        waiting = self._waiting.setdefault((news.campaign, news.kind), [])
        waiting.append(news)
        del waiting[1:-1]  # the count is in the text; the first and the last are enough

    def due(self) -> list[News]:
        """Return what is to be told now."""
        now, due = self._clock(), []
        for key, waiting in list(self._waiting.items()):
            number, last = self._told.get(key, (0, -math.inf))
            if number and now - last > QUIET_INTERVALS * THEN_EVERY:
                number = 0 if now - last > QUIET_INTERVALS * _interval(number) else number
            if number >= MESSAGES_AT_ONCE and now - last < _interval(number):
                continue
            del self._waiting[key]
            self._told[key] = (number + 1, now)
            due.append(waiting[-1])
        return due


def _interval(number: int) -> float:
    """Seconds that have to pass after so many messages."""
    return float(THEN_EVERY * 2.0 ** min(max(number - MESSAGES_AT_ONCE, 0), 8))


def _silent(now: CampaignStatus) -> str:
    if now.state == "gone":
        return f"its folder cannot be read any more: {now.problem}."
    rest = {"at rest": "the oven is at rest", "not at rest": "the rig is NOT AT REST"}.get(
        now.rest, "whether the oven is at rest is not known: look at it"
    )
    if now.abandoned:
        return f"flexura acquire is gone without a word; by its log, {rest}. {now.line}"
    since = f"flexura acquire has written nothing for {duration(now.silent_for)}"
    return f"{since} (a sweep and a margin are {duration(now.patience)}); by its log, {rest}. {now.line}"


def _same_end(now: CampaignStatus, ended: CampaignStatus | None) -> bool:
    """Whether a campaign has ended as it had before: not one sweep, hit or reading has come since."""
    return ended is not None and all(getattr(now, name) == getattr(ended, name) for name in OF_AN_END)


def _beyond(value: float, limit: float, end: float) -> bool:
    return value >= limit if limit >= end else value <= limit


def _news(now: CampaignStatus, kind: Kind, text: str) -> News:
    words: str = "NOT AT REST" if kind == "not at rest" else kind
    if kind == "finished" and now.missing:
        words = f"finished, {now.finished} of {now.total} {now.kind}"
    return News(kind, now.folder, f"Flexura, {now.name}: {words}", text)
