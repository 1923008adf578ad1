"""Few sharp resonances: the start finds their basin wherever in the box they lie."""

import numpy as np
import pytest

from analysis.declaration.plate import Plate
from analysis.material import MaterialBox
from analysis.updating import start
from analysis.updating.normal_equations import SweepData
from analysis.updating.update import update


@pytest.mark.parametrize("loss", [1e-3, 4e-3])
def test_sharp_resonances_are_met_from_afar(affine_modes, loss: float) -> None:
    rng = np.random.default_rng(5)
    twin = affine_modes(np.random.default_rng(8), modes=7)
    twin.box = MaterialBox((1.6e9, 2.4e9), (0.3, 0.37), (2e-4, 0.02))
    for _ in range(6):
        truth = (rng.uniform(1.65e9, 2.35e9), rng.uniform(0.31, 0.36), loss)
        result = update(twin.measured(np.array([20.0]), [truth], 12.0, rng, noise=0.02), twin)
        assert result.settled.all()
        assert result.material.youngs_modulus[0] == pytest.approx(truth[0], rel=1e-3)
        assert result.material.loss_factor[0] == pytest.approx(loss, rel=0.1)


@pytest.mark.parametrize(("believed", "ratios"), [(0.1, 1), (0.0, 3)])
def test_other_ratios_are_asked_only_where_the_middle_one_leads_nowhere(
    affine_modes, monkeypatch: pytest.MonkeyPatch, believed: float, ratios: int
) -> None:
    monkeypatch.setattr(start, "ROUGH", believed)
    monkeypatch.setattr(start, "NOISY", 0.0)
    rng = np.random.default_rng(1)
    twin = affine_modes(np.random.default_rng(8))
    data = SweepData.of(twin.measured(np.array([20.0]), [(2e9, 0.45, 0.03)], 12.0, rng, noise=1e-3), 0, 4)
    asked, frf = set(), twin.frf
    monkeypatch.setattr(twin, "frf", lambda laws, *rest: asked.add(round(laws.value[1], 6)) or frf(laws, *rest))
    shares: list[float] = []
    found = start.start_material(twin, data, shares.append)
    assert shares == sorted(shares)
    assert shares[-1] == 1.0
    assert found[0] == pytest.approx(2e9, rel=0.1)
    assert len(asked) == ratios


def test_frequencies_in_khz_that_were_taken_for_hz_are_refused() -> None:
    """0.04 to 0.6 ended with a traceback of a matrix that has no factor. A free square has kL = 3.67 first."""
    plate = Plate(length_x=0.2, length_y=0.15, thickness=0.0022, mass=0.06)
    with pytest.raises(ValueError, match=r"end at 0\.6 Hz.*no resonance below about 21 Hz. Are.* in kHz\?"):
        start.require_bending(plate, np.linspace(0.04, 0.6, 100))
    start.require_bending(plate, np.linspace(1.0, 21.0, 100))
