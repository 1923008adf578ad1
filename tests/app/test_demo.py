"""flexura demo: what is put into the simulated plate comes back, and every stage of both campaigns is done."""

import json
import re
from collections.abc import Callable
from pathlib import Path

import pytest
from click.testing import CliRunner
from threadpoolctl import threadpool_limits

from app.commands import demo
from app.files.declarations.experiment import read_acquired_experiment
from app.main import flexura

NUMBER = r"\d+\.\d+"
ROW = re.compile(
    rf"│ +(\d+) │ +({NUMBER}) │ +({NUMBER}) │ +({NUMBER}) │ +({NUMBER}) │ +({NUMBER}) │ +({NUMBER}) │"
)


@pytest.fixture(scope="module", autouse=True)
def _surroundings() -> object:
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("COLUMNS", "80")
        with threadpool_limits(1):
            yield


def printed_laws(table: str) -> dict[int, tuple[float, ...]]:
    """T -> E put in, found [GPa], nu put in, found, eta put in, found [%]."""
    return {int(row[1]): tuple(float(value) for value in row.groups()[1:]) for row in ROW.finditer(table)}


def assert_close(laws: dict[int, tuple[float, ...]]) -> None:
    for e, e_found, nu, nu_found, eta, eta_found in laws.values():
        assert e_found == pytest.approx(e, rel=0.015)  # thickness and lengths are declared to tolerances
        assert nu_found == pytest.approx(nu, abs=0.01)
        assert eta_found == pytest.approx(eta, rel=0.03)


def test_the_shipped_experiment_goes_over_a_port() -> None:
    simulation = read_acquired_experiment(demo.EXPERIMENT).simulation
    assert simulation is not None
    assert simulation.served


def test_the_acquired_laws_stand_beside_those_put_in(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """The first half of the demo, on a narrow band and four temperatures."""
    from rich.console import Console

    text = demo.EXPERIMENT.read_text(encoding="utf-8")
    for pattern, replacement in (
        (r"^band = .*", "band = [100.0, 600.0]"),
        (r"^duration = .*", "duration = 1.0"),
        (r"^lowest = .*", "lowest = 15.0"),
        (r"^highest = .*", "highest = 45.0"),
        (r"^soak_before = .*", "soak_before = 300.0"),
    ):
        text, count = re.subn(pattern, replacement, text, count=1, flags=re.MULTILINE)
        assert count == 1, pattern
    file = tmp_path / "narrow.toml"
    file.write_text(text, encoding="utf-8")
    monkeypatch.setattr(demo, "EXPERIMENT", file)
    acquired, *_ = demo.parts_in(tmp_path / "out")
    status, seconds = demo.run_stages(acquired)
    assert status == 0
    assert list(seconds) == ["acquire", "identify", "update"]
    capsys.readouterr()
    Console(width=80).print(demo.laws_table(acquired.run))
    laws = printed_laws(capsys.readouterr().out)
    assert list(laws) == [15, 25, 35, 45]
    assert_close(laws)
    put_in = read_acquired_experiment(file).simulation.laws.laws().at(25.0)  # type: ignore[union-attr]
    assert laws[25][0] == pytest.approx(put_in.youngs_modulus[0] / 1e9, abs=1e-4)
    assert laws[25][4] == pytest.approx(100 * put_in.loss_factor[0], abs=1e-3)


def test_a_stage_that_is_not_good_enough_is_told_and_the_rest_done(tmp_path: Path) -> None:
    """Real cards and oven asked for where there are none: status 3, nothing is known to be at rest."""
    asked = ("acquire", str(demo.EXPERIMENT), "--rig", "ni", "--out", str(tmp_path / "none"))
    status, seconds = demo.run_stages(demo.Part("broken", tmp_path, (asked, ("doctor", "--help"))))
    assert status == 3
    assert list(seconds) == ["acquire", "doctor"]


def test_bad_input_ends_it_with_a_sentence(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, run_flexura: Callable[..., tuple[int, str, str]]
) -> None:
    monkeypatch.setattr(demo, "EXPERIMENT", tmp_path / "absent.toml")
    status, out, err = run_flexura("demo", "--out", tmp_path / "out")
    assert (status, out) == (2, "")
    assert "absent.toml" in err
    assert "Traceback" not in err


def test_what_was_put_in_has_its_unit() -> None:
    assert list(demo.put_in()) == [("point_mass", "mass 0.0008 kg")]


def test_the_share_of_the_gap_that_closes_has_its_standard_deviation(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    held_out = {"closure": 0.9512, "closure_sigma": 0.0123}
    gap = {"verdict": "explained", "effects": [], "gap": {"held_out": held_out}}
    monkeypatch.setattr("app.files.results.gap_file.load_gap", lambda _: (None, gap))
    caption = demo.effects_table(tmp_path).caption
    assert caption == "gap explained; 95.1 ± 1.2 % of the gap closes on held-out data"


def test_the_quick_demo_measures_the_same_plate() -> None:
    """So that what is found in it may stand beside the laws of the other experiment."""
    quick, whole = (read_acquired_experiment(file) for file in (demo.QUICK, demo.EXPERIMENT))
    assert quick.plate == whole.plate
    assert quick.patch == whole.patch
    assert quick.simulation == whole.simulation


@pytest.mark.slow
def test_the_quick_demo(tmp_path: Path) -> None:
    out = tmp_path / "demo"
    result = CliRunner().invoke(flexura, ["demo", "--quick", "--out", str(out)])
    assert result.exit_code == 0, result.output
    for name in ("frf.h5", "modes.h5", "laws.h5", "filters.h5", "report.html"):
        assert (out / "quick-run" / name).is_file()
    laws = printed_laws(result.stdout)
    assert list(laws) == [20, 30, 40]
    assert_close(laws)
    assert "one campaign in" in result.stderr
    assert result.stdout.rstrip().endswith("report.html")
    again = CliRunner().invoke(flexura, ["demo", "--quick", "--out", str(out), "--json", "--quiet"])
    printed = json.loads(again.stdout)
    assert list(printed) == ["seconds", "temperatures_c", "laws", "reports"]
    assert list(printed["seconds"]) == ["quick"]


@pytest.mark.slow
def test_the_whole_demo(tmp_path: Path) -> None:
    out = tmp_path / "demo"
    result = CliRunner().invoke(flexura, ["demo", "--out", str(out)])
    assert result.exit_code == 0, result.output
    for name in ("frf.h5", "modes.h5", "laws.h5"):
        assert (out / "simulated-run" / name).is_file()
    for name in ("frf.h5", "modes.h5", "laws.h5", "filters.h5", "compensation.h5", "report.html"):
        assert (out / "run" / name).is_file()
    verdict = json.loads((out / "puzzle-run" / "gap.json").read_text(encoding="utf-8"))
    assert verdict["verdict"] == "explained"
    assert [effect["name"] for effect in verdict["effects"]] == ["point_mass"]
    assert verdict["effects"][0]["parameters"]["mass"]["value"] == pytest.approx(0.0008, rel=0.03)
    assert "gap explained" in result.stdout
    laws = printed_laws(result.stdout)
    assert list(laws) == [0, 10, 20, 30, 40, 50, 60]
    assert_close(laws)
    assert "$ flexura acquire" in result.stderr
    assert result.stdout.rstrip().endswith("report.html")
    again = CliRunner().invoke(flexura, ["demo", "--out", str(out)])
    assert again.exit_code == 0, again.output
    assert "0 of them now" in again.stderr
    assert printed_laws(again.stdout) == laws
