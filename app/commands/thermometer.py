"""``flexura thermometer``: the temperature of a panel from its own patches while it plays."""

import math
from pathlib import Path
from typing import TYPE_CHECKING

import click

from app.commands.bad_input import bad_input
from app.commands.options import RUN_WITH_FILTERS, SOUND, laws_of_twin, out_folder, picture
from app.commands.output import Output, output_options

if TYPE_CHECKING:
    from analysis.arrays import Real
    from analysis.campaign_extent import CampaignExtent
    from analysis.progress import Progress
    from analysis.rendering.programme import TemperatureProgramme
    from app.files.exports.shipment import Shipment
    from app.sound.listening_panel import ListeningPanel
    from app.sound.played_signals import PlayedSignals
    from app.sound.stretch import RecordingStretch

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
    from app.files.exports.shipment import shipment
    from app.files.run_folder import run_folder
    from app.stages.panel_laws import laws_for, range_of

    _asked(drive, response, simulate, temperature)
    given = run or Path()
    sent = shipment(given, None, "thermometer")
    origin = laws_for(given, twin, "thermometer")
    laws = sent.panel.plate.grown(origin.laws)
    low, high = range_of(sent.panel, laws, origin.path, origin.extent)
    place = _sensor(sent, sensor)

    from app.sound.listening import listened
    from app.sound.listening_panel import ListeningPanel
    from app.sound.stretch import write_stretches
    from app.twins.panel_twin import panel_twin

    with run_folder(given, out or given) as folder, output.progress() as report:
        panel = ListeningPanel(panel_twin(sent.panel, laws, report), laws, place)
        signals, course = _signals(sent, panel, (drive, response, simulate), (temperature, snr, seed), report)
        stretches = listened(panel, signals, sent.panel.filters.edges, (low, high), stretch, largest_sigma, report)
    for note in origin.notes:
        output.note(note)
    true = None if course is None else course.at([one.time for one in stretches])
    target = write_stretches(stretches, folder, true)
    if picture:
        from app.report.sound import readings
        from app.report.style import saved

        saved(target.with_suffix(".png"), lambda: readings(stretches, true))
    _print(stretches, panel, true, target, output, origin.extent)


def _print(
    stretches: "list[RecordingStretch]",
    panel: "ListeningPanel",
    true: "Real | None",
    target: Path,
    output: Output,
    extent: "CampaignExtent | None",
) -> None:
    """Print the last temperature and the reasons of refused readings; exit status 1 where all were refused."""
    from app.summaries.campaign_extent import extent_record, led
    from app.summaries.thermometer import record, summary

    accepted = any(not stretch.reading.refused for stretch in stretches)
    by_laws = panel.law_sigma(stretches[-1].temperature) if accepted else math.inf
    output.result(lambda: record(stretches, by_laws, true, target) | extent_record(extent))
    for reason in sorted({stretch.reading.refused for stretch in stretches} - {""})[:3]:
        output.note(f"refused: {reason}")
    if not accepted:
        output.failure(f"none of {len(stretches)} stretches gives a temperature; {target}")
        raise click.exceptions.Exit(1)
    output.summary(f"{led(extent)}{summary(stretches, by_laws, true, target)}")


def _asked(drive: Path | None, response: Path | None, simulate: Path | None, temperature: str | None) -> None:
    if simulate is None and (drive is None or response is None):
        raise click.UsageError("name --drive and --response of a recording, or --simulate SOUND --temperature T")
    if simulate is not None and (drive is not None or response is not None):
        raise click.UsageError("--simulate takes the place of --drive and --response")
    if (simulate is None) != (temperature is None):
        raise click.UsageError("--simulate and --temperature belong together")


def _sensor(sent: "Shipment", sensor: str | None) -> int:
    """Index of the sensing patch; ResultFileError if there is none."""
    from app.files.bad_file import ResultFileError

    names = [patch.id for patch in sent.panel.patch]
    if len(names) < 2:
        raise ResultFileError(
            "a panel that is its own thermometer has two or more patches: one listens to the others"
        )
    if sensor is None:
        return len(names) - 1
    if sensor not in names:
        raise ResultFileError(f"--sensor {sensor}: no patch of this panel; allowed: {', '.join(names)}")
    return names.index(sensor)


def _signals(
    sent: "Shipment",
    panel: "ListeningPanel",
    files: tuple[Path | None, Path | None, Path | None],
    simulation: tuple[str | None, float, int],
    report: "Progress",
) -> tuple["PlayedSignals", "TemperatureProgramme | None"]:
    import numpy as np

    from app.commands.render import covered
    from app.files.sound_file import opened_sound
    from app.sound.played_signals import recorded, simulated
    from app.sound.temperatures import programme

    drive, response, sound = files
    temperature, snr, seed = simulation
    if sound is not None and temperature is not None:
        with opened_sound(sound, sent.filters.sample_rate) as opened:
            course = programme(temperature, opened.seconds)
            covered(sent, panel.laws, course)
            report("Simulated panel", 0.0)
            signals = simulated(opened, sent, panel, course, snr, np.random.default_rng(seed))
            report("Simulated panel", 1.0)
            return signals, course
    if drive is None or response is None:
        raise TypeError("neither a recording nor a simulation")  # excluded by _asked
    highest = sent.panel.filters.edges[1]
    with opened_sound(drive) as played, opened_sound(response) as measured:
        return recorded(played, measured, panel, sent.names, highest), None
