"""A faultless file of every format of other programs: signals, FRFs, transfers of a panel, sounds, tables."""

from pathlib import Path

import h5py
import numpy as np

from analysis.estimation.transfer import MeasuredTransfer
from analysis.focusing.measured import MeasuredTransfers
from app.files.results.transfers_file import write_transfers
from app.files.sound_file import create_wav
from app.files.uff.frfs import write_frfs


def write_measurements(root: Path) -> None:
    """Write them beside the panel of `tests.fuzz.whole_results`, whose transfers some are."""
    _write_uff(root)
    _write_sound(root)
    _write_measurements(root / "measured")
    _write_transfers(root / "panel")


def _write_sound(root: Path) -> None:
    """Write sounds, one recording of four patches of which the last listens, and temperatures."""
    import soundfile

    samples = 0.1 * np.random.default_rng(2).standard_normal((2000, 2))
    soundfile.write(root / "sound.wav", samples, 8_000, subtype="FLOAT")
    soundfile.write(root / "sound.flac", samples, 8_000)
    (root / "readings.csv").write_text("time_s,temperature_c\n0,20\n2.5,21.5\n10,30\n", encoding="utf-8")
    (root / "heard").mkdir()
    for name, count in (("drive", 3), ("response", 1)):
        heard = np.zeros((count + (name == "drive"), 600))
        heard[:count] = 0.5 * np.random.default_rng(count).standard_normal((count, 600))
        with create_wav(root / "heard" / f"{name}.wav", 4000.0, len(heard), 600, "fuzz") as file:
            file.write(heard)


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


def _write_transfers(folder: Path) -> None:
    """Write transfers of four actuators to twelve points: as HDF5 of ours and of others, and as UFF with nodes."""
    import pyuff

    x, y = np.meshgrid([0.06, 0.12, 0.2, 0.33], [0.07, 0.15, 0.23])
    points, lines = np.column_stack([x.ravel(), y.ravel()]), np.arange(50.0, 371.0, 10.0)
    rng = np.random.default_rng(3)
    h = 1e-6 * (rng.normal(size=(1, 4, len(lines), 12)) + 1j * rng.normal(size=(1, 4, len(lines), 12)))
    held = MeasuredTransfers(np.array([20.0]), points, lines, h, np.full(h.shape, 1e-16))
    write_transfers(folder / "scan.h5", held)
    with h5py.File(folder / "others.h5", "w") as file:
        for name in ("points", "frequency"):
            file[name] = getattr(held, name)
        file["temperature"] = 20.0
        file.create_dataset("transfer", data=h[0], compression="gzip", chunks=(1, len(lines), 12))
    ends = [(node, actuator) for actuator in range(4) for node in range(12)]
    write_frfs(
        folder / "scan.uff",
        [
            MeasuredTransfer(f"{node}", f"{node + 1}:+3", f"{91 + k}:+3", "displacement", lines, h[0, k, :, node])
            for node, k in ends
        ],
    )
    none = np.zeros(12, dtype=int)
    nodes = pyuff.prepare_2411(np.arange(1, 13), none, none, none, *points.T, np.zeros(12))
    pyuff.UFF(str(folder / "scan.uff")).write_sets(nodes | {"type": 2411}, "add")


def _write_with_extras(folder: Path, time: np.ndarray, force: np.ndarray, acc: np.ndarray) -> None:
    """Write a workbook and a vehicle recorder's file."""
    import asammdf
    import openpyxl

    book = openpyxl.Workbook()
    book.active.append(["Time [s]", "Force [N]", "Acc [g]"])
    for row in zip(time.tolist(), force.tolist(), acc.tolist(), strict=True):
        book.active.append(row)
    book.save(folder / "a.xlsx")
    with asammdf.MDF(version="4.10") as file:
        signals = (("Force", force, "N"), ("Acc", acc, "g"))
        file.append([asammdf.Signal(values, time, name=name, unit=unit) for name, values, unit in signals])
        file.save(folder / "a.mf4", overwrite=True)


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
    _write_containers(folder, time, force, acc)
    _write_with_extras(folder, time, force, acc)
    text = (folder / "a.uff").read_text(encoding="utf-8")
    (folder / "a.D.uff").write_text(text.replace("e-", "D-").replace("e+", "D+"), encoding="utf-8")
    (folder / "test.toml").write_text(
        'format = "flexura-test/1"\nkind = "hammer"\n[channels]\nTime = { role = "time" }\n'
        'Force = { role = "drive", unit = "N" }\nAcc = { role = "response", unit = "g", at = "2:+z" }\n'
        '[hammer]\ntrigger = 0.1\n[[record]]\nfile = "a.csv"\nat = { Force = "3:-x" }\n'
        "[points]\n2 = [0.0, 1.0, 0.0]\n",
        encoding="utf-8",
    )
    (folder / "points.csv").write_text("node,x,y,z\n1,0.0,0.0,0.0\n2,0.1,0.05,0.0\n3,0.2,0.1,0.002\n", "utf-8")


def _write_containers(folder: Path, time: np.ndarray, force: np.ndarray, acc: np.ndarray) -> None:
    """HDF5 with attributes, netCDF of both versions, a list of structures of MATLAB, FRFs of SDynPy."""
    from scipy.io import netcdf_file

    texts = h5py.string_dtype()
    with h5py.File(folder / "a.h5", "w") as file:
        file["time"], file["test/acc"] = time, np.array([acc, force])
        file["time"].make_scale("time")
        file["test/acc"].dims[1].attach_scale(file["time"])
        file["test/acc"].attrs.update({"units": "g", "fs": 1000.0})
    with netcdf_file(folder / "a.nc", "w") as file:
        file.createDimension("time", len(time))
        held = file.createVariable("force", "d", ("time",))
        held[:], held.units = force, "N"
    with h5py.File(folder / "a.nc4", "w") as file:
        file.attrs["sample_rate"] = 1000.0
        file["time_data"] = np.array([force, acc])
        table = {"node_number": ["1", "2"], "node_direction": ["Z+", "X-"], "unit": ["N", "g"]}
        for key, column in table.items():
            file[f"channels/{key}"] = np.array(column, dtype=texts)
    with h5py.File(folder / "a.v73.mat", "w", userblock_size=512) as file:
        for key, values in (("force", force), ("acc", acc)):
            parts = [file.create_dataset(f"#refs#/{key}{n}", data=values[:, None]).ref for n in range(2)]
            file[f"run/{key}"] = np.array(parts, dtype=h5py.ref_dtype)
    ends = [("node", "<u8"), ("direction", "i1")]
    kind = [("abscissa", "<f8", (40,)), ("ordinate", "<c16", (40,)), ("coordinate", ends, (2,))]
    data = np.zeros(2, dtype=kind)
    data["abscissa"], data["ordinate"], data["coordinate"]["node"] = np.arange(1.0, 41.0), 1j, 3
    np.savez(folder / "a.sdynpy.npz", data=data, function_type=4)
