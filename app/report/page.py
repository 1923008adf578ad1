"""One self-contained HTML page: text, tables and figures, nothing fetched from anywhere."""

import base64
import io
from collections.abc import Sequence
from dataclasses import dataclass
from html import escape

from matplotlib.figure import Figure

STYLE = """
body { font: 16px/1.5 system-ui, sans-serif; color: #222; max-width: 62rem; margin: 2rem auto; padding: 0 1rem }
h1 { margin-bottom: 0 } h2 { margin-top: 2.5rem; border-bottom: 1px solid #ddd }
figure { margin: 1.2rem 0 } figure img { width: 100% } figcaption { color: #555; font-size: 0.9rem }
table { border-collapse: collapse; margin: 1rem 0; font-size: 0.92rem }
th, td { border-bottom: 1px solid #e3e3e3; padding: 0.3rem 0.7rem; text-align: left; vertical-align: top }
td.n { text-align: right; font-variant-numeric: tabular-nums; white-space: nowrap }
.verdict { background: #e9f5f6; border-left: 6px solid #00798c; padding: 0.7rem 1rem; margin: 1rem 0 }
.verdict.open { background: #fdeef0; border-left-color: #d1495b }
.verdict strong { display: block; font-size: 1.15rem; margin-bottom: 0.3rem }
.absent { background: #fff6e5; border-left: 4px solid #e0a030; padding: 0.5rem 1rem }
pre { background: #f6f6f6; padding: 0.8rem; overflow-x: auto; font-size: 0.8rem }
"""


@dataclass(frozen=True)
class Table:
    """Headings and rows of text; cells of the columns in `numbers` are set right."""

    headings: Sequence[str]
    rows: Sequence[Sequence[str]]
    numbers: Sequence[int] = ()

    def html(self) -> str:
        """Return the table as HTML, every cell escaped."""
        head = "".join(f"<th>{escape(h)}</th>" for h in self.headings)
        body = "".join(
            "<tr>"
            + "".join(
                f"<td class=n>{escape(cell)}</td>" if place in self.numbers else f"<td>{escape(cell)}</td>"
                for place, cell in enumerate(row)
            )
            + "</tr>"
            for row in self.rows
        )
        return f"<table><thead><tr>{head}</tr></thead><tbody>{body}</tbody></table>"


@dataclass(frozen=True)
class Picture:
    """A figure, the name of its file, and the sentence under it."""

    name: str
    figure: Figure
    caption: str

    def html(self) -> str:
        """Return the figure as an inline PNG; the same figure gives the same bytes."""
        stream = io.BytesIO()
        self.figure.savefig(stream, format="png", dpi=120, metadata={"Software": None})
        data = base64.b64encode(stream.getvalue()).decode("ascii")
        caption = escape(self.caption)
        image = f'<img src="data:image/png;base64,{data}" alt="{caption}">'
        return f"<figure>{image}<figcaption>{caption}</figcaption></figure>"


@dataclass(frozen=True)
class Paragraph:
    """Plain text."""

    text: str

    def html(self) -> str:
        """Return the text escaped."""
        return f"<p>{escape(self.text)}</p>"


@dataclass(frozen=True)
class Verdict:
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
class Absent:
    """A stage that has not been run, and the command that runs it."""

    text: str

    def html(self) -> str:
        """Return the notice escaped."""
        return f'<p class="absent">{escape(self.text)}</p>'


@dataclass(frozen=True)
class Listing:
    """Machine-written text, kept as it is."""

    text: str

    def html(self) -> str:
        """Return the text escaped, line by line."""
        return f"<pre>{escape(self.text)}</pre>"


Item = Table | Picture | Paragraph | Verdict | Absent | Listing


@dataclass(frozen=True)
class Section:
    """A heading and what stands under it."""

    title: str
    items: Sequence[Item]


def page(title: str, subtitle: str, sections: Sequence[Section]) -> str:
    """Return the whole page as HTML."""
    parts = [
        '<!doctype html><html lang="en"><meta charset="utf-8">',
        '<meta name="viewport" content="width=device-width, initial-scale=1">',
        f"<title>{escape(title)}</title><style>{STYLE}</style>",
        f"<h1>{escape(title)}</h1><p>{escape(subtitle)}</p>",
    ]
    for section in sections:
        parts.append(f"<h2>{escape(section.title)}</h2>")
        parts.extend(item.html() for item in section.items)
    return "\n".join(parts) + "\n</html>\n"
