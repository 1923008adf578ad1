"""Modes as rows of a table, one of them marked."""

from collections.abc import Container, Sequence

from PySide6.QtCore import QSignalBlocker, Qt, Signal
from PySide6.QtGui import QKeyEvent, QKeySequence
from PySide6.QtWidgets import QAbstractItemView, QApplication, QHeaderView, QTableWidget, QTableWidgetItem


class ModeTable(QTableWidget):
    """Table whose rows can be chosen; Ctrl+C copies all of it.

    Parameters
    ----------
    headings : sequence of str
    numbers : container of int
        Columns that are set right.

    Attributes
    ----------
    chosen : Signal(int)
        Row that was clicked, or gone to with the keys.
    """

    chosen = Signal(int)

    def __init__(self, headings: Sequence[str], numbers: Container[int]) -> None:
        super().__init__(0, len(headings))
        self._numbers = numbers
        self.setHorizontalHeaderLabels(list(headings))
        self.setSelectionBehavior(QAbstractItemView.SelectionBehavior.SelectRows)
        self.setSelectionMode(QAbstractItemView.SelectionMode.SingleSelection)
        self.setEditTriggers(QAbstractItemView.EditTrigger.NoEditTriggers)
        self.verticalHeader().setDefaultSectionSize(22)
        header = self.horizontalHeader()
        header.setSectionResizeMode(QHeaderView.ResizeMode.ResizeToContents)
        header.setStretchLastSection(True)
        self.currentCellChanged.connect(self._chosen)
        self.cellClicked.connect(lambda row, _: self.chosen.emit(row))  # also the one that is marked already

    @property
    def text(self) -> str:
        """All of it, headings and rows, as spreadsheets take it: tabs and lines."""
        columns = range(self.columnCount())
        heads = [self.horizontalHeaderItem(column) for column in columns]
        rows = [[self.item(row, column) for column in columns] for row in range(self.rowCount())]
        return (
            "\n".join("\t".join("" if c is None else c.text() for c in cells) for cells in (heads, *rows)) + "\n"
        )

    def keyPressEvent(self, event: QKeyEvent) -> None:
        """Copy the whole table, where Qt would copy one cell."""
        if event.matches(QKeySequence.StandardKey.Copy):
            QApplication.clipboard().setText(self.text)
        else:
            super().keyPressEvent(event)

    def show_rows(self, rows: Sequence[Sequence[str]]) -> None:
        """Show other rows, none of them marked."""
        with QSignalBlocker(self):
            self.setRowCount(0)
            self.setRowCount(len(rows))
            for n, row in enumerate(rows):
                for column, text in enumerate(row):
                    cell = QTableWidgetItem(text)
                    cell.setToolTip(text)
                    if column in self._numbers:
                        cell.setTextAlignment(Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter)
                    self.setItem(n, column, cell)

    def mark(self, row: int) -> None:
        """Mark a row, which is not taken for a choice."""
        with QSignalBlocker(self):
            self.selectRow(row)

    def print_bold(self, rows: Container[int]) -> None:
        """Print some rows in bold."""
        for n in range(self.rowCount()):
            for column in range(self.columnCount()):
                if (cell := self.item(n, column)) is not None:
                    font = cell.font()
                    font.setBold(n in rows)
                    cell.setFont(font)

    def _chosen(self, row: int, _column: int, before: int, _before_column: int) -> None:
        if row >= 0 and row != before:
            self.chosen.emit(row)
