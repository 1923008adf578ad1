"""Messages reach Apprise and commands; those that fail or hang disturb nothing."""

import json
import os
import sys
import threading
from http.server import BaseHTTPRequestHandler, HTTPServer
from pathlib import Path

import pytest

from app.watch import notifiers
from app.watch.news import News
from app.watch.notifiers import TOKEN, AppriseNotifier, CommandNotifier, Messenger, SecretError, command_of

NEWS = News("silent", "/rigs/left; rm -rf ~", "Flexura, left: silent", "nothing was written for 90 s.")


def writing(file: Path) -> CommandNotifier:
    code = (
        "import json, os, sys; told = {n: os.environ.get(n) for n in "
        "('FLEXURA_KIND', 'FLEXURA_CAMPAIGN', 'FLEXURA_TITLE', 'FLEXURA_MESSAGE', 'FLEXURA_WATCH_TOKEN')}; "
        "open(sys.argv[1], 'a').write(json.dumps([sys.stdin.read(), told, sys.argv[2:]]) + '\\n')"
    )
    return CommandNotifier((sys.executable, "-c", code, str(file), "$HOME; echo"))


def test_a_command_gets_the_message_and_no_shell(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(TOKEN, "0123456789abcdef")
    assert writing(tmp_path / "told").tell(NEWS) == ""
    said, environment, rest = json.loads((tmp_path / "told").read_text())
    assert said == f"{NEWS.title}\n{NEWS.text}\n"
    assert environment == {
        "FLEXURA_KIND": "silent",
        "FLEXURA_CAMPAIGN": NEWS.campaign,
        "FLEXURA_TITLE": NEWS.title,
        "FLEXURA_MESSAGE": NEWS.text,
        TOKEN: None,
    }
    assert rest == ["$HOME; echo"]


def test_a_command_is_a_list_of_arguments() -> None:
    assert command_of('mail -s "a b" me').command == ("mail", "-s", "a b", "me")
    assert command_of('["C:\\\\my mail.exe", "-s", "$X"]').command == ("C:\\my mail.exe", "-s", "$X")
    for bad in ("", '"', "[1]", "[]", '["a", 1]', '{"a": 1', '["a\\u0000"]'):
        if bad != '{"a": 1':  # a program of that name, as strange as it is
            with pytest.raises(SecretError, match="allowed: a program and its arguments"):
                command_of(bad)


def test_what_goes_wrong_is_said_without_the_arguments(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    assert "cannot be started" in CommandNotifier((str(tmp_path / "none"), "secret")).tell(NEWS)
    failing = CommandNotifier((sys.executable, "-c", "raise SystemExit(7)", "secret"))
    assert failing.tell(NEWS) == "ended with 7"
    assert "secret" not in failing.name
    assert AppriseNotifier("slack://a/secret", 2).name == "slack (address 2)"
    monkeypatch.setattr(notifiers, "ATTEMPT_TIMEOUT", 0.5)
    mark = tmp_path / "child"
    code = f"import subprocess, time; subprocess.Popen(['sleep', '60']); open({str(mark)!r}, 'w'); time.sleep(60)"
    assert CommandNotifier((sys.executable, "-c", code)).tell(NEWS) == "took longer than 0.5 s and was ended"


def test_one_that_hangs_keeps_no_other_waiting_and_is_said_once(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(notifiers, "ATTEMPT_TIMEOUT", 0.3)
    hanging = CommandNotifier((sys.executable, "-c", "import time; time.sleep(60)"))
    complaints: list[str] = []
    messenger = Messenger([hanging, writing(tmp_path / "told")], complaints.append, attempts=(0.0, 0.0))
    for _ in range(2):
        messenger.tell(NEWS)
    messenger.wait(30.0)
    assert len((tmp_path / "told").read_text().splitlines()) == 2
    assert (messenger.delivered, messenger.failed) == (2, 2)
    assert len(complaints) == 2
    assert "took longer" in complaints[0]
    assert "took longer" in messenger.last_failure


def test_what_is_to_be_tried_again_is_known_after_the_first_attempt() -> None:
    ready = threading.Event()

    class Failing:
        name = "failing"

        def tell(self, news: News) -> str:
            ready.wait(30.0)
            return "refused"

    messenger = Messenger([Failing()], lambda _: None, attempts=(0.0, 60.0))
    assert messenger.untold() == []
    messenger.tell(NEWS)
    assert messenger.untold() is None
    ready.set()
    while (said := messenger.untold()) is None:
        pass
    assert said[0].startswith("a message (silent) is not told yet by failing: refused; tried again")
    messenger.tell(NEWS)
    assert (messenger.untold() or [""])[0].startswith("2 messages are not told yet by failing")
    messenger.end()
    messenger.wait(30.0)
    assert messenger.untold() == []


@pytest.mark.skipif(sys.platform == "win32", reason="needs modes")
def test_a_command_that_cannot_be_run_is_refused_without_its_arguments(tmp_path: Path) -> None:
    (tmp_path / "script").write_text("#!/bin/sh\n")
    for program, said in (
        ("no-such-program", "there is no such program"),
        (str(tmp_path / "none"), "there is no such program"),
        (str(tmp_path / "script"), "is not executable; allow it with chmod"),
        (str(tmp_path), "is a folder"),
    ):
        with pytest.raises(SecretError, match=said) as raised:
            notifiers.notifiers([], [f"{program} --password secret"], [])
        assert str(raised.value).startswith(f"--notify-command: {program}: ")
        assert "secret" not in str(raised.value)
    (tmp_path / "script").chmod(0o755)
    assert [one.name for one in notifiers.notifiers([], [str(tmp_path / "script"), "sh -c true"], [])] == [
        str(tmp_path / "script"),
        "sh",
    ]


def test_of_many_that_wait_the_oldest_are_dropped() -> None:
    ready, told = threading.Event(), []

    class Slow:
        name = "slow"

        def tell(self, news: News) -> str:
            ready.wait(30.0)
            told.append(news.text)
            return ""

    messenger = Messenger([Slow()], lambda _: None)
    for number in range(500):
        messenger.tell(News("silent", "/a", "t", str(number)))
    ready.set()
    messenger.wait(30.0)
    assert len(told) <= notifiers.MOST_WAITING + 1
    assert told[-1] == "499"


def test_apprise_tells_a_web_hook_on_this_computer(tmp_path: Path) -> None:
    pytest.importorskip("apprise", reason="the extra notify is not installed")
    posted = []

    class Hook(BaseHTTPRequestHandler):
        def do_POST(self) -> None:
            posted.append(json.loads(self.rfile.read(int(self.headers["Content-Length"]))))
            self.send_response(200)
            self.end_headers()

        def log_message(self, format: str, *args: object) -> None:
            pass

    with HTTPServer(("127.0.0.1", 0), Hook) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        good = AppriseNotifier(f"json://127.0.0.1:{server.server_port}/", 1)
        assert good.check() == ""
        assert posted == []
        assert good.tell(NEWS) == ""
        server.shutdown()
    assert [(one["title"], one["message"]) for one in posted] == [(NEWS.title, NEWS.text)]
    assert AppriseNotifier("json://127.0.0.1:9/", 1).tell(NEWS) == "was not delivered"
    with pytest.raises(SecretError, match=r"^--notify: nonsense \(address 2\): Apprise knows no such address$"):
        notifiers.notifiers(["json://127.0.0.1:9/", "nonsense://x"], [], [])


def test_without_apprise_it_says_what_to_install(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    (tmp_path / "apprise.py").write_text("raise ImportError('not there')\n")
    monkeypatch.syspath_prepend(str(tmp_path))
    assert "pip install 'flexura[notify]'" in AppriseNotifier("ntfy://topic", 1).check()
    assert os.environ.get("PYTHONPATH") is None or str(tmp_path) not in os.environ["PYTHONPATH"]
