"""A plate over temperature: recordings, FRFs, modes, material laws, and what its twin lacks."""

from collections.abc import Mapping
from pathlib import Path
from time import perf_counter

from analysis.identification.modes import Damping
from analysis.identification.settings import Settings
from analysis.recordings.frf import Frf, campaign_frf
from analysis.recordings.frf_campaign import AnyCampaign
from analysis.recordings.grid_frequency import require_mains
from app.files.campaigns.loading import load_campaign
from app.files.campaigns.of_run import remember_campaign
from app.files.results.next_experiment import rig_table
from app.files.results.run_folder import writable_folder
from app.plate_frfs.plate_of_modes import read_plate_of_modes
from app.stages import gap as gap_stage
from app.stages import identify as identify_stage
from app.stages import update as update_stage
from app.stages import update_modes as update_modes_stage
from app.stages.gap import GapRequest
from app.stages.identify_options import Method, Wanted
from app.stages.update import UpdateRequest
from flexura.arguments import File, as_path, computing


def load(campaign: File) -> AnyCampaign:
    """Read a campaign: a folder with ``campaign.toml``, ``protocol.json`` or ``plate.toml``.

    The first is recorded, the second imported or acquired; the third declares a plate with FRFs of other programs.
    The other functions take such a folder, too, and read it anew each time. Raises
    `app.files.campaign_error.CampaignFileError` with everything that is wrong with it.
    """
    return load_campaign(as_path(campaign))


def frf(campaign: File | AnyCampaign, *, mains: float = 50.0) -> Frf:
    """H1 of every sweep and sensor, with variance and coherence, inside the protocol's band.

    Lines at harmonics of `mains` (Hz) are marked as excluded. Raises ValueError for sweeps of different lengths,
    and for a frequency that no mains have.
    """
    require_mains(mains)
    return campaign_frf(_loaded(campaign), mains=mains)


def identify(
    campaign: File | AnyCampaign,
    *,
    band: tuple[float, float] | None = None,
    damping: Damping = "hysteretic",
    method: Method = "auto",
    twin: File | None = None,
    actuator: str | None = None,
    mains: float = 50.0,
    out: File | None = None,
    progress: bool | None = None,
) -> identify_stage.IdentifiedCampaign:
    """Identify modes in every sweep and follow them over temperature, as ``flexura identify``.

    Parameters
    ----------
    campaign : AnyCampaign or path
    band : (float, float), optional
        Hz; all lines where it is left out.
    damping : str
        How poles are read: ``hysteretic`` or ``viscous``.
    method : str
        ``peak-picking`` is the paper's recipe.
    twin : path, optional
        Run folder of ``flexura update`` whose twin says which modes to expect.
    actuator : str, optional
        Of several that drove in turn, whose sweeps are taken; the first where it is left out.
    mains : float
        Hz.
    out : path, optional
        Run folder for frf.h5, modes.h5 and modes.csv; nothing is written where it is left out.
    progress : bool, optional
        Draw progress bars on the error stream, where that is a terminal, or in a notebook; None: in a notebook.

    Raises
    ------
    ValueError
        For an option outside what it allows.
    app.files.bad_file.ResultFileError
        For a campaign, a band or a run folder that cannot be used.
    """
    wanted = Wanted(Settings(mains=mains), damping, method, band, actuator)
    given, campaign, run = campaign, _loaded(campaign), _run(out)
    with computing(shown=progress) as report:
        found = identify_stage.compute(campaign, wanted, report, None if twin is None else as_path(twin))
    if run is not None:
        identify_stage.save(run, campaign, found, wanted)
        _remember(run, given)
    return found


def update(
    campaign: File | AnyCampaign,
    *,
    twin: File | None = None,
    effects: File | None = None,
    mains: float = 50.0,
    out: File | None = None,
    progress: bool | None = None,
) -> update_stage.Updating:
    """Fit E, nu and eta of the twin at every temperature, and laws through them, as ``flexura update``.

    Parameters
    ----------
    campaign : AnyCampaign or path
    twin : path, optional
        Twin file whose effects are switched on, with the values they have there.
    effects : path, optional
        Folder with a user's own effects.
    mains : float
        Hz.
    out : path, optional
        Run folder for frf.h5 and laws.h5; nothing is written where it is left out.
    progress : bool, optional
        Draw progress bars on the error stream, where that is a terminal, or in a notebook; None: in a notebook.

    Returns
    -------
    Updating
        Of an orthotropic sheet ``updated.sheet`` has the constants by direction, ``value`` and ``sigma``.

    Raises
    ------
    app.files.bad_file.ResultFileError
        For a campaign that cannot be judged, with the reason.
    """
    require_mains(mains)
    request = UpdateRequest(_loaded(campaign), twin=_path(twin), effects=_path(effects), mains=mains)
    run = _run(out)
    with computing(shown=progress) as report:
        found = update_stage.compute(request, report, run=run)
    if run is not None:
        update_stage.save(run, request, found)
        _remember(run, campaign)
    return found


def gap(
    campaign: File | AnyCampaign,
    *,
    twin: File | None = None,
    effects: File | None = None,
    mains: float = 50.0,
    plan: bool = False,
    experiment: File | None = None,
    hours: Mapping[str, float] | None = None,
    after: tuple[File | AnyCampaign, File] | None = None,
    out: File | None = None,
    progress: bool | None = None,
) -> gap_stage.GapComparison:
    """Compare a campaign with its twin and name the effects that the twin lacks, as ``flexura gap``.

    Parameters
    ----------
    campaign : AnyCampaign or path
    twin : path, optional
        Twin file whose effects are switched on from the beginning.
    effects : path, optional
        Folder with a user's own effects.
    mains : float
        Hz.
    plan : bool
        Whether the next experiment is planned.
    experiment : path, optional
        For a plan: file by which the campaign was acquired; by default what its folder holds of it.
    hours : mapping of str to float, optional
        For a plan: laboratory hours of kinds of measurement, as ``--hours``.
    after : (AnyCampaign or path, path), optional
        An earlier campaign and its run folder, whose plan this campaign follows.
    out : path, optional
        Run folder for gap.json, gap.h5, frf.h5, twin.toml and laws; nothing is written where it is left out.
    progress : bool, optional
        Draw progress bars on the error stream, where that is a terminal, or in a notebook; None: in a notebook.

    Raises
    ------
    app.files.bad_file.ResultFileError
        For a campaign that cannot be judged, with the reason.
    """
    require_mains(mains)
    rig = None
    if experiment is not None or (plan and not isinstance(campaign, AnyCampaign)):
        rig = rig_table(Path() if isinstance(campaign, AnyCampaign) else as_path(campaign), _path(experiment))
    request = GapRequest(
        _loaded(campaign),
        twin=_path(twin),
        effects=_path(effects),
        mains=mains,
        plan=plan,
        hours=hours or {},
        rig=rig,
        after=None if after is None else (_loaded(after[0]), as_path(after[1])),
    )
    run, began = _run(out), perf_counter()
    with computing(shown=progress) as report:
        found = gap_stage.compute(request, report, run=run)
    if run is not None:
        gap_stage.save(run, request, found, perf_counter() - began)
        _remember(run, campaign)
    return found


def update_modes(
    plate: File, table: File | None = None, *, out: File | None = None, progress: bool | None = None
) -> update_modes_stage.UpdatingByModes:
    """Fit E, nu and eta of the twin to natural frequencies and damping, as ``flexura update MODES.csv --plate``.

    Parameters
    ----------
    plate : path
        ``plate.toml``, or its folder.
    table : path, optional
        Modes as CSV; those that the declaration states where it is left out.
    out : path, optional
        Run folder for laws.h5; nothing is written where it is left out.
    progress : bool, optional
        Draw progress bars on the error stream, where that is a terminal, or in a notebook; None: in a notebook.

    Raises
    ------
    app.files.campaign_error.CampaignFileError
        With all that is wrong with the declaration.
    app.files.bad_file.ResultFileError
        For modes that cannot be read or fitted, with the reason.
    """
    loaded = read_plate_of_modes(as_path(plate), None if table is None else as_path(table))
    run = _run(out)
    with computing(shown=progress) as report:
        found = update_modes_stage.compute(loaded, report)
    if run is not None:
        update_modes_stage.save(run, loaded, found)
    return found


def _loaded(campaign: File | AnyCampaign) -> AnyCampaign:
    return campaign if isinstance(campaign, AnyCampaign) else load(campaign)


def _remember(run: Path, campaign: File | AnyCampaign) -> None:
    """Keep where the campaign of a run folder is, for commands on its report; not known of one in memory."""
    if not isinstance(campaign, AnyCampaign):
        remember_campaign(run, as_path(campaign))


def _path(file: File | None) -> Path | None:
    return None if file is None else as_path(file)


def _run(out: File | None) -> Path | None:
    """Run folder that results go to, made if need be; None where nothing is to be written."""
    return None if out is None else writable_folder(as_path(out), "out")
