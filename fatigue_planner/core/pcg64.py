"""Uniform random numbers as a part of compiled code: those of NumPy's generator PCG64, bit for bit.

Numba calls NumPy for every number, which takes longer than the number itself and keeps the processor from working on
anything else. A kernel that draws in every step is handed the generator's state instead (`Words`).
"""

from typing import Any

import numpy as np
from llvmlite import ir
from numba import types
from numba.extending import intrinsic, overload
from numpy.typing import NDArray

from fatigue_planner.core.jit import INLINED

# The state and the increment (4,), the low half of each first.
Words = NDArray[np.uint64]

# O'Neill 2014, PCG: A family of simple fast space-efficient statistically good algorithms; output function XSL RR.
MULTIPLIER = 0x2360ED051FC65DA44385DF649FCCF645
PRECISION = 2.0**-53
WORD, WHOLE = 2**64 - 1, 2**128 - 1


def words_of(rng: np.random.Generator) -> Words | None:
    """The state of a generator; None if it is no PCG64."""
    if type(rng.bit_generator) is not np.random.PCG64:
        return None
    own = rng.bit_generator.state["state"]
    return np.frombuffer(own["state"].to_bytes(16, "little") + own["inc"].to_bytes(16, "little"), np.uint64).copy()


def go_on(rng: np.random.Generator, words: Words) -> None:
    """Let a generator go on where its words have come to."""
    state = dict(rng.bit_generator.state)
    state["state"]["state"] = int.from_bytes(words[:2].tobytes(), "little")
    rng.bit_generator.state = state


def uniform(rng: Any) -> float:
    """The next number in [0, 1) of a generator, or of the words of one."""
    if isinstance(rng, np.random.Generator):
        return rng.random()
    low, high, low_added, high_added = (int(word) for word in rng)
    state = ((high << 64 | low) * MULTIPLIER + (high_added << 64 | low_added)) & WHOLE
    rng[0], rng[1] = state & WORD, state >> 64
    mixed, turn = (state >> 64 ^ state) & WORD, state >> 122
    return float((((mixed >> turn | mixed << (-turn & 63)) & WORD) >> 11) * PRECISION)


def below(rng: Any, count: int) -> int:
    """The next number of 0 ... count - 1, as `int(uniform(rng) * count)`."""
    return int(uniform(rng) * count)


@intrinsic  # type: ignore[untyped-decorator]
def _next(_typing: Any, words: Any) -> Any:
    """The 53 bits of which `uniform` with words makes its number."""

    def codegen(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        half, whole = ir.IntType(64), ir.IntType(128)
        data = context.make_array(signature.args[0])(context, builder, args[0]).data
        place, increment = (
            builder.bitcast(builder.gep(data, [ir.Constant(half, i)]), whole.as_pointer()) for i in (0, 2)
        )
        state = builder.mul(builder.load(place, align=8), ir.Constant(whole, MULTIPLIER))
        state = builder.add(state, builder.load(increment, align=8))
        builder.store(state, place, align=8)
        high = builder.trunc(builder.lshr(state, ir.Constant(whole, 64)), half)
        mixed, turn = builder.xor(high, builder.trunc(state, half)), builder.lshr(high, ir.Constant(half, 58))
        back = builder.and_(builder.neg(turn), ir.Constant(half, 63))
        turned = builder.or_(builder.lshr(mixed, turn), builder.shl(mixed, back))
        return builder.lshr(turned, ir.Constant(half, 11))

    return types.int64(words), codegen


@overload(uniform, strict=False, jit_options=INLINED)  # type: ignore[untyped-decorator]
def _uniform(rng: Any) -> Any:
    if isinstance(rng, types.Array):
        return lambda rng: _next(rng) * PRECISION
    return lambda rng: rng.random()


@overload(below, strict=False, jit_options=INLINED)  # type: ignore[untyped-decorator]
def _below(rng: Any, count: Any) -> Any:
    if not isinstance(rng, types.Array):
        return lambda rng, count: int(rng.random() * count)

    def drawn(rng: Any, count: int) -> int:
        bits = _next(rng)
        # of two, the first bit decides: no need to wait for a product of floating-point numbers
        return bits >> 52 if count == 2 else int(bits * PRECISION * count)

    return drawn
