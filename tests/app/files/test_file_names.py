"""Names of files in declarations: one that no file can have is refused, not looked for."""

import pytest
from pydantic import TypeAdapter, ValidationError

from analysis.declaration.strict import LONGEST_NAME, FileName
from app.files.declarations.modal_test import RecordOfTest
from app.files.declarations.plate import FrfsOfPlate, ModesOfPlate
from app.files.drawings.drawing import Drawing, MeshFile


@pytest.mark.parametrize("name", ["a.uff", "frfs/*.uff", "é" * 127 + "e", "/".join(["a" * 200] * 4)])
def test_what_a_file_can_be_called_is_taken(name: str) -> None:
    assert TypeAdapter(FileName).validate_python(name) == name


@pytest.mark.parametrize("name", ["a" * (LONGEST_NAME + 1), "é" * 128, f"folder/{'a' * 300}", "a/" * 600])
@pytest.mark.parametrize("model", [RecordOfTest, FrfsOfPlate, ModesOfPlate, Drawing, MeshFile])
def test_what_no_file_can_be_called_is_refused(model: type, name: str) -> None:
    with pytest.raises(ValidationError, match="no file can have"):
        TypeAdapter(model).validate_python({"file": f"{name}.dxf"})
