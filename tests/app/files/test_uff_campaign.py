"""FRFs of a campaign in a universal file: what another program reads of them."""

from pathlib import Path

import numpy as np
import pyuff

from analysis.experiment import Experiment
from analysis.recordings.frf import Frf
from app.files.campaigns.export import campaign_frfs, campaign_points
from app.files.uff.frfs import read_frfs, write_frfs
from app.files.uff.geometry import read_nodes

FREQUENCY = 100.0 + 0.5 * np.arange(40)


def declared() -> Experiment:
    return Experiment.model_validate(
        {
            "title": "any",
            "plate": {"length_x": 0.24, "length_y": 0.19, "thickness": 0.003, "mass": 0.13},
            "patch": [
                {"id": "S1", "role": "sensor", "center": (0.04, 0.035), "size": (0.02, 0.02), "thickness": 5e-4}
            ],
            "drive": [{"id": "hammer", "point": (0.12, 0.1)}],
            "sensor": [{"id": "acc", "kind": "acceleration", "point": (0.2, 0.1), "side": "bottom"}],
            "acquisition": {
                "module": "NI-9234",
                "sample_rate": 8e3,
                "input_resistance": 3e5,
                "input_capacitance": 1e-10,
            },
            "protocol": {
                "sweep": "linear",
                "band": (100.0, 700.0),
                "sweep_duration": 1.0,
                "tail": 0.1,
                "repeats": 2,
                "ramp_rate": 0.4,
                "temperatures": (20.0, 30.0),
                "directions": ("up",),
                "levels": (2.0,),
            },
            "oven": {"room_temperature": 22.0},
        }
    )


def test_nodes_directions_quantities_and_units(tmp_path: Path) -> None:
    rng, shape = np.random.default_rng(0), (2, 2, 40)
    h = rng.normal(size=shape) + 1j * rng.normal(size=shape)
    ones = np.ones(shape)
    frf = Frf(
        temperature=np.array([20.0, 30.0]),
        direction=("up", "up"),
        level=np.array([2.0, 2.0]),
        frequency=FREQUENCY,
        h=h,
        variance=ones,
        coherence=ones,
        excluded=np.zeros(40, bool),
        channels=("S1", "acc"),
        level_units=("V",),
    )
    path = tmp_path / "frfs.uff"
    write_frfs(path, campaign_frfs(declared(), frf), campaign_points(declared()))
    found = read_frfs(path)
    assert [one.name for one in found[:2]] == [
        "S1/hammer [V/N] 20.00 C up 2 V",
        "acc/hammer [m/s2/N] 20.00 C up 2 V",
    ]
    assert [(one.response, one.reference) for one in found[2:]] == [("1:+0", "3:-3"), ("2:-3", "3:-3")]
    assert [(one.quantity, one.reference_quantity) for one in found[:2]] == [
        ("unknown", "force"),
        ("acceleration", "force"),
    ]
    assert [one.units for one in found[:2]] == [("V", "N"), ("m/s2", "N")]
    np.testing.assert_allclose([one.h for one in found], h.reshape(4, 40), rtol=1e-10)
    assert read_nodes(path) == {2: (0.2, 0.1, 0.0), 3: (0.12, 0.1, 0.0)}
    nodes, header, units, again, line, *sets = pyuff.UFF(str(path)).read_sets()
    assert [one["type"] for one in (nodes, header, units, again, line)] == [15, 151, 164, 2411, 82]
    kinds = [(one["ordinate_spec_data_type"], one["orddenom_spec_data_type"]) for one in sets]
    assert kinds == [(1, 13), (12, 13)] * 2
