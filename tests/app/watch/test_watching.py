"""`flexura watch` beside campaigns in other processes: killed, hanging, hostile, under load, in a browser."""

import json
import os
import signal
import socket
import subprocess
import sys
import threading
import time
import urllib.request
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

import pytest

from app.files.campaigns.folder import digest
from app.files.campaigns.loading import load_campaign
from app.files.folder_lock import folder_lock
from app.watch.watched import Watched
from tests.app.hammer_bench import acquire as acquire_hits
from tests.app.hammer_bench import experiment as hammer_experiment
from tests.app.watch.conftest import Campaign
from tests.browser import Browser, opened_browser

ROOT = Path(__file__).resolve().parents[3]
pytestmark = [pytest.mark.slow, pytest.mark.skipif(sys.platform == "win32", reason="needs signals")]

ACQUIRE = """
import sys, time
from pathlib import Path
from tests.app import test_kill_acquire
from app.files.declarations.experiment import read_acquired_experiment
made = test_kill_acquire.plate
def slowly(*asked):
    time.sleep(float(sys.argv[2]))
    return made(*asked)
test_kill_acquire.plate = slowly
example = read_acquired_experiment(test_kill_acquire.EXAMPLE)
programme = example.programme.model_copy(update={
    "lowest": 24.0, "highest": 34.0, "every": 2.0, "ramp_rate": 2.0, "lead": 2.0, "soak_before": 60.0})
sweep = example.sweep.model_copy(update={"duration": 0.5, "taper": 0.05, "tail": 0.2})
test_kill_acquire.acquire(example.model_copy(update={"programme": programme, "sweep": sweep}), Path(sys.argv[1]))
"""


def started(*words: str, **options: Any) -> "subprocess.Popen[str]":
    command = [sys.executable, "-m", "flexura", *words]
    return subprocess.Popen(
        command, cwd=ROOT, text=True, stdout=subprocess.PIPE, stderr=subprocess.PIPE, **options
    )


def acquiring(folder: Path, pace: float) -> "subprocess.Popen[bytes]":
    """Start a campaign whose repeats take `pace` seconds; return when its log begins."""
    child = subprocess.Popen([sys.executable, "-c", ACQUIRE, str(folder), str(pace)], cwd=ROOT)
    until = time.monotonic() + 120.0
    while not (folder / "events.jsonl").exists():
        assert child.poll() is None
        assert time.monotonic() < until
        time.sleep(0.05)
    return child


@contextmanager
def watching(*words: str) -> Iterator[tuple[str, "subprocess.Popen[str]"]]:
    """Yield the page's address and the watcher."""
    child = started("watch", *words, "--json")
    assert child.stdout is not None
    try:
        text = ""
        while not text.rstrip().endswith("}"):
            line = child.stdout.readline()
            assert line, child.stderr.read() if child.stderr else ""
            text += line
        yield json.loads(text)["url"], child
    finally:
        child.send_signal(signal.SIGINT)
        try:
            child.communicate(timeout=30.0)
        finally:
            child.kill()


def writing(file: Path) -> str:
    """Return a command that appends the kind of a message to a file."""
    code = "import os, sys; open(sys.argv[1], 'a').write(os.environ['FLEXURA_KIND'] + '\\n')"
    return json.dumps([sys.executable, "-c", code, str(file)])


def told(file: Path) -> list[str]:
    return file.read_text().splitlines() if file.exists() else []


def get(url: str) -> Any:
    with urllib.request.urlopen(url, timeout=30.0) as answer:  # noqa: S310 (our own)
        return json.load(answer)


def memory(process: int) -> int:
    """Resident memory, kB."""
    lines = Path(f"/proc/{process}/status").read_text().splitlines()
    return int(next(line for line in lines if line.startswith("VmRSS")).split()[1])


def test_a_campaign_that_was_killed_is_told_once_and_its_end_when_it_is_continued(tmp_path: Path) -> None:
    folder, file = tmp_path / "campaign", tmp_path / "told"
    child = acquiring(folder, 3.0)
    hanging = json.dumps([sys.executable, "-c", "import time; time.sleep(600)"])
    with watching(str(folder), "--notify-command", hanging, "--notify-command", writing(file)) as (url, _):
        until = time.monotonic() + 120.0
        while not get(url + "status.json")["campaigns"][0]["finished"]:
            assert time.monotonic() < until
            time.sleep(0.2)
        child.send_signal(signal.SIGKILL)
        child.wait()
        killed, patience = time.monotonic(), Watched(folder).patience
        while not told(file):
            assert time.monotonic() - killed < patience + 60.0
            time.sleep(0.5)
        if sys.platform == "linux":  # the lock says which process is gone; elsewhere silence has to last
            assert time.monotonic() - killed < 0.5 * patience
        else:
            assert time.monotonic() - killed > patience - 5.0
        time.sleep(20.0)
        assert told(file) == ["silent"]
        assert get(url + "status.json")["campaigns"][0]["state"] == "silent"
        assert acquiring(folder, 0.0).wait(300.0) == 0
        until = time.monotonic() + 60.0
        while told(file)[-1] != "finished":
            assert time.monotonic() < until
            time.sleep(0.5)
    assert [one for one in told(file) if one != "sweep given up"] == ["silent", "finished"]


def test_a_thousand_requests_and_fifty_listeners_leave_campaign_and_memory_alone(
    tmp_path: Path, finished: Path
) -> None:
    folder = tmp_path / "campaign"
    with watching(str(folder), "--wait") as (url, watcher):
        child = acquiring(folder, 2.0)
        host, port = url.removeprefix("http://").rstrip("/").split(":")
        listeners = [socket.create_connection((host, int(port))) for _ in range(50)]
        for one in listeners:
            one.sendall(b"GET /events HTTP/1.0\r\nHost: localhost\r\n\r\n")
        get(url + "status.json")
        before, campaign_before = memory(watcher.pid), memory(child.pid)
        failures: list[str] = []

        def ask(count: int) -> None:
            for number in range(count):
                try:
                    get(url + ("status.json" if number % 2 else "campaigns/0"))
                except urllib.error.HTTPError as error:
                    if error.code != 404:  # before the campaign has begun
                        failures.append(str(error))
                except OSError as error:
                    failures.append(str(error))

        threads = [threading.Thread(target=ask, args=(250,)) for _ in range(4)]
        for thread in threads:
            thread.start()
        campaign_grown = 0
        while any(thread.is_alive() for thread in threads):
            if child.poll() is None:
                with suppress(StopIteration):  # it ends just now
                    campaign_grown = max(campaign_grown, memory(child.pid) - campaign_before)
            time.sleep(0.2)
        grown = memory(watcher.pid) - before
        for one in listeners:
            one.close()
        assert failures == []
        assert grown < 40_000
        assert campaign_grown < 40_000
        assert child.wait(300.0) == 0
    # its own, virtual clock decides what is measured: to the last bit as without a watcher
    assert [digest(s) for s in load_campaign(folder).sweeps] == [digest(s) for s in load_campaign(finished).sweeps]


def test_acquire_is_watched_by_a_process_of_its_own(tmp_path: Path) -> None:
    folder, file = tmp_path / "campaign", tmp_path / "told"
    words = [
        "acquire",
        "examples/quick-rig.toml",
        "--out",
        str(folder),
        "--watch",
        "--notify-command",
        writing(file),
    ]
    child = started(*words)
    _, err = child.communicate(timeout=600.0)
    assert child.returncode == 0, err
    assert "note: watched at http://127.0.0.1:" in err
    url = err.split("watched at ")[1].split()[0]
    until = time.monotonic() + 90.0
    while told(file) != ["finished"] or answers(url):  # it tells, and then ends by itself
        assert time.monotonic() < until
        time.sleep(0.5)


def test_the_death_of_its_watcher_is_nothing_to_a_campaign(tmp_path: Path) -> None:
    folder = tmp_path / "campaign"
    refused = ["--notify-command", json.dumps([sys.executable, "-c", "raise SystemExit(7)"])]
    child = started("acquire", "examples/quick-rig.toml", "--out", str(folder), "--watch", *refused)
    assert child.stderr is not None
    said = ""
    while "watched at" not in said:
        line = child.stderr.readline()
        assert line, said
        said += line
    children = Path(f"/proc/{child.pid}/task/{child.pid}/children").read_text().split()
    (watcher,) = [one for one in children if b"watch" in Path(f"/proc/{one}/cmdline").read_bytes().split(b"\0")]
    os.kill(int(watcher), signal.SIGKILL)
    _, err = child.communicate(timeout=600.0)
    assert child.returncode == 0, err
    assert "sweeps in" in err
    assert "note: the watcher has ended; nothing more is told of this campaign" in err


def test_what_could_not_be_told_is_said_by_acquire(tmp_path: Path) -> None:
    words = ["acquire", "examples/quick-rig.toml", "--out", str(tmp_path / "campaign"), "--quiet"]
    done = started(*words, "--notify-command", "no-such-program --x")
    out, err = done.communicate(timeout=60.0)
    assert done.returncode == 2
    assert err.strip().splitlines()[-1].startswith("Error: --notify-command: no-such-program: there is no such")
    assert not (tmp_path / "campaign").exists()
    done = started(*words, "--notify-command", json.dumps([sys.executable, "-c", "raise SystemExit(7)"]))
    out, err = done.communicate(timeout=600.0)
    assert done.returncode == 0, err
    assert f"note: a message (finished) is not told yet by {sys.executable}: ended with 7; tried again" in err
    assert "Traceback" not in out + err


def answers(url: str) -> bool:
    try:
        get(url + "status.json")
    except OSError:
        return False
    return True


@pytest.fixture(scope="module")
def browser() -> Iterator[Browser]:
    with opened_browser() as found:
        yield found


HOSTILE = "<img src=x onerror=document.title='hit'>"
OVERFLOWING = """
const wide = document.documentElement.clientWidth;
return [...document.querySelectorAll('body *')].filter((one) => {
  const box = one.getBoundingClientRect();
  return box.width > 0 && (box.right > wide + 1 || box.left < -1);
}).map((one) => one.outerHTML.slice(0, 100));
"""
SMALLEST = """
const sizes = [...document.querySelectorAll('body *')].filter((one) => one.textContent.trim() && one.clientHeight)
  .map((one) => parseFloat(getComputedStyle(one).fontSize));
return Math.min(...sizes);
"""


def test_the_page_is_live_on_a_telephone_and_on_a_screen(
    tmp_path: Path, campaign: Campaign, browser: Browser
) -> None:
    hostile = campaign(
        HOSTILE,
        more=[
            {"event": "trouble", "what": "<script>document.title='hit'</script>" + "x" * 300},
            {"event": "missing", "step": 3, "place": HOSTILE, "why": "</li><b id=hit>"},
        ],
    )
    folder = tmp_path / "campaign"
    child = acquiring(folder, 0.7)
    with watching(str(folder), str(hostile)) as (url, _):
        browser.look(url, 360)
        browser.until("return document.querySelectorAll('.card').length == 2")
        browser.until("return document.querySelector('.badge').textContent == 'running'")
        before = browser.until("return document.querySelector('progress').value + 1")
        browser.until(f"return document.querySelector('progress').value + 1 > {before}", 120.0)
        for width in (360, 768, 1280):
            for dark in (False, True):
                browser.look(url, width, dark=dark)
                browser.until("return document.querySelectorAll('svg path').length > 4")
                assert browser.run("return document.documentElement.scrollWidth") <= width
                assert browser.run(OVERFLOWING) == []
                assert browser.run(SMALLEST) >= 11.0
                assert (
                    browser.run("return parseFloat(getComputedStyle(document.querySelector('svg text')).fontSize)")
                    >= 11
                )
                colour = browser.run("return getComputedStyle(document.body).backgroundColor")
                assert (sum(map(int, colour[4:-1].split(","))) < 200) is dark
        assert browser.run("return document.querySelectorAll('h2')[1].textContent") == HOSTILE
        assert browser.run(
            "return [document.querySelectorAll('img').length, !!document.getElementById('hit')]"
        ) == [
            0,
            False,
        ]
        assert HOSTILE in browser.run("return document.querySelectorAll('.log')[1].textContent")
        assert "hit" not in browser.run("return document.title")
        asked = browser.requests()
        assert asked
        assert [one for one in asked if not one.startswith((url, "data:"))] == []
        assert browser.complaints() == []
        child.wait(300.0)
        browser.until("return document.querySelector('.badge').textContent == 'complete'", 60.0)
    browser.until("return document.getElementById('link').className == 'lost'")
    assert "this is how it stood at" in browser.run("return document.getElementById('link').textContent")


def test_cards_say_what_to_do_and_draw_no_empty_boxes(
    tmp_path: Path, campaign: Campaign, browser: Browser
) -> None:
    """Of a hammer test the page draws nothing; a campaign whose process is gone follows no programme."""
    hits, killed = tmp_path / "hits", campaign("killed")
    acquire_hits(hammer_experiment(double_hits=0.0, overloads=0.0), hits)
    with folder_lock(killed):
        owner = json.loads(killed.with_name("killed.lock").read_text())
    killed.with_name("killed.lock").write_text(json.dumps(owner | {"begun": 1}))
    with watching(str(hits), str(killed)) as (url, _):
        browser.complaints()
        browser.look(url, 360)
        browser.until("return document.querySelectorAll('.card').length == 2")
        first, second = browser.run("return [...document.querySelectorAll('.card')].map((one) => one.innerText)")
        assert "next: flexura identify " in first
        assert "temperatures, last FRF" not in first
        assert "–" not in first
        assert "silent: its process is gone without a word for " in second
        assert "next: the same flexura acquire continues it" in second
        assert "not known" in second
        assert browser.run("return document.documentElement.scrollWidth") <= 360
        assert browser.complaints() == []


def test_the_token_is_typed_once(campaign: Campaign, tmp_path: Path, browser: Browser) -> None:
    token = tmp_path / "token"
    folder = campaign("one")
    with watching(str(folder), "--token-file", str(token)) as (url, child):
        browser.look(url, 360)
        assert browser.run("return document.querySelectorAll('.card').length") == 0
        word = token.read_text().strip()
        browser.run(
            f"document.querySelector('input').value = {json.dumps(word)}; document.forms[0].submit(); return 1"
        )
        browser.until("return document.querySelectorAll('.card').length == 1")
        assert browser.run("return location.href") == url
        browser.look(url, 360)
        browser.until("return document.querySelectorAll('.card').length == 1")
        assert child.poll() is None


def test_times_are_those_of_the_reader_with_their_offset(campaign: Campaign, browser: Browser) -> None:
    with watching(str(campaign("one"))) as (url, _):
        browser.cdp("Emulation.setTimezoneOverride", {"timezoneId": "Asia/Kolkata"})
        try:
            browser.look(url, 1280)
            browser.until("return document.getElementById('link').textContent.endsWith(' +05:30')")
            date = "2026-03-01T08:00:05+00:00"
            assert browser.run(f"return when('{date}', false)") == "2026-03-01 13:30:05 +05:30"
            assert browser.run(f"return when('{date}', true)") == "08:00:05 simulated"
            browser.until("return document.querySelectorAll('svg path').length > 4")
            assert "temperatures, °C; simulated time" in browser.run("return document.body.textContent")
        finally:
            browser.cdp("Emulation.setTimezoneOverride", {"timezoneId": ""})
