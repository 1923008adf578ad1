"""The chosen reading of poles in every place where a person meets frequencies."""

import csv
import json
from pathlib import Path

import numpy as np
import pytest

from analysis.estimation.transfer import MeasuredTransfer
from app.files.results.modes_file import load_modes
from app.files.uff.frfs import write_frfs
from app.modal_test.edits import add_mode, drop_mode
from app.report.modal_test import sections_of_test
from app.report.page import PageTable, Paragraph
from tests.app.modal_test.conftest import typed

NATURAL, ZETA = np.array([100.0, 260.0]), np.array([0.15, 0.01])
HYSTERETIC = NATURAL * np.sqrt(1.0 - 2.0 * ZETA**2)


@pytest.fixture(scope="module")
def frfs(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Two FRFs of two modes; the two readings of the first, heavily damped one are 2 Hz apart."""
    rng, f = np.random.default_rng(4), np.arange(10.0, 400.0, 0.5)
    s, poles = 2j * np.pi * f, 2 * np.pi * NATURAL * (-ZETA + 1j * np.sqrt(1.0 - ZETA**2))
    made = []
    for n, shape in enumerate(((1.0, 0.3), (1.0, -0.2)), start=1):
        h = sum(r / 2j / p.imag * (1 / (s - p) - 1 / (s - p.conj())) for r, p in zip(shape, poles, strict=True))
        h = h + 1e-3 * np.abs(h).max() * (rng.normal(size=f.size) + 1j * rng.normal(size=f.size))
        made.append(MeasuredTransfer(f"point {n}", f"{n}:+3", "1:+3", "displacement", f, h))
    path = tmp_path_factory.mktemp("heavy") / "heavy.uff"
    write_frfs(path, made)
    return path


@pytest.mark.parametrize(("damping", "wanted"), [("viscous", NATURAL), ("hysteretic", HYSTERETIC)])
def test_json_table_report_and_universal_file_agree(
    frfs: Path, tmp_path: Path, damping: str, wanted: np.ndarray
) -> None:
    words = ("identify", frfs, "--shared-poles", "--damping", damping, "--out", tmp_path)
    found = json.loads(typed(*words, "--json").stdout)
    frequency = [mode["frequency_hz"] for mode in found["modes"]]
    assert frequency == pytest.approx(list(wanted), rel=2e-3)
    assert [shape["frequency_hz"] for shape in found["shapes"]] == frequency
    with (tmp_path / "modes.csv").open(encoding="utf-8") as file:
        written = [float(row["frequency_hz"]) for row in csv.DictReader(file)]
    assert written == pytest.approx(frequency)
    _, _, parts = sections_of_test(tmp_path)
    items = next(part.items for part in parts if part.title == "Modes")
    (table,) = (item for item in items if isinstance(item, PageTable))
    assert [row[:2] for row in table.rows] == [(str(n), f"{f:.3f}") for n, f in enumerate(frequency, start=1)]
    assert damping in next(item.text for item in items if isinstance(item, Paragraph))
    for n, f in enumerate(frequency, start=1):
        assert f"mode {n}: {f:.4f} Hz" in (tmp_path / "modes.uff").read_text(encoding="ascii")


def test_the_choice_stays_when_modes_are_changed_by_hand(frfs: Path, tmp_path: Path) -> None:
    typed("identify", frfs, "--shared-poles", "--damping", "viscous", "--out", tmp_path, "--quiet")
    assert float(drop_mode(tmp_path, 100.0).split()[2]) == pytest.approx(NATURAL[0], rel=2e-3)
    assert load_modes(tmp_path / "modes.h5").damping == "viscous"
    assert float(add_mode(tmp_path, 99.0).split()[2]) == pytest.approx(NATURAL[0], rel=2e-3)
    assert load_modes(tmp_path / "modes.h5").modes[0].damping == "viscous"
