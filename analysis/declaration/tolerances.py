"""Tolerances of a declaration: how exactly a campaign's plate, patches and instruments are known.

Nothing declared is exact. Each quantity is a Gaussian parameter of the twin, with the declared value as its mean
and its tolerance as its standard deviation. Those below are what a careful workshop reaches with a steel rule, a
calliper, a laboratory scale and the data sheets of patches and cards.
"""

from collections.abc import Mapping
from typing import Annotated, Any, Self

from pydantic import Field

from analysis.declaration.strict import Declared

Share = Annotated[float, Field(ge=0.0, le=0.3)]
Logarithm = Annotated[float, Field(ge=0.0, le=2.0)]
Distance = Annotated[float, Field(ge=0.0, le=0.01, description="m")]

USUAL_LAG = 300.0
"""Of 3 mm of polymer in moving air, s: c h rho/(2 alpha), alpha = 10 W/m2K."""


class Tolerances(Declared):
    """``[tolerances]``: standard deviations; 0 for what is exact.

    Attributes
    ----------
    length : float
        Of the plate's extents along x and y, m.
    thickness, mass : float
        Of the plate, as a share.
    patch_place, patch_size : float
        Of a patch's centre along x and along y, and of each of its sides, m.
    patch_thickness, patch_modulus, strain_constant, permittivity : float
        Of each patch, as a share; the strain constant is d31. Ceramics of one name, and their bonds, differ by
        more in stiffness than any thickness is wrong by.
    input_resistance, input_capacitance : float
        Of the card's inputs with their cables, as a share.
    transducer_place : float
        Of a force's or a motion sensor's centre along x and along y, m.
    transducer_mass : float
        Of an accelerometer that is not laid aside weightless, with what holds it, kg.
    transducer_contact : float
        Of the area over which a force acts, or an accelerometer averages, as a share: a base that does not bend
        does not average as a disc does, and a tip rarely touches with all of its face. 1 is as far as a point.
    attachment_place : float
        Of a string's or a cable's point along x and along y, m: felt where an effect acts there.
    place_contact : float
        Of how the plate gives way under something that nobody declared, natural logarithm: it depends on the area
        that is held, 0.7 is a factor of two. Felt where an effect acts at such a place.
    sensitivity : float
        Of a motion sensor with all its points, as a share; that of the drive is the gain, which is always free.
    oven_offset : float
        Of the plate's temperature at room temperature, less the reading, K.
    oven_slope : float
        Of the same, per kelvin above it, as a share.
    plate_lag : float
        Of the plate's lag behind the air, s, in sweeps of one ramp at temperatures of the air: where nothing
        recorded tells it.
    moduli, transverse_shear : float
        Of an orthotropic sheet: of each of Ex, Ey and G12, and of each transverse shear modulus where these are
        declared (where not, a factor of e; 0 holds them there too), natural logarithms; 0.25 is about 25 %.
    loss_direction : float
        Of such a sheet: natural logarithm of the ratios of its loss factors along x, along y and in shear.
    plate_shear : float
        Of the transverse shear modulus of an isotropic plate, over E / 2 (1 + nu), as a share: a drawn or rolled
        sheet has it within some per cent, and a plate that shears just so would tell its thickness.
    plate_theory : float
        Share of what elasticity adds to the theory of plates that may be missing: a real plate has all of it, one
        computed by Mindlin's theory nothing.
    own : mapping
        Of single quantities, by their place in the declaration (``plate.thickness``, ``patch.S1.center``), in the
        unit of the quantity; declared there: ``thickness = { value = 0.003, tolerance = 3e-5 }``.
    """

    length: Distance = 2e-4
    thickness: Share = 0.005
    mass: Share = 0.001
    patch_place: Distance = 3e-4
    patch_size: Distance = 1e-4
    patch_thickness: Share = 0.02
    patch_modulus: Share = 0.05
    strain_constant: Share = 0.05
    permittivity: Share = 0.1
    input_resistance: Share = 0.02
    input_capacitance: Share = 0.05
    transducer_place: Distance = 5e-4
    transducer_mass: Annotated[float, Field(ge=0.0, le=0.01, description="kg")] = 5e-5
    transducer_contact: Annotated[float, Field(ge=0.0, le=3.0)] = 1.0
    attachment_place: Distance = 5e-4
    place_contact: Logarithm = 0.7
    sensitivity: Share = 0.02
    oven_offset: Annotated[float, Field(ge=0.0, le=10.0, description="K")] = 0.3
    oven_slope: Annotated[float, Field(ge=0.0, le=0.1)] = 0.005
    plate_lag: Annotated[float, Field(ge=0.0, le=7200.0, description="s")] = USUAL_LAG
    moduli: Logarithm = 0.25
    transverse_shear: Logarithm = 0.3
    loss_direction: Logarithm = 0.7
    plate_shear: Share = 0.03
    plate_theory: Annotated[float, Field(ge=0.0, le=3.0)] = 1.0
    own: dict[str, Annotated[float, Field(ge=0.0)]] = Field(default_factory=dict, max_length=1000)

    @classmethod
    def exact(cls) -> Self:
        """Return those of a declaration in which everything is exact, as of a computed campaign."""
        return cls.model_validate(dict.fromkeys(cls.model_fields.keys() - {"own"}, 0.0))

    def of(self, place: str, usual: float) -> float:
        """Return the tolerance of a quantity at a place: its own, else `usual`; in the quantity's unit."""
        return self.own.get(place, usual)


ALLOWED = {
    "plate": ("thickness", "mass", "length_x", "length_y"),
    "patch": ("center", "size", "thickness"),
    "drive": ("point", "radius"),
    "sensor": ("point", "mass", "radius"),
    "acquisition": ("input_resistance", "input_capacitance"),
}
"""Keys of each table that may be declared with a tolerance of their own."""


def without_tolerances(table: Mapping[str, Any]) -> dict[str, Any]:
    """Return a declaration whose ``{ value, tolerance }`` are values, the tolerances under ``tolerances.own``.

    ValueError, with the place, for a key that cannot have one, or a tolerance that is no number of at least 0.
    """
    found: dict[str, Any] = dict(table)
    own: dict[str, float] = {}
    for name in ALLOWED:
        part = table.get(name)
        if isinstance(part, Mapping):
            found[name] = _values(name, name, part, own)
        elif isinstance(part, (list, tuple)):
            found[name] = [
                _values(name, f"{name}.{one.get('id', place)}", one, own) if isinstance(one, Mapping) else one
                for place, one in enumerate(part)
            ]
    if own:
        given = table.get("tolerances", {})
        kinds = dict(given) if isinstance(given, Mapping) else given.model_dump()
        found["tolerances"] = {**kinds, "own": {**kinds.get("own", {}), **own}}
    return found


def _values(kind: str, place: str, part: Mapping[str, Any], own: dict[str, Any]) -> dict[str, Any]:
    """Return a table with values only; tolerances are put into `own`."""
    found = dict(part)
    for key, item in part.items():
        if not (isinstance(item, Mapping) and set(item) == {"value", "tolerance"}):
            continue
        if key not in ALLOWED[kind]:
            raise ValueError(
                f"{place}.{key} has a tolerance of its own; allowed for {', '.join(ALLOWED[kind])} of {kind}"
            )
        tolerance = item["tolerance"]
        if isinstance(tolerance, bool) or not isinstance(tolerance, (int, float)) or not tolerance >= 0.0:
            raise ValueError(f"{place}.{key}: tolerance {tolerance!r}; a number of at least 0 wanted, in its unit")
        found[key], own[f"{place}.{key}"] = item["value"], float(tolerance)
    return found
