"""Laws of the pieces of a fleet beside one another: scatter, outliers, pieces that are known at few temperatures.

What a declaration leaves open (thickness, mass, positions) is another for each piece, and its laws contain it: it
is counted as scatter between pieces, not as an error. Only the noise of the estimates is taken off.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from analysis.arrays import Real
from analysis.fleet.scatter import (
    FEWEST_PIECES,
    Outlier,
    PredictedLaw,
    Scatter,
    estimate_scatter,
    outliers,
    predict_piece,
)
from analysis.material import Material, MaterialLaws, MaterialSigma
from analysis.updated import Updated
from analysis.updating.laws import fit_laws
from app.files.bad_file import ResultFileError
from app.files.results.best_twin import best_twin, gap_record_of

CONSTANTS = ("youngs_modulus", "poisson_ratio", "loss_factor")
"""In the order of a law's rows; the first and the last by their logarithm."""
MISFIT = "misfit"
COMPARED_SPACING = 10.0
"""K between temperatures at which laws are compared: nearer ones would count one bend of a smooth law twice."""


@dataclass(frozen=True)
class Piece:
    """What is known of one piece.

    Attributes
    ----------
    name : str
    laws : MaterialLaws or None
        By the noise of its estimates alone; None for fewer than three temperatures.
    updated : Updated
        Of the best twin.
    misfit : float
        Median over sweeps of the plain twin's misfit, over the noise.
    lacks : str
        What its twin lacks, as ``flexura gap`` says; empty where it lacks nothing, or was not compared.
    """

    name: str
    laws: MaterialLaws | None
    updated: Updated
    misfit: float
    lacks: str


@dataclass(frozen=True)
class PredictedPiece:
    """Laws of a piece that was measured at one or two temperatures.

    Attributes
    ----------
    name : str
    measured_at : float
        °C.
    temperature : (K,) ndarray
        °C.
    laws : mapping of str to PredictedLaw
        By constant, on its scale.
    """

    name: str
    measured_at: float
    temperature: Real
    laws: Mapping[str, PredictedLaw]


@dataclass(frozen=True)
class FleetLaws:
    """A fleet's laws.

    Attributes
    ----------
    pieces : tuple of Piece
    temperature : (K,) ndarray
        At which they are compared, °C; empty for fewer than three pieces with laws, or without a common range.
    values : (3, P, K) ndarray
        Log E, nu and log eta of the P pieces with laws.
    scatter : mapping of str to Scatter
        By constant, without the outliers; empty where nothing is compared.
    outliers : mapping of str to Outlier
        By name of the piece.
    predicted : tuple of PredictedPiece
    unread : mapping of str to str
        Pieces whose results cannot be used, and why.
    """

    pieces: tuple[Piece, ...]
    temperature: Real
    values: Real
    scatter: Mapping[str, Scatter]
    outliers: Mapping[str, Outlier]
    predicted: tuple[PredictedPiece, ...]
    unread: Mapping[str, str]

    @property
    def with_laws(self) -> tuple[Piece, ...]:
        """Pieces that have laws."""
        return tuple(one for one in self.pieces if one.laws is not None)


def laws_beside(runs: Mapping[str, Path]) -> FleetLaws:
    """Compare the laws in some run folders, by name of the piece."""
    pieces, unread = list[Piece](), dict[str, str]()
    for name, run in runs.items():
        try:
            pieces.append(_piece(name, run))
        except ResultFileError as error:
            unread[name] = str(error)
    known = [one for one in pieces if one.laws is not None]
    nothing = FleetLaws(tuple(pieces), np.empty(0), np.empty((3, 0, 0)), {}, {}, (), unread)
    places = common_temperatures([one.laws for one in known if one.laws is not None])
    if len(known) < FEWEST_PIECES or not places.size:
        return nothing
    values, covariance = _values(known, places)
    quantities = {name: (values[row], covariance[row]) for row, name in enumerate(CONSTANTS)}
    misfit = np.log([[one.misfit] for one in known])
    off = outliers({**quantities, MISFIT: (misfit, np.zeros((len(known), 1, 1)))}, one_sided=(MISFIT,))
    inside = [place for place in range(len(known)) if place not in {one.piece for one in off}]
    scatter = {
        name: estimate_scatter(values[row][inside], covariance[row][inside]) for row, name in enumerate(CONSTANTS)
    }
    fleet = [known[place] for place in inside]
    new = [_predicted(one, fleet, places) for one in pieces if one.laws is None]
    return FleetLaws(
        tuple(pieces),
        places,
        values,
        scatter,
        {known[one.piece].name: one for one in off},
        tuple(one for one in new if one is not None),
        unread,
    )


def common_temperatures(laws: Sequence[MaterialLaws]) -> Real:
    """Temperatures (K,), °C, evenly over the range that all laws have in common; empty where that is below 1 K."""
    if not laws:
        return np.empty(0)
    low = max(one.temperature_range[0] for one in laws)
    high = min(one.temperature_range[1] for one in laws)
    if high - low < 1.0:
        return np.empty(0)
    return np.linspace(low, high, max(round((high - low) / COMPARED_SPACING), 2) + 1)


def _piece(name: str, run: Path) -> Piece:
    """Read one piece; ResultFileError where it has no readable estimates."""
    best = best_twin(run, "run")
    updated, plain = best.twin.updated, (best.uncorrected or best.twin).updated
    there, laws = updated.settled, None
    if best.twin.laws is not None:
        settled = Material(*(row[there] for row in vars(updated.material).values()))
        own = MaterialSigma(*(row[there] for row in vars(updated.own_sigma).values()))
        span = best.twin.laws.temperature_range
        laws = fit_laws(updated.temperature[there], settled, own, temperature_range=span)
    misfit = float(np.median(plain.misfit / plain.noise_floor))
    return Piece(name, laws, updated, misfit, _lacks(run))


def _lacks(run: Path) -> str:
    record = gap_record_of(run)
    if record is None or record["verdict"] == "none":
        return ""
    named = []
    for effect in record["effects"]:
        title = record.get("titles", {}).get(effect["name"]) or effect["name"].replace("_", " ")
        values = ", ".join(
            f"{key.replace('_', ' ')} {one['value']:.3g} ± {one['sigma']:.1g} {one['unit']}".rstrip()
            for key, one in effect["parameters"].items()
        )
        named.append(f"{title} ({values})")
    verdict = {"explained": "", "partly_explained": ", and something unknown"}.get(record["verdict"])
    return "something unknown" if verdict is None else "; ".join(named) + verdict


def _values(pieces: Sequence[Piece], places: Real) -> tuple[Real, Real]:
    """Return log E, nu and log eta (3, P, K) at temperatures (K,), and their covariances (3, P, K, K)."""
    found = [one.laws.scaled(places) for one in pieces if one.laws is not None]
    return np.stack([one[0] for one in found], axis=1), np.stack([one[1] for one in found], axis=1)


def _predicted(piece: Piece, fleet: Sequence[Piece], places: Real) -> PredictedPiece | None:
    """Predict a piece from its sharpest settled estimate within the fleet's range; None where there is none."""
    updated = piece.updated
    inside = updated.settled & (updated.temperature >= places[0] - 0.5) & (updated.temperature <= places[-1] + 0.5)
    if not inside.any():
        return None
    share = np.where(inside, updated.own_sigma.youngs_modulus / updated.material.youngs_modulus, np.inf)
    row = int(np.argmin(share))
    at = float(np.clip(updated.temperature[row], places[0], places[-1]))
    nearest = int(np.argmin(np.abs(places - at)))
    grid = places.copy()
    grid[nearest] = at
    values, covariance = _values(fleet, grid)
    e, nu, eta = (getattr(updated.material, name)[row] for name in CONSTANTS)
    own = [getattr(updated.own_sigma, name)[row] for name in CONSTANTS]
    measured = ((np.log(e), own[0] / e), (nu, own[1]), (np.log(eta), own[2] / eta))
    laws = {
        name: predict_piece(estimate_scatter(values[k], covariance[k]), nearest, float(mean), float(sigma))
        for k, (name, (mean, sigma)) in enumerate(zip(CONSTANTS, measured, strict=True))
    }
    return PredictedPiece(piece.name, float(updated.temperature[row]), grid, laws)
