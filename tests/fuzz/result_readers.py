"""Results of the verbs, and reduced models in the cache."""

from collections.abc import Callable
from pathlib import Path

from app.files.basis_cache import load_basis, load_plate_basis
from app.files.effect_cache import load_operators
from app.files.exports.shipment import shipment
from app.files.results.best_twin import gap_record_of
from app.files.results.gap_file import load_gap, load_signatures
from app.files.results.laws_file import effects_in_laws, laws_elsewhere, load_laws, load_updated
from app.files.results.modes_file import load_frf, load_modes
from app.files.results.panel_files import (
    load_compensation,
    load_focusing,
    load_method,
    load_panel,
    load_radiation,
    load_studies,
    load_uncorrected,
    made_from_transfers,
)
from app.modal_test.modes_of_test import load_frfs, load_stabilization
from app.report.summary import stamps
from tests.fuzz.hdf5_edits import edited
from tests.fuzz.measurement_readers import FILTERS
from tests.fuzz.reader import Reader

Read = Callable[[Path], object]
RUN: dict[str, Read] = {
    "run/frf.h5": load_frf,
    "run/modes.h5": load_modes,
    "run/laws.h5": lambda path: (load_laws(path), load_updated(path), effects_in_laws(path)),
    "run/gap.h5": lambda path: (load_gap(path), load_signatures(path)),
}
FOCUSED: dict[str, Read] = {
    FILTERS: lambda path: (
        load_focusing(path),
        load_uncorrected(path),
        load_method(path),
        load_panel(path),
        made_from_transfers(path),
        shipment(path.parent, "linear", "export"),
    ),
    "panel/compensation.h5": lambda path: (load_compensation(path), shipment(path.parent, None, "export")),
    "panel/radiation.h5": load_radiation,
    "panel/studies.h5": load_studies,
}
TESTED: dict[str, Read] = {"test/transfers.h5": load_frfs, "test/stabilization.h5": load_stabilization}
CACHED: dict[str, Read] = {
    "cache/basis.h5": load_basis,
    "cache/plate-basis.h5": load_plate_basis,
    "cache/effects.h5": load_operators,
}


def _cached(root: Path, name: str) -> object:
    return CACHED[name](root / name)


def _result(root: Path, name: str) -> object:
    return (RUN | FOCUSED | TESTED)[name](root / name), stamps((root / name).parent, [Path(name).name])


RESULTS = (
    Reader("HDF5, results", tuple(RUN), _result, 0.09, digest=True),
    Reader("gap.json", ("run/gap.json",), lambda root, name: gap_record_of((root / name).parent), 0.01, text=True),
    Reader("laws.json", ("apart/laws.json",), lambda root, _: laws_elsewhere(root / "apart"), 0.005, text=True),
    Reader("HDF5, results of a panel", tuple(FOCUSED), _result, 0.025, digest=True),
    Reader("HDF5, results of a test", tuple(TESTED), _result, 0.015, digest=True),
    Reader("HDF5, edited and sealed", (*RUN, *FOCUSED, *TESTED), _result, 0.015, damage=edited),
    Reader("cache", tuple(CACHED), _cached, 0.01, digest=True),
    Reader(
        "cache, edited and sealed",
        tuple(CACHED),
        _cached,
        0.005,
        damage=edited,
    ),
)
