"""Laws of the pieces of a fleet beside one another: scatter, outliers, pieces that are known at few temperatures.

What a declaration leaves open (thickness, mass, positions) is another for each piece, and its laws contain it: it
is counted as scatter between pieces, not as an error. Only the noise of the estimates is taken off.

Which panel's filters can be used for which: the contrast that each panel's filters have on each other panel.

The filters designed with one piece's laws are played, at the temperatures they were designed for, on the twin of
the panel with another piece's laws; what is lost against that piece's own filters is what exchanging them costs.
"""

from collections.abc import Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from analysis.arrays import Complex, Real
from analysis.checked_fields import check_shapes
from analysis.fleet import (
    FEWEST_PIECES,
    Outlier,
    PredictedLaw,
    Scatter,
    estimate_scatter,
    outliers,
    predict_piece,
)
from analysis.material import Material, MaterialLaws, MaterialSigma
from analysis.progress import Progress
from analysis.updated import Updated
from analysis.updating.laws import fit_laws
from app.files.bad_file import ResultFileError
from app.files.results.best_twin import best_twin, gap_record_of

if TYPE_CHECKING:
    from analysis.focusing.energy import EnergyForms

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


FILTERS = "filters.h5"
USABLE_LOSS = 0.02
"""Mean contrast that other filters may lose, as `flexura compensate` allows its networks."""
MOST_TEMPERATURES = 3
"""Lowest, middle, highest that two panels' filters have in common."""


@dataclass(frozen=True)
class Exchange:
    """Loss of contrast by exchanged filters.

    Attributes
    ----------
    names : tuple of str
        Of N panels.
    loss : (N, N) ndarray
        Mean over band and temperatures of what the filters of the panel in the row lose on that in the column;
        NaN where the two have no design in common.
    notes : tuple of str
    """

    names: tuple[str, ...]
    loss: Real
    notes: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        check_shapes(self, loss="N N")

    def users_of(self, row: int) -> tuple[str, ...]:
        """Names of the other panels on which a panel's filters are good enough."""
        others = zip(self.names, self.loss[row], strict=True)
        return tuple(name for place, (name, lost) in enumerate(others) if place != row and lost <= USABLE_LOSS)


def exchanged(runs: Mapping[str, Path], executor: Executor, report: Progress) -> Exchange | None:
    """Compare the filters of all runs that have some; None for fewer than two.

    Parameters
    ----------
    runs : mapping of str to Path
        Run folders by name.
    executor : Executor
        Takes a task a panel.
    report : callable
        Called with the stage and the share done.
    """
    known = {name: run for name, run in runs.items() if (run / FILTERS).is_file()}
    if len(known) < 2:
        return None
    report("exchanged filters", 0.0)
    tasks = {name: executor.submit(losses_on, run, list(known.values())) for name, run in known.items()}
    columns, notes = [], []
    for count, (name, task) in enumerate(tasks.items(), start=1):
        column, said = task.result()
        columns.append(column)
        notes += [f"{name}: {said}"] if said else []
        report("exchanged filters", count / len(known))
    return Exchange(tuple(known), np.stack(columns, axis=1), tuple(notes))


def losses_on(run: Path, others: list[Path]) -> tuple[Real, str]:
    """Return what the filters of other runs lose on the panel of one, (N,), and why it cannot be said."""
    from analysis.focusing.panel_model import responses
    from analysis.focusing.performance import aim
    from app.chain.models_ahead import silent
    from app.files.results.panel_files import load_focusing
    from app.stages.panel.laws import laws_for
    from app.twins.panel_twin import panel_twin

    lost = np.full(len(others), np.nan)
    try:
        panel, own, _ = load_focusing(run / FILTERS)
        laws = laws_for(run, None, "run").laws
        model = panel_twin(panel, laws, silent)
    except ResultFileError as error:
        return lost, str(error)
    lines, asked = panel.filters.frequency, model.space.asked(panel.target.displacement)
    band = panel.filters.in_band(lines)
    played: dict[float, tuple[EnergyForms, Complex]] = {}
    for row, other in enumerate(others):
        try:
            theirs = load_focusing(other / FILTERS)[1]
        except ResultFileError:
            continue
        same = (
            theirs.bank.sample_rate == own.bank.sample_rate and theirs.bank.taps.shape[1] == own.bank.taps.shape[1]
        )
        places = np.intersect1d(own.temperature, theirs.temperature)
        if not same or not places.size:
            continue
        places = places[
            np.unique(np.linspace(0, places.size - 1, min(places.size, MOST_TEMPERATURES)).astype(int))
        ]
        differences = []
        for here in places:
            if here not in played:
                ((constants, amplitude),) = responses(model, laws, np.array([here]), lines)
                forms = model.forms(*constants, lines, panel.target.displacement).at(slice(None), band)
                played[here] = (forms, amplitude[:, band])
            forms, amplitude = played[here]
            reached = [
                aim(
                    model.space,
                    forms,
                    amplitude,
                    one.bank.response(lines[band])[int(np.flatnonzero(one.temperature == here)[0])],
                    asked,
                )[0].mean()
                for one in (own, theirs)
            ]
            differences.append(reached[0] - reached[1])
        lost[row] = float(np.mean(differences))
    return lost, ""
