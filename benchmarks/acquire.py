"""A simulated campaign of 31 temperatures and three hours: how long it takes, and whether it is right.

    python benchmarks/acquire.py [--long]

The plain way of taking a campaign is to wait for it. The rig's virtual clock waits for nobody, through the same
drivers: nidaqmx calls to the simulated device server, Modbus frames to the simulated controller, one file for
every sweep forced to the disk. The laws that were put in are identified from the files and compared. The same
campaign with the server behind a loopback port must give the same sweeps.

With --long a campaign of ten times the duration and sweeps is run as well; the memory in use must not grow.
"""

import argparse
import json
import platform
import tempfile
import time
from pathlib import Path

import numpy as np
from threadpoolctl import threadpool_limits

from analysis.recordings.frf import campaign_frf
from analysis.updating.update import update
from app.files.acquisition.campaign_folder import campaign_log
from app.files.campaigns.folder import Source, digest
from app.files.campaigns.loading import load_campaign
from app.files.declarations.experiment import AcquiredExperiment, read_acquired_experiment
from app.rig.assembly import rig_of
from app.stages.acquire import acquire_campaign
from app.terminal.progress import progress
from app.twins.campaign_twin import campaign_twin
from drivers.rig.campaign import Moment
from drivers.rig.session import Session

ROOT = Path(__file__).resolve().parents[1]
EXAMPLE = ROOT / "examples" / "simulated-rig.toml"


def three_hours(*, served: bool = False, **changes: float) -> AcquiredExperiment:
    """Return the shipped simulated experiment with the paper's programme, or a change of it."""
    example = read_acquired_experiment(EXAMPLE)
    if example.simulation is None:
        raise SystemExit("the example simulates nothing")
    paper = {"every": 2.0, "ramp_rate": 0.4, "lead": 2.0, "soak_before": 600.0, "approach_rate": 3.0}
    return example.model_copy(
        update={
            "programme": example.programme.model_copy(update={**paper, **changes}),
            "simulation": example.simulation.model_copy(update={"served": served}),
        }
    )


def acquire(experiment: AcquiredExperiment, folder: Path) -> dict[str, float]:
    """Run a campaign into `folder`; wall and virtual seconds, sweeps, growth of the memory in use."""
    source, acquired = Source(EXAMPLE.name, "0" * 64), experiment.model_dump(mode="json")
    memory: list[tuple[int, float]] = []

    def look(moment: Moment) -> None:
        if not memory or moment.done != memory[-1][0]:
            memory.append((moment.done, resident()))

    with progress() as report, rig_of(experiment, "simulated", EXAMPLE, report) as rig:
        session = Session(rig, experiment.limits, campaign_log(folder))
        started = time.perf_counter()
        outcome = acquire_campaign(session, experiment, folder, source, acquired, look)
        seconds = time.perf_counter() - started
    if outcome.missing or session.unsafe:
        raise SystemExit(f"the campaign is not whole: {outcome}")
    tenth = max(1, len(memory) // 10)
    return {
        "sweeps": outcome.finished,
        "seconds": seconds,
        "virtual_seconds": rig.clock.now(),
        "memory_after_a_tenth_mb": memory[tenth][1] / 1e6,
        "memory_at_the_end_mb": memory[-1][1] / 1e6,
    }


def resident() -> float:
    """Memory in use now, bytes; NaN where the system does not say."""
    try:
        pages = int(Path("/proc/self/statm").read_text(encoding="ascii").split()[1])
    except OSError:
        return float("nan")
    return 4096.0 * pages


def errors(experiment: AcquiredExperiment, folder: Path) -> dict[str, float]:
    """Largest distance of the identified constants from those put in, over all temperatures."""
    campaign = load_campaign(folder)
    frf = campaign_frf(campaign)
    with progress() as report:
        found = update(frf, campaign_twin(campaign.experiment, report))
    if experiment.simulation is None:
        raise SystemExit("the experiment simulates nothing")
    truth = experiment.simulation.laws.laws().at(frf.temperature)
    return {
        "youngs_modulus_percent": 100 * _largest(found.material.youngs_modulus / truth.youngs_modulus - 1.0),
        "poisson_ratio": _largest(found.material.poisson_ratio - truth.poisson_ratio),
        "loss_factor_percent": 100 * _largest(found.material.loss_factor / truth.loss_factor - 1.0),
        "gain_percent": 100 * abs(found.gain / float(experiment.simulation.gain or np.nan) - 1.0),
    }


def digests(folder: Path) -> list[str]:
    """Of every sweep's samples, times and temperatures."""
    return [digest(sweep) for sweep in load_campaign(folder).sweeps]


def _largest(values: np.ndarray) -> float:
    return float(np.abs(values).max())


def main() -> None:
    """Run, compare, print and write the figures."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--long", action="store_true", help="ten times the duration and the sweeps, too")
    given = parser.parse_args()
    result: dict[str, object] = {"machine": platform.processor() or platform.machine()}
    with threadpool_limits(1), tempfile.TemporaryDirectory() as scratch:
        experiment = three_hours()
        figures = acquire(experiment, Path(scratch) / "campaign")
        wrong = errors(experiment, Path(scratch) / "campaign")
        ratio = figures["virtual_seconds"] / figures["seconds"]
        result |= {"campaign": figures, "ratio": ratio, "errors": wrong}
        print(
            f"{figures['sweeps']:.0f} sweeps, {figures['virtual_seconds'] / 3600:.2f} h of virtual time in "
            f"{figures['seconds']:.1f} s: {ratio:.0f} times as fast as waiting"
        )
        print(
            f"identified against put in: E {wrong['youngs_modulus_percent']:.3f} %, "
            f"nu {wrong['poisson_ratio']:.5f}, eta {wrong['loss_factor_percent']:.3f} %, "
            f"gain {wrong['gain_percent']:.3f} %"
        )
        result["over_a_port"] = outside = acquire(three_hours(served=True), Path(scratch) / "served")
        if digests(Path(scratch) / "served") != digests(Path(scratch) / "campaign"):
            raise SystemExit("the sweeps over the port are others")
        print(f"over a loopback port in {outside['seconds']:.1f} s, the same sweeps to the last bit")
        if given.long:
            long = acquire(three_hours(ramp_rate=0.04, every=0.2, tolerance=0.08), Path(scratch) / "long")
            result["ten_times_longer"] = long
            print(
                f"{long['sweeps']:.0f} sweeps, {long['virtual_seconds'] / 3600:.1f} h in {long['seconds']:.1f} s; "
                f"memory {long['memory_after_a_tenth_mb']:.0f} MB after a tenth, "
                f"{long['memory_at_the_end_mb']:.0f} MB at the end"
            )
            if long["memory_at_the_end_mb"] > 1.1 * long["memory_after_a_tenth_mb"]:
                raise SystemExit("the memory in use grows with the campaign")
    out = ROOT / "benchmarks" / "results" / "acquire.json"
    out.parent.mkdir(exist_ok=True)
    out.write_text(json.dumps(result, indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
