"""Reduced models kept between runs: whole, checked, and made again where they are not."""

import h5py
import numpy as np
import pytest

import simulation.reduction.plate_basis
from analysis.experiment import Patch, Plate
from analysis.material import MaterialBox
from app.files.basis_cache import ARRAYS, cache_folder, cached_reduction, load_basis, save_basis, told_unkept
from app.files.hdf5_file import BLOCK, sealed
from simulation.meshing.plate_mesh import MeshRecipe
from simulation.reduction.reduced_model import ReducedModel
from simulation.shell.fineness import Fineness

PLATE = Plate(length_x=0.12, length_y=0.1, thickness=0.003, mass=0.0342)
PATCHES = [Patch(id="A", role="actuator", center=(0.05, 0.05), size=(0.02, 0.02), thickness=0.0005)]
BOX, BAND = MaterialBox((2e9, 2.2e9), (0.37, 0.38), (0.05, 0.06)), (100.0, 400.0)
COARSE = Fineness(MeshRecipe(spacing=0.08, grading=0.0, pieces=1), degree=4, tolerance=1e-6)


def model(size=6, points=2):
    rng = np.random.default_rng(0)
    k = rng.standard_normal((3, size, size))
    return ReducedModel(
        *(k + k.transpose(0, 2, 1)),
        coupling=rng.standard_normal((size, 3)),
        capacitance=rng.uniform(1e-9, 9e-9, 3),
        box=BOX,
        band=BAND,
        error=3.2e-5,
        dashpots=rng.standard_normal((size, 2)),
        deflection=rng.standard_normal((points, size)),
        points=rng.uniform(0, 0.1, (points, 2)),
        footprints=rng.standard_normal((points, size)),
    )


def same(a, b):
    arrays = all(np.array_equal(getattr(a, name), getattr(b, name)) for name in ARRAYS)
    return arrays and (a.box, a.band, a.error) == (b.box, b.band, b.error)


@pytest.mark.parametrize("points", [0, 2])
def test_round_trip(tmp_path, points):
    file = tmp_path / "basis.h5"
    save_basis(file, model(points=points))
    assert same(load_basis(file), model(points=points))


def test_missing_is_none(tmp_path):
    assert load_basis(tmp_path / "basis.h5") is None


@pytest.mark.parametrize("share", [0.0, 0.3, 0.9])
def test_cut_short_is_none(tmp_path, share):
    file = tmp_path / "basis.h5"
    save_basis(file, model())
    file.write_bytes(file.read_bytes()[: int(share * file.stat().st_size)])
    assert load_basis(file) is None


@pytest.mark.parametrize("name", ARRAYS)
def test_a_changed_number_is_noticed(tmp_path, name):
    file = tmp_path / "basis.h5"
    save_basis(file, model())
    with h5py.File(file, "r+") as stored:
        stored[name][(0,) * stored[name].ndim] += 1e-9
    assert load_basis(file) is None


@pytest.mark.parametrize("name", ["error", "band", "youngs_modulus", "loss_factor"])
def test_a_changed_promise_is_noticed(tmp_path, name):
    file = tmp_path / "basis.h5"
    save_basis(file, model())
    with h5py.File(file, "r+") as stored:
        stored.attrs[name] = np.asarray(stored.attrs[name]) * 1.01
    assert load_basis(file) is None


def test_a_missing_array_or_another_format_is_none(tmp_path):
    for spoil in (lambda f: f.pop("coupling"), lambda f: f.attrs.update(format="flexura-basis/0")):
        file = tmp_path / "basis.h5"
        save_basis(file, model())
        with h5py.File(file, "r+") as stored:
            spoil(stored)
        file.write_bytes(b"".join(sealed(file.read_bytes()[BLOCK:])))
        assert load_basis(file) is None


def test_folder_follows_the_environment(tmp_path, monkeypatch):
    monkeypatch.setenv("FLEXURA_CACHE", str(tmp_path / "here"))
    assert cache_folder() == tmp_path / "here"
    monkeypatch.delenv("FLEXURA_CACHE")
    assert cache_folder().name == "flexura"


def test_second_time_is_read_and_a_damaged_file_made_again(tmp_path, monkeypatch):
    monkeypatch.setenv("FLEXURA_CACHE", str(tmp_path))
    made = []
    true_reduce = simulation.reduction.plate_basis.reduce

    def counted(*args, **kwargs):
        made.append(1)
        return true_reduce(*args, **kwargs)

    monkeypatch.setattr(simulation.reduction.plate_basis, "reduce", counted)
    first = cached_reduction(PLATE, PATCHES, BOX, BAND, points=[(0.06, 0.05)], fineness=COARSE)
    assert same(cached_reduction(PLATE, PATCHES, BOX, BAND, points=[(0.06, 0.05)], fineness=COARSE), first)
    assert len(made) == 1
    (file,) = tmp_path.glob("basis-*.h5")
    file.write_bytes(file.read_bytes()[:1000])
    again = cached_reduction(PLATE, PATCHES, BOX, BAND, points=[(0.06, 0.05)], fineness=COARSE)
    assert len(made) == 2
    assert np.allclose(
        again.compliance(2.1e9, 0.375, 0.055, [200.0]), first.compliance(2.1e9, 0.375, 0.055, [200.0])
    )
    assert [p.name for p in tmp_path.iterdir()] == [file.name]
    cached_reduction(PLATE, PATCHES, BOX, BAND, fineness=COARSE)
    assert len(made) == 3


def test_a_cache_that_cannot_be_written_is_told_once_with_the_way_on(tmp_path, caplog):
    for _ in range(2):
        told_unkept(str(tmp_path / "basis-1.h5"), "cannot be written (Permission denied)")
    assert [record.getMessage() for record in caplog.records] == [
        f"note: {tmp_path / 'basis-1.h5'}: cannot be written (Permission denied); the model is built again "
        "next time (FLEXURA_CACHE=FOLDER keeps models elsewhere)"
    ]
