"""Twin files: a plate with its laws and effects, in TOML that people edit; whether one belongs to a plate.

What a twin is stands in the file; the matrices made from it stand in the cache, named by a hash of what decides
them. Each version of the format keeps its reader: old files load.
"""

import hashlib
import json
from collections.abc import Mapping
from pathlib import Path
from types import MappingProxyType
from typing import Annotated, Any, ClassVar, Literal, Self

from pydantic import Field, model_validator

from analysis.declaration.strict import Declared, Sparse
from analysis.declaration.tolerances import Tolerances
from analysis.declaration.transducers import Drive, Sensor
from analysis.effect_card import EffectCard
from analysis.experiment import (
    Acquisition,
    Attachment,
    Experiment,
    OvenDeclaration,
    Patch,
    Plate,
    Protocol,
    Temperature,
)
from app.files.allowed_values import nearest
from app.files.atomic import write_text
from app.files.campaign_error import CampaignFileError, Problem
from app.files.settings_toml import checked, read_table, toml_text

FORMAT = "flexura-twin/1"
COMMENT = """\
A twin of Flexura. SI units; temperatures in degrees Celsius; sigma is one standard deviation.
laws: what the plate is made of at its own temperature. effect: what the plain twin lacked.
departure: true less declared value of what is declared with a tolerance; laws and effects hold together with
it. Of an orthotropic sheet the laws are those of (Ex + Ey)/2, sqrt(nu_xy nu_yx) and sqrt(eta_x eta_y), and
departure holds logarithms of ratios."""


def inputs_digest(hashes: Mapping[str, str]) -> str:
    """SHA-256 over the files of a campaign: of their names and SHA-256."""
    return hashlib.sha256(json.dumps(sorted(hashes.items())).encode()).hexdigest()


Hash = Annotated[str, Field(pattern="^[0-9a-f]{64}$")]
Name = Annotated[str, Field(pattern="^[A-Za-z][A-Za-z0-9_]{0,63}$")]
Sigma = Annotated[float, Field(ge=0.0)]
Count = 100_000


class Estimated(Declared):
    """A number that was fitted."""

    value: float
    sigma: Sigma
    unit: Annotated[str, Field(max_length=32)]


class TwinEffect(Declared):
    """An effect that is on, with all its parameters."""

    name: Name
    parameter: Annotated[dict[str, Estimated], Field(min_length=1, max_length=32)]


class TwinDeparture(Declared):
    """What a fit found about one declared quantity: true less declared, or as a share of the declared."""

    quantity: Annotated[str, Field(min_length=1, max_length=80)]
    parameter: Name
    value: float
    sigma: Sigma
    tolerance: Annotated[float, Field(gt=0.0)]
    unit: Annotated[str, Field(max_length=32)]


class TwinLaws(Declared):
    """E, nu and eta at temperatures that ascend, and where laws through them hold."""

    temperature_range: tuple[Temperature, Temperature]
    temperature: Annotated[tuple[Temperature, ...], Field(min_length=1, max_length=Count)]
    youngs_modulus: Annotated[tuple[Annotated[float, Field(ge=1e6, le=1e12)], ...], Field(description="Pa")]
    sigma_youngs_modulus: Annotated[tuple[Sigma, ...], Field(description="Pa")]
    poisson_ratio: tuple[Annotated[float, Field(gt=-1.0, lt=1.0)], ...]
    sigma_poisson_ratio: tuple[Sigma, ...]
    loss_factor: tuple[Annotated[float, Field(gt=0.0, le=2.0)], ...]
    sigma_loss_factor: tuple[Sigma, ...]

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        for name in ("youngs_modulus", "poisson_ratio", "loss_factor"):
            for key in (name, f"sigma_{name}"):
                count = len(getattr(self, key))
                if count != len(self.temperature):
                    raise ValueError(f"{key} has {count} values for {len(self.temperature)} temperatures")
        for before, after in zip(self.temperature, self.temperature[1:], strict=False):
            if after <= before:
                raise ValueError(f"temperature must ascend: {after:g} follows {before:g}")
        return self


class Basis(Declared):
    """The matrices this twin was computed with."""

    operators: Hash
    error: Annotated[float, Field(ge=0.0, le=1.0, description="share of the peak")]


class TwinOrigin(Declared):
    """What the twin was made from."""

    flexura: str
    campaign: str
    inputs: Annotated[Hash, Field(description="SHA-256 over the campaign's files")]
    verdict: Literal["none", "explained", "partly_explained", "unknown"]
    based_on: Hash | None = None


class TwinFile(Sparse):
    """The whole file, version 1."""

    always: ClassVar[frozenset[str]] = frozenset({"format", "patch", "string", "cable", "effect"})

    format: Literal["flexura-twin/1"] = "flexura-twin/1"
    title: str
    plate: Plate
    patch: tuple[Patch, ...] = ()
    drive: tuple[Drive, ...] = ()
    sensor: tuple[Sensor, ...] = ()
    string: tuple[Attachment, ...] = ()
    cable: tuple[Attachment, ...] = ()
    acquisition: Acquisition
    protocol: Protocol
    oven: OvenDeclaration
    tolerances: Tolerances = Tolerances()
    gain: Annotated[Estimated, Field(description="of the amplifier")]
    further_gain: Annotated[tuple[Estimated, ...], Field(max_length=200, description="of other actuators")] = ()
    laws: TwinLaws
    effect: Annotated[tuple[TwinEffect, ...], Field(max_length=64)] = ()
    departure: Annotated[tuple[TwinDeparture, ...], Field(max_length=1000)] = ()
    basis: Basis
    origin: TwinOrigin

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        names = [effect.name for effect in self.effect]
        if len(set(names)) != len(names):
            raise ValueError(f"effects {names}: each may occur once")
        if self.plate.material is None or self.plate.material.orthotropy is None:
            for row, value in enumerate(self.laws.poisson_ratio):
                if not value < 0.5:
                    raise ValueError(f"laws.poisson_ratio[{row}] = {value:g}; allowed: below 0.5")
        if not self.gain.value > 0.0:
            raise ValueError(f"gain.value {self.gain.value:g} must be above 0")
        self.experiment()
        return self

    def experiment(self) -> Experiment:
        """Return the declaration of the plate this is a twin of."""
        return Experiment(
            title=self.title,
            plate=self.plate,
            patch=self.patch,
            drive=self.drive,
            sensor=self.sensor,
            string=self.string,
            cable=self.cable,
            acquisition=self.acquisition,
            protocol=self.protocol,
            oven=self.oven,
            tolerances=self.tolerances,
        )

    @property
    def effects(self) -> dict[str, dict[str, float]]:
        """Values of the effects that are on."""
        return {e.name: {name: p.value for name, p in e.parameter.items()} for e in self.effect}

    @property
    def departures(self) -> dict[str, dict[str, float]]:
        """Values of the declared quantities that were fitted, by quantity and parameter."""
        found: dict[str, dict[str, float]] = {}
        for one in self.departure:
            found.setdefault(one.quantity, {})[one.parameter] = one.value
        return found


READERS: Mapping[str, type[TwinFile]] = MappingProxyType({FORMAT: TwinFile})
"""By what the file says under ``format``; a new version adds its model here and its way to `TwinFile`."""


def write_twin(path: Path, twin: TwinFile) -> None:
    """Write a twin, whole or not at all."""
    write_text(path, toml_text(twin.model_dump(mode="json"), COMMENT))


def read_twin(path: Path) -> TwinFile:
    """Read a twin file of any version; CampaignFileError with everything that is wrong with it."""
    table = read_table(path)
    version = table.get("format")
    if not isinstance(version, str) or version not in READERS:
        known = " or ".join(repr(name) for name in READERS)
        seen = "nothing" if version is None else repr(version)[:60]
        remedy = "a newer Flexura may have written it" if str(version).startswith("flexura-twin/") else ""
        raise CampaignFileError(path.parent, [Problem(path.name, "format", seen, known, remedy)])
    return checked(path, table, READERS[version])


RECORDER = ("acquisition.module", "acquisition.sample_rate")
"""May differ between campaigns on one plate: they change nothing a twin answers."""
PLATE = ("plate", "patch", "drive", "sensor", "string", "cable", "acquisition")
"""Tables of a declaration that describe the plate and what is on it."""
DRIVEN_OR_HELD = {repr("actuator"), repr("shorted")}
"""Roles of one patch in campaigns that several actuators drove one after the other; short-circuited in either."""


def require_same_plate(path: Path, twin: TwinFile, experiment: Experiment) -> None:
    """Raise unless a twin's plate is that of the campaign.

    Parameters
    ----------
    path : Path
        File of the twin.
    experiment : Experiment
        Of the campaign.

    Raises
    ------
    CampaignFileError
        With all that is declared otherwise, but for `RECORDER` and which of several patches drove the plate.
    """
    remedy = "as the campaign declares; a twin belongs to one plate with its patches"
    problems = [
        Problem(path.name, place, seen, wanted, remedy)
        for place, seen, wanted in _of_the_plate(twin, experiment, (*PLATE, "oven"))
        if not (place.endswith(".role") and {seen, wanted} == DRIVEN_OR_HELD)
    ]
    if problems:
        raise CampaignFileError(path.parent, problems)


def require_same_panel(folder: Path, name: str, later: Experiment, baseline: Experiment) -> None:
    """Raise unless a later recording is of the panel of a baseline, with its patches in the same roles.

    Parameters
    ----------
    folder : Path
        Of the later recording.
    name : str
        Of the file there that declares it.
    later, baseline : Experiment

    Raises
    ------
    CampaignFileError
        With all that is declared otherwise, but for `RECORDER`.
    """
    remedy = "as the baseline declares; a panel is compared with itself: name its own baseline"
    found = _of_the_plate(later, baseline, PLATE)
    if found:
        raise CampaignFileError(
            folder, [Problem(name, place, seen, wanted, remedy) for place, seen, wanted in found]
        )


def require_known_effects(path: Path, twin: TwinFile, cards: Mapping[str, EffectCard]) -> None:
    """Raise unless the library has a twin's effects, their parameters and units, and allows the values.

    Parameters
    ----------
    path : Path
        File of the twin.
    cards : mapping of str to EffectCard
        The library's, by effect.

    Raises
    ------
    CampaignFileError
        With all that it does not know or allow.
    """
    problems: list[Problem] = []
    for number, effect in enumerate(twin.effect):
        place = f"effect[{number}]"
        if effect.name not in cards:
            own = "a user's own needs --effects FOLDER"
            remedy = "; ".join(filter(None, (nearest(effect.name, cards), own)))
            problems.append(Problem(path.name, f"{place}.name", repr(effect.name), ", ".join(cards), remedy))
            continue
        known = {p.name: p for p in cards[effect.name].parameters}
        if set(effect.parameter) != set(known):
            seen = ", ".join(effect.parameter)
            problems.append(Problem(path.name, f"{place}.parameter", seen, "exactly " + ", ".join(known)))
            continue
        for name, given in effect.parameter.items():
            wanted, key = known[name], f"{place}.parameter.{name}"
            if given.unit != wanted.unit:
                problems.append(Problem(path.name, f"{key}.unit", repr(given.unit), repr(wanted.unit)))
            if not wanted.low <= given.value <= wanted.high:
                allowed = f"{wanted.low:g} to {wanted.high:g} {wanted.unit}"
                problems.append(Problem(path.name, f"{key}.value", f"{given.value:g}", allowed))
    if problems:
        raise CampaignFileError(path.parent, problems)


def _of_the_plate(
    ours: TwinFile | Experiment, theirs: Experiment, tables: tuple[str, ...]
) -> list[tuple[str, str, str]]:
    """Places in some tables at which two plates differ, with both values; not in what only records."""
    found = [one for key in tables for one in _differences(key, getattr(ours, key), getattr(theirs, key))]
    return [one for one in found if one[0] not in RECORDER]


def _differences(place: str, ours: Any, theirs: Any) -> list[tuple[str, str, str]]:
    """Places at which two declarations differ, with both values."""
    if isinstance(ours, Declared) and type(ours) is type(theirs):
        names = type(ours).model_fields
        return [d for n in names for d in _differences(f"{place}.{n}", getattr(ours, n), getattr(theirs, n))]
    if _tables(ours) and _tables(theirs):
        if len(ours) != len(theirs):
            return [(place, f"{len(ours)} tables", f"{len(theirs)} tables")]
        pairs = zip(ours, theirs, strict=True)
        return [d for n, (a, b) in enumerate(pairs) for d in _differences(f"{place}[{n}]", a, b)]
    return [] if ours == theirs else [(place, _said(ours), _said(theirs))]


def _tables(value: Any) -> bool:
    return isinstance(value, tuple) and all(isinstance(item, Declared) for item in value)


def _said(value: Any) -> str:
    return "nothing" if value is None else repr(value)
