"""The pages as a site: all links and anchors lead somewhere, and nothing is fetched when it is read."""

import importlib
import importlib.util
import os
import re
import subprocess
import sys
from html.parser import HTMLParser
from pathlib import Path

import pytest

import analysis

ROOT = Path(__file__).resolve().parents[2]
PAGES = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *sorted((ROOT / "docs").rglob("*.md"))]
NAMED = [page for page in PAGES if page.parent.name != "history"] + [ROOT / "docs" / "architecture.svg"]
"""Pages that name modules of today; the history names those of its time."""
FLOORS = "analysis|app|drivers|flexura|simulation"
ENTRY_POINTS = {"flexura.cards", "flexura.ovens", "flexura.thermometers"}
"""Groups of entry points, which are no modules."""


def name(page: Path) -> str:
    return str(page.relative_to(ROOT))


def exists(dotted: str) -> bool:
    """Whether a module, or a name in one, is there; modules are imported only for the names in them."""
    words = dotted.split(".")
    count = max(n for n in range(1, len(words) + 1) if is_module(".".join(words[:n])))
    if count == len(words):
        return True
    found: object = importlib.import_module(".".join(words[:count]))
    for word in words[count:]:
        if not hasattr(found, word) and word not in getattr(found, "__dataclass_fields__", {}):
            return False
        found = getattr(found, word, None)
    return True


def is_module(dotted: str) -> bool:
    try:
        return importlib.util.find_spec(dotted) is not None
    except ModuleNotFoundError:  # what stands before the last point is no package
        return False


@pytest.mark.parametrize("page", NAMED, ids=name)
def test_every_module_named_is_there(page: Path) -> None:
    text = re.sub(r"```.*?```", "", page.read_text(encoding="utf-8"), flags=re.DOTALL)
    dotted = re.findall(rf"[`>]((?:{FLOORS})(?:\.\w+)+)[`<]", text)
    assert [one for one in dotted if not exists(one) and one not in ENTRY_POINTS] == []
    paths = re.findall(rf"`((?:{FLOORS}|tests|docs|benchmarks|examples)/[\w./-]*)`", text)
    assert [one for one in paths if "NAME" not in one and not (ROOT / one).exists()] == []


def test_a_module_that_is_not_there_is_seen() -> None:
    assert exists("analysis.recordings.frf.Frf.noise_floor")
    assert not exists("analysis.recordings.frf.Nothing")
    assert not exists("analysis.nowhere.at_all")


def test_the_citation_names_this_version_and_the_paper() -> None:
    yaml = pytest.importorskip("yaml", reason="PyYAML comes with the extra docs")
    cited = yaml.safe_load((ROOT / "CITATION.cff").read_text(encoding="utf-8"))
    assert cited["version"] == analysis.__version__
    assert cited["license"] == "BSD-3-Clause"
    (paper,) = cited["references"]
    readme = " ".join((ROOT / "README.md").read_text(encoding="utf-8").split())
    assert paper["title"].lower() in readme.lower()
    assert [author["family-names"] for author in paper["authors"]] == ["Benbara", "Martin", "Rébillat", "Mechbal"]


class Fetched(HTMLParser):
    """Addresses that a browser asks for by itself when it shows a page."""

    def __init__(self) -> None:
        super().__init__()
        self.addresses: list[str] = []
        self.formulas = 0

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        held = dict(attrs)
        self.formulas += tag == "math"
        if tag in ("script", "img", "iframe", "source"):
            self.addresses.append(held.get("src") or "")
        elif tag == "link":
            self.addresses.append(held.get("href") or "")


@pytest.mark.slow
def test_the_site_is_built_without_a_warning_and_fetches_nothing(tmp_path: Path) -> None:
    for tool in ("sphinx", "myst_parser", "furo"):
        pytest.importorskip(tool, reason="the extra docs is not installed; python3 start.py docs installs it")
    sphinx = [sys.executable, "-m", "sphinx", "--fresh-env", "--fail-on-warning", "--keep-going", "--quiet"]
    done = subprocess.run(
        [*sphinx, "--conf-dir", "docs/site", ".", str(tmp_path)],
        cwd=ROOT,
        env={**os.environ, "NO_COLOR": "1"},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    made = {str(page.relative_to(tmp_path)) for page in tmp_path.rglob("*.html")}
    assert {str(page.relative_to(ROOT).with_suffix(".html")) for page in PAGES} < made
    assert {
        "index.html",
        "search.html",
        "docs/api/analysis/analysis.gap.html",
        "docs/api/flexura/flexura.html",
    } < made
    assert (tmp_path / "searchindex.js").stat().st_size > 100_000
    formulas = 0
    for page in tmp_path.rglob("*.html"):
        seen = Fetched()
        seen.feed(page.read_text(encoding="utf-8"))
        assert [a for a in seen.addresses if "//" in a] == [], page
        formulas += seen.formulas
    assert formulas > 200
    styles = "".join(style.read_text(encoding="utf-8") for style in tmp_path.rglob("*.css"))
    assert re.findall(r"(?:@import|url\()\s*['\"]?(?:https?:)?//[^)'\"]*", styles) == []
