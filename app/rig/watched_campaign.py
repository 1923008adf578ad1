"""What a window may see of a running campaign, and ask of it, through files in the campaign's folder."""

import logging
import math
import time
from pathlib import Path

from app.files.control import wish, wished
from app.files.readings import ReadingLine, append_reading
from drivers.rig.campaign import Moment
from drivers.rig.errors import RESUME, RigStopped

PATIENCE = 0.2
"""Seconds of ours between two looks at a pause: a simulated oven's time would race on otherwise."""

log = logging.getLogger(__name__)


class WatchedCampaign:
    """Publishes the readings of a campaign, and hears what is wished of it.

    Parameters
    ----------
    folder : Path
        The campaign's; what was wished of an earlier run is forgotten.
    """

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        wish(folder, "go on")

    def observe(self, moment: Moment) -> None:
        """Write a moment down; RigStopped where a stop is wished."""
        plate = moment.reading.plate
        line = ReadingLine(
            date=moment.date,
            air_c=moment.reading.air,
            plate_c=math.nan if plate is None else plate,
            stage=moment.stage,
            done=moment.done,
            total=moment.total,
            seconds_left=round(moment.seconds_left, 1),
        )
        try:
            append_reading(self._folder, line)
        except OSError as error:  # the sweeps will tell of a full disk; a reading is no reason to stop
            log.warning("a reading could not be written: %s", error)
        if wished(self._folder) == "stop":
            wish(self._folder, "go on")
            raise RigStopped("stopped as wished in flexura view", RESUME)

    def paused(self) -> bool:
        """Whether a pause is wished."""
        pause = wished(self._folder) == "pause"
        if pause:
            time.sleep(PATIENCE)
        return pause
