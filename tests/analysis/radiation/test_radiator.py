"""Closed forms: circular piston, Wallace's and Maidanik's efficiencies, point source, dipole of two pistons."""

import numpy as np
import pytest
from scipy.special import j1

from analysis.radiation.measures import (
    arc,
    directivity_index,
    far_power,
    group_delay,
    hemisphere,
    radiation_efficiency,
    sound_pressure_level,
)
from analysis.radiation.radiator import Air, Radiator

RADIUS = 0.08
FREQUENCY = np.array([50.0, 300.0, 1000.0, 3000.0])


def disc(radii=16, angles=48):
    """Gauss-Legendre in r², even angles."""
    place, weight = np.polynomial.legendre.leggauss(radii)
    r = RADIUS * np.sqrt(0.5 * (place + 1.0))
    angle = 2.0 * np.pi * np.arange(angles) / angles
    points = np.stack([np.outer(r, np.cos(angle)), np.outer(r, np.sin(angle))], axis=-1).reshape(-1, 2)
    return Radiator(points, np.repeat(0.5 * weight * np.pi * RADIUS**2 / angles, angles))


def cells(length_x, length_y, count_x, count_y, **options):
    x, y = ((np.arange(n) + 0.5) / n * length for n, length in ((count_x, length_x), (count_y, length_y)))
    points = np.stack(np.meshgrid(x, y, indexing="ij"), axis=-1).reshape(-1, 2)
    return Radiator(points, np.full(len(points), length_x * length_y / len(points)), **options)


def mode(radiator, m, n, length_x, length_y):
    x, y = radiator.points.T
    return np.sin(m * np.pi * x / length_x) * np.sin(n * np.pi * y / length_y)


def test_pressure_on_the_axis_of_a_piston_is_exact():
    """P = 2ρcv |sin(k/2 (√(z² + a²) - z))|, Kinsler et al., eq. 7.4.5; phase included."""
    piston, z = disc(), np.array([0.05, 0.3, 1.0, 4.0])
    got = piston.pressure(np.stack([0 * z, 0 * z, z], axis=1), FREQUENCY).sum(axis=-1)
    k, omega = piston.wavenumber(FREQUENCY), 2.0 * np.pi * FREQUENCY
    edge = np.hypot(z, RADIUS)[:, None]
    exact = piston.air.density * piston.air.sound_speed * 1j * omega
    exact = exact * (np.exp(-1j * k * z[:, None]) - np.exp(-1j * k * edge))
    np.testing.assert_allclose(got, exact, rtol=1e-3)
    np.testing.assert_allclose(got, exact, rtol=1e-6)


def test_power_of_a_piston_is_exact_and_that_of_the_far_field():
    """W = ½ρcSv² (1 - J1(2ka)/ka)."""
    piston = disc()
    field = np.ones((len(FREQUENCY), len(piston.area), 1))
    power = piston.sources(3000.0).power(field, FREQUENCY)[:, 0, 0].real
    ka = piston.wavenumber(FREQUENCY) * RADIUS
    area = np.pi * RADIUS**2
    speed = 2.0 * np.pi * FREQUENCY
    exact = 0.5 * piston.air.density * piston.air.sound_speed * area * speed**2 * (1.0 - j1(2.0 * ka) / ka)
    np.testing.assert_allclose(power, exact, rtol=1e-3)
    np.testing.assert_allclose(power, exact, rtol=1e-5)
    np.testing.assert_allclose(far_power(piston, field[..., 0], FREQUENCY), power, rtol=1e-6)
    efficiency = radiation_efficiency(piston, power, np.full(len(FREQUENCY), area), FREQUENCY)
    np.testing.assert_allclose(efficiency, 1.0 - j1(2.0 * ka) / ka, rtol=1e-5)


def test_directivity_of_a_piston():
    """2 J1(ka sin θ)/(ka sin θ), and the index (ka)²/(1 - J1(2ka)/ka) on the axis."""
    piston = disc()
    degrees = np.array([-60.0, -20.0, 0.0, 35.0, 75.0])
    got = piston.far_field(arc(degrees, 30.0), FREQUENCY).sum(axis=-1)
    ka = piston.wavenumber(FREQUENCY) * RADIUS
    x = np.maximum(np.abs(ka * np.sin(np.deg2rad(degrees))[:, None]), 1e-9)
    np.testing.assert_allclose(got / got[2], 2.0 * j1(x) / x, rtol=1e-6, atol=1e-7)
    power = piston.sources(3000.0).power(np.ones((4, len(piston.area), 1)), FREQUENCY)[:, 0, 0].real
    index = directivity_index(piston, got[2], power)
    np.testing.assert_allclose(index, 10.0 * np.log10(ka**2 / (1.0 - j1(2.0 * ka) / ka)), atol=1e-3)


def wallace(m, n, k, a, b):
    """Radiation efficiency of a mode of a simply supported plate, Wallace, JASA 51 (1972) 946, eq. (5)."""

    def part(argument, order):
        return np.cos(argument / 2.0) if order % 2 else np.sin(argument / 2.0)

    place, weight = np.polynomial.legendre.leggauss(80)
    angle, weight = 0.25 * np.pi * (place + 1.0), 0.25 * np.pi * weight
    theta, phi = angle[:, None], angle[None]
    alpha, beta = k * a * np.sin(theta) * np.cos(phi), k * b * np.sin(theta) * np.sin(phi)
    below = ((alpha / (m * np.pi)) ** 2 - 1.0) * ((beta / (n * np.pi)) ** 2 - 1.0)
    whole = weight @ ((part(alpha, m) * part(beta, n) / below) ** 2 * np.sin(theta)) @ weight
    return 64.0 * k**2 * a * b / (np.pi**6 * m**2 * n**2) * whole


@pytest.mark.parametrize(("m", "n"), [(1, 1), (2, 1), (2, 2), (3, 1), pytest.param(3, 5, marks=pytest.mark.slow)])
def test_modes_of_a_simply_supported_plate_radiate_as_wallace_says(m, n):
    a, b = 0.5, 0.4
    plate = cells(a, b, 24 + 12 * m, 24 + 12 * n)
    field = mode(plate, m, n, a, b)
    for share in (0.1, 0.6, 1.3):  # of coincidence
        k = share * np.hypot(m * np.pi / a, n * np.pi / b)
        frequency = np.array([k * plate.air.sound_speed / (2.0 * np.pi)])
        power = plate.sources(frequency[0]).power(field[None, :, None], frequency)[:, 0, 0].real
        got = radiation_efficiency(plate, power, np.array([plate.area @ field**2]), frequency)[0]
        assert got == pytest.approx(wallace(m, n, k, a, b), rel=1e-2)
        assert far_power(plate, field[None], frequency)[0] == pytest.approx(power[0], rel=5e-3)


def test_an_odd_mode_far_below_coincidence_radiates_from_its_corners():
    """Wallace's eq. (6): the corner radiation of Maidanik, 32 k²ab/(m²n²π⁵) (1 - ...)."""
    a, b, m, n = 0.5, 0.4, 3, 1
    plate = cells(a, b, 50, 40)
    field, k = mode(plate, m, n, a, b), 1.0
    frequency = np.array([k * plate.air.sound_speed / (2.0 * np.pi)])
    power = plate.sources(frequency[0]).power(field[None, :, None], frequency)[:, 0, 0].real
    got = radiation_efficiency(plate, power, np.array([plate.area @ field**2]), frequency)[0]
    bracket = (1.0 - 8.0 / (m * np.pi) ** 2) * a / b + (1.0 - 8.0 / (n * np.pi) ** 2) * b / a
    assert got == pytest.approx(
        32.0 * k**2 * a * b / (m**2 * n**2 * np.pi**5) * (1.0 - k**2 * a * b / 12.0 * bracket), rel=1e-2
    )


def test_a_high_mode_above_coincidence_radiates_as_an_infinite_plate():
    """Maidanik, JASA 34 (1962) 809: σ = 1/√(1 - (kp/k)²)."""
    a, b, m, n = 1.0, 0.8, 10, 8
    plate = cells(a, b, 60, 48)
    kp = np.hypot(m * np.pi / a, n * np.pi / b)
    frequency = np.array([1.6 * kp * plate.air.sound_speed / (2.0 * np.pi)])
    field = mode(plate, m, n, a, b)
    power = plate.sources(frequency[0]).power(field[None, :, None], frequency)[:, 0, 0].real
    got = radiation_efficiency(plate, power, np.array([plate.area @ field**2]), frequency)[0]
    assert got == pytest.approx(1.0 / np.sqrt(1.0 - 1.0 / 1.6**2), rel=0.03)


def test_the_sum_converges_with_the_square_of_the_cells_side():
    """A free edge, where the field does not vanish: midpoint rule, order 2."""
    position, frequency = np.array([[0.1, 0.2, 0.5]]), np.array([400.0])

    def heard(count):
        plate = cells(0.3, 0.2, count, count)
        return (plate.pressure(position, frequency)[0, 0] @ np.cos(7.0 * plate.points[:, 0])).item()

    exact = heard(320)
    errors = np.array([abs(heard(count) - exact) for count in (10, 20, 40)])
    np.testing.assert_allclose(np.log2(errors[:-1] / errors[1:]), 2.0, atol=0.1)


def test_nodes_replace_all_points(rng):
    plate = cells(0.3, 0.2, 30, 20)
    field = rng.normal(size=(1, 600, 3)) + 1j * rng.normal(size=(1, 600, 3))
    for frequency in (100.0, 3000.0):
        k = 2.0 * np.pi * frequency / plate.air.sound_speed
        apart = np.linalg.norm(plate.points[:, None] - plate.points, axis=-1)
        omega = 2.0 * np.pi * frequency
        full = omega**4 * plate.air.density / (4.0 * np.pi * plate.air.sound_speed) * np.sinc(k * apart / np.pi)
        driven = plate.area[:, None] * field[0]
        exact = driven.conj().T @ full @ driven
        got = plate.sources(3000.0).power(field, np.array([frequency]))[0]
        np.testing.assert_allclose(got, exact, rtol=1e-7, atol=1e-7 * abs(exact).max())


def test_powers_of_region_and_rest_add_up_and_two_far_pistons_share_nothing():
    plate = cells(0.3, 0.2, 30, 20)
    field = np.exp(3j * plate.points[:, 0])[None, :, None]
    left = (plate.points[:, 0] < 0.1).astype(float)
    sources, frequency = plate.sources(500.0), np.array([500.0])
    parts = [sources.power(field, frequency, part) for part in (left, 1.0 - left)]
    np.testing.assert_allclose(sum(parts), sources.power(field, frequency), rtol=1e-12)
    assert parts[0][0, 0, 0].real > 0.0


def test_a_small_box_radiates_as_a_point_source():
    """The pressure is ρ a / 4πr, half of that in a baffle; so is the power, and that of the far field."""
    baffle, box = (cells(0.02, 0.02, 6, 6, mounting=mounting) for mounting in ("baffle", "box"))
    place, frequency = np.array([[0.01, 0.01, 1.0]]), np.array([200.0])
    at_box, in_baffle = (one.pressure(place, frequency).sum() for one in (box, baffle))
    omega, k = 2.0 * np.pi * 200.0, 2.0 * np.pi * 200.0 / 343.2
    assert at_box == pytest.approx(-(omega**2) * 1.204 * 4e-4 / (4.0 * np.pi) * np.exp(-1j * k), rel=3e-4)
    assert at_box == pytest.approx(0.5 * in_baffle)
    field = np.ones((1, 36, 1))
    power = box.sources(200.0).power(field, frequency)[:, 0, 0].real
    assert power == pytest.approx(0.5 * baffle.sources(200.0).power(field, frequency)[:, 0, 0].real)
    assert far_power(box, field[..., 0], frequency) == pytest.approx(power, rel=1e-9)
    assert power[0] == pytest.approx(1.204 * omega**2 * (omega * 4e-4) ** 2 / (8.0 * np.pi * 343.2), rel=1e-3)
    assert cells(0.24, 0.18, 40, 30).box_limit == pytest.approx(343.2 / (np.pi * 0.3) * 40 / 39, rel=0.01)


def test_what_cannot_be_heard_is_refused_with_what_is_allowed():
    plate = cells(0.3, 0.2, 12, 8)
    with pytest.raises(ValueError, match=r"z = -0.2 m; allowed: 0.01 m or more in front"):
        plate.pressure(np.array([[0.1, 0.1, -0.2]]), FREQUENCY)
    plate.require_fine(2000.0)
    with pytest.raises(ValueError, match=r"points 25 mm apart are too coarse for 3000 Hz.*of sound is 114 mm"):
        plate.require_fine(3000.0)
    with pytest.raises(ValueError, match=r"of the plate is 100 mm: allowed is a sixth of it, 16.7 mm"):
        plate.require_fine(300.0, 0.1)
    for wrong in ({"sound_speed": 34.3}, {"density": 1204.0}, {"sound_speed": float("nan")}):
        with pytest.raises(ValueError, match=r"sound_speed|density"):
            Air(**wrong)
    with pytest.raises(ValueError, match="points"):
        Radiator(np.zeros((3, 2)), np.ones(4))


def test_small_measures():
    directions, weight = hemisphere(6)
    assert weight.sum() == pytest.approx(2.0 * np.pi)
    np.testing.assert_allclose(np.linalg.norm(directions, axis=1), 1.0)
    assert sound_pressure_level(np.array([np.sqrt(2.0)]))[0] == pytest.approx(93.979, abs=1e-3)
    frequency = np.linspace(100.0, 200.0, 51)
    np.testing.assert_allclose(group_delay(np.exp(-2j * np.pi * frequency * 0.004), frequency), 0.004)
