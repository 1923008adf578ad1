"""The best twin of a run: its laws, the effects that are on, and where both come from.

`flexura update` fits the plain twin (laws.h5). Where `flexura gap` then names what that twin lacks, the laws under
these effects (laws-corrected.h5) take its place in everything that follows: the plain ones have absorbed a part of
what was missing. This is the only place that decides between the two.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from analysis.estimates import DeclaredQuantity, Estimate, FittedLaws
from analysis.material import MaterialLaws
from analysis.updated import Updated
from app.files.bad_file import ResultFileError
from app.files.hdf5_file import result_file
from app.files.parsed_text import parse_json
from app.files.provenance import read_stamp
from app.files.results.laws_file import TwinFrf, effects_in_laws, laws_if_any, load_laws, load_updated
from app.files.results.run_folder import run_file

PLAIN, CORRECTED = "laws.h5", "laws-corrected.h5"
CLAIMED = ("explained", "partly_explained")
"""Verdicts that put the effects named into the twin."""
NOT_OF_THE_CAMPAIGN = ("twin ", "effect ")
"""Beginnings of the names of inputs that are no recordings: a twin file, a user's own effects."""
TOLD = ("verdict", "effects", "starting_effects", "provenance")
"""Keys that are alike in gap.json and gap.h5 of one comparison."""
BEFORE, BY_UPDATE = "before", "by update, before the gap was looked for"
"""How laws are called that corrected ones are set against: those of the comparison itself, and those of update."""
SAME_MISFIT = 1e-3
"""Relative difference up to which the misfits of two fits of the plain twin are those of one: other recordings,
mains or versions change them by more, another machine's rounding by less."""


@dataclass(frozen=True)
class TwinOfRun:
    """Estimates of one fit, each read when it is first asked for; ResultFileError where that cannot be.

    Attributes
    ----------
    path : Path
        File of the laws.
    """

    path: Path

    @cached_property
    def laws(self) -> MaterialLaws | None:
        """Laws over temperature; None for fewer than three temperatures."""
        return laws_if_any(self.path)

    @property
    def needed_laws(self) -> MaterialLaws:
        """Laws over temperature; ResultFileError, which says why, where there are none."""
        return self.laws or load_laws(self.path)

    @property
    def updated(self) -> Updated:
        """Estimates per sweep."""
        return self._estimates[0]

    @property
    def answers(self) -> TwinFrf:
        """FRFs of the twin."""
        return self._estimates[1]

    @cached_property
    def _estimates(self) -> tuple[Updated, TwinFrf]:
        return load_updated(self.path)

    @property
    def declared(self) -> tuple[DeclaredQuantity, ...]:
        """Declared quantities, estimated together with the laws."""
        return self.updated.declared


@dataclass(frozen=True)
class BestTwin:
    """The twin of a run that everything after the fit uses.

    Attributes
    ----------
    twin : TwinOfRun
    effects : mapping of str to tuple of Estimate
        Those that are on.
    titles : mapping of str to str
        Their names for people.
    uncorrected : TwinOfRun or None
        The plain twin, where `twin` is another one.
    ignored : tuple of str
        Why results of `flexura gap` that lie in the run are not used, a sentence each.
    compared : Path or None
        gap.h5 of the comparison that found all the effects; None where it is not there, or began with some.
    """

    twin: TwinOfRun
    effects: Mapping[str, tuple[Estimate, ...]] = field(default_factory=dict)
    titles: Mapping[str, str] = field(default_factory=dict)
    uncorrected: TwinOfRun | None = None
    ignored: tuple[str, ...] = ()
    compared: Path | None = None

    @cached_property
    def nodes(self) -> tuple[FittedLaws, FittedLaws] | None:
        """E, nu and eta of the comparison's twin without the effects, and with; None where these are not known."""
        if self.compared is None:
            return None
        from app.files.results.gap_file import load_gap_laws

        return load_gap_laws(self.compared)

    @cached_property
    def before(self) -> MaterialLaws | None:
        """Laws that the corrected ones are set against; None where there are none, and where nothing is corrected.

        Through `nodes`, else those of flexura update. The comparison weighs the data otherwise than update and
        moves what is declared; without any effect this alone changed η by 2 % in a campaign where the effect
        changed it by 0.4 % the other way. They are values to compare with: their bands are those of the corrected
        ones, so that both are smoothed alike (by their own bands, which the effect widens, η was 0.4 % off its
        nodes). ResultFileError where they cannot be read.
        """
        if self.uncorrected is None:
            return None
        if self.nodes is None:
            return self.uncorrected.laws
        if self.twin.laws is None:
            return None
        from analysis.updating.corrected_twin import smooth_laws

        before, after = self.nodes
        try:
            alike = replace(before, sigma=after.sigma, common=after.common)
            return smooth_laws(alike, self.twin.laws.temperature_range)
        except ValueError as error:
            raise ResultFileError(
                f"{self.compared}: the laws before cannot be used: {error}; make it again: flexura gap"
            ) from error

    @property
    def before_said(self) -> str:
        """What `before` is, for headings and legends."""
        return BY_UPDATE if self.compared is None else BEFORE

    @property
    def names(self) -> str:
        """Names of the effects for people, in one line."""
        return ", ".join(self.titles.get(name) or name.replace("_", " ") for name in self.effects)

    @property
    def said(self) -> str:
        """Where the laws come from, in one line; empty where the twin is the plain one."""
        if not self.effects:
            return ""
        by = "flexura update --twin" if self.uncorrected is None else "flexura gap"
        return f"laws and twin are corrected ({self.names}; {by}): {self.twin.path.name}"

    @property
    def record(self) -> dict[str, Any]:
        """Which file holds it, its effects, and what is not used, for JSON."""
        return {"laws": self.twin.path.name, "effects": list(self.effects), "ignored": list(self.ignored)}

    @property
    def notes(self) -> list[str]:
        """`said` and `ignored`, as far as there is something to say."""
        return [*filter(None, [self.said]), *self.ignored]


def best_twin(run: Path, verb: str) -> BestTwin:
    """Read the best twin of a run folder.

    Parameters
    ----------
    verb : str
        Of the command that asks, for messages.

    Raises
    ------
    ResultFileError
        Where there is no readable laws.h5.
    """
    path = run_file(run, PLAIN, verb)
    plain = TwinOfRun(path)
    on = effects_in_laws(path)
    if on:
        held = {
            name: tuple(Estimate(parameter, float(value), 0.0, "") for parameter, value in values.items())
            for name, values in on.items()
        }
        return BestTwin(plain, held)
    try:
        record = gap_record_of(run)
        effects = {} if record is None else _claimed(record)
        if record is None and (run / CORRECTED).is_file():
            raise _NotUsedError("there is no gap.json that says which effects it holds")
        if record is not None and not effects and (run / CORRECTED).is_file():
            raise _NotUsedError("gap.json names no effect")
        if record is None or not effects:
            return BestTwin(plain)
        corrected = _corrected(run, plain, record)
    except _NotUsedError as reason:
        what = f"{CORRECTED} is not used" if (run / CORRECTED).is_file() else "the laws are uncorrected"
        return BestTwin(plain, ignored=(f"{what}: {reason}; compare again: flexura gap",))
    except ResultFileError as error:
        return BestTwin(plain, ignored=(f"the laws of {PLAIN} are uncorrected: {error}",))
    titles = {name: record.get("titles", {}).get(name, "") for name in effects}
    stored = run / "gap.h5"
    compared = stored if stored.is_file() and not record["starting_effects"] else None
    return BestTwin(corrected, effects, titles, plain, compared=compared)


class _NotUsedError(Exception):
    """Why corrected laws are not used."""


def gap_record_of(run: Path) -> dict[str, Any] | None:
    """Return the record of a run's comparison, None without one.

    Raises
    ------
    ResultFileError
        Where gap.json or gap.h5 cannot be read, and where they are of different comparisons.
    """
    held, beside = run / "gap.h5", run / "gap.json"
    record = _checked(held, load_gap_record(held)) if held.is_file() else None
    if not beside.is_file():
        return record
    try:
        read = _checked(beside, parse_json(beside.read_text(encoding="utf-8")))
    except ResultFileError:
        raise
    except (OSError, ValueError) as error:
        raise ResultFileError(f"{beside}: cannot be read: {error}; make it again: flexura gap") from error
    if record is not None and any(record[key] != read[key] for key in TOLD):
        raise ResultFileError(
            f"{beside}: of another comparison than gap.h5 beside it; make both again: flexura gap"
        )
    return read


def load_gap_record(path: Path) -> dict[str, Any]:
    """Read the record of gap.h5 alone; ResultFileError where the file is something else."""
    with result_file(path, "gap") as file:
        record: dict[str, Any] = parse_json(file["record"].asstr()[()])
        return record


def _checked(path: Path, record: Any) -> dict[str, Any]:
    """Return a record that holds what is asked of it here; ResultFileError for anything else."""
    try:
        _claimed(record)
        dict(record["provenance"]["inputs"])
        found: dict[str, Any] = record
    except (KeyError, TypeError, AttributeError, ValueError) as error:
        raise ResultFileError(
            f"{path}: no record of a comparison ({error}); make it again: flexura gap"
        ) from error
    return found


def _claimed(record: Mapping[str, Any]) -> dict[str, tuple[Estimate, ...]]:
    """Effects that a comparison put into its twin."""
    found = dict(record["starting_effects"])
    if record["verdict"] in CLAIMED:
        found |= {effect["name"]: effect["parameters"] for effect in record["effects"]}
    return {
        name: tuple(Estimate(key, one["value"], one["sigma"], one["unit"]) for key, one in values.items())
        for name, values in found.items()
    }


def _corrected(run: Path, plain: TwinOfRun, record: Mapping[str, Any]) -> TwinOfRun:
    """Read corrected laws; _NotUsedError unless they belong to the record and to the plain twin beside them."""
    path = run / CORRECTED
    if not path.is_file():
        raise _NotUsedError(f"gap.json names {', '.join(_claimed(record))}, but {CORRECTED} is not here")
    ours, theirs, told = _inputs(plain.path), _inputs(path), record["provenance"]["inputs"]
    if theirs != told:
        raise _NotUsedError("gap.json is of another comparison")
    if recordings(ours) != recordings(theirs):
        raise _NotUsedError(f"it was found on other recordings, or another declaration, than {PLAIN}")
    found = TwinOfRun(path)
    before, now = found.updated.misfit_start, plain.updated.misfit
    if before.shape != now.shape or not np.allclose(before, now, rtol=SAME_MISFIT):
        raise _NotUsedError(f"{PLAIN} was made again since, with other results")
    return found


def _inputs(path: Path) -> dict[str, str]:
    with result_file(path, "gap" if path.name == CORRECTED else "update") as file:
        return dict(read_stamp(file)["inputs"])


def recordings(inputs: Mapping[str, str]) -> dict[str, str]:
    """Return those inputs of a result that are files of its campaign."""
    return {name: digest for name, digest in inputs.items() if not name.startswith(NOT_OF_THE_CAMPAIGN)}
