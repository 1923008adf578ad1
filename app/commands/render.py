"""``flexura render``: sound filtered with temperature-dependent filters."""

from pathlib import Path

import click

from app.commands.bad_input import bad_input
from app.commands.options import (
    RUN_WITH_FILTERS,
    SOUND,
    WEATHER,
    following_method,
    laws_of_twin,
    out_folder,
    picture,
)
from app.commands.output import Output, output_options

EXAMPLES = """\b
Examples:
  flexura render music.wav plate-run --temperature 20:45
  flexura render music.wav plate-run --temperature 20:60 --heard
  flexura render music.flac plate-run --temperature readings.csv --method network
  flexura render music.flac plate-run --weather examples/warming-car.toml --heard
"""


@click.command(name="render", epilog=EXAMPLES, short_help="Play a sound file through the filters.")
@click.argument("sound", type=SOUND)
@click.argument("run", type=RUN_WITH_FILTERS, required=False)
@click.option(
    "--temperature",
    metavar="T[:T...]|FILE",
    help="°C: one, a way between several over the sound, or a CSV file of seconds and °C.",
)
@click.option(
    "--weather",
    type=WEATHER,
    help="A weather's file (*.toml) in place of --temperature: filters follow its thermometers.",
)
@following_method
@click.option(
    "--block",
    type=click.IntRange(16, 65_536),
    default=512,
    show_default=True,
    help="Samples filtered at a time, after which a new temperature is heeded.",
)
@click.option("--heard", is_flag=True, help="Write the sound at the panel's listeners, too, and at two ears.")
@picture
@laws_of_twin
@out_folder("Folder for the results (default: RUN).")
@output_options("contrast along the way and the real-time factor")
@bad_input
def command(
    sound: Path,
    run: Path | None,
    temperature: str | None,
    weather: Path | None,
    method: str | None,
    block: int,
    heard: bool,
    picture: bool,
    twin: Path | None,
    out: Path | None,
    output: Output,
) -> None:
    """Filter SOUND as the panel of RUN would be driven while its temperature moves.

    SOUND is WAV, FLAC or what else libsndfile reads, at the sample rate of the filters; channels are averaged. RUN
    is a run folder with laws.h5 and filters.h5 or compensation.h5 (default: the current folder). Writes
    SOUND-rendered.wav, one channel per actuator in volts, and SOUND-rendered.csv: temperature and contrast of the
    twin's field along the way, with the filters in use and with those of the beginning kept. --heard computes the
    sound at the listeners of the panel's file, in pascals, as WAV: SOUND-heard.wav, one channel per listener, and
    SOUND-binaural.wav, at the ears of the first (a rigid sphere for a head); SOUND-heard-kept.wav and
    SOUND-binaural-kept.wav with the filters of the beginning kept. With --weather, the panel has the field of
    temperatures that the heat equation gives it, from the beginning of the sound on (--heard: with this field);
    filters follow the plane through the thermometers, and its tilt too where flexura compensate --weather made
    filters for it.
    """
    from app.stages.render import RenderRequest, compute

    given = run or Path()
    request = RenderRequest(
        sound=sound,
        run=given,
        temperature=temperature,
        weather=weather,
        method=method,
        block=block,
        heard=heard,
        twin=twin,
    )
    with output.progress() as report:
        done = compute(request, out or given, report)
    if picture:
        from app.report.sound import along_the_way
        from app.report.style import saved

        saved(done.rendering.trace.with_suffix(".png"), lambda: along_the_way(done.trace.moments))
    output.result(done.record)
    for note in done.notes:
        output.note(note)
    output.summary(repr(done))
