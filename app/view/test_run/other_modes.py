"""Modes that are set beside those of a test: another test's, or those of a plate's twin."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from app.files.bad_file import ResultFileError
from app.files.best_twin import PLAIN
from app.files.campaign_inputs import origin_of_result
from app.files.run_folder import is_test_run
from app.view.folder import viewed
from app.view.recorded.results import Results
from app.view.test_run.held import HeldTest


@dataclass(frozen=True)
class TwinBeside:
    """Modes of a plate's twin beside those measured on the plate.

    Attributes
    ----------
    run : Path
        Folder of flexura update.
    pairing : mapping
        Of `app.files.pairing_json.pairing_record`.
    """

    run: Path
    pairing: Mapping[str, Any]

    def said_beside(self, test: Path) -> str:
        """Say whether the twin was updated with the files that a test's run was made from."""
        mine = set(origin_of_result(test / "transfers.h5", "identify").inputs.values())
        same = mine & set(origin_of_result(self.run / PLAIN, "update").inputs.values())
        if same:
            return f"Twin of {self.run.name}, updated with the recordings of this test."
        return f"Twin of {self.run.name}, updated with other recordings than this test's: not its modes."


def other_modes(folder: Path) -> HeldTest | TwinBeside:
    """Read the modes of a test's run, or of the twin in a campaign's; ResultFileError where there are none."""
    if is_test_run(folder):
        return HeldTest.read(folder)
    found = viewed(folder)
    results = Results(found)
    pairing = results.pairing
    if found.run is not None and pairing is not None:
        return TwinBeside(found.run, pairing)
    if results.problems:
        raise ResultFileError("; ".join(f"{folder}: {name}: {what}" for name, what in results.problems.items()))
    raise ResultFileError(
        f"{folder}: holds no modes to be compared; name the run folder of flexura identify TEST.toml, or that of "
        "flexura update with an FRF of the plate"
    )
