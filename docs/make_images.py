"""Make every picture of README and docs again: python docs/make_images.py [--independent FOLDER].

Takes about ten minutes, most of them for the first comparison with effects. The recording with two hidden effects
is not shipped: its picture is made again where `--independent` names that campaign.
"""

import argparse
import json
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Mapping
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from scipy.io import wavfile

ROOT = Path(__file__).resolve().parents[1]
IMAGES = ROOT / "docs" / "images"
FLEXURA = (sys.executable, "-m", "flexura")
RECORDED = ROOT / "examples" / "pp-plate"
RIG = ROOT / "examples" / "simulated-rig.toml"
HAMMER = ROOT / "examples" / "hammer-rig.toml"
TESTS = ROOT / "examples" / "modal-tests"

CHAIN = {name: name for name in ("waterfall", "identified", "laws", "overlays", "before", "after")}
"""Figures of the report on the shipped recording, and what they are called here."""
GAP = {name: name for name in ("gap-map", "gap-candidates", "gap-laws")}
"""Those of the same recording with its sensor declared where it is not."""
TWO_EFFECTS = {"gap-map": "gap-two-effects"}
"""That of the recording with two hidden effects."""
PAGES = ("frfs", "modes", "gap", "fields")
"""Pages of the window on the latter."""
LIVE = ("live",)
"""The page of the window on a campaign under way."""
TEST = ("test-frfs", "test-modes")
"""Pages of the window on a modal test, that of the laser in docs/guide/modal-test.md."""
BESIDE_TWIN = ("test-twin",)
"""The page with modes of test and twin, of the hammer test in docs/guide/hammer-test.md."""
SOUND = {"music-rendered": "rendered", "thermometer": "thermometer"}
"""Pictures of notes through the filters of that run, and of its panel as its own thermometer."""
WATCHED = {"watch": 1280, "watch-telephone": 360}
"""Pictures of the page of `flexura watch`, and how many pixels wide they are."""
MADE = {
    *SOUND.values(),
    *CHAIN.values(),
    *GAP.values(),
    *TWO_EFFECTS.values(),
    *(f"view-{page}-dark" for page in PAGES + LIVE + TEST + BESIDE_TWIN),
    *WATCHED,
}
SWEEPS_WATCHED = 4
"""Sweeps after which a campaign under way is looked at."""


def flexura(*words: str | Path) -> None:
    """Run a verb; stop where it fails."""
    print("flexura", *words, flush=True)
    subprocess.run([*FLEXURA, *map(str, words)], cwd=ROOT, check=True)


def analyse(campaign: Path, run: Path, *, gap: bool) -> None:
    """Take a campaign through every stage, with the gap closed before filters are made or without."""
    flexura("identify", campaign, "--out", run, "--quiet")
    flexura("update", campaign, "--out", run, "--quiet")
    if gap:
        flexura("gap", campaign, "--out", run, "--quiet")
    flexura("focus", run, "--quiet")
    flexura("compensate", run, "--quiet")


def take(run: Path, figures: Mapping[str, str]) -> None:
    """Copy figures of a run's report, each to the name it has here."""
    with TemporaryDirectory() as folder:
        flexura("report", run, "--pictures", "--out", folder, "--quiet")
        for figure, image in figures.items():
            shutil.copyfile(Path(folder) / f"{figure}.png", IMAGES / f"{image}.png")


def look(folder: Path, pages: tuple[str, ...], *window: str) -> None:
    """Copy pages of the window on a folder."""
    with TemporaryDirectory() as shots:
        flexura("view", folder, *window, "--theme", "dark", "--screenshot", shots)
        for page in pages:
            shutil.copyfile(Path(shots) / f"view-{page}-dark.png", IMAGES / f"view-{page}-dark.png")


def play(run: Path) -> None:
    """Play notes struck at random through a run's filters, and let the panel tell its temperature by them."""
    rate, rng = 44_100, np.random.default_rng(0)
    sound = 0.003 * rng.standard_normal(60 * rate)
    for begin in range(0, len(sound), rate // 8):
        time = np.arange(min(len(sound) - begin, 2 * rate)) / rate
        pitch, fall = 82.0 * 2.0 ** (rng.integers(0, 40) / 12.0), rng.uniform(0.1, 0.6)
        harmonics = sum(rng.uniform(0.2, 1.0) / h * np.sin(2 * np.pi * h * pitch * time) for h in range(1, 8))
        sound[begin : begin + len(time)] += np.exp(-time / fall) * harmonics
    with TemporaryDirectory() as folder:
        music = Path(folder) / "music.wav"
        wavfile.write(music, rate, np.float32(0.5 * sound / np.abs(sound).max()))
        words = ("--picture", "--out", folder, "--quiet")
        flexura("render", music, run, "--temperature", "20:45", *words)
        flexura("thermometer", run, "--simulate", music, "--temperature", "20:21", *words)
        for made, image in SOUND.items():
            shutil.copyfile(Path(folder) / f"{made}.png", IMAGES / f"{image}.png")


def sensor_declared_elsewhere(folder: Path) -> Path:
    """Copy the shipped recording, its sensor declared 2 mm away, as docs/guide/closing-a-gap.md does."""
    shutil.copytree(RECORDED, folder)
    declaration = folder / "campaign.toml"
    text = declaration.read_text(encoding="utf-8")
    moved = text.replace("center = [0.04, 0.035]", "center = [0.042, 0.034]")
    if moved == text:
        raise SystemExit(f"{declaration}: no patch at [0.04, 0.035] to be moved")
    declaration.write_text(moved, encoding="utf-8")
    return folder


def watch(campaign: Path) -> None:
    """Look at a campaign under way: the runner is held for as long as the picture takes."""
    running = subprocess.Popen([*FLEXURA, "acquire", str(RIG), "--out", str(campaign), "--quiet"], cwd=ROOT)
    while len(list(campaign.glob("sweeps/*.h5"))) < SWEEPS_WATCHED:
        if running.poll() is not None:
            raise SystemExit(f"{RIG}: ended with status {running.returncode} before it could be looked at")
        time.sleep(0.05)
    running.send_signal(signal.SIGSTOP)
    try:
        look(campaign, LIVE, "--window", "live")
        look_at_page(campaign)
    finally:
        running.send_signal(signal.SIGCONT)
        running.wait()


def look_at_page(campaign: Path) -> None:
    """Take pictures of the page of `flexura watch` in Chromium, which has to be installed."""
    sys.path.insert(0, str(ROOT))
    from tests.browser import opened_browser

    watcher = subprocess.Popen(
        [*FLEXURA, "watch", str(campaign), "--json"], cwd=ROOT, stdout=subprocess.PIPE, text=True
    )
    try:
        text = ""
        while not text.rstrip().endswith("}"):
            text += watcher.stdout.readline()  # type: ignore[union-attr]
        with opened_browser() as browser:
            for image, width in WATCHED.items():
                browser.look(json.loads(text)["url"], width, dark=width > 1000)
                browser.until("return document.querySelectorAll('svg path').length > 4")
                time.sleep(1.0)
                browser.picture(IMAGES / f"{image}.png")
    finally:
        watcher.send_signal(signal.SIGINT)
        watcher.wait()


def modal_test(folder: Path) -> None:
    """Take a modal test from its files to the window."""
    shutil.copytree(TESTS / "laser", folder)
    words = ("--frf-units", "mm/s", "N", "--points", folder / "points.csv", "--quiet")
    flexura("new", "test", folder / "laser.npz", *words)
    flexura("identify", folder / "test.toml", "--out", folder / "run", "--quiet")
    look(folder / "run", TEST)


def hammer_test(folder: Path) -> None:
    """Hit a simulated plate, and look at its modes beside those of the twin."""
    hits, modes, run = (folder / name for name in ("hammered", "hammered-modes", "hammered-run"))
    flexura("acquire", HAMMER, "--out", hits, "--quiet")
    flexura("identify", hits, "--band", "60", "600", "--out", modes, "--quiet")
    flexura("update", hits, "--out", run, "--quiet")
    look(modes, BESIDE_TWIN, "--beside", str(run))


def main() -> None:
    """Make them all."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--independent", type=Path, metavar="FOLDER", help="the campaign with two hidden effects")
    independent = parser.parse_args().independent
    with TemporaryDirectory() as desk:
        folder = Path(desk)
        modal_test(folder / "laser")
        hammer_test(folder)
        watch(folder / "rig")
        analyse(RECORDED, folder / "run", gap=False)
        take(folder / "run", CHAIN)
        play(folder / "run")
        moved = sensor_declared_elsewhere(folder / "moved")
        analyse(moved, folder / "moved-run", gap=True)
        take(folder / "moved-run", GAP)
        look(folder / "moved-run", PAGES, "--window", "recorded")
        if independent is not None:
            flexura("update", independent, "--out", folder / "two-run", "--quiet")
            flexura("gap", independent, "--out", folder / "two-run", "--quiet")
            take(folder / "two-run", TWO_EFFECTS)
    print(f"pictures made again in {IMAGES}; look at them before committing")


if __name__ == "__main__":
    main()
