"""Recordings with something wrong in them that is no physics: said in words, and never named as an effect."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from simulation.meshing.plate_mesh import MeshRecipe
from simulation.reduction.effect_reduction import reduce_with_effects
from simulation.shell.fineness import Fineness

Run = Callable[..., tuple[int, str, str]]
Cut = Callable[[Path, tuple[int, ...]], None]
Change = Callable[[Path, Callable[[str, NDArray[Any]], NDArray[Any]]], None]

pytestmark = pytest.mark.slow


def sweeps(folder: Path) -> list[Path]:
    return sorted((folder / "sweeps").iterdir())


def no_gap(run: Run, folder: Path) -> str:
    """Compare a recording on which nothing may be named; what was said besides."""
    status, out, err = run("gap", folder, "--json")
    record = json.loads(out)
    assert (status, record["verdict"], record["effects"]) == (0, "none", [])
    assert record["gap"]["baseline"]["chi2_per_dof"] == pytest.approx(1.0, abs=0.06)
    return err


def test_an_inverted_channel_and_understated_noise(
    tmp_path: Path, cut_recording: Cut, change_samples: Change, run_flexura: Run
) -> None:
    """Three temperatures; the repeats drawn together by 0.7 state a noise that is too small."""
    folder = tmp_path / "inverted"
    cut_recording(folder, (12, 24, 36))

    def spoil(name: str, repeats: NDArray[Any]) -> NDArray[Any]:
        middle = repeats.mean(0)
        return repeats if name == "drive" else -(middle + 0.7 * (repeats - middle))

    for path in sweeps(folder):
        change_samples(path, spoil)
    said = no_gap(run_flexura, folder)
    assert "channel S1 is inverted: wiring, patch polarity" in said
    assert "channel S1: the noise is 1.4" in said
    status, _, said = run_flexura("update", folder)
    assert status == 0
    assert "channel S1 is inverted" in said


def test_hum_of_a_mains_frequency_not_declared(
    tmp_path: Path, cut_recording: Cut, change_samples: Change, run_flexura: Run
) -> None:
    """One temperature; 49.9 Hz and thirty harmonics, whose upper ones miss the lines left out for 50 Hz."""
    folder = tmp_path / "hum"
    cut_recording(folder, (24,))

    rng = np.random.default_rng(1)

    def hum(name: str, repeats: NDArray[Any]) -> NDArray[Any]:
        if name == "drive":
            return repeats
        begin = rng.uniform(0.0, 1.0, (len(repeats), 1))  # repeats do not wait for the mains
        time = begin + np.arange(repeats.shape[1]) * 6 / 51_200.0
        loud = sum(np.sin(2 * np.pi * 49.9 * n * time + n) / n for n in range(1, 31))
        return repeats + 0.005 * np.abs(repeats).max() * loud

    change_samples(sweeps(folder)[0], hum)
    assert "mains hum at multiples of 49.9" in no_gap(run_flexura, folder)


def test_a_saturated_sweep_among_good_ones(
    tmp_path: Path, cut_recording: Cut, change_samples: Change, run_flexura: Run
) -> None:
    """Peaks rounded off, not cut: no sample looks clipped, and every temperature has its own material."""
    folder = tmp_path / "saturated"
    cut_recording(folder, (8, 12, 16, 20, 24))

    def saturate(name: str, repeats: NDArray[Any]) -> NDArray[Any]:
        top = 0.5 * np.abs(repeats).max()
        return repeats if name == "drive" else top * np.tanh(repeats / top)

    change_samples(sweeps(folder)[2], saturate)
    assert "sweep at 16.0 °C (up, 1 V) left out" in no_gap(run_flexura, folder)


def test_a_coarse_mesh_is_refused(
    tmp_path: Path, cut_recording: Cut, run_flexura: Run, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The recording has no effect in it; a twin on a coarse mesh would find one."""
    folder = tmp_path / "coarse"
    cut_recording(folder, (24,))
    mesh = MeshRecipe(spacing=0.08, strip=2.7, edge_strip=2.7, growth=2.0, grading=0.0, pieces=1)
    coarse = Fineness(mesh, degree=3, tolerance=1e-5)

    def build(experiment: Any, box: Any, report: Any, **_: Any) -> Any:
        return reduce_with_effects(experiment, box, fineness=coarse)[0]

    monkeypatch.setattr("app.twins.campaign_twin.cached_operators", build)
    status, out, err = run_flexura("gap", folder, "--json")
    assert (status, out) == (2, "")
    assert "coarse: cannot be judged: the twin of this plate has an estimated error of" in err
    assert "sigma of the noise" in err
