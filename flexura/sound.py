"""What a panel plays, what is heard of it, and what its own patches say of its temperature."""

from app.stages import radiation as radiation_stage
from app.stages import render as render_stage
from app.stages import thermometer as thermometer_stage
from app.stages.radiation import RadiatingPanel, RadiationRequest
from app.stages.render import USUAL_BLOCK, RenderedSound, RenderRequest
from app.stages.thermometer import MeasuredTemperatures, ThermometerRequest
from flexura.arguments import File, as_path, computing


def render(
    sound: File,
    run: File,
    *,
    temperature: float | str | None = None,
    weather: File | None = None,
    method: str | None = None,
    block: int = USUAL_BLOCK,
    heard: bool = False,
    twin: File | None = None,
    out: File | None = None,
    progress: bool | None = None,
) -> RenderedSound:
    """Filter a piece of sound as a panel would be driven while its temperature moves, as ``flexura render``.

    Parameters
    ----------
    sound : path
        WAV, FLAC or what else libsndfile reads, at the sample rate of the filters; channels are averaged.
    run : path
        Run folder with laws.h5 and filters.h5 or compensation.h5.
    temperature : float or str, optional
        Degrees Celsius: one, a way between several over the sound (``"20:45"``), or the name of a CSV file of
        seconds and degrees.
    weather : path, optional
        A weather's file in place of `temperature`.
    method : str, optional
        How filters follow the temperature; what ``flexura compensate`` recommends where it is left out.
    block : int
        Samples filtered at a time.
    heard : bool
        Whether the sound at the panel's listeners is written, too.
    twin : path, optional
        Twin file whose laws are taken.
    out : path, optional
        Folder for the files; the run folder where it is left out.
    progress : bool, optional
        Draw progress bars on the error stream, where that is a terminal, or in a notebook; None: in a notebook.

    Raises
    ------
    app.files.bad_file.ResultFileError
        For options that exclude each other, files that cannot be used, and temperatures outside what laws or
        filters cover.
    """
    request = RenderRequest(
        sound=as_path(sound),
        run=as_path(run),
        temperature=None if temperature is None else str(temperature),
        weather=None if weather is None else as_path(weather),
        method=method,
        block=block,
        heard=heard,
        twin=None if twin is None else as_path(twin),
    )
    with computing(shown=progress) as report:
        return render_stage.compute(request, as_path(run if out is None else out), report)


def radiation(
    run: File,
    *,
    panel: File | None = None,
    transfers: File | None = None,
    twin: File | None = None,
    out: File | None = None,
    progress: bool | None = None,
) -> RadiatingPanel:
    """Compute what listeners hear of a panel with its filters, over temperature, as ``flexura radiation``.

    Parameters
    ----------
    run : path
        Run folder with filters.h5 and laws, or that file.
    panel : path, optional
        Panel file whose ``[sound]`` is taken; the filters' own where it is left out.
    transfers : path, optional
        Measured transfers, from which the filters were made, in place of laws and a twin.
    twin : path, optional
        Twin file whose laws are taken.
    out : path, optional
        Folder for radiation.h5; nothing is written where it is left out.
    progress : bool, optional
        Draw progress bars on the error stream, where that is a terminal, or in a notebook; None: in a notebook.

    Raises
    ------
    app.files.bad_file.ResultFileError
        For options that exclude each other, files that cannot be used, and a grid or points too coarse for the
        wavelength.
    app.files.campaign_error.CampaignFileError
        For a twin file that cannot be used.
    """
    request = RadiationRequest(
        run=as_path(run),
        panel=None if panel is None else as_path(panel),
        transfers=None if transfers is None else as_path(transfers),
        twin=None if twin is None else as_path(twin),
    )
    with computing(shown=progress) as report:
        return radiation_stage.compute(request, None if out is None else as_path(out), report)


def thermometer(
    run: File,
    *,
    drive: File | None = None,
    response: File | None = None,
    simulate: File | None = None,
    temperature: float | str | None = None,
    sensor: str | None = None,
    snr: float = 20.0,
    seed: int = 0,
    stretch: float = 1.0,
    largest_sigma: float = 1.0,
    twin: File | None = None,
    out: File | None = None,
    progress: bool | None = None,
) -> MeasuredTemperatures:
    """Read a panel's temperature from its own patches while it plays, as ``flexura thermometer``.

    Parameters
    ----------
    run : path
        Run folder with laws.h5 and filters.h5 or compensation.h5.
    drive, response : path, optional
        Sound files of the volts on every patch, and of the listening patch's charge.
    simulate : path, optional
        Instead of both: a sound, played and answered by the twin, at `temperature`.
    temperature : float or str, optional
        Of the simulated panel, as for `render`.
    sensor : str, optional
        Patch used as sensor; the panel's last where it is left out.
    snr : float
        Between simulated response and white noise, dB.
    seed : int
        Of the simulated noise.
    stretch : float
        Seconds of sound to a reading.
    largest_sigma : float
        K above which a reading is refused.
    twin : path, optional
        Twin file whose laws are taken.
    out : path, optional
        Folder for thermometer.csv; nothing is written where it is left out.
    progress : bool, optional
        Draw progress bars on the error stream, where that is a terminal, or in a notebook; None: in a notebook.

    Raises
    ------
    app.files.bad_file.ResultFileError
        For options that exclude each other, files that cannot be used, a patch that the panel does not have, and
        temperatures outside what laws or filters cover.
    """
    request = ThermometerRequest(
        run=as_path(run),
        drive=None if drive is None else as_path(drive),
        response=None if response is None else as_path(response),
        simulate=None if simulate is None else as_path(simulate),
        temperature=None if temperature is None else str(temperature),
        sensor=sensor,
        snr=snr,
        seed=seed,
        stretch=stretch,
        largest_sigma=largest_sigma,
        twin=None if twin is None else as_path(twin),
    )
    with computing(shown=progress) as report:
        return thermometer_stage.compute(request, None if out is None else as_path(out), report)
