"""How Sphinx makes the documentation site; ``python3 start.py docs`` runs it.

The sources are the Markdown pages where they stand (the source folder is the project's root), so that the same
files are read on a code host and on the site. Nothing is fetched: formulas become MathML, which browsers draw
themselves, and the theme holds all its scripts and fonts.
"""

import re
import sys
from pathlib import Path

from docutils import nodes
from docutils.utils.math import MathError
from docutils.utils.math.latex2mathml import tex2mathml
from sphinx.application import Sphinx
from sphinx.util import logging
from sphinx.util.typing import ExtensionMetadata
from sphinx.writers.html5 import HTML5Translator

ROOT = Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT)]  # this tree's packages are described, not those of another installation

import analysis  # noqa: E402 (only now is it this tree's)

CONTENTS = {
    "Guide": [
        "docs/README",
        "docs/guide/five-minutes",
        "docs/guide/real-hardware",
        "docs/guide/recorded-campaign",
        "docs/guide/modal-test",
        "docs/guide/hammer-test",
        "docs/guide/frfs-of-other-programs",
        "docs/guide/any-plate",
        "docs/guide/filters",
        "docs/guide/listening",
        "docs/guide/closing-a-gap",
        "docs/gap",
        "docs/guide/adding-hardware-and-effects",
        "docs/guide/bring-your-own-instrument",
        "docs/adding-an-effect",
        "docs/view",
        "docs/watch",
        "docs/guide/command-line",
        "docs/guide/fleets",
        "docs/guide/health",
        "docs/guide/library",
        "docs/guide/file-formats",
        "docs/guide/troubleshooting",
        "docs/faq",
        "docs/glossary",
    ],
    "Theory": ["docs/theory/README"],
    "Evidence": ["docs/verification", "docs/safety", "docs/faults"],
    "Development": [
        "docs/architecture",
        "CONTRIBUTING",
        "docs/decisions/README",
        "docs/dependencies",
        "CHANGELOG",
        "docs/history/README",
    ],
    "Reference": [f"docs/api/{name}/{name}" for name in ("flexura", "analysis", "simulation", "drivers")],
}
"""Pages of the sidebar, by caption; what is in no list of contents is a warning, and warnings are errors."""

COLON = "\N{WORD JOINER}"
"""Stands for a colon while napoleon reads a one-line docstring."""
logger = logging.getLogger(__name__)

PUBLIC = {
    "flexura": ("__main__.py", "arguments.py", "own_packages.py"),
    "analysis": (),
    "simulation": ("meshing", "reduction", "shell"),
    "drivers": ("**/simulated", "ni"),
}
"""Packages of the reference, and what of each is left out: insides of the twin, of cards and simulations."""

project = "Flexura"
author = "the Flexura developers"
copyright = "2026, the Flexura developers"
release = version = analysis.__version__

extensions = ["myst_parser", "sphinx.ext.apidoc", "sphinx.ext.autodoc", "sphinx.ext.napoleon"]
root_doc = "README"
include_patterns = ["README.md", "CONTRIBUTING.md", "CHANGELOG.md", "docs/**"]
exclude_patterns = ["docs/site/**", "docs/api/*/modules.rst"]
source_suffix = {".md": "markdown", ".rst": "restructuredtext"}
nitpicky = False

myst_enable_extensions = ["dollarmath"]
myst_dmath_allow_space = False
myst_dmath_allow_digits = False
myst_heading_anchors = 4

html_theme = "furo"
html_title = f"Flexura {release}"
html_math_renderer = "mathml"
html_additional_pages = {"index": "to-readme.html"}
html_show_sourcelink = False
html_copy_source = False
templates_path = ["templates"]

apidoc_modules = [
    {
        "path": str(ROOT / name),
        "destination": f"docs/api/{name}",
        "exclude_patterns": [str(ROOT / name / part) for part in left_out],
        "automodule_options": {"members", "show-inheritance"},
        "no_headings": False,
        "module_first": True,
    }
    for name, left_out in PUBLIC.items()
]
autodoc_typehints = "signature"  # docstrings add shapes and units, and do not repeat types
autodoc_member_order = "bysource"
default_role = "literal"
suppress_warnings = ["ref.python"]  # a class name in an Attributes section may be that of several packages
napoleon_google_docstring = False
napoleon_use_ivar = True
add_module_names = False


def contents(_app: Sphinx, page: str, source: list[str]) -> None:
    """Give the first page its lists of contents, which a code host would show as raw text."""
    if page == root_doc:
        for caption, pages in CONTENTS.items():
            listed = "\n".join(f"/{name}" for name in pages)
            source[0] += f"\n```{{toctree}}\n:hidden:\n:caption: {caption}\n\n{listed}\n```\n"
    if page == "docs/theory/README":
        listed = "\n".join(re.findall(r"^\d+\. \[[^]]*\]\((\w+)\.md\)", source[0], re.MULTILINE))
        source[0] += f"\n```{{toctree}}\n:hidden:\n\n{listed}\n```\n"
    for folder, names in {"decisions": "*-*", "history": "[0-9]*"}.items():
        if page == f"docs/{folder}/README":
            source[0] += f"\n```{{toctree}}\n:hidden:\n:glob:\n\n{names}\n```\n"


def plain_docstrings(
    _app: Sphinx, what: str, _name: str, _obj: object, _options: object, lines: list[str]
) -> None:
    """Take the docstrings' bars, stars and underscores as they are, and indented formulas line by line."""
    kept, literal = [], False
    for before, line in zip(["", *lines], lines, strict=False):
        indented = line.startswith("    ")
        if literal and line.strip() and not indented:
            literal = False
        if indented and not before.strip() and not literal and what == "module":
            if not _last_text(kept).endswith("::"):
                kept += ["::", ""]
            literal = True
        elif _last_text(kept).endswith("::"):
            literal = literal or indented
        kept.append(line if literal else _escaped(line))
    if what in ("attribute", "data", "property"):
        kept = [line.replace(":", COLON) for line in kept]
    lines[:] = kept


def colons(_app: Sphinx, _what: str, _name: str, _obj: object, _options: object, lines: list[str]) -> None:
    """Put back the colons that napoleon would have taken for the end of a type."""
    lines[:] = [line.replace(COLON, ":") for line in lines]


def _last_text(lines: list[str]) -> str:
    return next((line for line in reversed(lines) if line.strip()), "")


def _escaped(line: str) -> str:
    """Escape what reStructuredText would read as markup, code in backticks excepted."""
    parts = re.split(r"(``.*?``|`[^`]*`)", line)
    parts[::2] = [re.sub(r"[|*]|(?<=\w)_(?!\w)", r"\\\g<0>", part) for part in parts[::2]]
    return "".join(parts)


def visit_math(writer: HTML5Translator, node: nodes.math) -> None:
    """Write a formula within a line."""
    writer.body.append(mathml(node))
    raise nodes.SkipNode


def visit_math_block(writer: HTML5Translator, node: nodes.math_block) -> None:
    """Write a formula of its own."""
    writer.body.append(f'<div class="math">{mathml(node, as_block=True)}</div>')
    raise nodes.SkipNode


def mathml(node: nodes.math | nodes.math_block, *, as_block: bool = False) -> str:
    """Write a formula as MathML; what docutils cannot read is a warning."""
    try:
        return str(tex2mathml(node.astext(), as_block=as_block))
    except MathError as error:
        logger.warning("%s in the formula %s", error, node.astext(), location=node)
        return ""


def setup(app: Sphinx) -> ExtensionMetadata:
    """Connect the above to Sphinx."""
    app.connect("source-read", contents)
    app.connect("autodoc-process-docstring", plain_docstrings, priority=400)  # before napoleon
    app.connect("autodoc-process-docstring", colons, priority=600)
    app.add_html_math_renderer("mathml", (visit_math, None), (visit_math_block, None))
    return {"parallel_read_safe": True, "parallel_write_safe": True}
