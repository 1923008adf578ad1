"""What gap.json, laws.h5 and ``--json`` share: pairing of modes, a record a sweep; declared quantities."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from analysis.estimates import DeclaredQuantity
from analysis.pairing.assignment import ModeList, ModePairs, PairedSweeps, Pairing
from analysis.pairing.points import PointComparison


def pairing_record(pairing: Pairing | None) -> dict[str, Any] | None:
    """Return what JSON holds of a pairing; None where there is none."""
    if pairing is None:
        return None
    return {
        "fit": pairing.fits,
        "said": pairing.said,
        "likely_reason": pairing.likely,
        "measured_modes": pairing.before.source,
        "shown": pairing.before.worst,
        "sweeps": _sweeps(pairing.before),
        "sweeps_after": None if pairing.after is None else _sweeps(pairing.after),
        "points": _points(pairing.before.points),
        "points_after": None if pairing.after is None else _points(pairing.after.points),
    }


def checked_pairing(record: Any) -> dict[str, Any]:
    """Return a record that was read, if it is one; ValueError otherwise."""
    if not isinstance(record, dict) or not isinstance(record.get("sweeps"), list):
        raise ValueError("a pairing is a table with a list of sweeps")
    wanted = {"fit", "said", "likely_reason", "measured_modes", "shown", "sweeps_after"}
    if lacking := sorted(wanted - set(record)):
        raise ValueError(f"a pairing lacks {', '.join(lacking)}")
    if not isinstance(record["shown"], int) or not 0 <= record["shown"] < len(record["sweeps"]):
        raise ValueError(f"a pairing shows sweep {record['shown']}; {len(record['sweeps'])} are there")
    return record


def shown(record: Mapping[str, Any], sweeps: str = "sweeps") -> Mapping[str, Any]:
    """Return the sweep of a record that is shown first: the worst of those that are no fit, or of all."""
    found: Mapping[str, Any] = record[sweeps][record["shown"]]
    return found


def _sweeps(paired: PairedSweeps) -> list[dict[str, Any]]:
    return [
        _sweep(one, float(misfit), bool(failing))
        for one, misfit, failing in zip(paired.sweeps, paired.misfit, paired.failing, strict=True)
    ]


def _sweep(pairs: ModePairs, misfit: float, failing: bool) -> dict[str, Any]:
    matched, strong = pairs.count
    return {
        "temperature_c": pairs.temperature,
        "band_hz": list(pairs.band),
        "misfit": misfit,
        "fit": not failing,
        "strong": strong,
        "matched": matched,
        "pairs": _pairs(pairs),
        "measured_only": _alone(pairs.measured, pairs.unpaired_measured),
        "computed_only": _alone(pairs.computed, pairs.missing),
        "mac": _mac(pairs),
    }


def _mac(pairs: ModePairs) -> dict[str, Any] | None:
    """Return the MAC of all measured modes (rows) and computed ones (columns), with four digits."""
    value = pairs.mac_of_all
    if value is None:
        return None
    return {
        "measured_hz": pairs.measured.frequency.tolist(),
        "computed_hz": pairs.computed.frequency.tolist(),
        "channels": len(pairs.measured.residues),
        "value": np.round(value, 4).tolist(),
    }


def _points(points: PointComparison | None) -> dict[str, Any] | None:
    """Return the comparison of points; shapes with four digits."""
    if points is None:
        return None
    return {
        "names": list(points.names),
        "comac": [round(float(one), 4) for one in points.comac],
        "wrong": np.flatnonzero(points.wrong).tolist(),
        "said": list(points.said),
        "frequency_hz": points.frequency.tolist(),
        "measured": np.round(points.measured.T, 4).tolist(),
        "computed": np.round(points.computed.T, 4).tolist(),
    }


def _pairs(pairs: ModePairs) -> list[dict[str, Any]]:
    measured, computed = pairs.measured, pairs.computed
    mac = pairs.mac
    rows = []
    for n, (i, j) in enumerate(zip(pairs.measured_index.tolist(), pairs.computed_index.tolist(), strict=True)):
        difference, sigma = float(pairs.difference[n]), float(pairs.sigma[n])
        rows.append(
            {
                "measured_hz": float(measured.frequency[i]),
                "computed_hz": float(computed.frequency[j]),
                "difference": difference,
                "window": float(pairs.window[n]),
                "difference_sigma": difference / sigma if sigma > 0.0 else None,
                "measured_damping_ratio": float(measured.damping_ratio[i]),
                "computed_damping_ratio": float(computed.damping_ratio[j]),
                "damping": float(pairs.damping[n]),
                "mac": None if mac is None else float(mac[n]),
                "residues": float(pairs.agreement[n]),
                "strong": bool(measured.strong[i]),
                "matched": bool(pairs.matched[n]),
            }
        )
    return rows


def _alone(modes: ModeList, rows: NDArray[np.int_]) -> list[dict[str, Any]]:
    return [
        {
            "frequency_hz": float(modes.frequency[j]),
            "damping_ratio": float(modes.damping_ratio[j]),
            "strong": bool(modes.strong[j]),
        }
        for j in rows.tolist()
    ]


def declared_record(one: DeclaredQuantity) -> dict[str, Any]:
    """Return a declared quantity as JSON holds it: true less declared, in its unit, or a share of the declared."""
    return {
        "name": one.name,
        "parameter": one.parameter,
        "unit": one.unit,
        "tolerance": one.tolerance,
        "value": one.value,
        "sigma": one.sigma,
        "beyond_tolerance": one.beyond,
    }
