"""Tables of natural frequencies: read, refused in words, and taken to E, nu and eta against published ones."""

import json
import re
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import flexura
from analysis.identification.modes import Damping, read_poles
from app.files.bad_file import ResultFileError
from app.plate_frfs.plate_of_modes import modes_of_table

Run = Callable[..., tuple[int, str, str]]

FREE_SQUARE = (13.4682, 19.5961, 24.2702, 34.8009, 34.8009, 61.0932, 61.0932, 63.6870, 69.2654, 77.1725)
"""w a^2 sqrt(rho h / D) of a free square thin plate with nu = 0.3 (Gorman, Free Vibration Analysis of Rectangular
Plates, 1982; to the digits shown by Liew et al., Vibration of Mindlin Plates, 1998, for thin ones)."""
SIDE, THICKNESS, DENSITY = 0.3, 0.001, 7850.0

PLATE = f"""
format = "flexura-plate/1"
title = "free square plate of steel, from a table"

[plate]
length_x = {SIDE}
length_y = {SIDE}
thickness = {THICKNESS}
mass = {DENSITY * SIDE**2 * THICKNESS}
material = {{ kind = "steel" }}
"""


def published(modulus: float) -> list[float]:
    """Natural frequencies, Hz, of the plate above with nu = 0.3."""
    rigidity = modulus * THICKNESS**3 / (12.0 * (1.0 - 0.3**2))
    return [w / (2.0 * np.pi * SIDE**2) * np.sqrt(rigidity / (DENSITY * THICKNESS)) for w in FREE_SQUARE]


def write(path: Path, text: str) -> Path:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text, encoding="utf-8")
    return path


def test_published_frequencies_give_their_modulus_and_poisson_ratio(tmp_path: Path, run_flexura: Run) -> None:
    """Half a per cent of thickness, of a weighed plate 1.5 % of E, is stated; the value is far nearer."""
    rows = [f"20.0;{f:.4f};{1e-3 * f:.4f};0,004" for f in published(205e9)]
    table = write(tmp_path / "modes.csv", "T [°C];f [Hz];sigma_f [Hz];eta\n" + "\n".join(rows).replace(".", ","))
    plate = write(tmp_path / "plate.toml", PLATE)
    status, out, said = run_flexura("update", table, "--plate", plate, "--out", tmp_path / "run", "--json")
    assert status == 0, said
    row = json.loads(out)["temperatures"][0]
    assert row["youngs_modulus_pa"] == pytest.approx(205e9, rel=4e-3)
    assert row["poisson_ratio"] == pytest.approx(0.3, abs=0.004)
    assert row["loss_factor"] == pytest.approx(0.004, rel=0.02)
    assert row["sigma"]["youngs_modulus_pa"] / 205e9 == pytest.approx(0.015, rel=0.1)
    assert [mode["mode"] for mode in row["modes"]] == list(range(1, 11))
    assert "10 modes" in said


def test_a_declaration_is_written_around_a_table(tmp_path: Path, run_flexura: Run) -> None:
    rows = [f"20.0,{f:.4f},{1e-3 * f:.4f}" for f in published(205e9)]
    table = write(tmp_path / "modes.csv", "temperature,frequency,sigma_frequency\n" + "\n".join(rows) + "\n")
    mass = f"{DENSITY * SIDE**2 * THICKNESS}"
    words = (
        "new",
        "plate",
        table,
        "--plate",
        f"{SIDE}",
        f"{SIDE}",
        f"{THICKNESS}",
        mass,
        "--out",
        tmp_path / "steel",
    )
    status, _, said = run_flexura(*words)
    assert status == 0, said
    text = (tmp_path / "steel" / "plate.toml").read_text(encoding="utf-8")
    assert '[[modes]]\nfile = "../modes.csv"' in text
    write(
        tmp_path / "steel" / "plate.toml",
        text.replace("[[modes]]", '[plate.material]\nkind = "steel"\n\n[[modes]]'),
    )
    status, _, said = run_flexura("update", tmp_path / "steel", "--quiet")
    assert status == 0, said


def test_the_library_does_the_same(tmp_path: Path) -> None:
    rows = [f"20.0,{f:.4f},{1e-3 * f:.4f}" for f in published(205e9)]
    table = write(tmp_path / "modes.csv", "temperature,frequency,sigma_frequency\n" + "\n".join(rows) + "\n")
    found = flexura.update_modes(write(tmp_path / "plate.toml", PLATE), table, out=tmp_path / "run")
    assert found.fitted.updated.material.poisson_ratio[0] == pytest.approx(0.3, abs=0.004)
    assert "1 sweep, 20.0 °C" in repr(found)
    assert (tmp_path / "run" / "laws.h5").is_file()


def test_modes_in_the_declaration_are_the_same(tmp_path: Path, run_flexura: Run) -> None:
    frequencies = ", ".join(f"{f:.4f}" for f in published(205e9)[:4])
    modes = f"\n[[modes]]\ntemperature = 20.0\nfrequency = [{frequencies}]\n"
    modes += "sigma_frequency = 0.02\nmode = [1, 2, 3, 4]\n"
    write(tmp_path / "steel" / "plate.toml", PLATE + modes)
    status, out, said = run_flexura("update", tmp_path / "steel", "--json")
    assert status == 0, said
    row = json.loads(out)["temperatures"][0]
    assert row["youngs_modulus_pa"] == pytest.approx(205e9, rel=6e-3)
    assert (tmp_path / "steel-run" / "laws.h5").is_file()
    assert "no damping is given" in said
    for verb in ("gap", "identify"):
        status, _, said = run_flexura(verb, tmp_path / "steel")
        assert status == 2
        assert "has modes, no FRFs: flexura update takes it" in said
    write(tmp_path / "bare" / "plate.toml", PLATE)
    status, _, said = run_flexura("update", tmp_path / "bare")
    assert status == 2
    assert "names no FRFs; " in said
    assert "for natural frequencies alone [[modes]]" in said


HEAD = "temperature,frequency,damping_ratio\n"


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "0 lines"),
        ("frequency,damping_ratio\n100,0.01\n", "no column 'temperature'; it has frequency, damping_ratio"),
        (HEAD + "20,abc,0.01\n", "row 2: frequency = 'abc'; a number is wanted"),
        (HEAD + "20,,0.01\n", "row 2: no frequency"),
        (HEAD + "300,100,0.01\n", "temperature 300 °C; allowed: -80 to 200"),
        (HEAD + "20,-5,0.01\n", "frequency -5 Hz; allowed"),
        (HEAD + "20,100,2.5\n", "damping_ratio 2.5; below 0.7 is allowed: % stands in the name"),
        (HEAD + "20,100,-0.1\n", "damping at 20 °C must be above 0"),
        ("temperature,frequency,status\n20,100,weak\n", "all its modes are weak"),
        ("temperature [K],frequency\n293,100\n", "column 'temperature [K]': temperatures in °C are wanted"),
    ],
)
def test_what_is_wrong_with_a_table_is_said(text: str, message: str, tmp_path: Path) -> None:
    path = write(tmp_path / "modes.csv", text)
    with pytest.raises(ResultFileError, match=re.escape(message)):
        modes_of_table(path)


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"temperature,frequency\n20,36,864\n", "row 2: 3 values below 2 names. If commas are decimal marks"),
        (b"temperature;frequency\n20,0;1.036\n", r"row 2: frequency = '1.036'; others .* decimal comma"),
        (b"temperature (K);frequency\n293,15;36,8\n", "temperatures in °C are wanted: K - 273.15"),
        ("temperature (°F);frequency\n68;36,8\n".encode(), "temperatures in °C are wanted: "),
        (b"temperature;frequency (mHz)\n20;36800\n", "unit 'mhz'; allowed: "),
        (b"PK\x03\x04whatever", "a workbook, no text; save its sheet as CSV"),
    ],
)
def test_numbers_that_would_be_taken_for_others_are_refused(content: bytes, message: str, tmp_path: Path) -> None:
    path = tmp_path / "modes.csv"
    path.write_bytes(content)
    with pytest.raises(ResultFileError, match=message):
        modes_of_table(path)


def test_a_table_of_western_windows_is_read(tmp_path: Path) -> None:
    path = tmp_path / "modes.csv"
    path.write_bytes("Temperatur [°C];Frequenz [Hz];Dämpfung [%]\n20,0;36,864;0,1\n".encode("cp1252"))
    (one,) = modes_of_table(path)
    assert one.temperature == 20.0
    assert one.frequency[0] == pytest.approx(36.864, rel=1e-5)
    assert one.loss_factor[0] == pytest.approx(2e-3, rel=1e-3)


def test_units_decimal_commas_and_viscous_modes_are_understood(tmp_path: Path) -> None:
    """A viscous pole of 10 % at |pole| = 2 pi 1000 Hz: k = -pole^2, f = sqrt(Re k) / 2 pi, eta = Im k / Re k."""
    path = write(
        tmp_path / "m.csv", "# a paper\nmode\tfreq [kHz]\tT\tdamping [%]\n3\t1,0\t21,04\t10\n7\t2,0\t21,0\t\n"
    )
    (one,) = modes_of_table(path)
    pole = 2.0 * np.pi * 1000.0 * (-0.1 + 1j * np.sqrt(1.0 - 0.01))
    k = -(pole**2)
    assert one.temperature == pytest.approx(21.02)
    assert one.number.tolist() == [3, 7]
    assert one.frequency[0] == pytest.approx(np.sqrt(k.real) / (2.0 * np.pi))
    assert one.loss_factor[0] == pytest.approx(k.imag / k.real)
    assert np.isnan(one.loss_factor[1])
    assert np.isnan(one.sigma).all()


def test_the_unit_of_a_column_counts_and_german_names_are_read(tmp_path: Path) -> None:
    """Frequencies in rad/s were taken as Hz, and the dampings left out."""
    path = write(
        tmp_path / "m.csv",
        "Temperatur [°C];frequency [rad/s];Dämpfung [%];Verlustfaktor [-]\n20,5;628,3185307179586;1,5;0,03\n",
    )
    (one,) = modes_of_table(path)
    assert one.temperature == pytest.approx(20.5)
    assert one.frequency == pytest.approx([100.0], rel=1e-3)
    assert one.loss_factor == pytest.approx([0.03], rel=1e-3)


@pytest.mark.parametrize("zeta", [0.002, 0.02, 0.15])
@pytest.mark.parametrize("columns", [("damping_ratio",), ("damping_ratio", "loss_factor"), ("loss_factor",)])
@pytest.mark.parametrize("damping", ["viscous", "hysteretic"])
def test_a_table_is_read_by_the_reading_that_it_was_written_with(
    tmp_path: Path, zeta: float, columns: tuple[str, ...], damping: Damping
) -> None:
    """The same poles, whatever is written of them: frequency and loss factor of the complex stiffness."""
    if columns == ("damping_ratio",) and damping == "hysteretic":
        pytest.skip(
            "a damping ratio alone stands beside undamped natural frequencies, as other programs print them"
        )
    if columns == ("loss_factor",) and damping == "viscous":
        pytest.skip("a loss factor alone stands beside frequencies of hysteretic damping")
    poles = 2.0 * np.pi * np.array([80.0, 210.0]) * (-zeta + 1j * np.sqrt(1.0 - zeta**2))
    reading = read_poles(poles, np.full((2, 2, 2), 1e-6), damping)
    lines = [",".join(("temperature", "frequency", *columns))]
    lines += [
        ",".join(
            f"{value:.9g}" for value in (20.0, reading.frequency_hz[n], *(getattr(reading, c)[n] for c in columns))
        )
        for n in range(2)
    ]
    (tmp_path / "modes.csv").write_text("\n".join(lines) + "\n", encoding="utf-8")
    (found,) = modes_of_table(tmp_path / "modes.csv")
    k = -((poles / (2.0 * np.pi)) ** 2)
    np.testing.assert_allclose(found.frequency, np.sqrt(k.real), rtol=1e-7)
    np.testing.assert_allclose(found.loss_factor, k.imag / k.real, rtol=1e-6)
