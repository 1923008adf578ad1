"""Study stage: the data of the paper's figures on a panel, computed and saved."""

import time
from collections.abc import Mapping
from contextlib import nullcontext
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

from analysis.compensation.settings import Training
from analysis.focusing.panel_model import spaced
from analysis.progress import Progress
from analysis.recordings.campaign import CampaignExtent
from app.files.bad_file import ResultFileError, UnsuitedOptionError
from app.files.campaigns.inputs import extent_settings
from app.files.provenance import provenance, sha256
from app.files.results.run_folder import run_folder
from app.stages.panel.inputs import panel_for
from app.stages.panel.laws import laws_for, range_of

if TYPE_CHECKING:  # a run is told to be of another kind before what computes is imported
    from app.files.results.panel_files import Studies

STUDIES = "studies.h5"
FIGURES = ("4", "13", "14", "15", "16", "17", "18", "19")
SPACINGS_OF = {"14": 5.0, "15": 5.0, "16": 5.0, "17": 5.0, "18": 5.0, "19": 8.0}
"""Widest spacing of training temperatures in figures with networks, K."""


@dataclass(frozen=True, kw_only=True)
class StudyRequest:
    """Figures of the paper that are made, as typed or declared.

    Attributes
    ----------
    figure : str
        Its number in the paper, or ``all``.
    run : Path or None
        Run folder or laws file; None for the current folder.
    panel : Path or None
        Panel file; None for that of the run's filters.
    as_paper : bool
        Whether networks are fed, scaled, started and split, and filters designed, as in the paper.
    seed : int
        Of all that is random.
    changes : mapping
        Filter settings that replace those of the panel, by key; None leaves one as it is.
    """

    figure: str
    run: Path | None = None
    panel: Path | None = None
    as_paper: bool = False
    seed: int = 0
    changes: Mapping[str, Any] = field(default_factory=dict)

    def __post_init__(self) -> None:
        """Raise UnsuitedOptionError for a figure that is none, a negative seed, and two designs at once."""
        if self.figure not in (*FIGURES, "all"):
            raise UnsuitedOptionError(f"figure {self.figure}: allowed are {', '.join(FIGURES)} and all")
        if self.seed < 0:
            raise UnsuitedOptionError(f"--seed {self.seed}: allowed are 0 and more")
        if self.as_paper and self.changes.get("design") is not None:
            raise UnsuitedOptionError("--as-paper sets --design itself: leave one of them out")

    @property
    def folder(self) -> Path:
        """That of the laws, for results; ResultFileError where there are none."""
        return laws_for(self.run, None, "study").folder

    @property
    def figures(self) -> tuple[str, ...]:
        """Numbers of all figures that are made."""
        return FIGURES if self.figure == "all" else (self.figure,)


@dataclass(frozen=True)
class StudiedPanel:
    """Result of the study stage.

    Attributes
    ----------
    studies : Studies
        With None for figures that were not asked for.
    file : Path or None
        studies.h5; None where nothing was written.
    seconds : float
        It took.
    extent : CampaignExtent or None
        Of the campaign that the laws come from.
    notes : tuple of str
        For people.
    """

    studies: "Studies"
    file: Path | None
    seconds: float
    extent: CampaignExtent | None = None
    notes: tuple[str, ...] = field(default=(), repr=False)

    def __repr__(self) -> str:
        """Say where the figures' data are, in one line, and the notes."""
        from app.summaries.table import as_text

        made = "in memory" if self.file is None else self.file
        return as_text(f"StudiedPanel: {made}, {self.seconds:.1f} s", self.notes)


def compute(request: StudyRequest, out: Path | None, report: Progress) -> StudiedPanel:
    """Compute the data of figures, and write studies.h5 where a folder is named for it.

    Parameters
    ----------
    out : Path or None
        Folder for the file.
    report : callable
        Called with a stage's name and the share of it done.

    Raises
    ------
    ResultFileError, CampaignFileError
        For laws and panels that cannot be used, and laws of too few degrees to train networks on.
    EvidenceCollapseError
        Where the networks of Figs. 15 to 17 are refused.
    """
    started = time.perf_counter()
    origin = laws_for(request.run, None, "study")
    design = {"design": "inverse-fft"} if request.as_paper else {}
    declared, panel_path = panel_for(request.panel, origin.folder, {**request.changes, **design})
    declared, notes = origin.on(declared)
    laws = declared.plate.grown(origin.laws)
    training = Training(seed=request.seed)
    _require_spacing(request, training, range_of(declared, laws, origin.path, origin.extent), origin.path)

    from app.files.results.panel_files import save_studies
    from app.stages.study_figures import run_studies
    from app.twins.panel_twin import panel_twin

    with nullcontext() if out is None else run_folder(origin.folder, out):
        model = panel_twin(declared, laws, report)
        training = training.as_paper() if request.as_paper else training
        found = run_studies(request.figures, model, declared, laws, training, report)
        inputs = {path.name: sha256(path) for path in (origin.path, panel_path)}
        settings = {
            "figures": list(request.figures),
            "as_paper": request.as_paper,
            "panel": declared.model_dump(mode="json"),
            **extent_settings(origin.extent),
        }
        file = None if out is None else out / STUDIES
        if file is not None:
            save_studies(file, declared, found, provenance(inputs, settings, request.seed))
    return StudiedPanel(found, file, time.perf_counter() - started, origin.extent, tuple(notes))


def _require_spacing(request: StudyRequest, training: Training, span: tuple[float, float], laws: Path) -> None:
    """Raise ResultFileError if the laws' range is too narrow for the networks of a requested figure."""
    spacing = max((SPACINGS_OF[one] for one in request.figures if one in SPACINGS_OF), default=None)
    if spacing is None:
        return
    low, high = span
    try:
        training.check_temperatures(len(spaced(low, high, spacing)))
    except ValueError as error:
        raise ResultFileError(
            f"{laws}: {low:g} to {high:g} °C give too few temperatures {spacing:g} °C apart to train "
            "networks on; take laws of a wider range, or figures 4 and 13"
        ) from error
