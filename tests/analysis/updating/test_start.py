"""Few sharp resonances: the start finds their basin wherever in the box they lie."""

import numpy as np
import pytest

from analysis.material import MaterialBox
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
