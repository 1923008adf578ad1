"""One small, faultless file of every kind that is read, in the folders they are read from."""

import re
import shutil
from dataclasses import replace
from pathlib import Path

import h5py
import numpy as np
from nptdms import ChannelObject, TdmsWriter

from analysis.recordings.frf import campaign_frf
from app.blind_trial.trial import begin
from app.files.acquisition import events
from app.files.acquisition.events import LatestRepeat, ReadingLine, append_reading, save_latest
from app.files.acquisition.hammer_folder import open_hammer_folder
from app.files.atomic import write_json
from app.files.campaigns.channels import read_experiment
from app.files.campaigns.export import export_frfs
from app.files.campaigns.folder import Source, frozen_protocol, write_protocol
from app.files.campaigns.import_recording import import_recording
from app.files.campaigns.recorded import read_recorded_campaign
from app.files.declarations.experiment import read_acquired_experiment
from app.files.declarations.hammer_experiment import read_hammer_experiment
from app.files.results.twin_file import Basis, Estimated, TwinEffect, TwinFile, TwinLaws, TwinOrigin, write_twin
from drivers.hammer.judged_hit import HitJudge, HitTemperature, KeptHit
from tests.app.conftest import RATE, TinyCampaign, tiny_campaign
from tests.fuzz.campaign_readers import EXPERIMENTS, HAMMERS, INSTRUMENTS, PANELS, SWEEP, TRIAL, WEATHERS
from tests.fuzz.whole_geometry import write_geometry
from tests.fuzz.whole_measurements import write_measurements
from tests.fuzz.whole_results import write_results

EXAMPLES = Path(__file__).resolve().parents[2] / "examples"


def write_all(root: Path) -> None:
    """Write a recording, its import, a campaign under way, declarations, then results and files of others."""
    tiny = tiny_campaign()
    tiny.toml = tiny.toml.replace("[10.0, 20.0, 30.0]", "[10.0]").replace('["up", "down"]', '["up"]')
    tiny.files = {"000.tdms": tiny.files["000.tdms"]}
    import_recording(tiny.write(root / "recording"), root / "imported")
    _write_plates(root)
    _write_recorder(tiny, root / "recorder")
    _write_old_sweep(root)
    _write_live(root / "live")
    _write_instruments(root / "instruments")
    _write_trial(root)
    (root / "fleet.txt").write_text("recording  # of June\nimported\n", encoding="utf-8")
    (root / "scheduler.json").write_text(
        '{"type": "Scheduler", "address": "tcp://10.0.0.1:8786"}', encoding="utf-8"
    )
    _write_twin(root / "twin.toml", root / "recording")
    for name in (*EXPERIMENTS, *HAMMERS, *PANELS, *WEATHERS):
        shutil.copy(EXAMPLES / name, root / name)
    _write_hits(root)
    write_results(root)
    write_measurements(root)
    write_geometry(root / "drawn")


def _write_hits(root: Path) -> None:
    """Write a hammer test of one hit, and a log in which another was undone and a point skipped."""
    declared = read_hammer_experiment(root / HAMMERS[0])
    judge = HitJudge(declared.hammer.test(), declared.volts, declared.channels, 5.0)
    acquired = declared.model_dump(mode="json") | {"rig": "simulated"}
    folder = open_hammer_folder(root / "hammered", declared, acquired, Source("mine.toml", "0" * 64), judge)
    rate = 51200.0 / 15
    time = np.arange(round(1.7 * rate)) / rate
    force = 20.0 * np.exp(-(((time - 0.11) / 5e-4) ** 2))
    hit = judge.judge_measured(force, 3.0 * np.gradient(force)[None], rate)
    folder.keep(hit, KeptHit(0, 0, 0), HitTemperature(21.0, "drifts"), "2026-11-27T10:00:00+00:00")
    for event in (
        {"event": "hit", "step": 0, "set_point": 0, "point": 0, "time": 1.0},
        {"event": "hit rejected", "step": 1, "set_point": 0, "point": 0, "time": 2.0, "why": "double hit"},
        {"event": "hit undone", "step": 2, "set_point": 0, "point": 0, "time": 3.0},
        {"event": "point skipped", "set_point": 0, "point": 1, "time": 4.0},
        {"event": "temperature in doubt", "step": 0, "what": ["drifts"], "time": 5.0},
    ):
        folder.log(event)


def _write_plates(root: Path) -> None:
    """Write the recording's FRFs as another program has them, and a table of modes, each with its plate."""
    campaign = read_recorded_campaign(root / "recording")
    declared = (root / "recording" / "campaign.toml").read_text(encoding="utf-8")
    declared = declared.replace("recorded-campaign/1", "flexura-plate/1")
    parts = {"plate": 'frf]]\nfile = "frfs.uff"\naverages = 2', "modal": 'modes]]\nfile = "modes.csv"'}
    for name, part in parts.items():
        (root / name).mkdir()
        (root / name / "plate.toml").write_text(f"{declared}\n[[{part}\n", encoding="utf-8")
    export_frfs(root / "plate" / "frfs.uff", campaign.experiment, campaign_frf(campaign))
    rows = ["temperature [°C], frequency [Hz], damping [%], mode", "20.0, 117.3, 2.1, 1", "20.0, 151.0, 1.9, 3"]
    (root / "modal" / "modes.csv").write_text("\n".join(rows) + "\n", encoding="utf-8")


def _write_recorder(tiny: TinyCampaign, folder: Path) -> None:
    """Write a campaign as a recorder leaves it: repeats one after the other, channels and sweeps declared."""
    names = {"drive": "ai0", "S1": "ai1", "S2": "ai2"}
    (folder / "sweeps").mkdir(parents=True)
    file = tiny.files["000.tdms"]
    wave = {"wf_increment": 1.0 / RATE}
    volts = {
        theirs: np.concatenate([repeat[ours] for repeat in file.groups.values()]) for ours, theirs in names.items()
    }
    with TdmsWriter(folder / "sweeps/log.tdms") as writer:
        writer.write_segment([ChannelObject("Log", theirs, one, wave) for theirs, one in volts.items()])
    (folder / "campaign.toml").write_text(
        f'{tiny.toml}\n[channels]\nai0 = {{ role = "drive", unit = "V" }}\n'
        'ai1 = { role = "response", at = "S1", unit = "mV", sensitivity = "1 mV/V" }\n'
        'ai2 = { role = "response", at = "S2", unit = "V" }\nRoom = { role = "unused" }\n'
        '[sweeps]\n"log.tdms" = { temperature = [9.97, 10.02], level = 1.0, start_time = "2024-03-11" }\n',
        encoding="utf-8",
    )


def _write_old_sweep(root: Path) -> None:
    """Write the imported campaign as versions did that sealed no file."""
    shutil.copytree(root / "imported", root / "old")
    (root / "old" / SWEEP).unlink()
    with h5py.File(root / "imported" / SWEEP) as source, h5py.File(root / "old" / SWEEP, "w") as target:
        for name in source:
            source.copy(name, target)
        for name, value in source.attrs.items():
            target.attrs[name] = value


def _write_live(folder: Path) -> None:
    declared = read_acquired_experiment(EXAMPLES / "simulated-rig.toml")
    recorded = declared.recorded(declared.sample_rate)
    folder.mkdir()
    acquired = declared.model_dump(mode="json")
    write_protocol(folder, frozen_protocol("live", recorded, {"a.toml": "00" * 32}, acquired))
    date = "2026-01-05T08:00:0{}+00:00"
    for n, event in enumerate(
        (
            {"event": "begun", "leg": 0},
            {"event": "oven", "command": "ramp", "target": 30.0, "rate": 0.5, "purpose": "to the start"},
            {"event": "finished", "step": 0, "temperature": 20.1, "attempts": 1},
            {"event": "rejected", "step": 1, "why": ["clipped"]},
            {"event": "paused"},
            {"event": "continued"},
            {"event": "missed", "step": 2, "place": "24 °C up 1 V"},
            {"event": "oven", "command": "safe", "purpose": "the end"},
        )
    ):
        events.append_event(folder, event | {"time": float(n), "date": date.format(n)})
        append_reading(folder, ReadingLine(date.format(n), 20.0 + n, 19.5 + n, "to the start", n, 40, 900.0))
    events.request(folder, "pause")
    count = 1 + len(recorded.outputs)
    names = ("drive", *(output.id for output in recorded.outputs))
    signals = np.random.default_rng(0).normal(size=(count, 400)).astype(np.float32)
    save_latest(folder, LatestRepeat(0, 1, "20 °C up", names, signals, np.zeros(count, bool), 8533.0, 5.0))


def _write_twin(path: Path, campaign: Path) -> None:
    declared = read_experiment(campaign)
    parts = {
        name: getattr(declared, name)
        for name in TwinFile.model_fields
        if hasattr(declared, name) and name != "format"
    }
    few = (1e-5, 1e-5, 1e-5)
    laws = {"youngs_modulus": (3.2e9, 2.8e9, 2.3e9), "poisson_ratio": (0.34, 0.35, 0.37)}
    laws |= {"loss_factor": (0.05, 0.07, 0.08), "temperature": (0.0, 10.0, 20.0)}
    sigmas = {f"sigma_{name}": few for name in ("youngs_modulus", "poisson_ratio", "loss_factor")}
    effect = TwinEffect(name="point_mass", parameter={"mass": Estimated(value=8e-4, sigma=1e-5, unit="kg")})
    twin = TwinFile(
        **parts,
        gain=Estimated(value=16.5, sigma=0.001, unit="V/V"),
        laws=TwinLaws.model_validate(laws | sigmas | {"temperature_range": (0.0, 20.0)}),
        effect=(effect,),
        basis=Basis(operators="ab" * 32, error=1e-4),
        origin=TwinOrigin(flexura="0.1.0", campaign="pp", inputs="cd" * 32, verdict="explained"),
    )
    write_twin(path, twin)


def _write_instruments(folder: Path) -> None:
    """Take the declarations of the guide: an oven by its registers; an oven and a thermometer of text."""
    guide = Path(__file__).resolve().parents[2] / "docs/guide/bring-your-own-instrument.md"
    registers, text, thermometer = re.findall(r"```toml\n(.*?)```", guide.read_text(encoding="utf-8"), re.DOTALL)[
        :3
    ]
    folder.mkdir()
    for name, declared in zip(INSTRUMENTS, (registers, f"{text}\n{thermometer}"), strict=True):
        (folder.parent / name).write_text(declared, encoding="utf-8")


def _write_trial(root: Path) -> None:
    """Write a blind trial of two campaigns, one with an effect, as far as its proof reads it."""
    trial = replace(TRIAL, folder=root / TRIAL.folder)
    begin(trial)
    mass = {"name": "point_mass", "equivalent": [], "probability": 0.98, "against": {"nothing": 900.0}}
    mass |= {"parameters": {"mass": {"value": 1.2e-3, "sigma": 2e-5, "unit": "kg"}}}
    for assignment in trial.assignments:
        hidden = assignment.kind == "single"
        truth = {"number": assignment.number, "kind": assignment.kind, "cosine": None, "ablated": None}
        truth |= {"effects": {"point_mass": {"mass": 1.2e-3, "x": 0.1, "y": 0.05}} if hidden else {}}
        truth |= {"prior_sigma": {"point_mass": {"mass": 1e-3}} if hidden else {}, "imitations": {}}
        truth |= {"size_sigma": {"point_mass": 80.0} if hidden else {}, "legs": ["up", "down"], "scatter": 0.003}
        laws = {"youngs_modulus": [2e9] * 4, "poisson_ratio": [0.38] * 4, "loss_factor": [0.06] * 4}
        truth |= {"laws": {"temperature": [0.0, 20.0, 40.0, 60.0], **laws}}
        write_json(trial.truth(assignment), truth)
        gap = {"held_out": {"closure": 0.93 if hidden else 0.0}, "held_out_also": [{"closure": 0.9}]}
        verdict = {"verdict": "explained" if hidden else "none", "effects": [mass] if hidden else [], "gap": gap}
        names = ("youngs_modulus_pa", "poisson_ratio", "loss_factor")
        final = {name: [1.0, 1.0] for one in names for name in (one, f"sigma_{one}")}
        verdict |= {"laws": {"final": {"temperature_c": [10.0, 30.0], **final}}}
        write_json(
            trial.run(assignment) / "gap.json", verdict | {"not_observable": ["high_pass"], "seconds": 31.0}
        )
