"""Rectangles: Navier against Levy, and both against classical thin plates."""

import numpy as np
import pytest

from tests.simulation.verification.exact_plates import HardRectangle, LevyPlate, PlateWaves


@pytest.mark.parametrize(("m", "n"), [(1, 1), (2, 1), (3, 4)])
def test_naviers_thin_plate_is_kirchhoffs(m, n):
    thin = np.pi**2 * (m**2 + (n / 0.8) ** 2)
    errors = [abs(HardRectangle(h, 0.3, 0.8).frequencies((m, n))[0] / thin - 1) for h in (0.002, 0.001)]
    assert errors[1] < 2e-4
    assert errors[0] / errors[1] == pytest.approx(4.0, rel=0.01)


@pytest.mark.parametrize("half_waves", [(1, 1), (2, 3)])
def test_naviers_bending_branch_is_that_of_travelling_waves(half_waves):
    """The hard plate's modes are sums of plane waves: wave numbers at each branch's frequency are the mode's."""
    branches = HardRectangle(0.15, 0.3, 0.7).frequencies(half_waves)
    k2 = np.pi**2 * (half_waves[0] ** 2 + (half_waves[1] / 0.7) ** 2)
    bending, twist = PlateWaves(0.15, 0.3).bending(branches)
    numbers = np.vstack([bending, twist])
    assert numbers[0, 0] == pytest.approx(k2)
    assert np.all(np.abs(numbers / k2 - 1).min(axis=0) < 1e-10)


@pytest.mark.parametrize("thickness", [0.01, 0.1, 0.25])
def test_levys_solution_contains_naviers(thickness):
    highest = 200.0
    branches = [HardRectangle(thickness, 0.3, 0.8).frequencies((2, n)) for n in range(1, 30)]
    # No half wave along y: theta_y alone, the same all over y.
    waves = PlateWaves(thickness, 0.3)
    branches.append(np.sqrt([(waves.shear + 0.35 * (2 * np.pi) ** 2) / waves.rotary]))
    wanted = np.sort(np.concatenate(branches))
    found = LevyPlate(thickness, 0.3, 0.8, "hard", "hard").frequencies(2, highest)
    assert found == pytest.approx(wanted[wanted < highest], rel=1e-8)
    assert found.size >= 3


LEISSA = {
    ("free", "free"): "9.6314 16.135 36.726 38.945 46.738 70.740",
    ("clamped", "clamped"): "28.951 54.743 69.327 94.585 102.216",
    ("clamped", "free"): "12.687 33.065 41.702 63.015 72.398",
    ("hard", "free"): "11.685 27.756 41.197 59.066 61.861",
    ("hard", "clamped"): "23.646 51.674 58.646 86.135",
}
"""Thin squares on simple supports at x = 0 and a, nu = 0.3: A. W. Leissa, J. Sound Vib. 31 (1973) 257-293."""


@pytest.mark.parametrize("edges", LEISSA)
def test_thin_square_plates_are_leissas(edges):
    wanted = np.array(LEISSA[edges].split(), float)
    found = LevyPlate(0.001, 0.3, 1.0, *edges).all_frequencies(1.002 * wanted[-1])
    assert found[: wanted.size] == pytest.approx(wanted, rel=6e-4)
    mirrored = LevyPlate(0.001, 0.3, 1.0, edges[1], edges[0]).all_frequencies(1.002 * wanted[-1])
    assert mirrored == pytest.approx(found, rel=1e-9)


def test_the_lowest_frequencies_are_the_same_by_both_solutions():
    by_navier = HardRectangle(0.1, 0.3, 0.5).lowest(9)
    assert by_navier == pytest.approx(LevyPlate(0.1, 0.3, 0.5, "hard", "hard").lowest(9), rel=1e-9)
    assert by_navier == pytest.approx(0.25**-1 * HardRectangle(0.2, 0.3, 2.0).lowest(9), rel=1e-9)


@pytest.mark.parametrize("edge", ["free", "clamped", "hard", "soft"])
def test_a_looser_edge_never_raises_a_frequency(edge):
    looser = {"free": "free", "clamped": "hard", "hard": "soft", "soft": "free"}[edge]
    tight = LevyPlate(0.1, 0.3, 0.9, edge, "soft").frequencies(1, 150.0)
    loose = LevyPlate(0.1, 0.3, 0.9, looser, "soft").frequencies(1, 150.0)
    assert loose.size >= tight.size >= 3
    assert np.all(loose[: tight.size] <= tight * (1 + 1e-12))


@pytest.mark.parametrize(
    ("make", "says"),
    [
        (lambda: HardRectangle(0.1, 0.3, 1.0).frequencies((0, 1)), r"half waves are \(0, 1\)"),
        (lambda: LevyPlate(0.1, 0.3, 0.0, "free", "free"), "width is 0"),
        (lambda: LevyPlate(0.1, 0.3, 1.0, "free", "glued"), "support is 'glued'"),
        (lambda: LevyPlate(0.1, 0.3, 1.0, "free", "free").frequencies(0, 5.0), "half waves is 0"),
    ],
)
def test_what_is_no_plate_is_refused(make, says):
    with pytest.raises(ValueError, match=says):
        make()
