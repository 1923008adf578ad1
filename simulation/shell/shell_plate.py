"""A declared plate with patches on a mesh: sections of every cell, and blocks of its matrices.

Lines that the mesh of a declared plate follows, and the mesh itself.

The force of one volt on each of its patches, too.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from analysis.arrays import Mask, Real
from analysis.experiment import Patch, Plate
from analysis.material import Orthotropy
from simulation.meshing.foreign import foreign_mesh
from simulation.meshing.mesher import Border, mesh_plate
from simulation.meshing.plate_mesh import MeshRecipe, PlateMesh
from simulation.shell.edges import LineBlock, held_functions, spring_blocks
from simulation.shell.piezo_material import PIEZO_MATERIALS, PiezoMaterial
from simulation.shell.rigidity import (
    SHEAR_FACTOR,
    THX,
    THY,
    Block,
    CellMatrices,
    CurvedSurface,
    InPlane,
    Rigidity,
    Transverse,
    U,
    V,
    Weight,
    laminate,
    matrix,
)
from simulation.shell.space import ShapeSpace


@dataclass(frozen=True)
class ShellPlate:
    """A plate, its patches and the space of functions on its mesh.

    Attributes
    ----------
    plate : Plate
    patches : tuple of Patch
    space : ShapeSpace
    materials : mapping
        Piezo material of each ``Patch.material``.
    """

    plate: Plate
    patches: tuple[Patch, ...]
    space: ShapeSpace
    materials: Mapping[str, PiezoMaterial] = field(default_factory=lambda: PIEZO_MATERIALS)

    @classmethod
    def of(
        cls,
        plate: Plate,
        patches: Sequence[Patch] = (),
        *,
        recipe: MeshRecipe | None = None,
        degree: int = 6,
        materials: Mapping[str, PiezoMaterial] = PIEZO_MATERIALS,
    ) -> "ShellPlate":
        """Mesh a plate and its patches.

        Parameters
        ----------
        recipe : MeshRecipe, optional
            Not used where the plate declares a mesh.
        degree : int
            Of the functions.
        materials : mapping
            Piezo material of each ``Patch.material``.

        Raises
        ------
        GeometryError
            If no good mesh is found, or a declared one does not fit, with the place.
        ValueError
            For a degree outside 1 to 12.
        """
        mesh = mesh_of(plate, patches, recipe)
        return cls(plate, tuple(patches), ShapeSpace.on(mesh, degree), materials)

    @cached_property
    def cells(self) -> CellMatrices:
        """Matrices of the cells."""
        return CellMatrices(self.space)

    @cached_property
    def thickness(self) -> Real:
        """Of every cell as declared, (cells,), m."""
        found = np.full(self.space.mesh.cells, self.plate.thickness)
        for k, zone in enumerate(self.plate.zone):
            found[self.space.mesh.inside[f"zone {k + 1}"]] = zone.thickness
        return found

    @cached_property
    def under(self) -> tuple[Mask, ...]:
        """Cells under each patch, (cells,) each."""
        return tuple(self.space.mesh.inside[f"patch {k + 1}"] for k in range(len(self.patches)))

    @cached_property
    def capacitance(self) -> Real:
        """Cp of every patch at zero in-plane strain, (P,), F."""
        ceramics = [self.materials[patch.material] for patch in self.patches]
        return np.array(
            [c.permittivity * p.area / p.thickness for c, p in zip(ceramics, self.patches, strict=True)]
        )

    @cached_property
    def surface(self) -> CurvedSurface | None:
        """Mid-surface at the points of quadrature; None for a flat plate."""
        return None if self.plate.curvature is None else CurvedSurface.of(self.plate, self.space.points)

    @cached_property
    def density(self) -> float:
        """Mass over volume, kg/m3; a curved plate has more than its drawing."""
        if self.surface is None:
            return self.plate.density
        volume = self.space.spread(self.thickness) * self.space.dx
        return self.plate.density * float(volume.sum() / (volume @ self.surface.area))

    @cached_property
    def held(self) -> Mask:
        """Functions of every field that supports hold at zero, (5, N)."""
        return held_functions(self.space, self.plate)

    def springs(self, *, damping: bool = False) -> Iterator[LineBlock]:
        """Stiffness of elastic supports along edges, or with `damping` their dashpots, N s/m2 and the like."""
        return spring_blocks(self.space, self.plate, damping=damping)

    @cached_property
    def sheet(self) -> Orthotropy:
        """Declared orthotropy of the material; none unless declared."""
        material = self.plate.material
        return (material.departure if material is not None else None) or Orthotropy(0.0, 0.0)

    @cached_property
    def orthotropic(self) -> bool:
        """Whether the material is declared orthotropic."""
        material = self.plate.material
        return material is not None and material.departure is not None

    def plate_stiffness(self, q: InPlane, shear: Transverse, thickness: Weight) -> Rigidity:
        """Return the rigidity of the plate alone: a layer symmetric about the mid-plane.

        Parameters
        ----------
        q : tuple of six
            Q11, Q22, Q12, Q66, Q16 and Q26 of the sheet, Pa.
        shear : tuple of three
            Transverse, see `simulation.shell.rigidity.transverse`, Pa.
        thickness : float or ndarray
            m.
        """
        plane = matrix(q)
        return self._rigidity(
            [[m * thickness for m in row] for row in plane],
            None,
            [[m * (1.0 / 12.0 * thickness**3) for m in row] for row in plane],
            tuple(SHEAR_FACTOR * (one * thickness) for one in shear),
        )

    def patch_stiffness(self, thickness: Real, bond: float = 1.0, share: Real | float = 1.0) -> Rigidity:
        """Return the rigidity of all patches on a plate of this thickness, per cell or per point.

        Parameters
        ----------
        thickness : (C,) or (C, Q) ndarray
            Of the plate, m.
        bond : float
            Factor on the membrane stiffness that acts at the patches' mid-height.
        share : float or (P,) ndarray
            Factor on all stiffness, of each patch.
        """
        a = [[np.zeros_like(thickness) for _ in range(3)] for _ in range(3)]
        b = [[np.zeros_like(thickness) for _ in range(3)] for _ in range(3)]
        d = [[np.zeros_like(thickness) for _ in range(3)] for _ in range(3)]
        shear = np.zeros_like(thickness)
        shares = np.broadcast_to(share, len(self.patches))
        for (patch, covered, height), own in zip(self._layers(thickness), shares, strict=True):
            place = own * covered
            q11, q12 = self.materials[patch.material].stiffness
            t = patch.thickness
            plane = matrix((q11, q11, q12, 0.5 * (q11 - q12), 0.0, 0.0))
            for i in range(3):
                for j in range(3):
                    value = plane[i][j]
                    a[i][j] = a[i][j] + value * bond * t * place
                    b[i][j] = b[i][j] + value * bond * t * height * place
                    d[i][j] = d[i][j] + value * (bond * t * height**2 + t**3 / 12.0) * place
            shear = shear + SHEAR_FACTOR * 0.5 * (q11 - q12) * t * place
        return self._rigidity(a, b, d, (shear, shear, 0.0))

    def inertia(
        self, thickness: Real, *, plate: bool = True, patches: bool = True, denser: Weight = 1.0
    ) -> Iterator[Block]:
        """Mass of plate and patches.

        Parameters
        ----------
        thickness : (cells,) or (Q,) ndarray, m
            Of the plate, for every cell or every point of quadrature.
        plate, patches : bool
            Whether to include the plate's own mass, and that of its patches.
        denser : float or ndarray
            Factor on the plate's density.
        """
        density, surface = self.density if plate else 0.0, self.surface
        if surface is not None and len(thickness) == self.space.mesh.cells:
            thickness = self.space.spread(thickness)
        straight, turning = density * denser * thickness, density * denser * thickness**3 / 12.0
        first = np.zeros_like(thickness)
        for patch, place, height in self._layers(thickness) if patches else ():
            area = self.materials[patch.material].density * patch.thickness * place
            straight = straight + area
            first = first + area * height
            turning = turning + area * (height**2 + patch.thickness**2 / 12.0)
        if surface is None:
            return self.cells.inertia(straight, first if first.any() else None, turning)
        straight, first, turning = (surface.area * one for one in (straight, first, turning))
        return self.cells.inertia(straight, first if first.any() else None, turning, surface.slope)

    def on(self, space: ShapeSpace) -> "ShellPlate":
        """Return the same plate on another space."""
        return replace(self, space=space)

    def _layers(self, thickness: Real) -> Iterator[tuple[Patch, Real, Real]]:
        """Yield every patch, its indicator function (1 or 0), and its mid-height over the mid-plane, m."""
        for patch, cells in zip(self.patches, self.under, strict=True):
            place = cells.astype(float)
            if len(thickness) != len(place):
                place = self.space.spread(place)
            height = 0.5 * (thickness + patch.thickness)
            yield patch, place, height if patch.side == "top" else -height

    def _rigidity(
        self,
        a: Sequence[Sequence[Weight]],
        b: Sequence[Sequence[Weight]] | None,
        d: Sequence[Sequence[Weight]],
        shear: Sequence[Weight],
    ) -> Rigidity:
        entries = laminate(a, b, d, shear)
        used = tuple((place, value) for place, value in entries if np.any(value))
        if self.surface is None:
            return Rigidity(used)
        spread = (
            (place, self.space.spread(v) if not isinstance(v, float) and len(v) == self.space.mesh.cells else v)
            for place, v in used
        )
        return Rigidity(tuple((place, self.surface.area * v) for place, v in spread), self.surface)


def borders_of(plate: Plate, patches: Sequence[Patch]) -> list[Border]:
    """Borders of outline, holes, zones, patches, and discs of supports at points.

    A mesh from another program has a disc only where a support is clamped.
    """
    borders = [Border("outline", plate.loop, "outline")]
    borders += [Border(f"hole {k + 1}", loop, "hole") for k, loop in enumerate(plate.hole_loops)]
    borders += [Border(f"zone {k + 1}", loop) for k, loop in enumerate(plate.zone_loops)]
    borders += [Border(f"patch {k + 1}", patch.loop) for k, patch in enumerate(patches)]
    borders += [
        Border(name, disc)
        for name, (support, disc) in plate.supported_discs().items()
        if plate.mesh is None or support.kind == "clamped"
    ]
    return borders


def mesh_of(plate: Plate, patches: Sequence[Patch], recipe: MeshRecipe | None = None) -> PlateMesh:
    """Mesh a plate and its patches, or take the mesh that it declares.

    Parameters
    ----------
    recipe : MeshRecipe, optional
        Not used where the plate declares a mesh.

    Raises
    ------
    GeometryError
        If no good mesh is found, or a declared one does not fit, with the place.
    """
    loops = (plate.loop, *plate.hole_loops)
    cuts = [
        (float(x), float(y))
        for held in plate.supported_edges()
        for curve, first, last in held.pieces
        for x, y in loops[held.loop].curves[curve].at([first, last])
    ]
    borders = borders_of(plate, patches)
    if plate.mesh is not None:
        return foreign_mesh(plate.mesh, borders, cuts)
    return mesh_plate(borders, plate.thickness, recipe, cuts)


def couplings(shell: ShellPlate, thickness: Real, bond: float = 1.0) -> list[dict[int, Real]]:
    """Force of one volt on every patch.

    Parameters
    ----------
    thickness : (cells,) or (Q,) ndarray
        Of the plate, for every cell or every point of quadrature, m.
    bond : float
        Share of the force transmitted by the bond.

    Returns
    -------
    list of dict of int to (N,) ndarray
        Of each patch, by field, values over the functions, N/V.
    """
    found = []
    for k, patch in enumerate(shell.patches):
        h = thickness if len(thickness) == len(shell.space.dx) else shell.space.spread(thickness)
        sign = 1.0 if patch.side == "top" else -1.0
        height = 0.5 * sign * (h + patch.thickness)
        factor = bond * shell.materials[patch.material].e31
        found.append(_dilatation(shell, k, factor * np.ones_like(h), factor * height))
    return found


def _dilatation(shell: ShellPlate, patch: int, flat: Real, height: Real) -> dict[int, Real]:
    """Integral under a patch of flat (u,x + v,y) + height (thx,x + thy,y), (Q,) each, by field (N,)."""
    cells = shell.under[patch]
    moments = shell.space.moments
    if shell.surface is None:
        return {
            U: moments("x", flat, cells),
            V: moments("y", flat, cells),
            THX: moments("x", height, cells),
            THY: moments("y", height, cells),
        }
    found: dict[int, Real] = {}
    for weight, strains in ((flat, (0, 1)), (height, (3, 4))):
        for strain in strains:
            for (unknown, letter), factor in shell.surface.strains[strain].items():
                part = moments(letter, shell.surface.area * weight * factor, cells)
                found[unknown] = found.get(unknown, 0.0) + part
    return found
