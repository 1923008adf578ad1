"""Effects that are on for good."""

from analysis.twin_model import HeldEffects


class Recording:
    """A model that notes for which effects it was counted."""

    def __init__(self, effects: tuple[str, ...] = ()) -> None:
        self.effects = effects

    def counted(self, laws: object, effects: list[str]) -> "Recording":
        return Recording(tuple(effects))


def test_what_is_held_is_counted_in_units_of_the_plain_plate_too() -> None:
    held = HeldEffects(Recording(), {"amplitude_softening": {"a": 0.01}})  # type: ignore[arg-type]
    found = held.counted([], ["point_mass"])
    assert found.held is held.held
    assert isinstance(found.twin, Recording)
    assert found.twin.effects == ("amplitude_softening", "point_mass")
