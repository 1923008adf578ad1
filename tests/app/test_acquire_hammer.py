"""`flexura acquire` of a hammer test on simulated cards: judged as drawn, undone, killed, taken up again."""

import json
import random
import sys
import time
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

from app.files.acquisition.events import read_events
from app.files.campaign_error import CampaignFileError
from app.files.declarations.hammer_experiment import HammerExperiment, read_hammer_experiment, require_simulated
from app.files.declarations.modal_test import read_modal_test
from app.files.hdf5_file import opened_hdf5
from app.main import flexura
from app.modal_test.declared_test import declared_frfs
from app.rig.assembly import SimulatedHammerRig
from drivers.hammer.campaign import Key, ToldHit
from drivers.ni.simulated.faults import Faults
from drivers.rig.end_requests import RigStopped
from tests.app.hammer_bench import DECAY, EXAMPLE, FREQUENCY, MASS, Listener, acquire, experiment
from tests.killed_process import killed


def with_hits(number: int, **hand: float) -> HammerExperiment:
    declared = experiment(**hand)
    return declared.model_copy(update={"hammer": declared.hammer.model_copy(update={"hits": number})})


@pytest.mark.slow
def test_double_hits_and_overloads_of_five_hundred_hits_are_rejected_as_drawn(tmp_path: Path) -> None:
    outcome, heard, parts = acquire(with_hits(39, double_hits=0.2, overloads=0.1), tmp_path / "hits")
    drawn = {strike.number: strike.drawn for strike in parts.hammer.strikes}
    bad = {number for number, kind in drawn.items() if kind != "good"}
    rejected = {hit.step for hit in heard.hits if hit.rejected}
    assert len(heard.hits) == len(drawn) >= 490
    assert len(bad) > 100
    assert len(bad & rejected) >= 0.98 * len(rejected)  # precision
    assert len(bad & rejected) >= 0.98 * len(bad)  # recall
    for hit in heard.hits:
        if hit.step in bad & rejected:
            assert drawn[hit.step] in hit.rejected
    assert outcome.accepted == 9 * 39
    assert outcome.rejected == len(rejected)


def test_hits_are_judged_as_drawn(tmp_path: Path) -> None:
    _, heard, parts = acquire(with_hits(3, double_hits=0.2, overloads=0.2), tmp_path / "hits")
    drawn = {strike.number: strike.drawn for strike in parts.hammer.strikes}
    assert {hit.step for hit in heard.hits if hit.rejected} == {n for n, kind in drawn.items() if kind != "good"}
    assert {"good", "double hit", "overload"} == set(drawn.values())


def test_the_frf_of_every_point_is_that_of_the_plate(tmp_path: Path) -> None:
    folder = tmp_path / "hits"
    acquire(with_hits(3), folder)
    found = declared_frfs(folder, lambda stage, share: None)
    assert [one.reference for one in found.transfers] == [f"{point}:-3" for point in range(1, 10)]
    inside = (found.frequency > 60.0) & (found.frequency < 600.0)
    step = 15 / 51200.0  # s: what the card makes of the rate asked for
    turn = np.exp(-2j * np.pi * found.frequency[inside] * step)
    pole = np.exp((-DECAY + 2j * np.pi * FREQUENCY) * step)
    of_mode = 0.5 / (1.0 - pole * turn) + 0.5 / (1.0 - np.conj(pole) * turn)  # the filter in `one_mode`
    for point, one in enumerate(found.transfers):
        true = (1.0 + 0.1 * point) / MASS * of_mode
        assert np.abs(one.h[inside] - true).max() < 0.01 * np.abs(true).max()


def test_undo_is_a_mark_and_the_point_is_asked_for_again(tmp_path: Path) -> None:
    folder = tmp_path / "hits"
    typed: Iterator[Key | None] = iter(["undo"])

    def key() -> Key | None:
        kept = list((folder / "hits").glob("*.h5")) if folder.exists() else []
        return next(typed, None) if len(kept) == 2 else None

    outcome, heard, _ = acquire(with_hits(2, double_hits=0.0, overloads=0.0), folder, key)
    assert outcome.accepted == 18
    assert len(heard.hits) == 19
    assert any("undone" in line for line in heard.lines)
    assert len(list((folder / "hits").glob("*.h5"))) == 19  # nothing measured is deleted
    named = {record.file for record in read_modal_test(folder / "test.toml").record}
    assert len(named) == 18
    assert not any("00001_" in name for name in named)
    assert [event["step"] for event in read_events(folder) if event["event"] == "hit undone"] == [1]


def test_a_skipped_point_is_missing_and_asked_for_again(tmp_path: Path) -> None:
    folder = tmp_path / "hits"
    keys: Iterator[Key | None] = iter(["skip"])
    declared = with_hits(1, double_hits=0.0, overloads=0.0)
    outcome, heard, _ = acquire(declared, folder, lambda: next(keys, None))
    assert (outcome.accepted, outcome.missing, outcome.skipped) == (8, 1, 1)
    assert [place.point for place in heard.places] == list(range(9))
    outcome, heard, _ = acquire(declared, folder)
    assert (outcome.made_now, outcome.missing) == (0, 1)
    outcome, heard, _ = acquire(declared, folder, again=True)
    assert (outcome.made_now, outcome.missing) == (1, 0)
    assert [place.point for place in heard.places] == [0]


def test_a_point_is_repeated_from_its_first_hit_and_q_stops(tmp_path: Path) -> None:
    folder = tmp_path / "hits"
    keys: Iterator[Key | None] = iter(["repeat", None, "stop"])

    def key() -> Key | None:
        kept = list((folder / "hits").glob("*.h5")) if folder.exists() else []
        return next(keys, None) if len(kept) == 2 else None

    outcome, _, _ = acquire(with_hits(3, double_hits=0.0, overloads=0.0), folder, key)
    assert outcome.stopped
    assert outcome.accepted == 0
    assert not (folder / "test.toml").exists()  # no hit counts
    outcome, heard, _ = acquire(with_hits(3, double_hits=0.0, overloads=0.0), folder)
    assert outcome.accepted == 27
    assert heard.hits[0].step == 2


def test_the_coherence_told_goes_on_after_an_interruption(tmp_path: Path) -> None:
    folder = tmp_path / "hits"
    declared = with_hits(3, double_hits=0.0, overloads=0.0)
    keys: Iterator[Key | None] = iter(["stop"])
    acquire(declared, folder, lambda: next(keys, None) if len(list((folder / "hits").glob("*"))) == 2 else None)
    _, heard, _ = acquire(declared, folder)
    assert heard.hits[0].asked.number == 3
    assert heard.hits[0].coherence is not None
    assert heard.hits[0].coherence > 0.99


def test_another_experiment_does_not_go_on_in_the_folder(tmp_path: Path) -> None:
    folder = tmp_path / "hits"
    acquire(with_hits(1), folder)
    with pytest.raises(CampaignFileError, match=r"\[hammer\] hits"):
        acquire(with_hits(2), folder)


def test_a_damaged_hit_is_named(tmp_path: Path) -> None:
    folder = tmp_path / "hits"
    acquire(with_hits(1), folder)
    hit = min((folder / "hits").glob("*.h5"))
    content = bytearray(hit.read_bytes())
    content[2000] ^= 1
    hit.write_bytes(content)
    with pytest.raises(CampaignFileError, match=rf"{hit.name}.*move it out"):
        acquire(with_hits(1), folder)
    hit.unlink()
    outcome, _, _ = acquire(with_hits(1), folder)
    assert (outcome.accepted, outcome.made_now) == (9, 1)


def test_what_is_in_a_file_of_a_hit(tmp_path: Path) -> None:
    folder = tmp_path / "hits"
    acquire(with_hits(1, double_hits=0.4), folder)
    with opened_hdf5(min((folder / "hits").glob("*.h5"))) as file:
        assert file["hammer"].attrs["unit"] == "N"
        assert file["acc"].attrs["unit"] == "m/s2"
        assert file.attrs["sample_rate"] == pytest.approx(51200 / 15)
        assert float(np.max(file["hammer"][()])) == pytest.approx(file.attrs["peak_n"], rel=0.01)
        assert "provenance" in file
    with opened_hdf5(min((folder / "rejected").glob("*.h5"))) as file:
        assert "double hit" in file.attrs["rejected"]


def test_cards_that_are_lost_end_it_and_it_is_taken_up_again(tmp_path: Path) -> None:
    folder = tmp_path / "hits"
    declared = with_hits(1, double_hits=0.0, overloads=0.0)

    def unplugged(parts: SimulatedHammerRig) -> None:
        parts.server.chassis.faults = Faults(unplugged=(25.0, 1e9))

    with pytest.raises(RigStopped, match="run the same command again"):
        acquire(declared, folder, prepare=unplugged)
    before = {path.name for path in (folder / "hits").glob("*.h5")}
    assert 1 < len(before) < 9
    outcome, _, _ = acquire(declared, folder)
    assert (outcome.accepted, outcome.made_now) == (9, 9 - len(before))


def test_samples_that_were_lost_are_told_and_the_hit_is_made_again(tmp_path: Path) -> None:
    def stalled(parts: SimulatedHammerRig) -> None:
        parts.server.chassis.faults = Faults(stalled=60.0, stalled_at=20.0)

    outcome, heard, _ = acquire(with_hits(1, double_hits=0.0), tmp_path / "hits", prepare=stalled)
    assert outcome.missing == 0
    assert any("samples were lost" in line for line in heard.lines)


def test_a_force_sensor_with_exchanged_poles_is_told_at_the_first_hit(tmp_path: Path) -> None:
    def exchanged(parts: SimulatedHammerRig) -> None:
        parts.hammer.force_volts *= -1.0

    def key() -> Key | None:
        rejected = list((tmp_path / "hits" / "rejected").glob("*.h5"))
        return "stop" if len(rejected) == 2 else None

    declared = with_hits(1, double_hits=0.0, overloads=0.0)
    outcome, heard, _ = acquire(declared, tmp_path / "hits", key, prepare=exchanged)
    assert outcome.accepted == 0
    assert "exchange the poles" in heard.hits[0].rejected


def test_the_temperature_is_that_of_a_thermocouple_on_the_plate(tmp_path: Path) -> None:
    text = EXAMPLE.read_text(encoding="utf-8")
    text = text.replace('coupling = "AC"\n', 'coupling = "AC"\nthermocouples = ["cDAQ1Mod3/ai0"]\n')
    text = text.replace("temperature = 21.0                    # of the plate", "# of the plate")
    text = text.replace("temperature = 21.0                    # of the sim", "temperature = 33.0  # of the sim")
    file = tmp_path / "mine.toml"
    file.write_text(text.replace("hits = 5", "hits = 1"), encoding="utf-8")
    acquire(read_hammer_experiment(file), tmp_path / "hits")
    test = read_modal_test(tmp_path / "hits" / "test.toml")
    assert test.temperature == pytest.approx(33.0, abs=0.1)


needs_fork = pytest.mark.skipif(sys.platform == "win32", reason="needs fork and SIGKILL")


def telling(declared: HammerExperiment, folder: Path, told: Path) -> None:
    """Acquire, and write down the hits that are told to have been accepted."""
    with told.open("a", encoding="utf-8", buffering=1) as file:
        hears = Listener.told

        def told_and_written(self: Listener, hit: ToldHit) -> None:
            hears(self, hit)
            if not hit.rejected:
                file.write(f"{hit.step}\n")

        Listener.told = told_and_written  # type: ignore[method-assign]
        acquire(declared, folder)


@pytest.fixture
def hunted(tmp_path: Path) -> Callable[[int, int, int], None]:
    """Return a function that kills a test so many times after its first hit; each is held against a whole one."""

    def hunt(hits: int, kills: int, seed: int) -> None:
        declared = with_hits(hits, double_hits=0.1, overloads=0.05)
        began = time.perf_counter()
        acquire(declared, tmp_path / "whole")
        seconds = time.perf_counter() - began
        whole = {path.name for path in (tmp_path / "whole" / "hits").glob("*.h5")}
        rng = random.Random(seed)  # noqa: S311 (moments, not secrets)
        struck, number = 0, 0
        while struck < kills:
            folder, told = tmp_path / f"hits-{number}", tmp_path / f"told-{number}"
            told.touch()
            number += 1
            before: dict[str, bytes] = {}
            for _ in range(4):
                was_killed = killed(partial(telling, declared, folder, told), rng.uniform(0.2, 0.8) * seconds)
                now = {path.name: path.read_bytes() for path in (folder / "hits").glob("*.h5")}
                struck += was_killed and bool(now)
                assert before.items() <= now.items(), "an accepted hit was lost or altered"
                there = {int(name[:5]) for name in now}
                assert {int(line) for line in told.read_text().splitlines()} <= there, (
                    "a hit was told, and is lost"
                )
                before = now
            outcome, _, _ = acquire(declared, folder)
            now = {path.name: path.read_bytes() for path in (folder / "hits").glob("*.h5")}
            assert before.items() <= now.items()
            assert set(now) == whole  # the same hits are asked for, and drawn, as without an interruption
            assert outcome.accepted == 9 * hits
            assert not list(folder.rglob("*.part"))
            assert len(read_modal_test(folder / "test.toml").record) == 9 * hits

    return hunt


@needs_fork
def test_killed_at_random_moments(hunted: Callable[[int, int, int], None]) -> None:
    hunted(1, 3, 1)


@needs_fork
@pytest.mark.slow
def test_killed_fifty_times(hunted: Callable[[int, int, int], None]) -> None:
    hunted(4, 50, 2)


def test_bad_input_is_told_without_a_traceback(tmp_path: Path) -> None:
    text = EXAMPLE.read_text(encoding="utf-8")
    wrong = {
        "double_hit = 0.1  ": ("double_hit = 3.0  ", "hammer.double_hit"),
        "duration = 1.6 ": ("duration = 0.01 ", "pretrigger"),
        "band = [60.0, 600.0]": ("band = [60.0, 1700.0]", "0.45 of cards.sample_rate"),
        "[0.02, 0.02], [0.11": ("[0.5, 0.02], [0.11", "hammer1"),
        "temperature = 21.0                    # of the plate": ("# of the plate", "none given"),
        'sensitivity_unit = "mV/g"': ('sensitivity_unit = "V"', "sensitivity_unit"),
        'responses = ["cDAQ1Mod1/ai1"]': ('responses = ["cDAQ1Mod1/ai1", "cDAQ1Mod1/ai2"]', "cards.responses"),
    }
    for number, (before, (after, said)) in enumerate(wrong.items()):
        assert text.count(before) == 1, before
        file = tmp_path / f"{number}.toml"
        file.write_text(text.replace(before, after), encoding="utf-8")
        done = CliRunner().invoke(flexura, ["acquire", str(file), "--out", str(tmp_path / "out")])
        assert done.exit_code in (1, 2), done.output
        assert said in done.output
        assert isinstance(done.exception, SystemExit)
    done = CliRunner().invoke(flexura, ["acquire", str(EXAMPLE), "--test-shot"])
    assert "--test-shot" in done.output
    assert done.exit_code == 2
    assert not (tmp_path / "out").exists()


def test_a_grid_of_more_than_a_hundred_points_is_one_of_many_forces(tmp_path: Path) -> None:
    """The plate that is hit had a hundred forces at most: a real rig's grid ended in a traceback."""
    text = EXAMPLE.read_text(encoding="utf-8")
    start, end = text.index("points = ["), text.index("[0.02, 0.17], [0.1, 0.165], [0.22, 0.17],")
    grid = [[x, y] for x in np.linspace(0.02, 0.22, 12).tolist() for y in np.linspace(0.02, 0.17, 12).tolist()]
    rest = text[end:].split("]\n", 1)[1]
    many = tmp_path / "many.toml"
    hidden = "\n[simulation.effects.air_loading]\nmass = 0.01\n"
    many.write_text(f"{text[:start]}points = {grid}\n{rest}", encoding="utf-8")
    declared = read_hammer_experiment(many)
    assert [drive.id for drive in declared.struck().drive] == [f"hammer{n}" for n in range(1, 145)]
    with pytest.raises(CampaignFileError, match="at most 100 on the simulated rig"):
        require_simulated(declared, many)
    many.write_text(f"{text[:start]}points = {grid}\n{rest}{hidden}", encoding="utf-8")
    with pytest.raises(CampaignFileError, match=r"simulation.effects.air_loading"):
        read_hammer_experiment(many)


@pytest.mark.slow
def test_from_the_first_hit_to_modes_and_modulus(tmp_path: Path) -> None:
    folder = tmp_path / "hits"
    done = CliRunner().invoke(flexura, ["acquire", str(EXAMPLE), "--out", str(folder), "--json", "--quiet"])
    assert done.exit_code == 0, done.stderr
    record = json.loads(done.stdout)
    assert (record["accepted"], record["missing"], record["state"]) == (45, 0, "complete")
    done = CliRunner().invoke(
        flexura, ["identify", str(folder), "--band", "60", "600", "--out", str(tmp_path / "run"), "--json"]
    )
    assert done.exit_code == 0, done.stderr
    modes = json.loads(done.stdout)["modes"]
    assert len([mode for mode in modes if mode["status"] == "kept"]) >= 9
    done = CliRunner().invoke(flexura, ["update", str(folder), "--out", str(tmp_path / "laws"), "--json"])
    assert done.exit_code == 0, done.stderr
    (row,) = json.loads(done.stdout)["temperatures"]
    simulation = experiment().simulation
    assert simulation is not None
    true = simulation.laws.laws().at([21.0])
    assert row["youngs_modulus_pa"] == pytest.approx(float(true.youngs_modulus[0]), rel=0.01)
    assert row["poisson_ratio"] == pytest.approx(float(true.poisson_ratio[0]), abs=0.003)
    assert row["loss_factor"] == pytest.approx(float(true.loss_factor[0]), rel=0.03)
