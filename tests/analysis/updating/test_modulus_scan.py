"""A scan of one sweep finds the modulus within a few per cent, and distinguishes a wrong range from a good one."""

from dataclasses import replace

import numpy as np
import pytest

from analysis.material import LocalLaws, MaterialBox
from analysis.updating.start import scan_modulus, scanned_box

BOX = MaterialBox((1.0e9, 4.0e9), (0.3, 0.48), (0.005, 0.12))


class Damped:
    """A twin at one loss factor, whatever the data's."""

    def __init__(self, twin) -> None:
        self.twin = twin

    def frf(self, e, nu, frequency):
        return self.twin.frf(LocalLaws.of_material(e, nu, 0.04), frequency)


def look(twin, modulus: float, loss: float = 0.05, box: MaterialBox = BOX, noise: float = 0.01):
    frf = twin.measured(np.array([20.0]), [(modulus, 0.4, loss)], 12.0, np.random.default_rng(1), noise)
    return scan_modulus(Damped(twin), frf.frequency, frf.h[0], box)


@pytest.mark.parametrize("modulus", [1.2e9, 2.0e9, 3.7e9])
@pytest.mark.parametrize("loss", [0.02, 0.08])
def test_a_modulus_within_the_range_is_found_there(twin, modulus: float, loss: float) -> None:
    seen = look(twin, modulus, loss)
    assert seen.modulus == pytest.approx(modulus, rel=0.1)
    assert (seen.outside, seen.far_outside) == (False, False)


@pytest.mark.parametrize("modulus", [0.25e9, 12e9])
def test_a_modulus_far_outside_is_found_and_stops(twin, modulus: float) -> None:
    seen = look(twin, modulus)
    assert seen.modulus == pytest.approx(modulus, rel=0.1)
    assert seen.far_outside


def test_noise_without_a_plate_stops_nothing(twin) -> None:
    rng = np.random.default_rng(2)
    lines = np.arange(100.0, 1500.0)
    for _ in range(5):
        h = rng.standard_normal((1, lines.size)) + 1j * rng.standard_normal((1, lines.size))
        assert not scan_modulus(Damped(twin), lines, h, BOX).outside


def test_sign_and_size_of_channels_do_not_matter(affine_modes) -> None:
    twin = affine_modes(np.random.default_rng(7), sensors=2)
    frf = twin.measured(np.array([20.0]), [(2e9, 0.4, 0.05)], 12.0, np.random.default_rng(3))
    turned = replace(frf, h=frf.h * np.array([-1.0, 30.0])[:, None])
    one, other = (scan_modulus(Damped(twin), f.frequency, f.h[0], BOX) for f in (frf, turned))
    assert other.agreement == pytest.approx(one.agreement)


def test_common_plates_are_scanned_whatever_is_declared() -> None:
    low, high = scanned_box(BOX).youngs_modulus
    assert low <= BOX.youngs_modulus[0] / 8.0
    assert high >= 210e9
    metal = scanned_box(MaterialBox((58e9, 83e9), (0.3, 0.36), (2e-4, 0.02)))
    assert metal.youngs_modulus[0] <= 1e9
