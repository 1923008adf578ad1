"""The chain as a user types it, on five temperatures of the shipped recording: folder in, page out."""

import json
import re
import shutil
import subprocess
from collections.abc import Callable
from pathlib import Path

import h5py
import numpy as np
import pytest
from click.testing import CliRunner, Result
from threadpoolctl import threadpool_limits

from app.files.provenance import read_stamp
from app.files.results.laws_file import load_laws, load_updated
from app.files.results.modes_file import load_modes
from app.main import flexura

Cut = Callable[[Path, tuple[int, ...]], None]
TEMPERATURES = (0, 16, 32, 48, 60)
CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")


def typed(*words: str) -> Result:
    with threadpool_limits(1):
        result = CliRunner().invoke(flexura, list(words))
    if result.exception is not None and not isinstance(result.exception, SystemExit):
        raise result.exception
    return result


@pytest.fixture(scope="module")
def recording(tmp_path_factory: pytest.TempPathFactory, cut_recording: Cut) -> Path:
    """Cut five sweeps out of the shipped recording."""
    folder = tmp_path_factory.mktemp("chain") / "five"
    cut_recording(folder, TEMPERATURES)
    return folder


@pytest.fixture(scope="module")
def run(recording: Path) -> Path:
    """Type every verb once; the run folder."""
    campaign, folder = recording.with_name("campaign"), recording.with_name("run")
    for words in (
        ("import", str(recording), "--out", str(campaign)),
        ("identify", str(campaign), "--out", str(folder)),
        ("update", str(campaign), "--out", str(folder)),
        ("focus", str(folder), "--temperature", "20", "--temperature", "40"),
        ("compensate", str(folder), "--spacing", "4"),
        ("report", str(folder)),
    ):
        result = typed(*words)
        assert result.exit_code == 0, f"flexura {' '.join(words)}: {result.output}"
    return folder


def test_misfit_is_the_noise_and_the_laws_fall(run: Path) -> None:
    updated, twin = load_updated(run / "laws.h5")
    assert updated.settled.all()
    assert (updated.misfit < 1.1 * updated.noise_floor).all()
    np.testing.assert_allclose(updated.chi2_per_dof, 1.0, atol=0.15)
    assert twin.basis_error <= 1e-4
    laws = load_laws(run / "laws.h5")
    assert laws.temperature_range == pytest.approx((0.0, 60.0), abs=0.2)
    assert (np.diff(laws.at(np.linspace(0.0, 60.0, 61)).youngs_modulus) < 0.0).all()


def test_identified_and_updated_agree_on_the_damping(run: Path) -> None:
    """Two ways that share nothing but the FRFs.

    A mode is as lossy as the plate's material less the lossless patches' share of its strain energy, a per cent or
    so. One pole that stands for two modes in one peak may miss that; the mean weighted by inverse variances is
    known to 1 %.
    """
    updated, _ = load_updated(run / "laws.h5")
    reading = load_modes(run / "modes.h5").reading()
    known = reading.sigma_loss_factor < 0.05 * reading.loss_factor
    for t, eta in enumerate(updated.material.loss_factor):
        assert known[t].sum() >= 8
        weight = reading.sigma_loss_factor[t][known[t]] ** -2.0
        assert 0.98 < np.average(reading.loss_factor[t][known[t]], weights=weight) / eta < 1.01


def test_identified_with_the_twin_of_the_run(recording: Path, run: Path) -> None:
    """Typed like all else: every mode has a track, and those kept fall with temperature."""
    folder = run.with_name("expected")
    result = CliRunner().invoke(
        flexura, ["identify", str(recording), "--twin", str(run), "--out", str(folder), "--json"]
    )
    assert result.exit_code == 0, result.output
    printed = json.loads(result.stdout)
    assert all(mode["track"] for sweep in printed["temperatures"] for mode in sweep["modes"])
    tracked = load_modes(folder / "modes.h5")
    f = np.abs(tracked.poles) / (2 * np.pi)
    step = np.diff(np.where(np.array(tracked.status) == "kept", f, np.nan), axis=0)
    assert np.isfinite(step).sum() > 20
    assert (step[np.isfinite(step)] < 0.0).all()
    with h5py.File(folder / "modes.h5") as file:
        assert "laws.h5" in read_stamp(file)["inputs"]


def test_update_prints_json_that_a_machine_can_read(recording: Path, run: Path) -> None:
    result = CliRunner().invoke(
        flexura, ["update", str(recording), "--out", str(run.with_name("again")), "--json"]
    )
    printed = json.loads(result.stdout)
    updated, _ = load_updated(run / "laws.h5")
    found = [row["youngs_modulus_pa"] for row in printed["temperatures"]]
    # BLAS libraries loaded by an earlier test keep their threads here, and so the last digits
    np.testing.assert_allclose(found, updated.material.youngs_modulus, rtol=1e-11)
    assert printed["gain"] == pytest.approx(updated.gain, rel=1e-11)
    assert set(printed["temperatures"][0]["sigma"]) == {"youngs_modulus_pa", "poisson_ratio", "loss_factor"}
    assert printed["seconds"] > 0.0


def test_the_report_is_one_page_that_fetches_nothing(run: Path) -> None:
    page = (run / "report.html").read_text(encoding="utf-8")
    assert page.count("data:image/") >= 12
    assert not re.search(r"""(src|href)=["']?(http|//|/)""", page)
    assert "not run yet" not in page
    for wanted in (
        "paper Fig. 7",
        "paper Fig. 9",
        "paper Fig. 10",
        "paper Fig. 11",
        "paper Fig. 12",
        "paper Fig. 13",
    ):
        assert wanted in page
    for wanted in ("paper Fig. 15", "paper Fig. 17", "why they differ"):
        assert wanted in page


def test_the_report_can_be_found_about_in_and_sent(run: Path) -> None:
    page = (run / "report.html").read_text(encoding="utf-8")
    anchors = re.findall(r' id="([^"]+)"', page)
    assert len(anchors) == len(set(anchors)) > 15
    # what stands above the contents is not among them
    assert set(re.findall(r'href="#([^"]+)"', page)) == set(anchors) - {"in-short"}
    assert page.count("<h3>") == page.count("<figure") == page.count("?</h3>")  # each figure answers a question
    assert len(re.findall(r"\d ± \d", page)) >= 20
    assert (run / "report.html").stat().st_size < 5_000_000


def opened(page: Path, picture: Path) -> str:
    """Open a page in headless Chromium and take a picture of it; what its console says."""
    assert CHROMIUM is not None
    profile = picture.with_suffix(".profile")
    switches = ("--headless=new", "--no-sandbox", "--disable-gpu", "--no-first-run", "--disable-sync")
    log = ("--enable-logging=stderr", "--disable-background-networking", f"--user-data-dir={profile}")
    taken = (f"--screenshot={picture}", "--window-size=1200,2000", page.resolve().as_uri())
    done = subprocess.run(
        [CHROMIUM, *switches, *log, *taken], capture_output=True, text=True, check=True, timeout=600
    )
    return "\n".join(line for line in done.stderr.splitlines() if "CONSOLE" in line)


@pytest.mark.slow
@pytest.mark.skipif(CHROMIUM is None, reason="there is no Chromium here")
def test_a_browser_shows_the_report_and_has_nothing_to_complain_of(run: Path, tmp_path: Path) -> None:
    assert opened(run / "report.html", tmp_path / "report.png") == ""
    assert (tmp_path / "report.png").stat().st_size > 50_000
    fetching = (run / "report.html").read_text(encoding="utf-8") + '<img src="http://127.0.0.1:9/x.png">'
    (tmp_path / "fetching.html").write_text(fetching, encoding="utf-8")
    assert "Content Security Policy" in opened(tmp_path / "fetching.html", tmp_path / "fetching.png")


@pytest.mark.slow
def test_the_same_page_comes_out_again(run: Path) -> None:
    first = (run / "report.html").read_bytes()
    assert typed("report", str(run)).exit_code == 0
    assert (run / "report.html").read_bytes() == first


def test_a_run_that_has_not_come_far_says_what_to_type(run: Path, tmp_path: Path) -> None:
    shutil.copy(run / "frf.h5", tmp_path)
    assert typed("report", str(tmp_path), "--pictures").exit_code == 0
    assert (tmp_path / "waterfall.png").stat().st_size > 10_000
    page = (tmp_path / "report.html").read_text(encoding="utf-8")
    assert page.count("not run yet; make it with: flexura") == 4
    nothing = typed("report", str(tmp_path / "absent"))
    assert nothing.exit_code != 0
    assert "does not exist" in nothing.output


def test_a_damaged_result_is_refused_in_a_sentence(run: Path, tmp_path: Path) -> None:
    (tmp_path / "frf.h5").write_bytes((run / "frf.h5").read_bytes()[:5000])
    result = typed("report", str(tmp_path))
    assert result.exit_code != 0
    assert "not a readable frf.h5" in result.output
