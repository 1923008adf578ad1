"""What the stages of one run share."""

from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING

from app.chain.input_files import campaign_hashes, is_import_of
from app.chain.request import RunRequest
from app.files.declarations.run_settings import RunSettings, Stage

if TYPE_CHECKING:
    from analysis.focusing.panel import Panel
    from analysis.recordings.frf_campaign import AnyCampaign
    from app.chain.models_ahead import ModelsAhead, WantedModel
    from app.report.written import DrawnParts
    from app.stages.update import Updating


@dataclass(frozen=True)
class Made:
    """What a stage came to.

    Attributes
    ----------
    said : str
        In one line.
    notes : tuple of str
        Important for the use of the result.
    good : bool
        Whether it is good enough, as the exit status of the stage's verb.
    seed : int or None
        Where randomness was involved.
    """

    said: str
    notes: tuple[str, ...] = ()
    good: bool = True
    seed: int | None = None


@dataclass
class Work:
    """One run at work.

    Attributes
    ----------
    request : RunRequest
    run : Path
        Run folder, there.
    models : ModelsAhead
        Set, as `parts` is, before the first stage is made.
    parts : DrawnParts
        Of the report.
    plain : Updating or None
        The twin without effects, fitted by the update stage for the gap stage, too.
    in_place : bool
        Whether a recording turned out to be read where it stands.
    broken : set of str
        Stages that failed in this run.
    """

    request: RunRequest
    run: Path
    models: "ModelsAhead" = field(init=False)
    parts: "DrawnParts" = field(init=False)
    plain: "Updating | None" = None
    in_place: bool = False
    broken: set[Stage] = field(default_factory=set)

    @property
    def settings(self) -> RunSettings:
        """Options of the stages."""
        return self.request.options.settings

    @property
    def folder(self) -> Path:
        """Campaign that stages read: the one imported, where there is one of this recording."""
        imported = self.request.imported
        if imported is None or self.in_place or not is_import_of(imported, self.request.campaign):
            return self.request.campaign
        return imported

    def place(self, stage: Stage) -> Path:
        """Return the folder that a stage's results are in."""
        return self.request.imported or self.run if stage == "import" else self.run

    @property
    def effects(self) -> Path | None:
        """Folder of a user's own effects."""
        return self.request.options.path(self.settings.effects)

    @property
    def panel(self) -> Path | None:
        """File of the panel; None for the paper's section 2."""
        return self.request.options.path(self.settings.focus.panel)

    @property
    def weather(self) -> Path | None:
        """File of the weather in which filters are judged; None without one."""
        return self.request.options.path(self.settings.compensate.weather)

    @cached_property
    def hashes(self) -> dict[str, str]:
        """SHA-256 of the campaign's files, taken before it is read: what comes later makes results out of date."""
        return campaign_hashes(self.folder)

    @cached_property
    def campaign(self) -> "AnyCampaign":
        """The campaign; CampaignFileError where it cannot be read."""
        from app.files.campaigns.loading import load_campaign

        assert self.hashes  # noqa: S101 (taken first)
        return load_campaign(self.folder)

    def renew(self) -> None:
        """Forget what was read: the campaign has been imported."""
        for name in ("hashes", "campaign"):
            self.__dict__.pop(name, None)

    def models_wanted(self) -> "tuple[WantedModel, ...]":
        """Return the reduced models that are not in the cache and that the stages asked for will need."""
        from app.chain.models_ahead import EFFECTS, PANEL, PLATE, WantedModel
        from app.twins.campaign_twin import twin_is_built
        from app.twins.panel_twin import panel_is_reduced

        wanted, found = set(self.request.stages), []
        experiment = self.campaign.experiment
        if {"update", "gap"} & wanted and not twin_is_built(experiment):
            found.append(WantedModel(PLATE, experiment.model_dump_json()))
        panel = self._panel_ahead() if {"focus", "compensate"} & wanted else None
        if panel is not None and not panel_is_reduced(panel):
            found.append(WantedModel(PANEL, panel.model_dump_json()))
        if "gap" in wanted:  # made quickly where it is in the cache
            found.append(WantedModel(EFFECTS, experiment.model_dump_json()))
        return tuple(found)

    def _panel_ahead(self) -> "Panel | None":
        """Return the panel whose model can be built before the plate is updated.

        None where it cannot be read, which the stage says, and where it declares the measured plate: it then gets
        what is found about that.
        """
        from app.files.bad_file import ResultFileError
        from app.stages.panel.inputs import panel_of
        from app.stages.panel.measured_plate import MeasuredPlate

        try:
            panel, _ = panel_of(self.panel, self.settings.focus.changes())
        except ResultFileError:
            return None
        return None if MeasuredPlate(self.campaign.experiment).is_that_of(panel) else panel
