"""Which plates are set beside the paper's."""

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from analysis.declaration.plate import Plate
from analysis.focusing.methods import MethodComparison
from analysis.identification.over_temperature.tracked_modes import TrackedModes
from analysis.material import Material, laws_through
from app.report.paper import (
    compensation_rows,
    is_the_papers,
    material_rows,
    method_rows,
    mode_rows,
    temperature_rows,
)
from tests.app.view.conftest import tracked


@pytest.mark.parametrize(
    ("size", "mass", "same"),
    [
        ((0.24, 0.19, 0.003), 0.12996, True),
        ((0.24, 0.19, 0.003), 0.33, False),
        ((0.3, 0.2, 0.002), 0.13, False),
    ],
)
def test_only_a_plate_of_its_size_and_mass_is_compared(
    size: tuple[float, float, float], mass: float, same: bool
) -> None:
    length_x, length_y, thickness = size
    assert is_the_papers(Plate(length_x=length_x, length_y=length_y, thickness=thickness, mass=mass)) is same


@pytest.mark.parametrize(("highest", "rows"), [(300.0, 3), (200.0, 2), (800.0, 4)])
def test_the_paper_is_compared_where_the_panel_s_band_goes(highest: float, rows: int) -> None:
    frequency = np.arange(100.0, highest + 1.0, 10.0)
    ones = np.ones((1, len(frequency)))
    found = method_rows(MethodComparison(("stif",), (1.1e9, 0.33, 0.06), frequency, ones, ones))
    assert len(found) == rows
    headings = " ".join(row.quantity for row in found)
    assert (f"to {min(540.0, highest):.0f} Hz" in headings, "to 540 Hz" in headings) == (True, highest > 540.0)
    assert all(row.ours in ("1.00 mean", "100 mean") for row in found)


@pytest.mark.parametrize("constants", [(1.1e9, 0.33, 0.06), (0.0, 0.0, 0.0)])
def test_rows_of_methods_name_the_plate_that_they_are_of(constants: tuple[float, float, float]) -> None:
    """They stood under `this run` without a word, and are of the illustration's material."""
    frequency = np.arange(100.0, 801.0, 10.0)
    ones = np.ones((1, len(frequency)))
    found = method_rows(MethodComparison(("stif",), constants, frequency, ones, ones))
    of = ", plate of E 1.1 GPa, η 6 %, not of this run's laws" if constants[0] else ", with the measured transfers"
    assert len(found) == 4
    assert all(of in row.quantity for row in found)


def modes_at(*temperature: float) -> TrackedModes:
    """Modes of the tests' plate, said to be found at other temperatures."""
    one = tracked()
    count = len(temperature)
    return replace(
        one,
        temperature=np.array(temperature),
        direction=one.direction[:count],
        level=one.level[:count],
        modes=one.modes[:count],
        track=one.track[:count],
        start=0,
    )


@pytest.mark.parametrize(
    ("temperature", "wanted"),
    [
        (
            (0.4, 25.0, 59.2),
            [
                "frequencies at 0 against 25 °C [%]",
                "frequencies at 59 against 25 °C [%]",
                "span",
                "span",
                "at 0",
                "at 59",
            ],
        ),
        ((15.0, 25.0, 45.0), []),
        ((0.4, 25.0, 45.0), ["frequencies at 0 against 25 °C [%]", "span", "at 0"]),
        ((0.4, 30.0, 60.0), ["span", "span", "at 0", "at 60"]),
        ((20.0,), []),
    ],
)
def test_modes_stand_beside_the_paper_s_at_its_temperatures_only(
    temperature: tuple[float, ...], wanted: list[str]
) -> None:
    """What it found at 0 and 60 °C stood beside whatever temperatures a campaign had."""
    found = [row.quantity for row in mode_rows(modes_at(*temperature))]
    assert len(found) == len(wanted)
    assert all(part in heading for part, heading in zip(wanted, found, strict=True))


@pytest.mark.parametrize(("span", "there"), [((0.0, 60.0), True), ((15.0, 45.0), False), ((0.0, 15.0), False)])
def test_the_damping_peak_is_compared_where_the_laws_reach_over_the_paper_s(
    span: tuple[float, float], there: bool
) -> None:
    t = np.linspace(*span, 9)
    material = Material(3e9 - 3e7 * t, 0.34 + 0.001 * t, 0.08 - 1e-5 * (t - 20.0) ** 2)
    found = material_rows(laws_through(t, material))
    assert (found[-1].quantity == "largest η [%]") is there


@pytest.mark.parametrize(
    ("reference", "temperature", "rows"),
    [(20.0, (0.0, 20.0, 60.0), 1), (30.0, (30.0, 45.0), 0), (20.0, (20.0, 80.0), 0), (20.0, (20.0, 42.5), 0)],
)
def test_filters_kept_are_compared_from_and_at_the_paper_s_temperatures(
    reference: float, temperature: tuple[float, ...], rows: int
) -> None:
    contrast = np.linspace(0.8, 0.3, len(temperature))[:, None]
    focusing: Any = SimpleNamespace(
        reference_temperature=reference,
        temperature=np.array(temperature),
        fixed=SimpleNamespace(contrast=contrast),
    )
    assert len(temperature_rows(focusing)) == rows


@pytest.mark.parametrize(("span", "rows"), [((0.0, 60.0), 4), ((15.0, 45.0), 2)])
def test_the_networks_are_judged_over_the_paper_s_temperatures_or_not_compared(
    span: tuple[float, float], rows: int
) -> None:
    one = np.ones((1, 3))
    compensation: Any = SimpleNamespace(
        methods=("network",),
        temperature=np.linspace(*span, 3),
        relative_error=one[:, :, None],
        contrast_loss=one,
        largest_loss=np.ones(1),
        best="network",
        seconds=np.ones(1),
        trained=SimpleNamespace(networks=SimpleNamespace(slope=np.ones(2))),
    )
    assert len(compensation_rows(compensation)) == rows
