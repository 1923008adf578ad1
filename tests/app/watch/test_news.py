"""What people are told of a campaign, and how often at most."""

from dataclasses import replace
from itertools import pairwise

import pytest

from app.watch.news import THEN_EVERY, BoundedNews, News, NewsOfCampaign
from app.watch.status import CampaignStatus
from app.watch.watcher import Watcher
from tests.app.watch.conftest import Campaign

CALM = CampaignStatus(
    name="one",
    folder="/one",
    state="running",
    air=20.0,
    plate=20.0,
    coldest=-10.0,
    hottest=70.0,
    lowest=0.0,
    highest=60.0,
    total=9,
)


def kinds(*statuses: CampaignStatus) -> list[str]:
    news = NewsOfCampaign()
    return [one.kind for status in statuses for one in news.of(status)]


def test_each_thing_is_told_once() -> None:
    unsafe = replace(CALM, state="stopped", unsafe=("the oven: hot",))
    assert kinds(CALM, CALM, replace(CALM, state="complete"), replace(CALM, state="complete")) == ["finished"]
    assert kinds(CALM, unsafe, unsafe) == ["not at rest", "stopped"]
    assert kinds(CALM, *[replace(CALM, missing=2)] * 3) == ["sweep given up"]
    assert kinds(CALM, *[replace(CALM, state="silent")] * 3, CALM, replace(CALM, state="silent")) == ["silent"] * 2
    assert kinds(CALM, *[replace(CALM, state="gone")] * 3, CALM) == ["silent"]


def test_what_happened_before_is_no_news_but_what_is_wrong_now_is() -> None:
    assert kinds(replace(CALM, state="complete", missing=3)) == []
    assert kinds(replace(CALM, state="stopped")) == []
    assert kinds(replace(CALM, state="silent")) == ["silent"]
    assert kinds(replace(CALM, state="stopped", unsafe=("the drive",))) == ["not at rest"]


@pytest.mark.parametrize(("name", "start", "end"), [("air", 60.0, 70.0), ("plate", 0.0, -10.0)])
def test_a_limit_is_approached_half_way_from_the_programme_s_end(name: str, start: float, end: float) -> None:
    def at(share: float) -> CampaignStatus:
        return replace(CALM, **{name: start + share * (end - start)})

    assert kinds(CALM, at(0.0), at(0.45)) == []
    assert kinds(CALM, at(0.55), at(0.9), at(1.2), at(0.4)) == ["limit approached"]
    assert kinds(CALM, at(0.55), at(0.1), at(0.55)) == ["limit approached"] * 2


def test_sweeps_given_up_say_how_many() -> None:
    news = NewsOfCampaign()
    news.of(CALM)
    (told,) = news.of(replace(CALM, missing=3, given_up="given up: 30 °C up 1 V: passed"))
    assert told.text.startswith("3 sweeps were given up (given up: 30 °C up 1 V: passed); ")
    assert told.title == "Flexura, one: sweep given up"


def test_an_end_without_all_sweeps_is_not_called_finished_alone() -> None:
    news = NewsOfCampaign()
    news.of(replace(CALM, missing=4, total=4))
    (told,) = news.of(replace(CALM, state="complete", missing=4, total=4))
    assert (told.kind, told.title) == ("finished", "Flexura, one: finished, 0 of 4 sweeps")


def test_messages_of_a_kind_become_ever_rarer_and_none_is_lost_for_good() -> None:
    now = [0.0]
    bounded = BoundedNews(lambda: now[0])
    told = []
    for second in range(0, 12 * 3600, 30):  # a sweep given up every half minute, all night
        now[0] = float(second)
        bounded.take(News("sweep given up", "/one", "title", f"at {second}"))
        told += [(second, one.text) for one in bounded.due()]
    assert [second for second, _ in told[:4]] == [0, 30, 60, 60 + THEN_EVERY]
    assert len(told) <= 10
    assert all(text == f"at {second}" for second, text in told)  # each is the latest
    gaps = [later - earlier for (earlier, _), (later, _) in pairwise(told[2:])]
    assert all(longer > shorter for shorter, longer in pairwise(gaps))
    bounded.take(News("not at rest", "/one", "title", "hot"))
    assert [one.text for one in bounded.due() if one.kind == "not at rest"] == ["hot"]
    now[0] += 30 * 86_400.0
    bounded.due()
    bounded.take(News("sweep given up", "/one", "title", "a month later"))
    now[0] += 1.0
    assert [one.text for one in bounded.due()] == ["a month later"]


def test_an_end_is_told_once_though_the_folder_was_away() -> None:
    gone, complete = (
        replace(CALM, state="gone", total=0),
        replace(CALM, state="complete", finished=9, read="10:00"),
    )
    stopped = replace(CALM, state="stopped", finished=3, read="08:00")
    for end, kind in ((complete, "finished"), (stopped, "stopped")):
        assert kinds(CALM, end, gone, gone, end) == [kind, "silent"]
        assert kinds(end, gone, end) == ["silent"]
        assert kinds(gone, end) == ["silent"]  # what happened before the watcher began
        for copied in ("silent", "not begun"):  # back in part
            assert kinds(end, gone, replace(end, state=copied, finished=0, read=None), end) == ["silent"]


def test_what_went_on_while_the_folder_was_away_is_told() -> None:
    gone, stopped = replace(CALM, state="gone", total=0), replace(CALM, state="stopped", finished=3, read="08:00")
    further = replace(stopped, finished=5, read="09:00")
    complete = replace(CALM, state="complete", finished=9, missing=2, read="10:00")
    assert kinds(CALM, gone, complete) == ["silent", "finished", "sweep given up"]
    assert kinds(stopped, gone, further) == ["silent", "stopped"]
    assert kinds(stopped, gone, complete) == ["silent", "finished", "sweep given up"]
    assert kinds(complete, gone, replace(complete, missing=0)) == ["silent", "finished"]
    assert kinds(stopped, gone, CALM, stopped) == ["silent", "stopped"]


def test_a_folder_that_is_moved_away_and_back_has_not_finished_again(campaign: Campaign) -> None:
    folder, told = campaign("one", None, readings=None), []
    watcher = Watcher([folder], lambda news: told.append(news.kind))
    watcher.look()
    for _ in range(2):
        folder.rename(folder.with_name("away"))
        watcher.look()
        folder.with_name("away").rename(folder)
        assert watcher.look()[0].state == "complete"
    assert told == ["silent"] * 2
