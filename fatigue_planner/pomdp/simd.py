"""The step of all entries at once, f = gain * state + offset, and sums over all entries, as vector code.

Numba compiles a loop over the entries to one entry after the other. This does the same in blocks of LANES
entries, and in groups of such blocks, which takes a quarter of the time. Plain Python adds in the same order.
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

from fatigue_planner.core.jit import inlined

Vector = NDArray[np.float64]
Array = NDArray[np.float64]

LANES = 8
GROUPS = (8, 4, 2, 1)  # how many blocks are read before any of them is written: as many as remain
CACHE_LINE = 64  # bytes


def aligned_zeros(shape: int | tuple[int, ...], kind: Any = np.float64) -> NDArray[Any]:
    """Zeros whose memory begins at a cache line; the system gives it only where it is used."""
    kind = np.dtype(kind)
    size = int(np.prod(shape)) * kind.itemsize
    raw = np.zeros(size + CACHE_LINE, np.uint8)
    skip = -raw.ctypes.data % CACHE_LINE
    return np.asarray(raw[skip : skip + size].view(kind).reshape(shape))


def aligned(array: NDArray[Any]) -> NDArray[Any]:
    """A copy whose memory begins at a cache line."""
    copy = aligned_zeros(array.shape, array.dtype)
    copy[...] = array
    return copy


def _emit(context: Any, builder: Any, signature: Any, args: Any, store: bool, squares: bool) -> Any:
    """The sum over a row's blocks of LANES entries of f^2 (`squares`) or f * state, f = gain * state + offset.

    `store` writes f to state.
    """
    block = ir.VectorType(ir.DoubleType(), LANES)
    arrays = [
        context.make_array(kind)(context, builder, value) for kind, value in zip(signature.args, args[:3], strict=False)
    ]
    width = cgutils.unpack_tuple(builder, arrays[0].shape)[1]
    first = builder.mul(args[3], width)
    gain, offset = (builder.gep(array.data, [first]) for array in arrays[:2])
    state = arrays[2].data
    total = cgutils.alloca_once_value(builder, ir.Constant(block, None))

    def number(value: int) -> Any:
        return ir.Constant(width.type, value)

    def add_blocks(j: Any, count: int) -> None:
        """Some blocks from entry j on: all are read before any is written."""
        starts = [builder.gep(table, [j]) for table in (gain, offset, state)]
        pointers = [
            [builder.bitcast(builder.gep(start, [number(i * LANES)]), block.as_pointer()) for start in starts]
            for i in range(count)
        ]
        after, factors = [], []
        for block_pointers in pointers:
            g, o, s = (builder.load(pointer, align=8) for pointer in block_pointers)
            after.append(builder.fadd(builder.fmul(g, s), o))
            factors.append(after[-1] if squares else s)
        if store:
            for (_, _, pointer), f in zip(pointers, after, strict=True):
                builder.store(f, pointer, align=8)
        terms = [builder.fmul(f, factor) for f, factor in zip(after, factors, strict=True)]
        while len(terms) > 1:  # neighbours first
            terms = [builder.fadd(left, right) for left, right in zip(terms[::2], terms[1::2], strict=True)]
        builder.store(builder.fadd(builder.load(total), terms[0]), total)

    begin = number(0)
    for count in GROUPS:
        end = builder.and_(width, number(-LANES * count))
        with cgutils.for_range_slice(builder, begin, end, number(LANES * count)) as (j, _):
            add_blocks(j, count)
        begin = end
    vector = builder.load(total)
    size = LANES
    while size > 1:  # halves on halves
        size //= 2
        undefined = ir.Constant(vector.type, ir.Undefined)
        masks = [ir.Constant(ir.VectorType(ir.IntType(32), size), [*range(i, i + size)]) for i in (0, size)]
        low, high = (builder.shuffle_vector(vector, undefined, mask) for mask in masks)
        vector = builder.fadd(low, high)
    return builder.extract_element(vector, ir.Constant(ir.IntType(32), 0))


def _emit_steps(context: Any, builder: Any, signature: Any, args: Any) -> Any:
    """What `_plain_steps` does: a few blocks at a time go through all steps in registers."""
    block = ir.VectorType(ir.DoubleType(), LANES)
    gain, offset, state, rows = (
        context.make_array(kind)(context, builder, value) for kind, value in zip(signature.args, args[:4], strict=False)
    )
    width = cgutils.unpack_tuple(builder, gain.shape)[1]

    def number(value: int) -> Any:
        return ir.Constant(width.type, value)

    def blocks(table: Any, place: Any, count: int) -> list[Any]:
        start = builder.gep(table.data, [place])
        return [builder.bitcast(builder.gep(start, [number(i * LANES)]), block.as_pointer()) for i in range(count)]

    begin = number(0)
    for count in GROUPS:
        end = builder.and_(width, number(-LANES * count))
        with cgutils.for_range_slice(builder, begin, end, number(LANES * count)) as (j, _):
            own = blocks(state, j, count)
            values = [cgutils.alloca_once(builder, block) for _ in own]
            for value, pointer in zip(values, own, strict=True):
                builder.store(builder.load(pointer, align=8), value)
            with cgutils.for_range_slice(builder, args[4], args[5], number(1)) as (step, _):
                place = builder.add(builder.mul(builder.load(builder.gep(rows.data, [step])), width), j)
                maps = zip(values, blocks(gain, place, count), blocks(offset, place, count), strict=True)
                for value, g, o in maps:
                    scaled = builder.fmul(builder.load(g, align=8), builder.load(value))
                    builder.store(builder.fadd(scaled, builder.load(o, align=8)), value)
            for value, pointer in zip(values, own, strict=True):
                builder.store(builder.load(value), pointer, align=8)
        begin = end
    return context.get_dummy_value()


def _plain_steps(gain: Array, offset: Array, state: Vector, rows: NDArray[np.int64], begin: int, end: int) -> None:
    """The steps of rows[begin ... end - 1] in turn."""
    width = gain.shape[1]
    for row in rows[begin:end]:
        state[:width] = gain[row] * state[:width] + offset[row]


def _plain(gain: Array, offset: Array, state: Vector, row: int, store: bool, squares: bool) -> float:
    """What `_emit` compiles."""
    width = gain.shape[1]
    f = gain[row] * state[:width] + offset[row]
    terms = (f * (f if squares else state[:width])).reshape(-1, LANES)
    if store:
        state[:width] = f
    total, begin = np.zeros(LANES), 0
    for count in GROUPS:
        end = len(terms) - len(terms) % count
        for i in range(begin, end, count):
            group = terms[i : i + count]
            while len(group) > 1:
                group = group[::2] + group[1::2]
            total += group[0]
        begin = end
    while total.size > 1:
        total = total[: total.size // 2] + total[total.size // 2 :]
    return float(total[0])


def _compiled(store: bool, squares: bool) -> Callable[[Array, Array, Vector, int], float]:
    @intrinsic  # type: ignore[untyped-decorator]
    def step(typing: Any, gain: Any, offset: Any, state: Any, row: Any) -> Any:
        def codegen(context: Any, builder: Any, signature: Any, args: Any) -> Any:
            return _emit(context, builder, signature, args, store, squares)

        return types.float64(gain, offset, state, types.intp), codegen

    found: Callable[[Array, Array, Vector, int], float] = step
    return found


def _interpreted(store: bool, squares: bool) -> Callable[[Array, Array, Vector, int], float]:
    return lambda gain, offset, state, row: _plain(gain, offset, state, row, store, squares)


_make = _interpreted if numba.config.DISABLE_JIT else _compiled

# move(gain, offset, state, row): state := gain * state + offset for a row of the (n, W) tables, W a multiple of
# LANES; the sum of the squares of the new state. A state may be longer than W; the rest stays.
move = _make(True, True)
# sum_of_squares_after(gain, offset, state, row): the same sum, and the state stays as it is.
sum_of_squares_after = _make(False, True)
# quadratic(square, linear, state, row): the sum of (square * state + linear) * state.
quadratic = _make(False, False)


@intrinsic  # type: ignore[untyped-decorator]
def _compiled_steps(_typing: Any, gain: Any, offset: Any, state: Any, rows: Any, begin: Any, end: Any) -> Any:
    return types.void(gain, offset, state, rows, types.intp, types.intp), _emit_steps


# move_along(gain, offset, state, rows, begin, end): the same as `move` along several rows, without the sums.
move_along = _plain_steps if numba.config.DISABLE_JIT else _compiled_steps


def _plain_put(state: Vector, states: Array, row: int) -> None:
    """What `_compiled_put` compiles."""
    state[:] = states[row]


@intrinsic  # type: ignore[untyped-decorator]
def _compiled_put(_typing: Any, state: Any, states: Any, row: Any) -> Any:
    def codegen(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        target, source = (context.make_array(signature.args[i])(context, builder, args[i]) for i in range(2))
        (size,) = cgutils.unpack_tuple(builder, target.shape)

        def copy(kind: Any, begin: Any, end: Any, step: int) -> None:
            with cgutils.for_range_slice(builder, begin, end, ir.Constant(size.type, step)) as (j, _):
                origin = cgutils.get_item_pointer(context, builder, states, source, (args[2], j))
                read, written = (
                    builder.bitcast(place, kind.as_pointer()) for place in (origin, builder.gep(target.data, [j]))
                )
                builder.store(builder.load(read, align=8), written, align=8)

        in_blocks = ir.Constant(size.type, 0)
        if states.layout == "C":
            in_blocks = builder.and_(size, ir.Constant(size.type, -LANES))
            copy(ir.VectorType(ir.DoubleType(), LANES), ir.Constant(size.type, 0), in_blocks, LANES)
        copy(ir.DoubleType(), in_blocks, size, 1)
        return context.get_dummy_value()

    return types.void(state, states, types.intp), codegen


# put(state, states, row): state (L,) := states[row], in the blocks that `move` reads: a processor waits where it reads
# at once what it has just written in smaller pieces.
put = _plain_put if numba.config.DISABLE_JIT else _compiled_put


@inlined
def sum_in_lanes(terms: Vector, lanes: Vector) -> float:
    """The sum of terms (W,), W a multiple of LANES, in LANES parts that do not wait for each other."""
    for lane in range(LANES):
        lanes[lane] = 0.0
    for j in range(0, terms.size, LANES):
        for lane in range(LANES):
            lanes[lane] += terms[j + lane]
    total = 0.0
    for lane in range(LANES):
        total += lanes[lane]
    return total
