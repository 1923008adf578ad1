"""The surroundings of a panel over time: a ``weather/1`` TOML file, checked strictly."""

from pathlib import Path

from analysis.weather.declared_weather import Weather
from app.files.settings_toml import read_settings


def read_weather(path: Path) -> Weather:
    """Read a weather; CampaignFileError with every missing, unknown, mistyped or implausible key."""
    return read_settings(path, Weather)
