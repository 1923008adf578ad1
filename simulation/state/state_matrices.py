"""Sparse matrices of a plate in any state, with fields at the points of quadrature.

Where a patch has an offset from its declared place, the mesh is deformed.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.sparse import csr_matrix

from analysis.arrays import Real
from analysis.channel import Footprint
from analysis.geometry.loop import Loop
from analysis.geometry.relations import overlap
from simulation.shell.points import footprint_rows
from simulation.shell.rigidity import W, moduli, transverse
from simulation.shell.shell_model import ShellModel
from simulation.shell.shell_plate import ShellPlate, couplings
from simulation.shell.space import ShapeSpace
from simulation.shell.unknowns import Unknowns
from simulation.state.plate_state import PlateState


@dataclass(frozen=True)
class StateMatrices:
    """A plate in one state: Z = storage K + j loss K_loss + Kp - w**2 M + (j w r - w**2 m) W.

    Attributes
    ----------
    plate, plate_loss, patches, mass, normal : (n, n) csr_matrix
        K, K_loss (already times the loss factor), Kp, M, and W, the integral of w times w.
    coupling : (n, P + S) ndarray
        Of the patches, then of the given footprints.
    """

    plate: csr_matrix
    plate_loss: csr_matrix
    patches: csr_matrix
    mass: csr_matrix
    normal: csr_matrix
    coupling: Real


LARGEST_REACH = 0.020
"""Largest distance from the patch at which cells are deformed, m."""
RIGID_SHARE = 1.0 / 6.0
"""Largest share of the free distance around the patch that moves rigidly with it or stays fixed, like strips."""
LEAST_ROOM = 0.4
"""Share of the free distance that must remain."""


def moved_space(
    shell: ShellPlate, patch: int, shift: tuple[float, float], larger: tuple[float, float] = (0.0, 0.0)
) -> ShapeSpace:
    """Space over the mesh with one patch moved, or enlarged; functions and their numbers stay.

    Integrals depend smoothly on the shift. Cells under other patches, and their matrices, do not change.

    Parameters
    ----------
    patch : int
        Index among the plate's patches.
    shift : (float, float)
        m.
    larger : (float, float)
        Along its first side and along its second, m.

    Raises
    ------
    ValueError
        For a patch that does not exist, too large a shift, or another patch on the opposite face.
    """
    if not 0 <= patch < len(shell.patches):
        raise ValueError(f"patch {patch} does not exist; the plate has {len(shell.patches)}")
    mesh, plate = shell.space.mesh, shell.plate
    own = shell.patches[patch].loop
    neighbours = [other.loop for k, other in enumerate(shell.patches) if k != patch]
    if any(overlap(own, other) is not None for other in neighbours):
        raise ValueError(f"patch {shell.patches[patch].id!r} lies opposite another one and cannot be moved alone")
    discs = [disc for _, disc in plate.supported_discs().values()]
    walls = [plate.loop, *plate.hole_loops, *plate.zone_loops, *discs]
    others = walls + neighbours
    room = min(float(other.distance(own.polygon).min()) for other in others)
    room = min(room, min(float(own.distance(other.polygon).min()) for other in others))
    if np.hypot(*shift) + max(map(abs, larger)) > (1.0 - LEAST_ROOM) * room:
        raise ValueError(f"patch {shell.patches[patch].id!r} moved by {shift} m has not the room around it")
    rigid = min(RIGID_SHARE * room, plate.thickness)
    near = np.maximum(_outside(own, mesh.points) - rigid, 0.0)
    away = [wall.distance(mesh.points) for wall in walls] + [_outside(other, mesh.points) for other in neighbours]
    far = np.min(away, axis=0)
    far = np.maximum(np.minimum(far - rigid, LARGEST_REACH), 0.0)
    share = np.maximum(0.0, np.minimum(far / np.maximum(near + far, 1e-12), 1.0 - near / LARGEST_REACH))
    share = np.where(near == 0.0, 1.0, share)
    low, high = own.bounds
    angle = np.deg2rad(shell.patches[patch].angle)
    axes = np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
    along = (mesh.points - 0.5 * np.add(low, high)) @ axes.T
    stretched = (np.divide(larger, shell.patches[patch].size) * along) @ axes
    moved = shell.space.moved(share[:, None] * (np.asarray(shift) + stretched))
    for here, there in zip(shell.space.groups, moved.groups, strict=True):
        if len(here.dx) and (there.dx < 0.2 * here.dx).any():
            raise ValueError(
                f"patch {shell.patches[patch].id!r} moved by {shift} m leaves no space for the cells around it"
            )
    return moved


def _outside(loop: Loop, points: Real) -> Real:
    """Distance from the inside of a loop, (K,); zero within."""
    return np.where(loop.contains(points), 0.0, loop.distance(points))


@dataclass(frozen=True)
class FullPlate:
    """A meshed plate with patches that can be assembled in any state.

    Attributes
    ----------
    shell : ShellPlate
    unknowns : Unknowns
    supports : (n, n) csr_matrix
        Stiffness of springs along edges and at points.
    damping : (n, n) csr_matrix
        Of dashpots there, N s/m; not included in `StateMatrices`.
    """

    shell: ShellPlate
    unknowns: Unknowns
    supports: csr_matrix
    damping: csr_matrix

    @classmethod
    def of(cls, model: ShellModel) -> "FullPlate":
        """Take mesh and unknowns of an assembled plate."""
        return cls(model.shell, model.unknowns, model.unknowns.springs(model.shell), model.damping)

    @property
    def moved(self) -> int:
        """The patch that a state's offset moves: the first sensor."""
        roles = [patch.role for patch in self.shell.patches]
        return roles.index("sensor") if "sensor" in roles else 0

    @property
    def sampling(self) -> tuple[Real, Real]:
        """Return xi and zeta of all points of quadrature; of a moved sensor's, see `moved_by`."""
        return self.shell.plate.normalised(self.shell.space.points)

    def moved_by(
        self, dx: float, dy: float, patch: int | None = None, larger: tuple[float, float] = (0.0, 0.0)
    ) -> "FullPlate":
        """Return the plate with one patch moved by (dx, dy) m, or enlarged.

        Parameters
        ----------
        dx, dy : float
            m.
        patch : int, optional
            The first sensor unless given.
        larger : (float, float)
            Along its first side and along its second, m.

        Raises
        ------
        ValueError
            If there is no space for it.
        """
        moving = self.moved if patch is None else patch
        return replace(self, shell=self.shell.on(moved_space(self.shell, moving, (dx, dy), larger)))

    def matrices(
        self, state: PlateState, *, loss: bool = True, footprints: Sequence[Footprint] = ()
    ) -> StateMatrices:
        """Assemble a state, without its discs and point loads; of its departures those of the sheet's moduli.

        Footprints stay on their cells: near a sensor with an offset they move with the deformed mesh.

        Parameters
        ----------
        state : PlateState
            With fields at the points of `sampling`, those of the moved plate if it has an offset.
        loss : bool
            Whether K_loss is assembled; it is left at zero otherwise.
        footprints : sequence of Footprint
            Further columns of the coupling, after those of the patches.

        Raises
        ------
        ValueError
            For an offset for which there is no space.
        """
        here = self
        if state.offset_x or state.offset_y:
            here = self.moved_by(state.offset_x, state.offset_y)
        shell, over = here.shell, self.unknowns
        thickness = shell.space.spread(shell.thickness) * state.thickness
        plate = here._plate(state, thickness)
        held = np.broadcast_to(1.0 - np.asarray(state.debonded), len(shell.patches))
        patches = shell.patch_stiffness(thickness, state.bond, held)
        columns = [over.vector(one) for one in couplings(shell, thickness, state.bond)]
        columns = [share * column for share, column in zip(held, columns, strict=True)]
        columns += list(over.rows(footprint_rows(self.shell.space, footprints), W).toarray()) if footprints else []
        return StateMatrices(
            plate=plate,
            plate_loss=here._loss(state, thickness) if loss else csr_matrix(plate.shape),
            patches=csr_matrix(over.matrix(shell.cells.of(patches)) + self.supports),
            mass=over.matrix(shell.inertia(thickness, denser=state.density)),
            normal=over.matrix(shell.cells.normal()),
            coupling=np.array(columns).reshape(len(columns), over.size).T,
        )

    def _loss(self, state: PlateState, thickness: Real) -> csr_matrix:
        """Imaginary part of the stiffness of plate and patches."""
        plate = self._plate(state, thickness, lossy=True)
        if not np.any(state.patch_loss):
            return plate
        share = state.patch_loss * state.bond
        whole, own = (self.shell.patch_stiffness(thickness, bond, share) for bond in (1.0, 0.0))
        membrane = [self.unknowns.matrix(self.shell.cells.of(one)) for one in (whole, own)]
        return csr_matrix(plate + membrane[0] - membrane[1])

    def _plate(self, state: PlateState, thickness: Real, *, lossy: bool = False) -> csr_matrix:
        """Stiffness of the plate, or with `lossy` its imaginary part."""
        nu = state.laws.poisson_ratio(state.temperature)
        c1 = state.modulus * state.laws.youngs_modulus(state.temperature) / (1.0 - nu**2)
        shear = 0.5 * c1 * (1.0 - nu)
        away = state.departures
        factors = [
            state.modulus_x * away.modulus_x,
            state.modulus_y * away.modulus_y,
            state.in_plane_shear * away.in_plane_shear,
        ]
        cross = 1.0
        if lossy:
            c1, shear = (state.laws.loss_factor(state.temperature) * one for one in (c1, shear * state.loss_shear))
            # both ratios so that Q12 and Q66 get their own loss factors, whatever their neighbours have
            cross = state.loss_cross / np.sqrt(state.loss_x * state.loss_y)
            own = (1.0 - nu) / (1.0 - nu * cross)
            for place, one in enumerate((state.loss_x, state.loss_y, own * state.loss_shear)):
                factors[place] = factors[place] * one
        q = moduli(self.shell.sheet, c1, nu * cross * c1, *factors)
        across = transverse(self.shell.sheet, shear * state.transverse_shear, away.shear_x, away.shear_y)
        return self.unknowns.matrix(self.shell.cells.of(self.shell.plate_stiffness(q, across, thickness)))
