"""The verbs on a campaign that is not complete, and again when more of its sweeps have come."""

import json
import os
import re
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import flexura
from app.files.campaigns.folder import frozen_protocol, read_protocol, write_protocol
from app.files.campaigns.inputs import origin_of_result
from app.files.campaigns.loading import load_campaign
from app.files.folder_lock import folder_lock
from app.files.results.laws_file import load_laws, load_updated
from app.files.results.modes_file import load_frf
from app.main import main
from app.report.written import sections

QUICK = Path(__file__).resolve().parents[2] / "examples" / "quick-rig.toml"
THREE = "interrupted, 3 of 4 sweeps, 15 to 35 °C"
Run = Callable[..., tuple[int, str, str]]


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return an undisturbed campaign of four sweeps."""
    folder = tmp_path_factory.mktemp("whole") / "plate"
    with pytest.raises(SystemExit) as ended:
        main(["acquire", str(QUICK), "--out", str(folder)])
    assert not ended.value.code
    return folder


@pytest.fixture
def cut(whole: Path, tmp_path: Path) -> Callable[[int], Path]:
    """Return a function that gives the campaign as it was after so many sweeps."""

    def after(count: int) -> Path:
        folder = shutil.copytree(whole, tmp_path / "plate")
        for path in sorted((folder / "sweeps").iterdir())[count:]:
            path.unlink()
        return folder

    return after


def go_on(whole: Path, folder: Path) -> None:
    """Measure the rest."""
    for path in sorted((whole / "sweeps").iterdir()):
        if not (folder / "sweeps" / path.name).exists():
            shutil.copy2(path, folder / "sweeps")


def cached() -> dict[str, int]:
    root = Path(os.environ["FLEXURA_CACHE"])
    return {str(path): path.stat().st_mtime_ns for path in root.rglob("*") if path.is_file()}


def test_three_sweeps_of_four_give_what_a_campaign_of_three_gives(
    cut: Callable[[int], Path], tmp_path: Path, run_flexura: Run
) -> None:
    folder, run = cut(3), tmp_path / "run"
    for verb in ("identify", "update"):
        status, output, message = run_flexura(verb, folder, "--out", run, "--json")
        assert status == 0, message
        assert message.splitlines()[-1].startswith(f"{THREE}: 3 sweeps")
        told = json.loads(output)["extent"]
        assert (told["state"], told["sweeps"], told["asked"], told["said"]) == ("interrupted", 3, 4, THREE)
    for name in ("frf.h5", "modes.h5", "laws.h5"):
        kept = origin_of_result(run / name, "update").extent
        assert kept is not None
        assert kept.said == THREE
    status, _, message = run_flexura("compensate", run, "--spacing", "30")
    assert status == 2
    assert "2 training temperatures; at least" in message
    assert f"the campaign of the laws is not complete: {THREE}" in message
    declared = shutil.copytree(folder, tmp_path / "declared")
    frozen, experiment = read_protocol(declared)
    three = experiment.protocol.model_copy(update={"temperatures": experiment.protocol.temperatures[:3]})
    shorter = experiment.model_copy(update={"protocol": three})
    write_protocol(declared, frozen_protocol(frozen["name"], shorter, frozen["source"], frozen["acquired"]))
    status, _, message = run_flexura("update", declared, "--out", tmp_path / "other")
    assert status == 0, message
    assert "3 of" not in message
    np.testing.assert_array_equal(load_frf(run / "frf.h5")[1].h, load_frf(tmp_path / "other" / "frf.h5")[1].h)
    ours, theirs = (load_updated(one / "laws.h5")[0] for one in (run, tmp_path / "other"))
    np.testing.assert_array_equal(ours.constants, theirs.constants)
    laws, others = (load_laws(one / "laws.h5") for one in (run, tmp_path / "other"))
    assert laws.temperature_range == others.temperature_range
    np.testing.assert_array_equal(laws.coefficients, others.coefficients)


@pytest.mark.slow
def test_more_sweeps_are_taken_in_and_the_end_is_that_of_an_undisturbed_campaign(
    whole: Path, cut: Callable[[int], Path], tmp_path: Path, run_flexura: Run
) -> None:
    folder, run, reference = cut(3), tmp_path / "plate-run", tmp_path / "reference"
    verbs = ("identify", "update")
    for verb in verbs:
        assert run_flexura(verb, folder)[0] == 0
        assert run_flexura(verb, whole, "--out", reference)[0] == 0
    go_on(whole, folder)
    said = (
        f"made from 3 sweeps of a campaign that has 4 finished ones now; to take them in: flexura update {folder}"
    )
    status, _, message = run_flexura("focus", run, "--temperature", "20", "--out", tmp_path / "filters")
    assert status == 0, message
    assert f"laws.h5: {said}" in message
    assert message.splitlines()[-1].startswith(f"{THREE}: 20 °C")
    assert run_flexura("identify", folder)[0] == 0
    amiss = sections(run, lambda stage, share: None).amiss  # modes of four sweeps beside laws of three
    assert amiss == [f"laws.h5 was {said}"]
    status, _, message = run_flexura("identify", folder, "--twin", run)
    assert status == 2
    assert "holds 3 sweeps, the campaign 4" in message
    before = cached()
    for verb in verbs:
        status, _, message = run_flexura(verb, folder)
        assert status == 0, message
        assert "3 of 4" not in message
    assert cached() == before  # no twin was built again
    for name in ("frf.h5", "modes.h5", "modes.csv", "laws.h5"):
        assert (run / name).read_bytes() == (reference / name).read_bytes(), name
    assert sections(run, lambda stage, share: None).amiss == []


def test_modes_of_fewer_sweeps_are_not_paired_and_that_is_said(
    whole: Path, cut: Callable[[int], Path], run_flexura: Run
) -> None:
    folder = cut(3)
    assert run_flexura("identify", folder)[0] == 0
    go_on(whole, folder)
    status, output, message = run_flexura("update", folder, "--json")
    assert status == 0, message
    assert "modes.h5: of 3 sweeps; the campaign has 4 now, so that these modes are not paired" in message
    assert json.loads(output)["pairing"]["measured_modes"] == "identified"


def test_while_it_is_recorded_it_is_running(cut: Callable[[int], Path], tmp_path: Path, run_flexura: Run) -> None:
    folder, run = cut(2), tmp_path / "run"
    with folder_lock(folder):
        status, _, message = run_flexura("identify", folder, "--out", run)
        assert status == 0, message
        assert message.splitlines()[-1].startswith("running, 2 of 4 sweeps, 15 to 25 °C: 2 sweeps")
    assert sections(run, lambda stage, share: None).subtitle == "running, 2 of 4 sweeps, 15 to 25 °C"


@pytest.mark.parametrize("count", [1, 2])
def test_too_few_temperatures_for_laws_are_counted(
    cut: Callable[[int], Path], tmp_path: Path, run_flexura: Run, count: int
) -> None:
    folder, run = cut(count), tmp_path / "run"
    status, _, message = run_flexura("update", folder, "--out", run)
    assert status == 0, message
    there = "there is 1" if count == 1 else "there are 2"
    assert f"settled estimates at 3 temperatures or more are needed, and {there}" in message
    for verb in ("focus", "compensate"):
        status, _, message = run_flexura(verb, run)
        assert status == 2
        assert len(message.splitlines()) == 1
        assert f"they need settled estimates at 3 temperatures or more, and there are {count}" in message
    found = flexura.update(folder)
    with pytest.raises(ValueError, match=there):
        flexura.focus(found)


@pytest.mark.parametrize("verb", ["identify", "update", "gap"])
def test_without_a_sweep_every_verb_says_so_in_one_line(
    cut: Callable[[int], Path], tmp_path: Path, run_flexura: Run, verb: str
) -> None:
    status, output, message = run_flexura(verb, cut(0), "--out", tmp_path / "run")
    assert (status, output) == (2, "")
    assert len(message.splitlines()) == 1
    assert "no sweep is finished yet, of 4: continue the campaign with flexura acquire" in message
    assert not (tmp_path / "run").exists()


@pytest.mark.slow
def test_the_library_says_how_many(cut: Callable[[int], Path], tmp_path: Path) -> None:
    campaign = flexura.load(cut(3))
    assert THREE in repr(campaign)
    for found in (flexura.frf(campaign), flexura.identify(campaign, out=tmp_path / "run")):
        assert THREE in repr(found)
    assert THREE in repr(flexura.update(campaign, out=tmp_path / "run"))
    focused = flexura.focus(tmp_path / "run", temperature=[20.0], out=tmp_path / "run")
    assert THREE in repr(focused)
    kept = origin_of_result(tmp_path / "run" / "filters.h5", "focus").extent
    assert kept == campaign.extent


@pytest.mark.slow
def test_gap_of_more_sweeps_makes_the_laws_beside_it_anew(
    whole: Path, cut: Callable[[int], Path], tmp_path: Path, run_flexura: Run
) -> None:
    folder, run = cut(3), tmp_path / "plate-run"
    status, output, message = run_flexura("gap", folder, "--json")
    assert status == 0, message
    assert message.splitlines()[-1].startswith(f"{THREE}: ")
    assert json.loads(output)["provenance"]["settings"]["extent"]["sweeps"] == 3
    status, _, message = run_flexura("compensate", run)
    assert status == 0, message
    assert message.splitlines()[-1].startswith(f"{THREE}: ")
    assert re.search(r"the laws cover 1[45][.\d]* to 35[.\d]* °C only", message)
    by_twin = ("focus", "--twin", run / "twin.toml", "--temperature", "20", "--out", tmp_path / "filters")
    status, _, message = run_flexura(*by_twin)
    assert status == 0, message
    assert message.splitlines()[-1].startswith(f"{THREE}: 20 °C")
    go_on(whole, folder)
    assert "twin.toml: made from 3 sweeps of a campaign that has 4" in run_flexura(*by_twin)[2]
    status, _, message = run_flexura("gap", folder)
    assert status == 0, message
    assert len(load_updated(run / "laws.h5")[0].temperature) == 4
    assert run_flexura("update", folder, "--out", tmp_path / "reference")[0] == 0
    ours, theirs = (load_laws(one / "laws.h5") for one in (run, tmp_path / "reference"))
    np.testing.assert_array_equal(ours.coefficients, theirs.coefficients)


@pytest.mark.slow
def test_a_campaign_is_read_while_it_is_acquired(
    cut: Callable[[int], Path], tmp_path: Path, run_flexura: Run
) -> None:
    """The rest is measured by flexura acquire in a process of its own, while its sweeps are identified."""
    import subprocess
    import sys

    folder = cut(1)
    words = [sys.executable, "-m", "flexura", "acquire", str(QUICK), "--out", str(folder), "--quiet"]
    with subprocess.Popen(words, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE) as rig:
        seen: list[Any] = []
        while rig.poll() is None:
            campaign = load_campaign(folder)
            seen.append(campaign)
            names = [name for name in campaign.hashes if name.startswith("sweeps/")]
            assert len(names) == len(campaign.sweeps)
            status, _, message = run_flexura("identify", folder, "--out", tmp_path / "run")
            assert status == 0, message
        assert rig.returncode == 0, rig.stderr.read() if rig.stderr else ""
    assert "running" in {one.extent.state for one in seen if one.extent is not None}
    last = load_campaign(folder)
    assert last.extent is None
    assert all(one.hashes.items() <= last.hashes.items() for one in seen)
