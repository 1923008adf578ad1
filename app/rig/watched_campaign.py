"""A running campaign shared with a window through files: readings out, pause and stop in."""

import logging
import math
import time
from pathlib import Path

from app.files.acquisition.running_campaign import ReadingLine, append_reading, request, requested
from drivers.rig.campaign import Moment
from drivers.rig.errors import RESUME, RigStopped

PAUSE_LOOK_INTERVAL = 0.2
"""Seconds of ours between two looks at a pause: a simulated oven's time would race on otherwise."""

log = logging.getLogger(__name__)


class WatchedCampaign:
    """Writes the readings of a campaign, and reads requests for pause and stop.

    Parameters
    ----------
    folder : Path
        The campaign's; requests to an earlier run are deleted.
    """

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        request(folder, "go on")

    def observe(self, moment: Moment) -> None:
        """Write a reading; RigStopped where a stop is requested."""
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
        except OSError as error:  # a full disk is reported when a sweep is written; a reading is no reason to stop
            log.warning("a reading could not be written: %s", error)
        if requested(self._folder) == "stop":
            request(self._folder, "go on")
            raise RigStopped("stopped from flexura view", RESUME)

    def paused(self) -> bool:
        """Whether a pause is requested."""
        pause = requested(self._folder) == "pause"
        if pause:
            time.sleep(PAUSE_LOOK_INTERVAL)
        return pause
