"""The air in front of a panel."""

from typing import Annotated

from pydantic import Field

from analysis.declared import Declared


class Air(Declared):
    """Speed of sound and density, by default those of dry air at 20 °C and 101.325 kPa (ISO 9613-1).

    The ranges contain air from -80 to 120 °C and up to 5 km above the sea.
    """

    sound_speed: Annotated[float, Field(ge=270.0, le=400.0, description="m/s")] = 343.2
    density: Annotated[float, Field(ge=0.4, le=2.0, description="kg/m3")] = 1.204
