"""``flexura thermometer``: the temperature of a panel from its own patches while it plays."""

from pathlib import Path

import click

from app.commands.bad_input import bad_input
from app.commands.options import RUN_WITH_FILTERS, SOUND, laws_of_twin, out_folder, picture
from app.commands.output import Output, output_options

EXAMPLES = """\b
Examples:
  flexura thermometer plate-run --drive drive.wav --response charge.wav --sensor A6
  flexura thermometer plate-run --simulate music.wav --temperature 20:22 --snr 20
"""


@click.command(
    name="thermometer", epilog=EXAMPLES, short_help="Measure a panel's temperature with its own patches."
)
@click.argument("run", type=RUN_WITH_FILTERS, required=False)
@click.option("--drive", type=SOUND, help="Sound file of the volts on every patch, as flexura render writes it.")
@click.option(
    "--response", type=SOUND, help="Sound file of the listening patch's charge, recorded with the drive."
)
@click.option("--sensor", metavar="PATCH", help="Patch used as sensor (default: the panel's last).")
@click.option("--simulate", type=SOUND, help="Instead of a recording: a sound, played and answered by the twin.")
@click.option("--temperature", metavar="T[:T...]|FILE", help="°C of the simulated panel, as for flexura render.")
@click.option(
    "--snr",
    type=click.FloatRange(-20.0, 120.0),
    default=20.0,
    show_default=True,
    help="dB between simulated response and white noise.",
)
@click.option("--seed", type=click.IntRange(0), default=0, show_default=True, help="Of the simulated noise.")
@click.option(
    "--stretch",
    type=click.FloatRange(0.25, 30.0),
    default=1.0,
    show_default=True,
    help="Seconds of sound to a reading.",
)
@click.option(
    "--largest-sigma",
    type=click.FloatRange(0.01, 10.0),
    default=1.0,
    show_default=True,
    help="K above which a reading is refused.",
)
@picture
@laws_of_twin
@out_folder("Folder for thermometer.csv (default: RUN).")
@output_options("the last temperature and every reading")
@bad_input
def command(
    run: Path | None,
    drive: Path | None,
    response: Path | None,
    sensor: str | None,
    simulate: Path | None,
    temperature: str | None,
    snr: float,
    seed: int,
    stretch: float,
    largest_sigma: float,
    picture: bool,
    twin: Path | None,
    out: Path | None,
    output: Output,
) -> None:
    """Estimate the temperature of RUN's panel from the response of one patch while the others play music.

    RUN is a run folder with laws.h5 and filters.h5 or compensation.h5 (default: the current folder). The gain
    between drive and response need not be known. Writes thermometer.csv: one reading per section of the sound, its
    standard deviation due to noise, and a smooth track through all. A section whose signal does not determine the
    temperature is refused. Exit status 1 if all are.
    """
    from app.stages.thermometer import ThermometerRequest, compute

    given = run or Path()
    request = ThermometerRequest(
        run=given,
        drive=drive,
        response=response,
        simulate=simulate,
        temperature=temperature,
        sensor=sensor,
        snr=snr,
        seed=seed,
        stretch=stretch,
        largest_sigma=largest_sigma,
        twin=twin,
    )
    with output.progress() as report:
        found = compute(request, out or given, report)
    if picture and found.file is not None:
        from app.report.sound import readings
        from app.report.style import saved

        saved(found.file.with_suffix(".png"), lambda: readings(found.stretches, found.true))
    output.result(found.record)
    for note in found.notes:
        output.note(note)
    if not found.accepted:
        output.failure(repr(found))
        raise click.exceptions.Exit(1)
    output.summary(repr(found))
