"""Units and names against data sheets and ISO 7626-1."""

import pytest

from analysis.estimation.quantities import calibration, frf_label, frf_name, unit


@pytest.mark.parametrize(
    ("text", "quantity", "scale"),
    [
        ("g", "acceleration", 9.80665),
        ("m/s^2", "acceleration", 1.0),
        ("µm/s", "velocity", 1e-6),
        ("kN", "force", 1e3),
        ("(m/s²)", "acceleration", 1.0),
        ("ms⁻²", "acceleration", 1.0),
    ],
)
def test_units_as_files_write_them(text: str, quantity: str, scale: float) -> None:
    assert (unit(text).quantity, unit(text).scale) == (quantity, scale)


def test_an_accelerometer_of_100_mv_per_g() -> None:
    """0.25 V are 2.5 g."""
    read = calibration("V", "100 mV/g")
    assert read.quantity == "acceleration"
    assert 0.25 * read.scale == pytest.approx(2.5 * 9.80665)


def test_a_hammer_of_2_25_mv_per_n_recorded_in_millivolts() -> None:
    read = calibration("mV", "2.25 mV/N")
    assert (read.quantity, read.unit) == ("force", "N")
    assert 22.5 * read.scale == pytest.approx(10.0)


def test_a_sound_file_and_a_sensor_that_is_turned_round() -> None:
    assert calibration("FS", "0.5 FS/Pa").scale == pytest.approx(2.0)
    assert calibration("V", "-100 mV/g").scale < 0.0


@pytest.mark.parametrize(
    ("written", "per_volt"),
    [
        ("10.2 mV/(m/s²)", 1e3 / 10.2),
        ("10,2mV/m/s2", 1e3 / 10.2),
        ("-1.02e1 mV/ms-2", -1e3 / 10.2),
        ("100mV/g", 98.0665),
        ("0.1 V/g", 98.0665),
    ],
)
def test_sensitivities_as_data_sheets_write_them(written: str, per_volt: float) -> None:
    read = calibration("V", written)
    assert (read.quantity, read.scale) == ("acceleration", pytest.approx(per_volt))


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("V", None), 'sensitivity, for example "100 mV/g"'),
        (("FS", None), "0.2 FS/g"),
        (("furlong", None), "'furlong' is not known; allowed: V, mV"),
        (("N", None, "acceleration"), "a unit of force, not of acceleration"),
        (("V", "100 pC/g"), "gives pC, but the file is in V"),
        (("V", "0 mV/g"), "other than 0"),
        (("V", "1,000 mV/g"), "with a decimal point"),
        (("V", "mV/g"), "a number other than 0"),
        (("FS", "100 mV/g"), "a sound file holds shares of full scale"),
        (("V", "100"), "2.25 mV/N"),
        (("V", "100 mV/g", "force"), "of acceleration, not of force"),
    ],
)
def test_what_cannot_be_a_calibration_says_what_to_write(arguments: tuple[str, ...], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        calibration(*arguments)  # type: ignore[arg-type]


def test_names_of_frfs() -> None:
    assert frf_label("acceleration", "force") == "accelerance [m/s2/N]"
    assert frf_label("velocity", "force") == "mobility [m/s/N]"
    assert frf_label("displacement", "force") == "receptance [m/N]"
    assert frf_name("force", "acceleration") == "apparent mass"
    assert frf_label("acceleration", "acceleration") == "transmissibility [m/s2/m/s2]"
    assert frf_label("acceleration", "voltage") == "acceleration per voltage [m/s2/V]"
