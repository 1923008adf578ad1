"""``--temperature`` in all its forms."""

import numpy as np
import pytest

from app.files.bad_file import ResultFileError
from app.sound.temperatures import programme


@pytest.mark.parametrize(
    ("said", "at", "expected"),
    [("20", [0.0, 9.0], [20.0, 20.0]), ("20:45", [0.0, 5.0, 10.0], [20.0, 32.5, 45.0]), ("-5:5:0", [5.0], [5.0])],
)
def test_numbers_are_spread_over_the_sound(said, at, expected):
    np.testing.assert_allclose(programme(said, 10.0).at(at), expected)


def test_readings_may_have_a_heading_and_remarks(tmp_path):
    path = tmp_path / "readings.csv"
    path.write_text("# of the car\ntime_s,temperature_c\n1,20\n3,30,ok\n\n7,10\n")
    np.testing.assert_allclose(programme(str(path), 10.0).at([0.0, 2.0, 5.0, 9.0]), [20.0, 25.0, 20.0, 10.0])


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("", "holds no readings"),
        ("0,20\n0,21\n", "moments must ascend"),
        ("0,20\n1,warm\n", "line 2 is '1,warm'"),
        ("0,20\n1\n", "line 2 is '1'"),
        ("0,nan\n", "finite"),
        ("0,20,5\n1,21,5\n", "line 1 is '0,20,5', a third number; allowed: .* or seconds;°C"),
        (b"\xff\xfe0,1", "cannot be read"),
    ],
)
def test_readings_that_are_none_are_told(tmp_path, text, said):
    path = tmp_path / "readings.csv"
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    with pytest.raises(ResultFileError, match=said):
        programme(str(path), 10.0)


@pytest.mark.parametrize(("said", "told"), [("warm", "neither °C"), ("20:nan", "finite"), ("", "neither °C")])
def test_other_words_are_told(said, told):
    with pytest.raises(ResultFileError, match=told):
        programme(said, 10.0)


@pytest.mark.parametrize("separator", [";", "\t"])
def test_readings_of_a_german_spreadsheet(tmp_path, separator):
    """Its first reading was taken for a heading, and the second refused."""
    rows = [("Zeit [s]", "T [°C]"), ("0", "20,5"), ("1,5", "30,25"), ("3", "40")]
    file = tmp_path / "Verlauf.csv"
    file.write_text("\n".join(separator.join(row) for row in rows), encoding="utf-8")
    found = programme(str(file), 3.0)
    np.testing.assert_array_equal(found.time, [0.0, 1.5, 3.0])
    np.testing.assert_array_equal(found.temperature, [20.5, 30.25, 40.0])


@pytest.mark.parametrize(
    ("heading", "scale"),
    [
        ("time_ms,T", 1e-3),
        ("time [min],T [°C]", 60.0),
        ("Zeit (h),T", 3600.0),
        ("t/ms,T", 1e-3),
        ("minutes,°C", 60.0),
        ("Time [ms],T", 1e-3),
        ("seconds,°C", 1.0),
        ("time,kettle", 1.0),
    ],
)
def test_times_of_readings_have_the_unit_of_their_heading(tmp_path, heading, scale):
    """Milliseconds were taken for seconds: the temperature stood still."""
    (tmp_path / "t.csv").write_text(f"{heading}\n0,20\n100,30\n", encoding="utf-8")
    course = programme(str(tmp_path / "t.csv"), 10.0)
    np.testing.assert_allclose(course.at(50.0 * scale), 25.0)


@pytest.mark.parametrize("heading", ["t,T [°F]", "t,T (K)", "t,temp_F", "t,Kelvin"])
def test_readings_in_other_degrees_are_refused(tmp_path, heading):
    (tmp_path / "t.csv").write_text(f"{heading}\n0,20\n100,30\n", encoding="utf-8")
    with pytest.raises(ResultFileError, match="temperatures in °C are wanted"):
        programme(str(tmp_path / "t.csv"), 10.0)
