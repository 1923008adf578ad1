"""Excel's workbooks (.xlsx, .xlsm) through openpyxl: a table on each sheet, with a head as in text files.

Values are taken as Excel last computed them; formulas are never evaluated, macros never run.
"""

import zipfile
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from app.files.measurements import text
from app.files.measurements.columns import MOST_BYTES, Columns

NEEDS = "Excel's workbooks need the extra tables: pip install 'flexura[tables]'; or save the sheet as CSV"
ZIP = b"PK"


def read(path: Path) -> Columns:
    """Read the tables of all sheets; of several, the columns are called ``SHEET/NAME``.

    Parameters
    ----------
    path : Path

    Returns
    -------
    Columns
        Sheets without a table are left out, with a note.

    Raises
    ------
    ValueError
        Where no sheet holds a table of numbers, with the row where something else stands among the numbers.
    """
    if path.suffix.lower() == ".xls":
        raise ValueError("a workbook of Excel 2003 or older; save it as .xlsx, or the sheet as CSV")
    if find_spec("openpyxl") is None:
        raise ValueError(NEEDS)
    with path.open("rb") as file:
        if file.read(2) != ZIP:
            raise ValueError("no .xlsx file (no ZIP archive); save it as Excel workbook (.xlsx) again")
    with zipfile.ZipFile(path) as archive:
        unpacked = sum(member.file_size for member in archive.infolist())
    if unpacked > MOST_BYTES // 4:
        raise ValueError(f"unpacks into {unpacked} bytes; at most {MOST_BYTES // 4} allowed: save a part of it")
    book = import_module("openpyxl").load_workbook(path, read_only=True, data_only=True, keep_links=False)
    found: dict[str, Columns] = {}
    refused: list[str] = []
    for sheet in book.worksheets:
        lines = [_line(row) for row in sheet.iter_rows(values_only=True)]
        if any(line.strip() for line in lines):
            try:
                found[sheet.title] = text.of_lines(lines)
            except ValueError as error:
                # rows are lines; a formula that Excel never computed has no value
                refused.append(f"sheet {sheet.title!r}: {str(error).replace('line ', 'row ', 1)}")
    if not found:
        raise ValueError("; ".join(refused[:3]) or "its sheets are empty")
    return _joined(found, tuple(f"{path.name}: {one}; left out" for one in refused))


def _line(row: tuple[Any, ...]) -> str:
    """Return a row as text with tabs, in which numbers keep all their digits."""
    cells = ["" if cell is None else " ".join(str(cell).split()) for cell in row]
    while cells and not cells[-1]:
        cells.pop()
    return "\t".join(cells)


def _joined(sheets: dict[str, Columns], notes: tuple[str, ...]) -> Columns:
    if len(sheets) == 1:
        (only,) = sheets.values()
        return Columns(only.values, only.units, scalars=only.scalars, notes=notes)
    joined = Columns(
        {f"{sheet}/{name}": values for sheet, one in sheets.items() for name, values in one.values.items()},
        notes=notes,
    )
    for sheet, one in sheets.items():
        joined.channels.update({f"{sheet}/{name}": name for name in one.values})
        joined.units.update({f"{sheet}/{name}": unit for name, unit in one.units.items()})
        joined.scalars.update({f"{sheet}/{name}": value for name, value in one.scalars.items()})
    return joined
