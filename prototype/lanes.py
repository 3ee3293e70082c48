"""The fused step as vector code: an intrinsic for compiled callers, the same order of sums in Python."""

import numba
import numpy as np
from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic

WIDTH = 8


def _emit(context, builder, signature, args, store, add=True):
    """IR: over blocks of WIDTH entries f = gain * state + offset; returns the sum of f^2; stores f into state."""
    vector = ir.VectorType(ir.DoubleType(), WIDTH)
    pointers = []
    for kind, value in zip(signature.args[:3], args[:3], strict=True):
        array = context.make_array(kind)(context, builder, value)
        pointers.append(array.data)
        size = cgutils.unpack_tuple(builder, array.shape)[0]
    gain, offset, state = pointers
    first = args[3]
    blocks = builder.lshr(size, ir.Constant(size.type, WIDTH.bit_length() - 1))
    at = lambda pointer, index: builder.bitcast(builder.gep(pointer, [index]), vector.as_pointer())
    total = cgutils.alloca_once_value(builder, ir.Constant(vector, None))
    with cgutils.for_range(builder, blocks) as loop:
        j = builder.shl(loop.index, ir.Constant(size.type, WIDTH.bit_length() - 1))
        k = builder.add(first, j)
        g, o, s = (builder.load(at(p, i), align=8) for p, i in ((gain, k), (offset, k), (state, j)))
        f = builder.fadd(builder.fmul(g, s), o)
        if store:
            builder.store(f, at(state, j), align=8)
        if add:
            builder.store(builder.fadd(builder.load(total), builder.fmul(f, f)), total)
    if not add:
        return context.get_dummy_value()
    lanes = builder.load(total)
    width = WIDTH
    while width > 1:
        half = width // 2
        mask = lambda start: ir.Constant(ir.VectorType(ir.IntType(32), half), list(range(start, start + half)))
        undef = ir.Constant(lanes.type, ir.Undefined)
        low, high = (builder.shuffle_vector(lanes, undef, mask(start)) for start in (0, half))
        lanes, width = builder.fadd(low, high), half
    return builder.extract_element(lanes, ir.Constant(ir.IntType(32), 0))


def _make(store):
    @intrinsic
    def run(typing, gain, offset, state, first):
        def codegen(context, builder, signature, args):
            return _emit(context, builder, signature, args, store)

        return types.float64(gain, offset, state, types.int64), codegen

    return run


@intrinsic
def _move(typing, gain, offset, state, first):
    def codegen(context, builder, signature, args):
        return _emit(context, builder, signature, args, True, False)

    return types.none(gain, offset, state, types.int64), codegen


def _python(gain, offset, state, first, store):
    lanes = np.zeros(WIDTH)
    for j in range(0, state.size, WIDTH):
        f = gain[first + j : first + j + WIDTH] * state[j : j + WIDTH] + offset[first + j : first + j + WIDTH]
        if store:
            state[j : j + WIDTH] = f
        lanes += f * f
    while lanes.size > 1:
        lanes = lanes[: lanes.size // 2] + lanes[lanes.size // 2 :]
    return float(lanes[0])


if numba.config.DISABLE_JIT:
    advance = lambda gain, offset, state, first: _python(gain, offset, state, first, True)
    squares_after = lambda gain, offset, state, first: _python(gain, offset, state, first, False)
    move = advance
else:
    advance, squares_after, move = _make(True), _make(False), _move
