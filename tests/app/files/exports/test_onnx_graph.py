"""The ONNX graph, run by onnxruntime, against the filters."""

import json

import numpy as np
import pytest

from app.files.exports.written_filters import NAME, write_onnx

onnxruntime = pytest.importorskip("onnxruntime")
WANTED = np.array([-40.0, 0.0, 3.3, 5.0, 20.0, 41.7, 57.5, 60.0, 300.0])


@pytest.mark.parametrize("kind", ["network", "cubic-spline", "cubic-spline-rigidity", "linear", "single"])
def test_the_runtime_gives_the_taps(tmp_path, shipments, kind):
    shipment = shipments[kind]
    write_onnx(shipment, tmp_path)
    session = onnxruntime.InferenceSession(tmp_path / NAME, providers=["CPUExecutionProvider"])
    found = [session.run(["taps"], {"temperature": np.array([t], np.float32)})[0] for t in WANTED]
    expected = shipment.filters.taps(WANTED)
    assert np.sum((np.array(found) - expected) ** 2) < 1e-11 * np.sum(expected**2)
    facts = session.get_modelmeta().custom_metadata_map
    assert facts["format"] == "flexura-filters/1"
    assert facts["actuators"] == "A1,A2,A3"
    assert (float(facts["sample_rate"]), int(facts["delay"])) == (8_000.0, 12)
    assert json.loads(facts["provenance"])["inputs"] == {"filters.h5": "0" * 64}


def test_the_same_filters_give_the_same_bytes(tmp_path, shipments):
    first = write_onnx(shipments["network"], tmp_path)[0].read_bytes()
    assert write_onnx(shipments["network"], tmp_path)[0].read_bytes() == first
