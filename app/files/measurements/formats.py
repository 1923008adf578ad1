"""The table of formats. A new one is a module beside this, whose ``read`` gives `Columns`, and its row here."""

import re
from dataclasses import dataclass
from pathlib import Path


@dataclass(frozen=True)
class Format:
    """One format.

    Attributes
    ----------
    name : str
        For people, and the ``format`` of a declaration.
    endings : tuple of str
    reader : str
        Module beside this one, whose ``read`` takes a path.
    """

    name: str
    endings: tuple[str, ...]
    reader: str


FORMATS = (
    Format("csv", (".csv", ".txt", ".dat", ".asc", ".tsv", ".gz"), "text"),
    Format("lvm", (".lvm",), "lvm"),
    Format("mat", (".mat",), "matlab"),
    Format("wav", (".wav",), "wave"),
    Format("npz", (".npz",), "numpy_archive"),
    Format("tdms", (".tdms",), "tdms"),
    Format("hdf5", (".h5", ".hdf5", ".hdf", ".nc", ".nc4", ".netcdf", ".cdf"), "hdf5"),
    Format("excel", (".xlsx", ".xlsm", ".xls"), "excel"),
    Format("mdf", (".mf4", ".mdf"), "mdf"),
    Format("uff", (".uff", ".unv", ".uf", ".bunv"), "uff_time"),
)
"""Every format that is read into columns."""


CLOSED = {
    "Polytec": (".svd", ".pvd", ".pvi"),
    "MEscope": (".blk", ".vtprj", ".mesprj", ".shp"),
}
"""Endings of files that only their maker's program reads, by that program."""

BEGINNINGS = {
    "lvm": rb"LabVIEW Measurement",
    "mat": rb"MATLAB ",
    "hdf5": rb"\x89HDF|CDF[\x01\x02]",
    "wav": rb"RIFF|RIFX|RF64",
    "npz": rb"(?s)PK\x03\x04.{26}[^\0]*\.npy",
    "excel": rb"(?s)PK\x03\x04.{26}(?:\[Content_Types\]|_rels/|docProps/|xl/)",
    "mdf": rb"MDF     |UnFinMF ",
    "tdms": rb"TDSm",
    "uff": rb" {4}-1[ \t]*\r?\n *\d+[b ]*\S*[^\r\n]*\r?\n",
}
"""First bytes of the formats that have their own."""


def by_content(path: Path) -> Format | None:
    """Return the format as which a file begins; None where that tells nothing."""
    with path.open("rb") as file:
        begins = file.read(200)
    return next((one for one in FORMATS if re.match(BEGINNINGS.get(one.name, rb"(?!)"), begins)), None)


def format_of(path: Path) -> Format:
    """Return the format of a file by its ending.

    Parameters
    ----------
    path : Path

    Returns
    -------
    Format

    Raises
    ------
    ValueError
        For an ending of none, with those there are.
    """
    for one in FORMATS:
        if path.suffix.lower() in one.endings:
            return one
    for program, endings in CLOSED.items():
        if path.suffix.lower() in endings:
            raise ValueError(
                f"a file of {program}, which only its own program reads; export as UFF 58 there (universal file, "
                "with its geometry), and name that file"
            )
    known = ", ".join(ending for one in FORMATS for ending in one.endings)
    raise ValueError(
        f"ending {path.suffix!r} is none of a measurement; allowed: {known}. Export it as one of these"
    )
