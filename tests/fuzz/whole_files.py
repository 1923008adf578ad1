"""One small, faultless file of every kind that is read, in the folders they are read from."""

import shutil
from pathlib import Path

import h5py
import numpy as np

from analysis.estimation.transfer import MeasuredTransfer
from analysis.updating.laws import fit_laws
from app.files import control, events
from app.files.campaign_folder import frozen_protocol, write_protocol
from app.files.campaign_toml import read_experiment
from app.files.experiment_toml import read_acquired_experiment
from app.files.frf_file import save_frf
from app.files.import_recording import import_recording
from app.files.latest_repeat import LatestRepeat, save_latest
from app.files.laws_file import TwinFrf, save_laws
from app.files.modes_file import save_modes
from app.files.readings import ReadingLine, append_reading
from app.files.twin_file import Basis, Estimated, TwinEffect, TwinFile, TwinLaws, TwinOrigin, write_twin
from app.files.uff58 import write_frfs
from tests.app.conftest import tiny_campaign
from tests.app.view.conftest import FREQUENCY, MADE, TEMPERATURE, experiment, frf, tracked, updated
from tests.fuzz.readers import EXPERIMENTS, PANELS, SWEEP

EXAMPLES = Path(__file__).resolve().parents[2] / "examples"


def write_all(root: Path) -> None:
    """Write a recording, its import, a campaign under way, a run, FRFs of others, and declarations."""
    tiny = tiny_campaign()
    tiny.toml = tiny.toml.replace("[10.0, 20.0, 30.0]", "[10.0]").replace('["up", "down"]', '["up"]')
    tiny.files = {"000.tdms": tiny.files["000.tdms"]}
    import_recording(tiny.write(root / "recording"), root / "imported")
    _write_old_sweep(root)
    _write_live(root / "live")
    _write_run(root / "run")
    _write_uff(root)
    _write_sound(root)
    _write_measurements(root / "measured")
    _write_twin(root / "twin.toml", root / "recording")
    for name in (*EXPERIMENTS, *PANELS):
        shutil.copy(EXAMPLES / name, root / name)


def _write_sound(root: Path) -> None:
    import soundfile

    samples = 0.1 * np.random.default_rng(2).standard_normal((2000, 2))
    soundfile.write(root / "sound.wav", samples, 8_000, subtype="FLOAT")
    soundfile.write(root / "sound.flac", samples, 8_000)
    (root / "readings.csv").write_text("time_s,temperature_c\n0,20\n2.5,21.5\n10,30\n", encoding="utf-8")


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
    control.wish(folder, "pause")
    count = 1 + len(recorded.outputs)
    names = ("drive", *(output.id for output in recorded.outputs))
    signals = np.random.default_rng(0).normal(size=(count, 400)).astype(np.float32)
    save_latest(folder, LatestRepeat(0, 1, "20 °C up", names, signals, np.zeros(count, bool), 8533.0, 5.0))


def _write_run(folder: Path) -> None:
    measured, found = frf(), updated()
    save_frf(folder / "frf.h5", experiment(), measured, MADE)
    save_modes(folder / "modes.h5", tracked(), MADE)
    laws = fit_laws(TEMPERATURE, found.material, found.sigma, temperature_range=(0.0, 40.0))
    save_laws(folder / "laws.h5", found, laws, TwinFrf(FREQUENCY, 1.01 * measured.h, 1e-4, 950.0), MADE)


def _write_uff(root: Path) -> None:
    import pyuff
    from pyuff.datasets.dataset_58 import prepare_58

    lines = np.arange(10.0, 60.0)
    rng = np.random.default_rng(1)
    h = rng.normal(size=(3, len(lines))) + 1j * rng.normal(size=(3, len(lines)))
    write_frfs(
        root / "frfs.uff",
        [
            MeasuredTransfer(f"point {n}", f"{n + 1}:+3", "9:+3", "acceleration", lines, one)
            for n, one in enumerate(h)
        ],
    )
    common = {"binary": 1, "func_type": 4, "rsp_dir": 3, "ref_node": 9, "ref_dir": 3, "abscissa_spacing": 1}
    common |= {"abscissa_spec_data_type": 18, "ordinate_spec_data_type": 12, "orddenom_spec_data_type": 13}
    common |= {"rsp_ent_name": "NONE", "ref_ent_name": "NONE", "x": lines, "id1": "door"}
    sets = [prepare_58(**common, rsp_node=n + 1, data=one) for n, one in enumerate(h)]
    pyuff.UFF(str(root / "binary.uff")).write_sets(sets, "add")


def _write_measurements(folder: Path) -> None:
    """One file of each format of other programs, and the declaration of a test."""
    import pyuff
    from nptdms import ChannelObject, RootObject, TdmsWriter
    from pyuff.datasets.dataset_58 import prepare_58
    from scipy.io import savemat, wavfile

    folder.mkdir()
    time = np.arange(100) / 1000.0
    force, acc = np.exp(-(((time - 0.02) / 0.002) ** 2)), np.sin(300 * time)
    table = np.column_stack([time, force, acc])
    np.savetxt(folder / "a.csv", table, delimiter=",", header="Time [s],Force [N],Acc [g]", comments="")
    savemat(folder / "a.mat", {"fs": 1000.0, "force": force, "test": {"acc": acc}})
    wavfile.write(folder / "a.wav", 1000, np.column_stack([force, acc]).astype("f4"))
    np.savez(folder / "a.npz", fs=1000.0, y=np.array([force, acc]))
    rows = "".join(f"\t{f:.6f}\t{a:.6f}\t\n" for f, a in zip(force, acc, strict=True))
    end = "***End_of_Header***\n"
    head = f"LabVIEW Measurement\nSeparator\tTab\n{end}Channels\t2\nDelta_X\t0.001\t0.001\n{end}"
    (folder / "a.lvm").write_text(f"{head}X_Value\tForce\tAcc\tComment\n{rows}", encoding="utf-8")
    with TdmsWriter(folder / "a.tdms") as writer:
        writer.write_segment(
            [RootObject({}), ChannelObject("Log", "Force", force), ChannelObject("Log", "Acc", acc)]
        )
    common = {"binary": 0, "func_type": 1, "rsp_dir": 3, "ref_node": 9, "ref_dir": 3, "abscissa_spacing": 1}
    common |= {"abscissa_spec_data_type": 17, "ordinate_spec_data_type": 12, "orddenom_spec_data_type": 0}
    common |= {"rsp_ent_name": "NONE", "ref_ent_name": "NONE", "x": time, "id1": "hit", "abscissa_inc": 0.001}
    sets = [prepare_58(**common, rsp_node=n + 1, data=one) for n, one in enumerate((force, acc))]
    pyuff.UFF(str(folder / "a.uff")).write_sets(sets, "add")
    (folder / "test.toml").write_text(
        'format = "flexura-test/1"\nkind = "hammer"\n[channels]\nTime = { role = "time" }\n'
        'Force = { role = "drive", unit = "N" }\nAcc = { role = "response", unit = "g", at = "2:+z" }\n'
        '[hammer]\ntrigger = 0.1\n[[record]]\nfile = "a.csv"\nat = { Force = "3:-x" }\n'
        "[points]\n2 = [0.0, 1.0, 0.0]\n",
        encoding="utf-8",
    )


def _write_twin(path: Path, campaign: Path) -> None:
    declared = read_experiment(campaign)
    parts = {name: getattr(declared, name) for name in type(declared).model_fields if name != "format"}
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
