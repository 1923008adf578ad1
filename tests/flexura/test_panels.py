"""Filters in a script: from measured transfers and from a twin file, as the verbs make them."""

from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest
import pyuff
from click.testing import CliRunner

import flexura
from analysis.estimation.transfer import MeasuredTransfer
from analysis.focusing.measured import MeasuredTransfers
from app.files.bad_file import ResultFileError
from app.files.campaign_error import CampaignFileError
from app.files.campaigns.channels import read_experiment
from app.files.declarations.panel import read_panel
from app.files.provenance import read_stamp, sha256
from app.files.results.panel_files import load_compensation, load_focusing
from app.files.results.transfers_file import read_transfers, write_transfers
from app.files.results.twin_file import Basis, Estimated, TwinFile, TwinLaws, TwinOrigin, read_twin, write_twin
from app.files.uff.frfs import write_frfs
from app.main import flexura as program
from app.stages import focus as focus_stage
from app.stages.panel import laws as panel_laws
from app.stages.panel.laws import laws_of_twin
from tests.two_patch_panel import PANEL

EXAMPLE = Path(__file__).resolve().parents[2] / "examples" / "pp-plate"


@pytest.fixture
def panel(tmp_path: Path) -> Path:
    (tmp_path / "panel.toml").write_text(PANEL, encoding="utf-8")
    return tmp_path / "panel.toml"


@pytest.fixture
def scan(tmp_path: Path) -> Path:
    """Six modes of a plate that softens with temperature, read at an even grid of points."""
    length_x, length_y = 0.24, 0.19
    x, y = np.meshgrid(length_x * (np.arange(10) + 0.5) / 10, length_y * (np.arange(8) + 0.5) / 8, indexing="ij")
    points = np.column_stack([x.ravel(), y.ravel()])
    orders = [(m, n) for m in (1, 2, 3) for n in (1, 2)]

    def shapes(at: np.ndarray[Any, np.dtype[np.float64]]) -> np.ndarray[Any, np.dtype[np.float64]]:
        return np.array(
            [np.sin(np.pi * m * at[:, 0] / length_x) * np.sin(np.pi * n * at[:, 1] / length_y) for m, n in orders]
        )

    natural = np.array([80.0 * ((m / 1.2) ** 2 + n**2) for m, n in orders])
    temperature = np.arange(0.0, 61.0, 10.0)
    frequency = np.arange(4.0, 52.0) * 4000.0 / 512.0
    driven = shapes(np.array([[0.07, 0.1], [0.15, 0.1]]))
    fields = []
    for stiffness in 1.0 - 0.005 * temperature:
        modal = 1e-2 / (stiffness * natural[:, None] ** 2 * (1.0 + 0.06j) - frequency**2)
        fields.append(np.einsum("ra,rf,rp->afp", driven, modal, shapes(points)))
    h = np.array(fields)
    write_transfers(tmp_path / "scan.h5", MeasuredTransfers(temperature, points, frequency, h, np.zeros(h.shape)))
    return tmp_path / "scan.h5"


@pytest.fixture
def twin(tmp_path: Path) -> Path:
    declared = read_experiment(EXAMPLE)
    few = (1e-5,) * 4
    laws = {"youngs_modulus": (3.2e9, 2.8e9, 2.3e9, 1.9e9), "poisson_ratio": (0.34, 0.35, 0.37, 0.38)}
    laws |= {"loss_factor": (0.05, 0.07, 0.08, 0.08), "temperature": (0.0, 10.0, 20.0, 30.0)}
    sigmas = {f"sigma_{name}": few for name in ("youngs_modulus", "poisson_ratio", "loss_factor")}
    file = TwinFile(
        **{
            name: getattr(declared, name)
            for name in TwinFile.model_fields
            if hasattr(declared, name) and name != "format"
        },
        gain=Estimated(value=16.5, sigma=0.001, unit="V/V"),
        laws=TwinLaws.model_validate(laws | sigmas | {"temperature_range": (0.0, 30.0)}),
        effect=(),
        basis=Basis(operators="ab" * 32, error=1e-4),
        origin=TwinOrigin(flexura="0.2.0", campaign="pp", inputs="cd" * 32, verdict="explained"),
    )
    write_twin(tmp_path / "twin.toml", file)
    return tmp_path / "twin.toml"


def test_filters_of_measured_transfers_are_those_of_the_verb(panel: Path, scan: Path, tmp_path: Path) -> None:
    found = flexura.focus(panel=panel, transfers=scan, out=tmp_path / "script")
    words = ["focus", "--panel", panel, "--transfers", scan, "--out", tmp_path / "verb", "--quiet"]
    done = CliRunner().invoke(program, [str(word) for word in words])
    assert done.exit_code == 0, done.output
    _, typed, _ = load_focusing(tmp_path / "verb" / "filters.h5")
    _, saved, _ = load_focusing(tmp_path / "script" / "filters.h5")
    assert found.measured
    for taps in (found.focusing.bank.taps, saved.bank.taps):
        np.testing.assert_array_equal(taps, typed.bank.taps)

    followed = flexura.compensate(tmp_path / "script", transfers=scan, out=tmp_path / "script")
    words = ["compensate", tmp_path / "verb", "--transfers", scan, "--quiet"]
    done = CliRunner().invoke(program, [str(word) for word in words])
    assert done.exit_code in (0, 1), done.output
    _, typed_networks = load_compensation(tmp_path / "verb" / "compensation.h5")
    assert followed.measured
    assert followed.panel == read_panel(panel)
    here = np.linspace(0.0, 60.0, 13)
    ours, theirs = (one.trained.networks.taps(here) for one in (followed.compensation, typed_networks))
    np.testing.assert_allclose(ours, theirs, rtol=1e-9, atol=1e-9 * np.abs(theirs).max())


def test_transfers_in_a_folder_of_universal_files(panel: Path, scan: Path, tmp_path: Path) -> None:
    """Each file's SHA-256 is kept, as by the verb."""
    folder = tmp_path / "scans"
    folder.mkdir()
    with pytest.raises(ResultFileError, match="a folder without universal files"):
        flexura.focus(panel=panel, transfers=folder, out=tmp_path / "script")
    with pytest.raises(ResultFileError, match="no such file"):
        flexura.compensate(panel=panel, transfers=tmp_path / "nothing.h5", out=tmp_path / "script")
    assert not (tmp_path / "script").exists()
    held = read_transfers(scan, (60.0, 360.0), 20.0)
    nodes = np.arange(1, len(held.points) + 1)
    for t, temperature in enumerate(held.temperature):
        frfs = [
            MeasuredTransfer("", f"{node}:+3", f"{900 + a}:+3", "displacement", held.frequency, h)
            for a, answers in enumerate(held.transfer[t])
            for node, h in zip(nodes, answers.T, strict=True)
        ]
        write_frfs(folder / f"scan_{temperature:g}C.uff", frfs)
        none, flat = np.zeros(len(nodes), dtype=int), np.zeros(len(nodes))
        placed = pyuff.prepare_2411(nodes, none, none, none, *held.points.T, flat)
        pyuff.UFF(str(folder / f"scan_{temperature:g}C.uff")).write_sets(placed | {"type": 2411}, "add")
    found = flexura.focus(panel=panel, transfers=folder, out=tmp_path / "script")
    single = flexura.focus(panel=panel, transfers=scan)
    taps = single.focusing.bank.taps
    np.testing.assert_allclose(found.focusing.bank.taps, taps, rtol=1e-6, atol=1e-6 * np.abs(taps).max())
    with h5py.File(tmp_path / "script" / "filters.h5") as file:
        inputs = read_stamp(file)["inputs"]
    names = [f"scan_{temperature:g}C.uff" for temperature in held.temperature]
    assert inputs == {one: sha256(folder / one) for one in names} | {panel.name: sha256(panel)}


def test_the_laws_of_a_twin_file_and_those_without_its_effects_reach_the_stage(
    panel: Path, twin: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Handed over as `flexura focus RUN --twin` hands them; the panel's own twin is not made for that."""
    asked: dict[str, Any] = {}

    class HandedOverError(Exception):
        pass

    def compute(declared: Any, laws: Any, report: Any, **options: Any) -> None:
        asked.update(options, panel=declared, laws=laws)
        raise HandedOverError

    monkeypatch.setattr(focus_stage, "compute", compute)
    plain = laws_of_twin(read_twin(twin), twin)
    monkeypatch.setattr(panel_laws, "uncorrected_laws", lambda run: {tmp_path / "run": plain}.get(run))
    (tmp_path / "run").mkdir()
    with pytest.raises(HandedOverError):
        flexura.focus(tmp_path / "run", panel, twin=twin)
    at = np.linspace(0.0, 30.0, 7)
    np.testing.assert_array_equal(
        asked["laws"].at(at).youngs_modulus, laws_of_twin(read_twin(twin), twin).at(at).youngs_modulus
    )
    assert asked["temperature"] is None
    assert asked["uncorrected"] is plain
    with pytest.raises(HandedOverError):
        flexura.focus(None, panel, twin=twin, temperature=[20.0])
    assert asked["temperature"].tolist() == [20.0]
    assert asked["uncorrected"] is None


def test_what_does_not_go_together_is_refused(panel: Path, scan: Path, twin: Path, tmp_path: Path) -> None:
    laws = laws_of_twin(read_twin(twin), twin)
    for stage in (flexura.focus, flexura.compensate):
        with pytest.raises(ValueError, match="laws, twin or transfers: one of them is needed"):
            stage()
        with pytest.raises(ValueError, match="twin takes the place of laws in memory"):
            stage(laws, panel, twin=twin)
        with pytest.raises(ValueError, match="transfers take the place of twin"):
            stage(panel=panel, transfers=scan, twin=twin)
    with pytest.raises(ValueError, match="transfers take the place of laws"):
        flexura.focus(laws, panel, transfers=scan)
    with pytest.raises(ValueError, match="modal-control needs the modes of a model"):
        flexura.focus(panel=panel, transfers=scan, method="modal-control")
    with pytest.raises(ValueError, match="transfers take the place of spacing"):
        flexura.compensate(panel=panel, transfers=scan, spacing=5.0)
    with pytest.raises(ValueError, match="laws beside transfers: the run folder"):
        flexura.compensate(laws, panel, transfers=scan)
    with pytest.raises(ResultFileError, match="was measured at 0, 10, 20, 30, 40, 50, 60 °C"):
        flexura.focus(panel=panel, transfers=scan, temperature=[21.0])
    with pytest.raises(CampaignFileError, match="no-twin"):
        flexura.focus(twin=tmp_path / "no-twin.toml", panel=panel)


@pytest.mark.parametrize("temperature", [21.5, [21.5], np.array([21.5])])
def test_one_temperature_need_not_be_in_a_list(
    panel: Path, scan: Path, monkeypatch: pytest.MonkeyPatch, temperature: Any
) -> None:
    asked = []

    def stopped(_: object, __: object, named: tuple[float, ...]) -> None:
        asked.append(named)
        raise KeyboardInterrupt

    monkeypatch.setattr("flexura.panels.measured_panel", stopped)
    with pytest.raises(KeyboardInterrupt):
        flexura.focus(panel=panel, transfers=scan, temperature=temperature)
    assert asked == [(21.5,)]
