"""``gap.h5``: what the figures of a comparison need, and its gap.json."""

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from analysis.checked_fields import check_ascending, check_shapes
from analysis.estimates import FittedLaws
from analysis.gap.data.groups import TemperatureGroups
from analysis.gap.fitting.residual_map import ResidualMap, Signature
from analysis.gap.report import GapReport
from app.files.atomic import atomic_hdf5
from app.files.hdf5_file import read_value, result_file, write_value
from app.files.parsed_text import parse_json
from app.files.provenance import stamp


@dataclass(frozen=True)
class GapMap:
    """Residual of a twin, see `analysis.gap.fitting.residual_map.ResidualMap`.

    Attributes
    ----------
    edges : (B + 1,) ndarray
        Hz.
    temperature, level : (T,) ndarray
        Degrees Celsius, V.
    direction, channels : tuple of str
    sigma, excess : (T, K, B) ndarray
        rms residual in units of noise, and chi2 beyond the noise's.
    """

    edges: NDArray[np.float64]
    temperature: NDArray[np.float64]
    level: NDArray[np.float64]
    direction: tuple[str, ...]
    channels: tuple[str, ...]
    sigma: NDArray[np.float64]
    excess: NDArray[np.float64]

    def __post_init__(self) -> None:
        by_sweep = dict.fromkeys(("temperature", "level", "direction"), "T")
        check_shapes(self, channels="K", edges="B+1", sigma="T K B", excess="T K B", **by_sweep)
        check_ascending(self, "edges")

    def by_temperature(self, channel: int) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Root mean square over the sweeps at each temperature: (G,) degrees Celsius and (G, B) sigma."""
        return self.grouped(self.sigma[:, channel])

    def grouped(self, sigma: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Do the same with any residual (T, B) of these sweeps."""
        groups = TemperatureGroups.of(self.temperature)
        return groups.reference, np.sqrt(groups.total(sigma**2) / groups.size[:, None])

    @classmethod
    def of(cls, found: ResidualMap) -> "GapMap":
        """Keep the arrays of a residual map."""
        return cls(
            found.edges,
            found.temperature,
            found.level,
            found.direction,
            found.channels,
            found.sigma,
            found.excess,
        )


@dataclass(frozen=True)
class GapFigures:
    """Arrays behind the figures of a comparison.

    Attributes
    ----------
    before, after : GapMap
        Without effects, and with those found.
    laws_before, laws_after : FittedLaws
        The latter those of the twin that was issued.
    """

    before: GapMap
    after: GapMap
    laws_before: FittedLaws
    laws_after: FittedLaws

    @classmethod
    def of(cls, report: GapReport, issued: FittedLaws) -> "GapFigures":
        """Collect them."""
        return cls(GapMap.of(report.before), GapMap.of(report.after), report.laws_before, issued)


@dataclass(frozen=True)
class Signatures:
    """What each candidate alone would leave, see `analysis.gap.fitting.residual_map.Signature`.

    Attributes
    ----------
    effects : tuple of str
    sigma : (S, T, K, B) ndarray
        rms residual in units of noise, in the cells of `GapFigures.before`.
    fitted : (S,) bool ndarray
        Fitted in full; else to first order.
    """

    effects: tuple[str, ...]
    sigma: NDArray[np.float64]
    fitted: NDArray[np.bool_]

    def __post_init__(self) -> None:
        check_shapes(self, effects="S", sigma="S T K B", fitted="S")


def save_gap(
    target: Path,
    figures: GapFigures,
    signatures: Sequence[Signature],
    record: Mapping[str, Any],
    made_from: Mapping[str, Any],
) -> None:
    """Write the arrays and the record of gap.json, whole or not at all.

    Parameters
    ----------
    signatures : sequence of Signature
        Of effects alone; may be empty.
    record : mapping
        Of `gap_record`.
    made_from : mapping
        Provenance.
    """
    with atomic_hdf5(target) as file:
        stamp(file, made_from)
        write_value(file.create_group("figures"), figures)
        if signatures:
            held = Signatures(
                effects=tuple(s.effect for s in signatures),
                sigma=np.array([s.sigma for s in signatures]),
                fitted=np.array([s.fitted for s in signatures]),
            )
            write_value(file.create_group("alone"), held)
        file.create_dataset("record", data=json.dumps(record, allow_nan=False))


def load_gap(path: Path) -> tuple[GapFigures, dict[str, Any]]:
    """Read back what `save_gap` wrote; ResultFileError where the file is something else."""
    with result_file(path, "gap") as file:
        record: dict[str, Any] = parse_json(file["record"].asstr()[()])
        return read_value(file["figures"], GapFigures), record


def load_gap_laws(path: Path) -> tuple[FittedLaws, FittedLaws]:
    """Read the laws before and after alone, of `GapFigures`; ResultFileError where the file is something else."""
    with result_file(path, "gap") as file:
        before, after = (read_value(file["figures"][name], FittedLaws) for name in ("laws_before", "laws_after"))
        return before, after


def load_signatures(path: Path) -> Signatures | None:
    """Read the signatures; None where there was no gap, and in files of versions that kept none."""
    with result_file(path, "gap") as file:
        return read_value(file["alone"], Signatures) if "alone" in file else None
