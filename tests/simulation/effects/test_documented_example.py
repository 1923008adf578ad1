"""The example of docs/adding-an-effect.md does what the page says."""

import re
from pathlib import Path

import pytest

from simulation.effects.library import apply_all, interior_point, library, numbers

PAGE = Path(__file__).parents[3] / "docs" / "adding-an-effect.md"


def blocks() -> list[str]:
    return re.findall(r"```python\n(.*?)```", PAGE.read_text(encoding="utf-8"), flags=re.DOTALL)


@pytest.fixture
def folder(tmp_path):
    (tmp_path / "drying.py").write_text(blocks()[0], encoding="utf-8")
    return tmp_path


def test_the_file_takes_part_where_both_ways_were_recorded(experiment, folder):
    assert list(library(experiment, folder)) == [*library(experiment), "drying"]
    one_way = experiment.protocol.model_copy(update={"directions": ("up",)})
    assert "drying" not in library(experiment.model_copy(update={"protocol": one_way}), folder)


def test_the_pages_test_passes(experiment, folder, trial):
    import numpy as np

    scope = {"LIBRARY": library(experiment, folder), "np": np}
    exec(compile(blocks()[1], str(PAGE), "exec"), scope)  # noqa: S102 - our own page
    scope["test_a_moist_plate_is_softer_on_the_way_up_only"](trial)


def test_it_acts_beside_all_others(experiment, folder, trial):
    circumstances, state = trial(temperature=40.0, rate=0.01)
    effects = library(experiment, folder)
    values = {
        name: interior_point(card, card.sites[0])
        for name, card in ((n, e.card(experiment)) for n, e in effects.items())
    }
    others = {name: own for name, own in values.items() if name != "drying"}
    with_it = apply_all(effects, state, circumstances, values)
    without = apply_all(effects, state, circumstances, others)
    changed = {name for name, value in numbers(without).items() if (numbers(with_it)[name] != value).any()}
    assert changed == {"storage", "loss"}


def test_the_pages_message_is_the_one_that_comes(experiment, folder):
    path = folder / "drying.py"
    path.write_text(path.read_text().replace('1.0 - values["softening"]', '1.0 - values["softening"].real'))
    quoted = re.search(r"my-effects/drying\.py: (softening: .*)", PAGE.read_text(encoding="utf-8"))
    with pytest.raises(ValueError, match=re.escape(f"{path}: {quoted[1]}")):
        library(experiment, folder)


def test_the_page_lists_every_attribute_of_a_state(trial):
    _, state = trial()
    page = PAGE.read_text(encoding="utf-8")
    assert [name for name in vars(state) if f"`{name}`" not in page and f"`state.{name}`" not in page] == []
