"""Gauss–Newton equations of a one-hidden-layer network with linear outputs, solved without forming the matrix.

A network of H hidden nodes and M outputs has 2H + M(H+1) parameters. With one α (weights) and one β
(errors) for all of them, β JᵀJ + α I is a block arrow: M equal blocks S = β ZᵀZ + α I of order H+1, one
for the weights into each output, and a border of the 2H hidden parameters. So a step costs one
factorization of Z and one system of order 2H, whatever M is, and so do the trace and the determinant for MacKay's
evidence. Moreover ‖·‖² and JᵀJ are invariant under a rotation of the M outputs: `analysis.compensation.batch`
rotates 512 taps to the few directions that the training filters span.

Tensors carry a leading axis B, see `analysis.compensation.linearised`.
"""

from analysis.compensation.linearised import Linearised, Weights
from analysis.compensation.tensors import Tensor, namespace


def step(weights: Weights, at: Linearised, alpha: Tensor, beta: Tensor, damping: Tensor) -> Weights:
    """Levenberg–Marquardt step of β E_D + α E_W: solves (β JᵀJ + (α + μ) I) d = -(β Jᵀe + α w).

    Parameters
    ----------
    at : Linearised
        The networks at `weights`.
    alpha, beta : (B,) Tensor
        Weights of the squared parameters and of the squared scaled errors.
    damping : (B,) Tensor
        μ, added to α in the matrix alone.

    Returns
    -------
    Weights
        The step d, to be added to `weights`.

    Raises
    ------
    LinAlgError
        Of numpy or torch, where the border matrix is singular to the digits at hand.
    """
    xp, a, b = namespace(alpha), alpha[:, None, None], beta[:, None, None]
    ridge = alpha + damping
    hidden = weights.output[:, :-1]
    gradient = b * at.features.mT @ at.error + a * weights.output
    pulled = at.error @ hidden.mT
    own = beta[:, None] * (at.slopes * xp.concat([pulled, pulled], 2)).sum(1) + alpha[:, None] * xp.concat(
        [weights.slope, weights.bias], 1
    )
    solved = _solve_outputs(at, gradient, ridge, beta)
    coupled = at.features @ solved @ hidden.mT
    own = own - beta[:, None] * (at.slopes * xp.concat([coupled, coupled], 2)).sum(1)
    move = -xp.linalg.solve(_border(at, ridge, beta), own[..., None])[..., 0]
    nodes = weights.slope.shape[1]
    slope, bias = move[:, :nodes], move[:, nodes:]
    by_slope, by_bias = at.slopes[..., :nodes], at.slopes[..., nodes:]
    tilt = by_slope * slope[:, None, :] + by_bias * bias[:, None, :]
    change = _solve_outputs(at, b * at.features.mT @ (tilt @ hidden), ridge, beta)
    return Weights(slope, bias, -solved - change)


def inverse_trace(at: Linearised, alpha: Tensor, beta: Tensor, outputs: int) -> Tensor:
    """Trace of (β JᵀJ + α I)⁻¹, from the blocks of the arrow and its border.

    Parameters
    ----------
    at : Linearised
        The networks at their weights.
    alpha, beta : (B,) Tensor
        Weights of the squared parameters and of the squared scaled errors.
    outputs : int
        Outputs M of a network, rotated away or not.

    Returns
    -------
    (B,) Tensor

    Raises
    ------
    LinAlgError
        Of numpy or torch, where the border matrix is singular to the digits at hand.
    """
    order = at.right.shape[-1]
    blocks = outputs * (1.0 / (beta[:, None] * at.power[:, :order] + alpha[:, None])).sum(1)
    count = at.rotated.shape[1]
    weight = beta[:, None] ** 2 * at.power[:, :count] / (beta[:, None] * at.power[:, :count] + alpha[:, None]) ** 2
    through = (at.rotated.mT * weight[:, None, :]) @ at.rotated * at.overlap
    xp = namespace(alpha)
    border = xp.linalg.solve(_border(at, alpha, beta), _identity(through) + through)
    return blocks + xp.linalg.diagonal(border).sum(1)


def log_determinant(at: Linearised, alpha: Tensor, beta: Tensor, outputs: int) -> Tensor:
    """Logarithm of the determinant of β JᵀJ + α I, from the blocks of the arrow and its border.

    Parameters
    ----------
    at : Linearised
        The networks at their weights.
    alpha, beta : (B,) Tensor
        Weights of the squared parameters and of the squared scaled errors.
    outputs : int
        Outputs M of a network, rotated away or not.

    Returns
    -------
    (B,) Tensor

    Raises
    ------
    LinAlgError
        Of numpy or torch, where the border matrix is singular to the digits at hand.
    """
    xp, order = namespace(alpha), at.right.shape[-1]
    blocks = outputs * xp.log(beta[:, None] * at.power[:, :order] + alpha[:, None]).sum(1)
    return blocks + xp.linalg.slogdet(_border(at, alpha, beta))[1]


def _solve_outputs(at: Linearised, right_hand: Tensor, ridge: Tensor, beta: Tensor) -> Tensor:
    order = at.right.shape[-1]
    scale = 1.0 / (beta[:, None] * at.power[:, :order] + ridge[:, None])
    return at.right.mT @ (scale[:, :, None] * (at.right @ right_hand))


def _border(at: Linearised, ridge: Tensor, beta: Tensor) -> Tensor:
    """Schur complement (B, 2H, 2H) of the output blocks.

    Written as Dᵀ(I + β/ridge ZZᵀ)⁻¹D, whose eigenvalues are positive term by term; subtracting
    β² DᵀZ S⁻¹ ZᵀD from β DᵀD loses all digits once β ZᵀZ dwarfs the ridge.
    """
    count = at.rotated.shape[1]
    weight = beta[:, None] * ridge[:, None] / (beta[:, None] * at.power[:, :count] + ridge[:, None])
    schur = (at.rotated.mT * weight[:, None, :]) @ at.rotated * at.overlap
    return schur + ridge[:, None, None] * _identity(schur)


def _identity(like: Tensor) -> Tensor:
    return namespace(like).eye(like.shape[-1], dtype=like.dtype, device=like.device)
