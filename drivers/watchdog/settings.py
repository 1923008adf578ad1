"""What the watchdog's process is told when it starts."""

from collections.abc import Mapping
from typing import Annotated, Any

from pydantic import Field

from analysis.declared import Declared
from analysis.protocol.limits import Limits
from drivers.watchdog.rest_watch import RestRule


class WatchdogSettings(Declared):
    """First line on the standard input of the watchdog."""

    oven: Annotated[Mapping[str, Any], Field(description="the [oven] of the experiment, as its kind declares it")]
    limits: Limits
    cards: Annotated[
        Mapping[str, Any] | None, Field(description="the [cards], to bring the drive to 0 V; None: not its task")
    ] = None
    rest: Annotated[RestRule, Field(description="when the oven, switched off, counts as at rest")]
    parent: Annotated[int, Field(ge=0, description="number of the campaign's process")] = 0
    signals: Annotated[
        int | None, Field(ge=0, description="descriptor on which the campaign's signals arrive")
    ] = None
    ending: Annotated[
        tuple[int, ...], Field(description="numbers of the signals that ask the campaign to end")
    ] = ()
    locks: Annotated[
        tuple[int, ...], Field(description="descriptors of the rig's locks, held as long as it lives")
    ] = ()
    log: Annotated[str | None, Field(description="file in which it says what nobody may be there to read")] = None
    linger: Annotated[
        float, Field(gt=0.0, description="s, longest time for which an oven that is not at rest is looked after")
    ] = 3600.0
