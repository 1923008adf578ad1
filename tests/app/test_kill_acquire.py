"""Campaigns killed by SIGKILL at any moment and taken up again end as if they had never been."""

import os
import random
import sys
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path

import numpy as np
import pytest
from scipy.signal import butter, sosfilt

from analysis.arrays import Real
from app.files.acquisition.campaign_folder import campaign_log
from app.files.campaigns.folder import Source, digest
from app.files.campaigns.loading import load_campaign
from app.files.declarations.experiment import AcquiredExperiment, read_acquired_experiment
from app.stages.acquire import acquire_campaign
from drivers.ni.modules import NI_9211, NI_9234, NI_9260
from drivers.rig.campaign import unobserved
from drivers.rig.session import Session
from drivers.rig.simulated import simulated_parts
from tests.killed_process import killed

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="needs fork and SIGKILL")

EXAMPLE = Path(__file__).resolve().parents[2] / "examples" / "simulated-rig.toml"


def plate(drive: Real, rate: float, temperature: Real) -> Real:
    """One resonance that softens: computed at once, so that a kill strikes anywhere but in the plate."""
    centre = 600.0 * (1.0 - 0.01 * (float(temperature.mean()) - 20.0))
    band = butter(1, [0.95 * centre, 1.05 * centre], btype="bandpass", fs=rate, output="sos")
    return np.asarray(0.5 * sosfilt(band, drive))[None]


@pytest.fixture(scope="module")
def experiment() -> AcquiredExperiment:
    """Six set-points 2 K apart, close to the room: half a second for a whole campaign."""
    example = read_acquired_experiment(EXAMPLE)
    programme = example.programme.model_copy(
        update={"lowest": 24.0, "highest": 34.0, "every": 2.0, "ramp_rate": 2.0, "lead": 2.0, "soak_before": 60.0}
    )
    sweep = example.sweep.model_copy(update={"duration": 0.5, "taper": 0.05, "tail": 0.2})
    return example.model_copy(update={"programme": programme, "sweep": sweep})


def acquire(experiment: AcquiredExperiment, folder: Path) -> None:
    """Do what `flexura acquire` does, with a plate that costs nothing."""
    parts = simulated_parts(
        experiment.cards, experiment.oven, plate, modules={1: NI_9234, 2: NI_9260, 3: NI_9211}, seed=3
    )
    session = Session(parts.rig(), experiment.limits, campaign_log(folder))
    source = Source("mine.toml", "0" * 64)
    acquire_campaign(session, experiment, folder, source, experiment.model_dump(mode="json"), unobserved)
    assert session.unsafe == ()


def files(folder: Path) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in (folder / "sweeps").glob("*.h5")}


def any_finished(folder: Path) -> bool:
    return any((folder / "sweeps").glob("*.h5"))


@pytest.fixture(scope="module")
def undisturbed(experiment: AcquiredExperiment, tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, float]:
    folder = tmp_path_factory.mktemp("undisturbed") / "campaign"
    began = time.perf_counter()
    acquire(experiment, folder)
    return folder, time.perf_counter() - began


@pytest.fixture
def hunted(
    experiment: AcquiredExperiment, undisturbed: tuple[Path, float], tmp_path: Path
) -> Callable[[int, int], None]:
    """Return a function that kills campaigns so many times after their first finished sweep.

    Kills before it are made as well, and not counted. Each campaign is held against the undisturbed one.
    """
    reference, seconds = undisturbed
    whole = [digest(sweep) for sweep in load_campaign(reference).sweeps]

    def hunt(kills: int, seed: int) -> None:
        rng = random.Random(seed)  # noqa: S311 (moments, not secrets)
        struck, number = 0, 0
        while struck < kills:
            folder = tmp_path / f"campaign-{number}"
            number += 1
            finished: dict[str, bytes] = {}
            for _ in range(4):  # killed, taken up, killed again
                # every second campaign is left alone until its first sweep is finished
                begun = partial(any_finished, folder) if number % 2 else lambda: True
                was_killed = killed(partial(acquire, experiment, folder), rng.uniform(0.0, 0.8 * seconds), begun)
                now = files(folder)
                struck += was_killed and bool(now)
                assert finished.items() <= now.items(), "a finished sweep was lost or altered"
                finished = now
            acquire(experiment, folder)
            assert finished.items() <= files(folder).items()
            # Samples, temperatures and times to the last bit; a sweep cut off has counted one attempt more.
            assert [digest(sweep) for sweep in load_campaign(folder).sweeps] == whole
            assert not list(folder.rglob("*.part"))

    return hunt


def test_killed_at_random_moments(hunted: Callable[[int, int], None]) -> None:
    hunted(10, 1)


@pytest.mark.slow
def test_killed_two_hundred_times(hunted: Callable[[int, int], None]) -> None:
    """`CAMPAIGN_KILLS` says another number."""
    hunted(int(os.environ.get("CAMPAIGN_KILLS", "200")), 2)
