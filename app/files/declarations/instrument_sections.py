"""The sections of an experiment that are instruments: each is checked by the class that its ``kind`` names."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any, TypeVar

from pydantic import create_model

from analysis.declaration.strict import Declared, Temperature
from app.files.campaign_error import CampaignFileError, Problem
from drivers.kinds import KindError, Kinds
from drivers.ni.cards import CARDS, CardsSettings
from drivers.ovens.settings import OVENS, OvenSettings
from drivers.thermometers.settings import THERMOMETERS

Model = TypeVar("Model", bound=Declared)


class OvenSection(OvenSettings):
    """The oven's limits and whatever its kind adds, and the room it stands in."""

    room_temperature: Temperature


class UnknownInstrument(ValueError):  # noqa: N818 (said of the file, whose section is wrong)
    """A section names a kind that is not there, or whose package is broken.

    Attributes
    ----------
    section : str
        ``cards``, ``oven`` or ``thermometer``.
    wrong : KindError
    """

    def __init__(self, section: str, wrong: KindError) -> None:
        self.section, self.wrong = section, wrong
        super().__init__(f"{section}.kind: {wrong}")

    def said_of(self, path: Path) -> CampaignFileError:
        """Return what a reader of the file raises in its place."""
        wrong = self.wrong
        problem = Problem(path.name, f"{self.section}.kind", wrong.seen, wrong.allowed, wrong.remedy)
        return CampaignFileError(path.parent, [problem])


def instrument_sections(table: Mapping[str, Any]) -> dict[str, Any]:
    """Return the fields that the instruments of an experiment's table make of its model.

    Raises
    ------
    UnknownInstrument
        For a kind that is not there.
    """
    sections: dict[str, Any] = {"cards": (_kind("cards", CARDS, table, default="ni") or CardsSettings, ...)}
    oven = _kind("oven", OVENS, table)
    if oven is not None:
        sections["oven"] = (create_model("OvenSection", __base__=(oven, OvenSection)), ...)
    thermometer = _kind("thermometer", THERMOMETERS, table)
    if thermometer is not None:
        sections["thermometer"] = (thermometer, ...)
    return sections


def _kind(
    section: str, kinds: Kinds[Model], table: Mapping[str, Any], default: str | None = None
) -> type[Model] | None:
    """Return the class of the kind a section names; None where it names none, which its own check then reports."""
    declared = table.get(section)
    name = declared.get("kind", default) if isinstance(declared, Mapping) else default
    if not isinstance(name, str):
        return None
    try:
        return kinds.find(name)
    except KindError as error:
        raise UnknownInstrument(section, error) from error
