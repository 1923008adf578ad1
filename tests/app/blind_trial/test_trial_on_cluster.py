"""A trial of twelve on a Dask cluster: workers killed, and the whole cluster; the proof is that of one process."""

import json
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import pytest

from app.blind_trial.outcome import is_judged
from app.blind_trial.trial import Trial, begin, run_trial
from app.commands.blind_trial import _proven
from app.files.bad_file import ResultFileError
from app.terminal.engine import Engine
from tests.app.blind_trial.quick_campaigns import KILLS, install

distributed = pytest.importorskip("distributed")
pytestmark = pytest.mark.slow
COUNT = 12
MEMORY = 5e8


def silent(stage: str, share: float) -> None:
    """Plates and campaigns."""


class Quickly(distributed.WorkerPlugin):  # type: ignore[misc, name-defined]
    """Puts quick campaigns into every worker, those that replace dead ones too."""

    def __init__(self, deaths: Path) -> None:
        self.deaths = deaths

    def setup(self, worker: Any) -> None:
        """Put them into this one."""
        install(self.deaths)


@pytest.fixture
def cluster() -> Iterator[Any]:
    made = distributed.LocalCluster(
        n_workers=2, threads_per_worker=1, memory_limit="1GB", dashboard_address=":0", silence_logs=50
    )
    with made:
        yield made


@pytest.fixture
def deaths(tmp_path: Path, cluster: Any) -> Path:
    """Put quick campaigns into the workers; the folder where their deaths are noted."""
    folder = tmp_path / "deaths"
    with distributed.Client(cluster, set_as_default=False) as client:
        client.register_plugin(Quickly(folder))
    return folder


@pytest.fixture
def alone(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> dict[str, Any]:
    """Do the trial in this process, which has quick campaigns from now on; its proof."""
    install(tmp_path / "nobody", monkeypatch.setattr)
    trial = trial_in(tmp_path / "alone")
    assert len(here(trial)) == COUNT
    return _proven(trial)


def trial_in(folder: Path) -> Trial:
    folder.mkdir()
    trial = Trial(folder, COUNT, 7, ("null", "single"))
    begin(trial)
    return trial


def here(trial: Trial) -> list[str]:
    lines: list[str] = []
    with ThreadPoolExecutor(1) as executor:
        run_trial(trial, executor, silent, lines.append)
    return lines


def there(trial: Trial, cluster: Any, lines: list[str], after: Any = None) -> None:
    def announce(line: str) -> None:
        lines.append(line)
        if after is not None:
            after(lines)

    with Engine(None, cluster.scheduler_address).executor(trial.folder, MEMORY, silent, print) as executor:
        run_trial(trial, executor, silent, announce)


def test_three_killed_workers_change_nothing(
    alone: dict[str, Any], cluster: Any, deaths: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    trial, lines = trial_in(tmp_path / "there"), list[str]()
    deaths.mkdir()
    install(deaths, monkeypatch.setattr)  # models are built by functions that this process names
    there(trial, cluster, lines)
    assert sorted(one.name for one in deaths.iterdir()) == sorted(KILLS)
    assert sorted(line.split()[1] for line in lines) == [one.name for one in trial.assignments]
    assert _proven(trial) == alone
    written = json.loads((trial.folder / "proof.json").read_text(encoding="utf-8"))
    assert written == json.loads((tmp_path / "alone" / "proof.json").read_text(encoding="utf-8"))
    names = sorted(one.name for one in (trial.folder / "campaigns").iterdir())
    assert names == [one.name for one in trial.assignments]  # and nothing that killed workers left


def test_what_a_vanished_cluster_did_stays_and_the_rest_is_done_elsewhere(
    alone: dict[str, Any], cluster: Any, deaths: Path, tmp_path: Path
) -> None:
    trial, lines = trial_in(tmp_path / "there"), list[str]()
    with pytest.raises(ResultFileError, match=r"it went away.* what is finished stays: run this again"):
        there(trial, cluster, lines, lambda said: cluster.close() if len(said) == 4 else None)
    done = [one for one in trial.assignments if is_judged(trial.run(one))]
    assert 4 <= len(done) < COUNT
    assert len(here(trial)) == COUNT - len(done)
    assert _proven(trial) == alone
