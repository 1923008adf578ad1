"""``fleet.json``: what a fleet is made of, how far its pieces differ, which do not belong to the others."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from analysis.arrays import Real
from analysis.fleet.scatter import predict_piece
from app.files.provenance import provenance
from app.files.results.run_record import hashed
from app.fleet.exchange import FILTERS, Exchange
from app.fleet.fleet_run import RunMember
from app.fleet.laws_beside import MISFIT, FleetLaws

SCHEMA = "flexura-fleet/1"
NAME = "fleet.json"
BAND_SHARE = 0.9
"""Share of further pieces that the band about the mean of the fleet is to hold."""
LINEAR = "poisson_ratio"
"""The constant whose law is compared as it is; of the others the logarithm is."""
TITLES = {"youngs_modulus": "E", "poisson_ratio": "ν", "loss_factor": "η"}


def fleet_record(
    members: Sequence[RunMember], laws: FleetLaws, exchange: Exchange | None, settings: Mapping[str, Any]
) -> dict[str, Any]:
    """Return what ``fleet.json`` holds.

    Parameters
    ----------
    settings : mapping
        Stages and options of the run.
    """
    files = ("laws.h5", "laws-corrected.h5", "gap.json", FILTERS)
    inputs = {f"{one.name}/{name}": digest for one in members for name, digest in hashed(one.run, files).items()}
    return {
        "schema": SCHEMA,
        "provenance": provenance(inputs, settings),
        "pieces": [
            {
                "name": one.name,
                "campaign": str(one.campaign),
                "run": str(one.run),
                "good": one.good,
                "said": one.said,
                "stages": {stage: state.state for stage, state in one.stages.items()},
                "unread": laws.unread.get(one.name, ""),
            }
            for one in members
        ],
        "temperature": laws.temperature.tolist(),
        "laws": {name: _constant(name, laws) for name in laws.scatter},
        "outliers": [
            {
                "name": name,
                "quantity": one.quantity,
                "deviation": one.deviation,
                "probability": one.probability,
                "said": said_of(name, laws),
            }
            for name, one in laws.outliers.items()
        ],
        "lacking": {one.name: one.lacks for one in laws.pieces if one.lacks},
        "predicted": [
            {
                "name": one.name,
                "measured_at": one.measured_at,
                "band": BAND_SHARE,
                "temperature": one.temperature.tolist(),
                **{
                    name: {key: _natural(name, getattr(law, key)) for key in ("value", "low", "high")}
                    for name, law in one.laws.items()
                },
            }
            for one in laws.predicted
        ],
        "exchange": None
        if exchange is None
        else {
            "names": list(exchange.names),
            "loss": [[None if np.isnan(x) else round(float(x), 5) for x in row] for row in exchange.loss],
            "usable_for": {name: list(exchange.users_of(row)) for row, name in enumerate(exchange.names)},
            "notes": list(exchange.notes),
        },
    }


def said_of(name: str, laws: FleetLaws) -> str:
    """Say why a piece does not belong to the others, and what that may be, in one sentence."""
    one = laws.outliers[name]
    lacks = next((piece.lacks for piece in laws.pieces if piece.name == name), "")
    if one.quantity == MISFIT:
        seen = f"its twin misses the measurement {np.exp(one.deviation):.1f} times as far as those of the others"
        return f"{seen}: {lacks or 'something is on it, or missing, that the others have not (flexura gap)'}"
    size = f"{one.deviation:+.3f}" if one.quantity == LINEAR else f"{100 * np.expm1(one.deviation):+.1f} %"
    seen = f"{TITLES[one.quantity]} is {size} from the others' mean"
    return f"{seen}: {lacks or 'of another batch?'}"


def summary_of(members: Sequence[RunMember], laws: FleetLaws) -> str:
    """Return the fleet in one line."""
    failed = sum(not one.good for one in members)
    said = [f"{len(members)} campaigns"]
    said += [f"{failed} with something amiss"] if failed else []
    if "youngs_modulus" in laws.scatter:
        said.append(f"E scatters by {100 * laws.scatter['youngs_modulus'].between:.2g} % between pieces")
    said += [f"not like the others: {', '.join(laws.outliers)}"] if laws.outliers else []
    return ", ".join(said)


def _constant(name: str, laws: FleetLaws) -> dict[str, Any]:
    scatter = laws.scatter[name]
    band = predict_piece(scatter, share=BAND_SHARE)
    return {
        "mean": _natural(name, scatter.mean),
        "band": {"share": BAND_SHARE, "low": _natural(name, band.low), "high": _natural(name, band.high)},
        "between": scatter.between,
        "within": scatter.within,
        "scale": "linear" if name == LINEAR else "logarithm",
        "pieces": scatter.pieces,
    }


def _natural(name: str, values: Real) -> list[float]:
    """Return values in the constant's own unit."""
    return (values if name == LINEAR else np.exp(values)).tolist()  # type: ignore[no-any-return]
