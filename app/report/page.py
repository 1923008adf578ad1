"""One self-contained HTML page: text, tables and figures, nothing fetched from anywhere."""

import base64
import io
import re
from collections.abc import Sequence
from dataclasses import dataclass
from html import escape

import matplotlib as mpl
from matplotlib.figure import Figure

from app.report.style import lay_out

POLICY = "default-src 'none'; img-src data:; media-src data:; style-src 'unsafe-inline'"
"""What browsers hold the page to: it can fetch nothing, nor run anything."""
LARGEST_SVG = 500_000
"""Bytes beyond which a figure (a map, ten thousand lines) goes in as PNG: a page has some twenty."""
SCROLLED, SENTENCE = 4, 40
"""Columns from which on a table is wider than a telephone; mean letters beyond which a column holds sentences."""
FULL_WIDTH = 10.0
"""Inches from which on a figure is as wide as the page."""
STYLE = """
body { font: 16px/1.5 system-ui, sans-serif; color: #222; max-width: 66rem; margin: 2rem auto; padding: 0 1rem }
h1 { margin-bottom: 0 } h2 { margin-top: 2.5rem; border-bottom: 1px solid #ddd }
h2, figure { scroll-margin-top: 1rem }
a { color: #00798c; text-decoration: none } a:hover { text-decoration: underline }
nav { background: #f6f8f9; padding: 0.6rem 1rem; margin: 1rem 0 } nav ol { margin: 0; padding-left: 1.4rem }
nav ul { margin: 0; padding-left: 1.1rem; font-size: 0.9rem; list-style: none }
figure { margin: 1.6rem 0 } figure h3 { margin: 0 0 0.4rem; font-size: 1.05rem }
figcaption { color: #555; font-size: 0.9rem }
table { border-collapse: collapse; margin: 1rem 0; font-size: 0.92rem }
th, td { border-bottom: 1px solid #e3e3e3; padding: 0.3rem 0.7rem; text-align: left; vertical-align: top }
td.c { font: 0.75em/1.6 monospace; overflow-wrap: anywhere }
td.n { text-align: right; font-variant-numeric: tabular-nums; white-space: nowrap }
.verdict { background: #e9f5f6; border-left: 6px solid #00798c; padding: 0.7rem 1rem; margin: 1rem 0 }
.verdict.open { background: #fdeef0; border-left-color: #d1495b }
.verdict strong { display: block; font-size: 1.15rem; margin-bottom: 0.3rem }
dl.words { display: grid; grid-template-columns: 9rem 1fr; gap: 0.45rem 1rem; margin: 1rem 0 }
dl.words dt { font-weight: 600; color: #00606f } dl.words dd { margin: 0; overflow-wrap: anywhere }
.absent { background: #fff6e5; border-left: 4px solid #e0a030; padding: 0.5rem 1rem }
summary { cursor: pointer; color: #00798c }
pre { background: #f6f6f6; padding: 0.8rem; overflow-x: auto; font-size: 0.8rem }
@media (max-width: 40rem) {
  body { margin: 0.8rem auto } h1 { font-size: 1.4rem; line-height: 1.25 } h1 + p { margin-top: 0.2rem }
  dl.words { display: block } dl.words dd { margin: 0 0 0.7rem }
}
@media screen and (max-width: 68rem) {
  table { display: block; overflow-x: auto }
  tr > :first-child:nth-last-child(n+5) ~ td:not(.n, .w) { min-width: 7rem }
  td.w { min-width: 28rem }
  tr > :first-child:nth-last-child(n+4):not(.n) { min-width: 7rem }
  figure h3::after { content: " \u2194"; font-weight: 400; color: #767676 }
  figure { overflow-x: auto } figure img { width: auto !important; max-width: none }
}
@media (min-width: 96rem) {
  nav { position: fixed; top: 1rem; left: calc(50% - 48rem); width: 12.5rem; max-height: 94vh; overflow-y: auto;
        box-sizing: border-box; font-size: 0.9rem }
}
@page { size: A4; margin: 15mm }
@media print {
  body { font-size: 10.5pt; max-width: none; margin: 0; padding: 0 } nav ul { display: none }
  h2, h3 { break-after: avoid } figure, tr, .verdict { break-inside: avoid } thead { display: table-header-group }
  table { font-size: 8.5pt } th, td { padding: 0.15rem 0.4rem } td.w { width: 45% }
  figure img { max-height: 22cm; object-fit: contain } pre { white-space: pre-wrap; word-break: break-all }
  .verdict, .absent, nav, pre { print-color-adjust: exact }
  details::details-content { content-visibility: visible; block-size: auto }
}
"""


@dataclass(frozen=True)
class PageTable:
    """Headings and rows of text; columns in `numbers` are set right, those in `codes` small, broken anywhere.

    On a telephone, a table of `SCROLLED` columns or more scrolls, and its columns of sentences stay wide.
    """

    headings: Sequence[str]
    rows: Sequence[Sequence[str]]
    numbers: Sequence[int] = ()
    codes: Sequence[int] = ()

    def html(self) -> str:
        """Return the table as HTML, every cell escaped."""
        kind = dict.fromkeys(self._sentences(), " class=w")
        kind |= dict.fromkeys(self.numbers, " class=n") | dict.fromkeys(self.codes, " class=c")
        head = "".join(f"<th>{escape(h)}</th>" for h in self.headings)
        body = "".join(
            "<tr>"
            + "".join(f"<td{kind.get(place, '')}>{escape(cell)}</td>" for place, cell in enumerate(row))
            + "</tr>"
            for row in self.rows
        )
        return f"<table><thead><tr>{head}</tr></thead><tbody>{body}</tbody></table>"

    def _sentences(self) -> list[int]:
        if len(self.headings) < SCROLLED:
            return []
        letters = [sum(len(row[n]) for row in self.rows) for n in range(len(self.headings))]
        return [n for n, count in enumerate(letters) if count > SENTENCE * len(self.rows)]


@dataclass(frozen=True)
class DrawnPicture:
    """A figure that is drawn already, perhaps by another process.

    Attributes
    ----------
    name, question : str
        As of `Picture`.
    code : str
        HTML.
    png : bytes
        The same as a PNG file; empty unless that was asked for.
    """

    name: str
    question: str
    code: str
    png: bytes = b""

    def html(self) -> str:
        """Return the figure inline."""
        return self.code


@dataclass(frozen=True)
class Picture:
    """A figure: the name of its file, the question it answers, and how it is to be read."""

    name: str
    question: str
    figure: Figure
    caption: str

    def drawn(self, *, png: bool = False) -> DrawnPicture:
        """Draw it, as a PNG file too if that is wanted; the same figure gives the same bytes."""
        stream = io.BytesIO()
        lay_out(self.figure)
        if png:
            self.figure.savefig(stream, format="png", dpi=100, metadata={"Software": None})
        return DrawnPicture(self.name, self.question, self.html(), stream.getvalue())

    def html(self) -> str:
        """Return the figure inline, as SVG unless that is too large; the same figure gives the same bytes."""
        kind, data = self._drawn()
        question, caption = escape(self.question), escape(self.caption)
        width = min(100.0, 100.0 * self.figure.get_figwidth() / FULL_WIDTH)
        image = (
            f'<img src="data:image/{kind};base64,{data}" alt="{question} {caption}" style="width: {width:.0f}%">'
        )
        name = escape(self.name)
        return f'<figure id="{name}"><h3>{question}</h3>{image}<figcaption>{caption}</figcaption></figure>'

    def _drawn(self) -> tuple[str, str]:
        """Kind of image and its base64."""
        stream = io.BytesIO()
        lay_out(self.figure)
        with mpl.rc_context({"svg.hashsalt": self.name}):
            self.figure.savefig(stream, format="svg", metadata={"Date": None})
        kind = "svg+xml"
        if stream.tell() > LARGEST_SVG:
            stream, kind = io.BytesIO(), "png"
            self.figure.savefig(stream, format="png", dpi=120, metadata={"Software": None})
        return kind, base64.b64encode(stream.getvalue()).decode("ascii")


@dataclass(frozen=True)
class Paragraph:
    """Plain text."""

    text: str

    def html(self) -> str:
        """Return the text escaped."""
        return f"<p>{escape(self.text)}</p>"


@dataclass(frozen=True)
class VerdictBox:
    """A headline and what it rests on, in a box of its own; `settled` where nothing is left open."""

    headline: str
    sentences: Sequence[str]
    settled: bool

    def html(self) -> str:
        """Return the box, all text escaped."""
        inside = "".join(f"<div>{escape(sentence)}</div>" for sentence in self.sentences)
        kind = "verdict" if self.settled else "verdict open"
        return f'<div class="{kind}"><strong>{escape(self.headline)}</strong>{inside}</div>'


@dataclass(frozen=True)
class Words:
    """A headline in a box, and below it headings with their sentences beside them."""

    headline: str
    settled: bool
    first: Sequence[str]
    parts: Sequence[tuple[str, Sequence[str]]]

    def html(self) -> str:
        """Return them as HTML, all text escaped."""
        rows = "".join(
            f"<dt>{escape(heading)}</dt><dd>{''.join(f'<div>{escape(one)}</div>' for one in said)}</dd>"
            for heading, said in self.parts
        )
        return f'{VerdictBox(self.headline, self.first, self.settled).html()}<dl class="words">{rows}</dl>'


@dataclass(frozen=True)
class Absent:
    """A stage that has not been run, and the command that runs it."""

    text: str

    def html(self) -> str:
        """Return the notice escaped."""
        return f'<p class="absent">{escape(self.text)}</p>'


@dataclass(frozen=True)
class Player:
    """A short piece of sound: what it is, a WAV file in base64, and how it is to be heard."""

    text: str
    data: str
    caption: str

    def html(self) -> str:
        """Return the player, with its sound inside the page."""
        sound = f'<audio controls preload="none" src="data:audio/wav;base64,{self.data}"></audio>'
        return (
            f"<figure><h3>{escape(self.text)}</h3>{sound}<figcaption>{escape(self.caption)}</figcaption></figure>"
        )


@dataclass(frozen=True)
class Listing:
    """Machine-written text, kept as it is."""

    text: str

    def html(self) -> str:
        """Return the text escaped, line by line."""
        return f"<pre>{escape(self.text)}</pre>"


@dataclass(frozen=True)
class Folded:
    """What few readers look at: one line, and the rest where that is clicked, or in print."""

    line: str
    items: Sequence[PageTable | Listing]

    def html(self) -> str:
        """Return it closed."""
        inside = "\n".join(item.html() for item in self.items)
        return f"<details><summary>{escape(self.line)}</summary>\n{inside}\n</details>"


Item = PageTable | Picture | DrawnPicture | Paragraph | VerdictBox | Words | Absent | Player | Listing | Folded


@dataclass(frozen=True)
class Section:
    """A heading and what stands under it."""

    title: str
    items: Sequence[Item]

    @property
    def anchor(self) -> str:
        """What links to the section name."""
        return re.sub(r"[^a-z0-9]+", "-", self.title.lower()).strip("-")

    def contents(self) -> str:
        """Return its line of the table of contents, with one for each figure's question, as HTML."""
        pictures = [item for item in self.items if isinstance(item, Picture | DrawnPicture)]
        lines = "".join(f'<li><a href="#{escape(p.name)}">{escape(p.question)}</a></li>' for p in pictures)
        below = f"<ul>{lines}</ul>" if lines else ""
        return f'<li><a href="#{self.anchor}">{escape(self.title)}</a>{below}</li>'


def page(title: str, subtitle: str, sections: Sequence[Section], lead: int = 0) -> str:
    """Return the whole page.

    Parameters
    ----------
    title, subtitle : str
        Plain text.
    lead : int
        Number of sections before the table of contents, which does not list them.

    Returns
    -------
    str
        HTML.
    """
    parts = [
        '<!doctype html><html lang="en"><meta charset="utf-8">',
        '<meta name="viewport" content="width=device-width, initial-scale=1">',
        f'<meta http-equiv="Content-Security-Policy" content="{POLICY}">',
        f"<title>{escape(title)}</title><style>{STYLE}</style>",
        f"<h1>{escape(title)}</h1><p>{escape(subtitle)}</p>",
    ]
    contents = f"<nav><ol>{''.join(section.contents() for section in sections[lead:])}</ol></nav>"
    for place, section in enumerate(sections):
        if place == lead:
            parts.append(contents)
        parts.append(f'<h2 id="{section.anchor}">{escape(section.title)}</h2>')
        parts.extend(item.html() for item in section.items)
    return "\n".join(parts) + "\n</html>\n"
