"""Where on the plate mass, stiffness or damping is missing: a map from the residual, with resolution and sigma.

A load at a place with apparent mass m(f) changes a response by m(f) t(f), t the tangent of a mass there. A spring
k is m = -k/w**2, a dashpot c is m = -j c/w: one tangent at each place gives all three maps, and any curve over
frequency. First order: what is several times the plate's own impedance at the place is drawn too small.
"""

from collections.abc import Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import qr

from analysis.arrays import Complex, Real
from analysis.gap.data.sweeps import GapSweeps
from analysis.gap.fitting.gap_fit import GapFit
from analysis.gap.fitting.normal_equations import GLOBAL, VALUES, whiten_all
from analysis.twin_model import Tangent, TwinModel

KINDS = ("mass", "stiffness", "damping")
"""Of the maps: kg, N/m, N s/m."""
UNITS = ("kg", "N/m", "N s/m")
SCALES = np.geomspace(1e-3, 1e3, 19)
"""Standard deviations of the prior tried, over the plate-wide mean of what one sigma of the data could be."""


@dataclass(frozen=True)
class PlaceTangents:
    """Whitened changes of all sweeps by a mass of 1 kg at each of some places, laws and gain eliminated.

    Attributes
    ----------
    places : (S, 2) ndarray, m
    frequency : (n,) ndarray, Hz
    columns : (T, S, K, n) complex ndarray
        Before whitening, at the nodes, V/V per kg.
    residual : (T, 2Kn) ndarray
        Whitened, what laws and gain of the sweep alone could explain taken out.
    nuisance : tuple of (2Kn, q) ndarray
        Orthonormal columns of each sweep's laws and gain.
    sweeps : GapSweeps
    errors : float
        By which chi2 is divided: the twin's own error, and what the fit leaves.
    """

    places: Real
    frequency: Real
    columns: Complex = field(repr=False)
    residual: Real = field(repr=False)
    nuisance: tuple[Real, ...] = field(repr=False)
    sweeps: GapSweeps = field(repr=False)
    errors: float

    @classmethod
    def of(
        cls,
        model: TwinModel,
        sweeps: GapSweeps,
        fit: GapFit,
        probe: str,
        executor: Executor,
        errors: float,
    ) -> "PlaceTangents":
        """Differentiate all sweeps by a mass at each site of an effect.

        Parameters
        ----------
        model : TwinModel
        sweeps : GapSweeps
        fit : GapFit
            Of these sweeps.
        probe : str
            Effect of a mass at a place: parameters ``mass``, ``x``, ``y``.
        executor : Executor
            Sweeps are linearised on it.
        errors : float

        Returns
        -------
        PlaceTangents
        """
        card, state = model.cards[probe], fit.state
        tangents: list[Tangent] = [(probe, "mass", card.zero(site)) for site in card.sites]
        laws = sweeps.smoothness.laws(state.laws)
        counted = model.counted(laws, state.on)

        def changes(sweep: int) -> Complex:
            point = state.circumstances(sweep, sweeps.points[sweep])
            group = sweeps.groups.of_sweep[sweep]
            near = laws[group].tilted(state.tilt[group], state.bend[group], point.temperature)
            line = counted.linearise(near, sweeps.nodes.frequency, state.on, point, tangents)
            return np.asarray(np.exp(state.log_gain[point.source]) * line.by_parameter)

        columns = np.array(list(executor.map(changes, range(sweeps.count))))
        white = whiten_all(model, sweeps, state, (), executor)
        nuisance, residual = [], []
        for sweep, one in enumerate(white):
            source = sweeps.points[sweep].source
            own = _flat(one.white[[*range(VALUES.stop), GLOBAL + source]])
            basis = qr((own / np.linalg.norm(own, axis=1, keepdims=True)).T, mode="economic")[0]
            rest = _flat(one.white[-1:])[0]
            nuisance.append(basis)
            residual.append(rest - basis @ (basis.T @ rest))
        places = np.array([[site["x"], site["y"]] for site in card.sites])
        frequency = sweeps.nodes.frequency
        return cls(places, frequency, columns, np.array(residual), tuple(nuisance), sweeps, errors)

    def equations(self, factors: Complex, places: Sequence[int] | None = None) -> tuple[Real, Real]:
        """Return normal equations for loads whose apparent masses are `factors` over frequency.

        Parameters
        ----------
        factors : (B, n) complex ndarray
            Apparent mass over frequency per unit of each.
        places : sequence of int, optional
            At which places, all by default.

        Returns
        -------
        matrix : (S B, S B) ndarray
            Place by place.
        gradient : (S B,) ndarray
        """
        chosen = np.arange(len(self.places)) if places is None else np.asarray(places)
        size = len(chosen) * len(factors)
        matrix, gradient = np.zeros((size, size)), np.zeros(size)
        for sweep, basis in enumerate(self.nuisance):
            changed = self.columns[sweep, chosen][:, None] * factors[:, None, :]
            splines = self.sweeps.nodes.coefficients(changed)
            white = self.sweeps.compressed[sweep].whitened(splines) * self.sweeps.rows[sweep]
            flat = _flat(white.reshape(size, *white.shape[2:]))
            left = flat - (flat @ basis) @ basis.T
            matrix += left @ left.T
            gradient += left @ self.residual[sweep]
        return matrix / self.errors, gradient / self.errors

    def evidence(self, factors: Complex) -> Real:
        """Log evidence of a load with any sum of `factors` (B, n) at each place, over none, nats: (S,)."""
        found = []
        for place in range(len(self.places)):
            matrix, gradient = self.equations(factors, [place])
            scale = 1.0 / np.sqrt(np.maximum(np.diag(matrix), 1e-300))
            found.append(_best_evidence(matrix * scale[:, None] * scale, gradient * scale)[0])
        return np.array(found)


@dataclass(frozen=True)
class PlaceMap:
    """Missing mass, stiffness and damping over the plate.

    Attributes
    ----------
    places : (S, 2) ndarray, m
    value, sigma : (3, S) ndarray
        Of `KINDS`, in `UNITS`: what is missing within one cell around each place.
    resolution : (3,) ndarray
        Distance at which two loads are told apart where the map is sharpest, m.
    nats : (3,) ndarray
        Log evidence of each map alone over none.
    """

    places: Real
    value: Real
    sigma: Real
    resolution: Real
    nats: Real


def place_map(tangents: PlaceTangents) -> PlaceMap:
    """Map what is missing: each kind alone, places alike to their neighbours.

    Parameters
    ----------
    tangents : PlaceTangents

    Returns
    -------
    PlaceMap
    """
    omega = 2.0 * np.pi * tangents.frequency
    factors = np.array([np.ones(omega.size), -(omega**-2.0), -1j / omega], dtype=complex)
    apart = np.linalg.norm(tangents.places[:, None] - tangents.places, axis=2)
    spacing = float(np.median(np.sort(apart, axis=1)[:, 1]))
    alike = np.exp(-0.5 * (apart / spacing) ** 2) + 1e-6 * np.eye(len(apart))
    value, sigma, resolution, nats = [], [], [], []
    for factor in factors:
        matrix, gradient = tangents.equations(factor[None])
        gain, variance = _best_evidence(matrix, gradient, alike)
        root = np.sqrt(variance) * np.linalg.cholesky(alike)
        posterior = root @ np.linalg.solve(np.eye(len(root)) + root.T @ matrix @ root, root.T)
        value.append(posterior @ gradient)
        sigma.append(np.sqrt(np.diag(posterior)))
        kernel = posterior @ matrix
        resolution.append(spacing / np.sqrt(float(np.clip(np.diag(kernel).max(), 1e-3, 1.0))))
        nats.append(gain)
    return PlaceMap(tangents.places, np.array(value), np.array(sigma), np.array(resolution), np.array(nats))


def _best_evidence(matrix: Real, gradient: Real, alike: Real | None = None) -> tuple[float, float]:
    """Largest log evidence of a Gaussian prior times `alike` over its variance, and that variance."""
    root = np.eye(len(matrix)) if alike is None else np.linalg.cholesky(alike)
    power, directions = np.linalg.eigh(root.T @ matrix @ root)
    pull = directions.T @ (root.T @ gradient)
    power = np.maximum(power, 0.0)
    middle = 1.0 / max(float(power.mean()), 1e-300)
    best = (0.0, middle * float(SCALES[0]))
    for variance in middle * SCALES**2:
        inner = 1.0 + variance * power
        gain = 0.5 * float((variance * pull**2 / inner).sum() - np.log(inner).sum())
        best = max(best, (gain, float(variance)))
    return best


def _flat(white: NDArray[np.complex128]) -> Real:
    """Real and imaginary parts of columns (C, K, n) in one row each, (C, 2Kn)."""
    rows = white.reshape(len(white), -1)
    return np.concatenate([rows.real, rows.imag], axis=1)
