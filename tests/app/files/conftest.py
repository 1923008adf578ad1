"""A recording that two actuators share."""

from pathlib import Path
from typing import Any

import pytest

HAMMER = '\n[[drive]]\nid = "hammer"\nkind = "force"\npoint = [0.12, 0.1]\n'


@pytest.fixture
def recorded(tiny: Any, tmp_path: Path) -> Path:
    """Make the way down, relabelled as up, the hammer's."""
    tiny.toml = tiny.toml.replace('["up", "down"]', '["up"]') + HAMMER
    for file in tiny.files.values():
        hammered = file.properties["direction"] == "down"
        file.properties |= {"actuator": "hammer" if hammered else "A1", "direction": "up"}
        if hammered:
            file.properties["step"] = 8 - file.properties["step"]  # warming up, as the first
            for channels in file.channel_properties.values():
                channels["drive"] = {**channels["drive"], "unit_string": "N"}
    folder: Path = tiny.write(tmp_path / "plate")
    return folder
