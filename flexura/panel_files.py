"""What `flexura.focus` and `flexura.compensate` take: laws, a twin file, a panel, measured transfers."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from analysis.focusing.methods import Method
from analysis.focusing.panel import Panel
from analysis.material import MaterialLaws
from analysis.recordings.campaign import CampaignExtent
from app.files.declarations.panel import SECTION_2, read_panel
from app.files.provenance import sha256
from app.files.results.laws_file import remember_laws
from app.files.results.run_folder import writable_folder
from app.files.results.transfers_file import transfer_files
from app.stages.gap import GapComparison
from app.stages.panel.inputs import method_for, panel_for, scanned_panel
from app.stages.panel.laws import PanelLaws, laws_for
from app.stages.update import Updating
from app.summaries.update import too_few
from flexura.arguments import File, as_path

Laws = File | MaterialLaws | Updating | GapComparison
"""A run folder, whose best twin is taken, or a file of laws; laws, or a result of `update` or `gap`."""


@dataclass(frozen=True)
class GivenLaws:
    """Laws of a panel's plate, from a file or in memory.

    Attributes
    ----------
    laws : MaterialLaws
    read : PanelLaws or None
        What else their file says; None for laws in memory.
    """

    laws: MaterialLaws
    read: PanelLaws | None = None

    @property
    def path(self) -> Path | None:
        """File the laws stand in; None for laws in memory."""
        return None if self.read is None else self.read.path

    @property
    def folder(self) -> Path | None:
        """Where their filters may lie."""
        return None if self.read is None else self.read.folder

    @property
    def extent(self) -> CampaignExtent | None:
        """Of the campaign they were found in, where a file says that it was not complete."""
        return None if self.read is None else self.read.extent

    @property
    def origin(self) -> Path:
        """Return what messages name."""
        return self.path or Path("laws")

    def remember(self, folder: Path) -> None:
        """Write into a folder of results where their laws are, if they are elsewhere."""
        if self.read is not None:
            remember_laws(folder, self.read.path, kind=self.read.kind)

    def on(self, panel: Panel) -> tuple[Panel, list[str]]:
        """Return a panel with what was found about its plate, and notes, see `PanelLaws.on`."""
        return (panel, []) if self.read is None else self.read.on(panel)


def laws_read(laws: Laws | None, twin: File | None, verb: str) -> GivenLaws:
    """Read the laws that a panel's plate obeys.

    Parameters
    ----------
    laws : path, MaterialLaws, Updating or GapComparison, optional
    twin : path, optional
        Twin file, whose laws take the place of those.
    verb : str
        Of the command that does the same, for messages.

    Raises
    ------
    ValueError
        For neither laws nor twin, laws in memory beside a twin, and a result without laws.
    """
    if twin is None and laws is None:
        raise ValueError("laws, twin or transfers: one of them is needed")
    if isinstance(laws, MaterialLaws | Updating | GapComparison):
        if twin is not None:
            raise ValueError(
                "twin takes the place of laws in memory: leave laws out, or name the run folder there"
            )
        if isinstance(laws, MaterialLaws):
            return GivenLaws(laws)
        found = laws.corrected.laws if isinstance(laws, GapComparison) else laws.laws
        if found is None:
            of = laws.plain if isinstance(laws, GapComparison) else laws
            raise ValueError(too_few(of.updated))
        return GivenLaws(found)
    read = laws_for(path_of(laws), path_of(twin), verb)
    return GivenLaws(read.laws, read)


def panel_followed(
    panel: File | Panel | None, method: Method | None, folder: Path | None, *, scanned: bool = False
) -> tuple[Panel, Path | None, Method]:
    """Choose panel and method of the filters that networks follow, as the verb does.

    Parameters
    ----------
    panel : path or Panel, optional
    method : str, optional
    folder : Path or None
        Run folder whose filters say what is left out.
    scanned : bool
        Whether the panel's transfers are measured: filters in `folder` may then come from transfers, too.

    Returns
    -------
    panel : Panel
    path : Path or None
        Its file; None for a panel in memory.
    method : str

    Raises
    ------
    ResultFileError
        For a panel that cannot be read, and for filters in `folder` that were designed from measured transfers
        where the panel is not `scanned`.
    """
    if isinstance(panel, Panel):
        return panel, None, method or "stif"
    named = path_of(panel)
    if folder is None:
        file = named or SECTION_2
        return read_panel(file), file, method or "stif"
    choose = scanned_panel if scanned else panel_for
    return *choose(named, folder, {}), method_for(method, named, folder)


def folder_of(run: Laws | None, transfers: Path) -> Path:
    """Run folder of the filters that were designed from transfers; that of the transfers where none is named."""
    if run is None:
        return transfers.parent
    if isinstance(run, MaterialLaws | Updating | GapComparison) or not as_path(run).is_dir():
        raise ValueError("laws beside transfers: the run folder of flexura focus --transfers, or leave it out")
    return as_path(run)


def kept(out: File | None, laws: Path | None, panel: Path | None) -> tuple[Path | None, Mapping[str, str]]:
    """Make the run folder for results that are to be written.

    Parameters
    ----------
    out : path, optional
    laws, panel : Path or None
        Files the results follow from; measured transfers, a file or a folder, count as laws.

    Returns
    -------
    folder : Path or None
        None where nothing is to be written.
    inputs : mapping
        SHA-256 of each file, by name.

    Raises
    ------
    ValueError
        For laws or a panel that are in no file.
    """
    if out is None:
        return None, {}
    if laws is None or panel is None:
        raise ValueError(
            "out keeps the SHA-256 of the files that filters follow from: name the run folder that holds laws.h5 "
            "in place of laws, and the panel's file in place of a panel"
        )
    files = (*transfer_files(laws), panel)
    return writable_folder(as_path(out), "out"), {path.name: sha256(path) for path in files}


def path_of(file: File | None) -> Path | None:
    """Path of a file, if one is named."""
    return None if file is None else as_path(file)
