"""Rows of the table at the end of a run: what was found, how sure it is, what to do next."""

from pathlib import Path

from app.files.bad_file import ResultFileError, quoted
from app.files.results.best_twin import PLAIN, best_twin, gap_record_of
from app.report.summary import summary, worth_of
from app.summaries.briefing import briefing

OF_THE_PANEL = (("filters", "focus"), ("at any temperature", "compensate"))
Rows = tuple[tuple[str, str], ...]


def found_rows(run: Path, campaign: str) -> Rows:
    """Return what a run folder holds, in words.

    Parameters
    ----------
    campaign : str
        How commands name the campaign.

    Returns
    -------
    tuple of (str, str)
        What, and what is said of it. A result that cannot be read is left out: the report says why.
    """
    rows: list[tuple[str, str]] = []
    lines = _lines(run)
    rows += [("modes", lines["identify"])] if "identify" in lines else []
    if (run / PLAIN).is_file():
        try:
            best = best_twin(run, "run")
            said = briefing(best, gap_record_of(run), campaign, worth_of(run))
        except ResultFileError as error:
            rows.append(("twin and plate", str(error)))
        else:
            rows.append(("twin and plate", "\n".join((said.headline, *said.first))))
            rows += [(heading.lower(), "\n".join(sentences)) for heading, sentences in said.parts]
    rows += [(name, lines[verb]) for name, verb in OF_THE_PANEL if verb in lines]
    last = [row for row in rows if row[0] == "next"]
    rows = [row for row in rows if row[0] != "next"]
    if (run / "report.html").is_file():
        page = run / "report.html"
        window = f"flexura view {quoted(run)}"
        rows.append(("report", f"{page}: open it in a browser; to look at it all in a window: {window}"))
    return (*rows, *last)


def _lines(run: Path) -> dict[str, str]:
    try:
        return summary(run)
    except ResultFileError:
        return {}
