"""The instruments that a file declares, whatever else stands in it; or a kind of oven by its name alone."""

from pathlib import Path
from typing import Any

from pydantic import ConfigDict, ValidationError, create_model

from analysis.declaration.strict import Declared
from app.files.bad_file import ResultFileError
from app.files.campaign_error import CampaignFileError, Problem
from app.files.declarations.experiment import UnknownInstrument, instrument_sections
from app.files.declarations.hammer_experiment import is_hammer_table
from app.files.settings_toml import checked, read_table
from drivers.kinds import KindError
from drivers.ni.cards import CardsSettings
from drivers.ovens.settings import OVENS, OvenSettings
from drivers.rig.occupancy import instrument_places
from drivers.thermometers.thermometer import ThermometerSettings

USUAL: dict[str, Any] = {"port": "simulated", "minimum": -5.0, "maximum": 65.0, "max_rate": 3.0}
"""What a kind is declared with where only its name is known."""


BASES: dict[str, type[Declared]] = {
    "cards": CardsSettings,
    "oven": OvenSettings,
    "thermometer": ThermometerSettings,
}
"""Sections, and what checks one without a kind, which is reported as missing."""


class DeclaredInstruments(Declared):
    """Cards, oven and thermometer of a file."""

    model_config = ConfigDict(extra="ignore")

    cards: CardsSettings | None = None
    oven: OvenSettings | None = None
    thermometer: ThermometerSettings | None = None

    @property
    def places(self) -> tuple[str, ...]:
        """What of them only one process can use."""
        return instrument_places(self.oven, self.thermometer, self.cards)


def declared_instruments(named: str) -> DeclaredInstruments:
    """Return the instruments of the file called so, or of the kind of oven.

    Raises
    ------
    CampaignFileError
        With every key that is wrong.
    ResultFileError
        For a kind that is not there, or needs more than its name.
    """
    if named.endswith(".toml") or Path(named).exists():
        return _of_file(Path(named))
    try:
        return DeclaredInstruments(oven=OVENS.find(named).model_validate({"kind": named, **USUAL}))
    except KindError as error:
        allowed = f"an experiment's file (*.toml), or a kind of oven: {error.allowed}"
        raise ResultFileError(f"{error.seen}; allowed: {allowed}; {error.remedy}") from error
    except ValidationError as error:
        keys = ", ".join(sorted({str(detail["loc"][0]) for detail in error.errors() if detail["loc"]}))
        seen = f"{named} is not defined by its name alone: it needs {keys or 'more'}"
        raise ResultFileError(f"{seen}; declare it in an [oven], and name that file") from error


def _of_file(path: Path) -> DeclaredInstruments:
    table = read_table(path)
    try:
        sections = instrument_sections(table)
    except UnknownInstrument as error:
        raise error.said_of(path) from error
    asked: dict[str, Any] = {name: table[name] for name in BASES if name in table}
    if is_hammer_table(table):
        asked.pop("cards", None)
        if not asked:
            said = "a hammer test without oven and thermometer: its cards only record; the first hit checks them"
            raise CampaignFileError(path.parent, [Problem(path.name, "", said, "")])
    if not asked:
        raise CampaignFileError(
            path.parent, [Problem(path.name, "", "has no [cards], no [oven] and no [thermometer]", "")]
        )
    model = create_model(
        "DeclaredInstruments",
        __base__=DeclaredInstruments,
        **{name: sections.get(name, (BASES[name], ...)) for name in asked},
    )
    return checked(path, asked, model)
