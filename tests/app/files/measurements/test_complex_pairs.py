"""FRFs in two columns each, as analysers export them."""

from pathlib import Path

import numpy as np
import pytest

from app.files.measurements.guarded import read_columns

LINES = np.arange(1.0, 101.0)
H = np.array([1.0 / (40.0**2 - LINES**2 + 3j * LINES), -2.0 / (70.0**2 - LINES**2 + 4j * LINES)])


def written(folder: Path, head: str, parts: list[np.ndarray]) -> Path:
    np.savetxt(folder / "a.csv", np.column_stack([LINES, *parts]), "%.17g", ";", header=head, comments="")
    return folder / "a.csv"


@pytest.mark.parametrize(
    ("head", "names"),
    [
        ("Frequency [Hz];P1 Re [g/N];P1 Im [g/N];P2 Re [g/N];P2 Im [g/N]", ["P1", "P2"]),
        ("f;H1_real;H1_imag;H2_real;H2_imag", ["H1", "H2"]),
        (
            "Freq;Real part, point 1;Imaginary part, point 1;Real part, point 2;Imaginary part, point 2",
            ["point 1", "point 2"],
        ),
        ("Hz;Re(A);Im(A);Re(B);Im(B)", ["FRF", "2"]),
    ],
)
def test_real_and_imaginary_parts_of_several_frfs(tmp_path: Path, head: str, names: list[str]) -> None:
    read = read_columns(written(tmp_path, head, [part for h in H for part in (h.real, h.imag)]))
    assert list(read.values)[1:] == names
    np.testing.assert_allclose(list(read.values.values())[1:], H, rtol=1e-12)
    if "g/N" in head:
        assert [read.units[name] for name in names] == ["g/N", "g/N"]


@pytest.mark.parametrize(
    ("head", "decibels", "degrees"),
    [
        ("Frequency [Hz];Magnitude [g/N];Phase [deg]", False, True),
        ("Frequency [Hz];Amplitude [dB re 1 g/N];Phase [°]", True, True),
        ("Frequency;Mag;Phase", False, False),
        ("Frequency;Mag;Phase", True, True),
        ("f;abs;arg [rad]", False, False),
    ],
)
def test_magnitude_and_phase(tmp_path: Path, head: str, decibels: bool, degrees: bool) -> None:
    magnitude, phase = np.abs(H[0]), np.angle(H[0])
    parts = [20 * np.log10(magnitude) if decibels else magnitude, np.degrees(phase) if degrees else phase]
    read = read_columns(written(tmp_path, head, parts))
    assert list(read.values)[1:] == ["FRF"]
    np.testing.assert_allclose(read.values["FRF"], H[0], rtol=1e-12)
    assert read.units.get("FRF", "g/N") == "g/N"


def test_a_single_frf_of_two_parts_keeps_them_and_signals_are_left_alone(tmp_path: Path) -> None:
    read = read_columns(written(tmp_path, "Frequency;Real;Imag", [H[0].real, H[0].imag]))
    assert list(read.values) == ["Frequency", "Real", "Imag"]
    read = read_columns(written(tmp_path, "Time;Amplitude;Phase", [H[0].real, H[0].imag]))
    assert list(read.values) == ["Time", "Amplitude", "Phase"]
