"""The step of all entries at once, f = gain * state + offset, as vector code.

Numba compiles a loop over the entries to one entry after the other; this is the same in blocks of LANES
entries, which takes a quarter of the time. In plain Python it adds in the same order.
"""

from collections.abc import Callable
from typing import Any

import numba
import numpy as np
from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic
from numpy.typing import NDArray

Vector = NDArray[np.float64]
Array = NDArray[np.float64]

LANES = 8
CACHE_LINE = 64  # bytes


def aligned(array: NDArray[Any]) -> NDArray[Any]:
    """A copy whose memory begins at a cache line."""
    raw = np.zeros(array.nbytes + CACHE_LINE, np.uint8)
    skip = -raw.ctypes.data % CACHE_LINE
    copy = raw[skip : skip + array.nbytes].view(array.dtype).reshape(array.shape)
    copy[...] = array
    return copy


def _emit(context: Any, builder: Any, signature: Any, args: Any, store: bool) -> Any:
    """The sum of f^2 over a row's blocks of LANES entries, f = gain * state + offset; `store` writes f to state."""
    block = ir.VectorType(ir.DoubleType(), LANES)
    arrays = [
        context.make_array(kind)(context, builder, value) for kind, value in zip(signature.args, args[:3], strict=False)
    ]
    gain, offset, state = (array.data for array in arrays)
    width = cgutils.unpack_tuple(builder, arrays[0].shape)[1]
    first = builder.mul(args[3], width)
    lanes = ir.Constant(width.type, LANES)

    def at(pointer: Any, index: Any) -> Any:
        return builder.bitcast(builder.gep(pointer, [index]), block.as_pointer())

    total = cgutils.alloca_once_value(builder, ir.Constant(block, None))
    with cgutils.for_range(builder, builder.udiv(width, lanes)) as loop:
        j = builder.mul(loop.index, lanes)
        k = builder.add(first, j)
        g, o, s = (builder.load(at(p, i), align=8) for p, i in ((gain, k), (offset, k), (state, j)))
        f = builder.fadd(builder.fmul(g, s), o)
        if store:
            builder.store(f, at(state, j), align=8)
        builder.store(builder.fadd(builder.load(total), builder.fmul(f, f)), total)
    left = builder.load(total)
    size = LANES
    while size > 1:  # halves on halves
        size //= 2
        undefined = ir.Constant(left.type, ir.Undefined)
        masks = [ir.Constant(ir.VectorType(ir.IntType(32), size), [*range(i, i + size)]) for i in (0, size)]
        low, high = (builder.shuffle_vector(left, undefined, mask) for mask in masks)
        left = builder.fadd(low, high)
    return builder.extract_element(left, ir.Constant(ir.IntType(32), 0))


def _plain(gain: Array, offset: Array, state: Vector, row: int, store: bool) -> float:
    """What `_emit` compiles."""
    width = gain.shape[1]
    f = gain[row] * state[:width] + offset[row]
    if store:
        state[:width] = f
    lanes = np.zeros(LANES)
    for j in range(0, width, LANES):
        lanes += f[j : j + LANES] * f[j : j + LANES]
    while lanes.size > 1:
        lanes = lanes[: lanes.size // 2] + lanes[lanes.size // 2 :]
    return float(lanes[0])


def _compiled(store: bool) -> Callable[[Array, Array, Vector, int], float]:
    @intrinsic  # type: ignore[untyped-decorator]
    def step(typing: Any, gain: Any, offset: Any, state: Any, row: Any) -> Any:
        def codegen(context: Any, builder: Any, signature: Any, args: Any) -> Any:
            return _emit(context, builder, signature, args, store)

        return types.float64(gain, offset, state, types.intp), codegen

    found: Callable[[Array, Array, Vector, int], float] = step
    return found


def _interpreted(store: bool) -> Callable[[Array, Array, Vector, int], float]:
    return lambda gain, offset, state, row: _plain(gain, offset, state, row, store)


_make = _interpreted if numba.config.DISABLE_JIT else _compiled

# move(gain, offset, state, row): state := gain * state + offset for a row of the (n, W) tables, W a multiple of
# LANES; the sum of the squares of the new state. A state may be longer than W; the rest stays.
move = _make(True)
# sum_of_squares_after(gain, offset, state, row): the same sum, and the state stays as it is.
sum_of_squares_after = _make(False)
