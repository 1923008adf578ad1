"""Bytes and multiplications that filters cost on the target."""

from dataclasses import dataclass
from typing import Self

from analysis.rendering.following import FollowingBank, TanhWeights, TiltBank


@dataclass(frozen=True)
class Cost:
    """What the C code takes.

    Attributes
    ----------
    constant_bytes : int
        Banks and tables, in read-only memory.
    state_bytes : int
        Two sets of taps and the past of the input, in memory.
    update_operations : int
        Multiply-adds of one change of temperature.
    sample_operations : int
        Multiply-adds of one sample of audio for all actuators; twice as many during a fade.
    """

    constant_bytes: int
    state_bytes: int
    update_operations: int
    sample_operations: int

    @classmethod
    def of(
        cls,
        filters: FollowingBank,
        fixed_point: bool,
        block: int,
        tilt: TiltBank | None = None,
        thermometers: int = 0,
    ) -> Self:
        """Count for float32 or, fixed point, int16.

        Parameters
        ----------
        block : int
            Samples filtered at a time.
        tilt : TiltBank, optional
            Filters of the tilt, with the number of `thermometers` that tell it.
        """
        actuators, weights, taps = filters.banks.shape
        size = 2 if fixed_point else 4
        tables = 8 * len(filters.input.temperature) + (4 * actuators * weights if fixed_point else 0)
        if isinstance(filters.weights, TanhWeights):
            tables += 8 * filters.weights.slope.size
            per_update = filters.weights.slope.size
        else:
            tables += 4 * (filters.weights.coefficients.size + len(filters.weights.knots))
            per_update = 3 * weights
        banks, state = filters.banks.size, 12
        if tilt is not None:
            banks, state = banks + tilt.banks.size, state + 8
            tables += 4 * (tilt.weights.coefficients.size + len(tilt.weights.knots) + 3 * thermometers)
            tables += 4 * tilt.banks[..., 0].size if fixed_point else 0
            per_update += tilt.banks.size + 3 * thermometers + 5 * tilt.banks[..., 0].size
        return cls(
            constant_bytes=size * banks + tables,
            state_bytes=-(-size * (2 * actuators * taps + taps - 1 + block) // 4) * 4 + state,
            update_operations=actuators * weights * taps + per_update,
            sample_operations=actuators * taps,
        )
