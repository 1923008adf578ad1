"""Other packages' identification of one FRF, for `benchmarks/identification.py --peers`.

None of them is needed by Flexura. They are installed into an environment of their own (`docs/dependencies.md`).
"""

from collections.abc import Callable
from contextlib import redirect_stdout

import numpy as np
from numpy.typing import NDArray

from tests.synthetic_frf import SyntheticFrf

Found = tuple[NDArray[np.complex128], NDArray[np.float64] | None]

MOST_DAMPED = 0.2
"""Damping ratio beyond which a pole counts as background, whoever found it."""

ORDER = 60
"""Polynomial order, or pairs of poles, at most."""


def sdypy_lscf(case: SyntheticFrf) -> Found:
    """LSCF of sdypy-EMA, its stable poles nearest to the true frequencies, which it is told."""
    from sdypy import EMA

    low, high = float(case.frequency[0]), float(case.frequency[-1])
    model = EMA.Model(
        case.h[None], case.frequency, lower=low, upper=high, pol_order_high=ORDER, frf_type="receptance"
    )
    model.get_poles(method="lscf", show_progress=False)
    model.select_closest_poles(list(np.abs(case.poles) / (2 * np.pi)))
    w, zeta = 2 * np.pi * np.asarray(model.nat_freq), np.asarray(model.nat_xi)
    return w * (-zeta + 1j * np.sqrt(1 - zeta**2)), None


def scikit_rf(case: SyntheticFrf) -> Found:
    """Vector fitting with automatic order of scikit-rf; its poles whose peak stands out of the noise."""
    import skrf
    from skrf.vectorFitting import VectorFitting

    size = float(np.abs(case.h).max())
    frequency = skrf.Frequency.from_f(case.frequency, unit="hz")
    fitted = VectorFitting(skrf.Network(frequency=frequency, s=(case.h / size)[:, None, None], z0=50))
    fitted.auto_fit(model_order_max=2 * ORDER, target_error=case.deviation / size)
    poles, residues = np.asarray(fitted.poles), size * np.asarray(fitted.residues)[0]
    upper = poles.imag > 0.0
    poles, residues = poles[upper], residues[upper]
    return poles[_mode(case, poles) & (np.abs(residues) / -poles.real > 4.0 * case.deviation)], None


def sdynpy_polypy(case: SyntheticFrf) -> Found:
    """PolyPy of SDynPy: the stable poles of its highest order."""
    from sdynpy.core.sdynpy_coordinate import coordinate_array
    from sdynpy.core.sdynpy_data import FunctionTypes, data_array
    from sdynpy.modal.sdynpy_polypy import PolyPy

    place = np.array([coordinate_array(1, 3), coordinate_array(2, 3)]).view(type(coordinate_array(1, 3)))
    frfs = data_array(FunctionTypes.FREQUENCY_RESPONSE_FUNCTION, case.frequency, case.h.copy(), place)
    fitted = PolyPy(frfs, displacement_derivative=0)
    with redirect_stdout(None):
        fitted.compute_poles(np.arange(4, ORDER + 1, 2))
    last = max(fitted.pole_list, key=len)
    stable = last[last["freq_stable"] & last["damp_stable"]]
    w, zeta = np.asarray(stable["omega"]), np.asarray(stable["zeta"])
    poles = w * (-zeta + 1j * np.sqrt(np.maximum(1 - zeta**2, 0.0)))
    return poles[_mode(case, poles)], None


def _mode(case: SyntheticFrf, poles: NDArray[np.complex128]) -> NDArray[np.bool_]:
    """Poles that may be modes of the case: stable, in band, not a slope of the background."""
    place, zeta = poles.imag / (2 * np.pi), -poles.real / np.abs(poles)
    return (zeta > 0.0) & (zeta < MOST_DAMPED) & (place > case.frequency[0]) & (place < case.frequency[-1])


PEERS: dict[str, Callable[[SyntheticFrf], Found]] = {
    "sdypy-EMA, told the frequencies": sdypy_lscf,
    "scikit-rf": scikit_rf,
    "SDynPy PolyPy": sdynpy_polypy,
}
