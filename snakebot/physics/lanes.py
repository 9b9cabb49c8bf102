"""Eight numbers in one: a numba type for a vector register, so that one kernel moves one robot or eight at once.

A kernel written for numbers and arrays of numbers compiles as it stands for ``Lanes`` and ``LaneArray``: the same
operations, eight gaits at once. What differs between the eight may not steer a branch: there is no comparison.
Numbers mix with lanes and spread over all of them. A processor with narrower registers uses several.
"""

# numba's own interfaces are typed in part only
# mypy: disable-error-code="no-untyped-call, import-untyped, attr-defined, untyped-decorator"

from __future__ import annotations

import operator
from typing import Any

from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.core.typeconv import Conversion
from numba.core.typing.templates import AbstractTemplate, infer_global, signature
from numba.extending import (
    intrinsic,
    lower_builtin,
    lower_cast,
    models,
    overload,
    register_model,
)

WIDTH = 8  # doubles in a vector: 512 bits
_VECTOR = ir.VectorType(ir.DoubleType(), WIDTH)
_BITS = ir.VectorType(ir.IntType(64), WIDTH)
_ALIGN = 8 * WIDTH  # bytes of such a vector


class LanesType(types.Type):
    """Eight float64."""

    def __init__(self) -> None:
        super().__init__(name="Lanes")

    def unify(self, context: Any, other: Any) -> Any:
        return self if isinstance(other, (types.Float, types.Integer)) else None

    def can_convert_from(self, context: Any, other: Any) -> Any:
        return Conversion.safe if isinstance(other, (types.Float, types.Integer)) else None


class LaneArrayType(types.Type):
    """A view of float64 memory as a row, or rows, of Lanes. It does not own that memory."""

    def __init__(self, ndim: int) -> None:
        self.ndim = ndim
        super().__init__(name=f"LaneArray({ndim})")


Lanes = LanesType()
LANE_ROW, LANE_ROWS = LaneArrayType(1), LaneArrayType(2)


@register_model(LanesType)
class _LanesModel(models.PrimitiveModel):
    def __init__(self, manager: Any, fe_type: Any) -> None:
        super().__init__(manager, fe_type, _VECTOR)


@register_model(LaneArrayType)
class _LaneArrayModel(models.StructModel):
    def __init__(self, manager: Any, fe_type: Any) -> None:
        super().__init__(
            manager, fe_type, [("data", types.voidptr), ("rows", types.int64), ("columns", types.int64)]
        )  # fmt: skip


def _spread(builder: Any, scalar: Any) -> Any:
    empty = ir.Constant(_VECTOR, ir.Undefined)
    one = builder.insert_element(empty, scalar, ir.Constant(ir.IntType(32), 0))
    zeros = ir.Constant(ir.VectorType(ir.IntType(32), WIDTH), [0] * WIDTH)
    return builder.shuffle_vector(one, empty, zeros)


@lower_cast(types.Float, LanesType)
@lower_cast(types.Integer, LanesType)
def _from_number(context: Any, builder: Any, from_type: Any, to_type: Any, value: Any) -> Any:
    return _spread(builder, context.cast(builder, value, from_type, types.float64))


def _binary(function: Any, instruction: str) -> None:
    @infer_global(function)
    class _Typing(AbstractTemplate):
        def generic(self, args: Any, kws: Any) -> Any:
            numbers = (LanesType, types.Float, types.Integer)
            if any(isinstance(a, LanesType) for a in args) and all(isinstance(a, numbers) for a in args):
                return signature(Lanes, *([Lanes] * len(args)))
            return None

    @lower_builtin(function, LanesType, LanesType)
    def _lower(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        return getattr(builder, instruction)(*args)


for _function, _instruction in (
    (operator.add, "fadd"), (operator.sub, "fsub"), (operator.mul, "fmul"), (operator.truediv, "fdiv"),
    (operator.iadd, "fadd"), (operator.isub, "fsub"), (operator.imul, "fmul"), (operator.itruediv, "fdiv"),
):  # fmt: skip
    _binary(_function, _instruction)


@infer_global(operator.neg)
class _NegTyping(AbstractTemplate):
    def generic(self, args: Any, kws: Any) -> Any:
        return signature(Lanes, Lanes) if isinstance(args[0], LanesType) else None


@lower_builtin(operator.neg, LanesType)
def _neg(context: Any, builder: Any, sig: Any, args: Any) -> Any:
    return builder.fneg(args[0])


def _kernel_intrinsic(function: Any) -> Any:
    """numba's ``intrinsic``: an operation that writes its own machine instructions, called from kernels only."""
    return intrinsic(function)


# ---------------------------------------------------------------- numbers or lanes alike


@_kernel_intrinsic
def magnitude(typingctx: Any, x: Any) -> Any:
    """|x|."""

    def codegen(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        bits_type, constant = _bits_like(sig.args[0])
        bits = builder.and_(builder.bitcast(args[0], bits_type), constant(~(1 << 63)))
        return builder.bitcast(bits, args[0].type)

    return signature(x, x), codegen


def _bits_like(kind: Any) -> Any:
    """The integer type as wide as a number or as lanes, and its constants."""
    if isinstance(kind, LanesType):
        return _BITS, lambda v: ir.Constant(_BITS, [v] * WIDTH)
    return ir.IntType(64), ir.IntType(64)


@_kernel_intrinsic
def at_most(typingctx: Any, x: Any, limit: Any) -> Any:
    """min(x, limit) for a number ``limit``."""

    def codegen(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        value, top = args
        if isinstance(sig.args[0], LanesType):
            top = _spread(builder, top)
        return builder.select(builder.fcmp_ordered("<", value, top), value, top)

    return signature(x, x, types.float64), codegen


@_kernel_intrinsic
def power_of_two(typingctx: Any, shifted: Any) -> Any:
    """2**k from k + 1.5 * 2**52, whose last bits are those of the integer k."""

    def codegen(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        bits_type, constant = _bits_like(sig.args[0])
        bits = builder.bitcast(args[0], bits_type)
        bits = builder.add(builder.shl(bits, constant(52)), constant(1023 << 52))
        return builder.bitcast(bits, args[0].type)

    return signature(shifted, shifted), codegen


# ---------------------------------------------------------------- arrays


@_kernel_intrinsic
def lane_rows(typingctx: Any, memory: Any, rows: Any, columns: Any) -> Any:
    """View a (rows * columns + 1) * WIDTH float64 buffer as ``rows`` rows of ``columns`` Lanes, aligned to a register.

    The view does not keep the buffer alive: call this where the buffer is an argument, which its caller holds.
    """

    def codegen(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        array = context.make_array(sig.args[0])(context, builder, args[0])
        word = ir.IntType(64)
        address = builder.ptrtoint(array.data, word)
        address = builder.and_(builder.add(address, word(_ALIGN - 1)), word(-_ALIGN))
        return _view(context, builder, LANE_ROWS, address, args[1], args[2])

    return signature(LANE_ROWS, memory, types.int64, types.int64), codegen


def _view(context: Any, builder: Any, kind: Any, address: Any, rows: Any, columns: Any) -> Any:
    out = cgutils.create_struct_proxy(kind)(context, builder)
    out.data = builder.inttoptr(address, context.get_value_type(types.voidptr))
    out.rows, out.columns = rows, columns
    return out._getvalue()


def _address(context: Any, builder: Any, kind: Any, value: Any, row: Any, column: Any) -> Any:
    view = cgutils.create_struct_proxy(kind)(context, builder, value=value)
    word = ir.IntType(64)
    index = builder.add(builder.mul(row, view.columns), column)
    return builder.add(builder.ptrtoint(view.data, word), builder.mul(index, word(_ALIGN)))


@_kernel_intrinsic
def _load(typingctx: Any, array: Any, row: Any, column: Any) -> Any:
    def codegen(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        address = _address(context, builder, sig.args[0], *args)
        return builder.load(builder.inttoptr(address, _VECTOR.as_pointer()), align=_ALIGN)

    return signature(Lanes, array, types.int64, types.int64), codegen


@_kernel_intrinsic
def _store(typingctx: Any, array: Any, row: Any, column: Any, value: Any) -> Any:
    def codegen(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        address = _address(context, builder, sig.args[0], *args[:3])
        builder.store(args[3], builder.inttoptr(address, _VECTOR.as_pointer()), align=_ALIGN)
        return context.get_dummy_value()

    return signature(types.void, array, types.int64, types.int64, Lanes), codegen


@_kernel_intrinsic
def _row(typingctx: Any, array: Any, row: Any) -> Any:
    def codegen(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        word = ir.IntType(64)
        address = _address(context, builder, sig.args[0], args[0], args[1], word(0))
        view = cgutils.create_struct_proxy(sig.args[0])(context, builder, value=args[0])
        return _view(context, builder, LANE_ROW, address, word(1), view.columns)

    return signature(LANE_ROW, array, types.int64), codegen


@_kernel_intrinsic
def sub_rows(typingctx: Any, array: Any, first: Any) -> Any:
    """The rows from ``first`` on."""

    def codegen(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        address = _address(context, builder, LANE_ROWS, args[0], args[1], ir.IntType(64)(0))
        view = cgutils.create_struct_proxy(LANE_ROWS)(context, builder, value=args[0])
        return _view(context, builder, LANE_ROWS, address, builder.sub(view.rows, args[1]), view.columns)

    return signature(LANE_ROWS, array, types.int64), codegen


@overload(operator.getitem, strict=False)
def _getitem(array: Any, index: Any) -> Any:
    if not isinstance(array, LaneArrayType):
        return None
    if isinstance(index, types.BaseTuple):
        return lambda array, index: _load(array, index[0], index[1])
    if array.ndim == 1:
        return lambda array, index: _load(array, 0, index)
    return lambda array, index: _row(array, index)


@overload(operator.setitem, strict=False)
def _setitem(array: Any, index: Any, value: Any) -> Any:
    if not isinstance(array, LaneArrayType):
        return None
    if isinstance(index, types.BaseTuple):
        return lambda array, index, value: _store(array, index[0], index[1], value)
    return lambda array, index, value: _store(array, 0, index, value)


@_kernel_intrinsic
def put_lane(typingctx: Any, array: Any, row: Any, column: Any, lane: Any, value: Any) -> Any:
    """Set one lane of an element."""

    def codegen(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        builder.store(args[4], _lane_pointer(context, builder, sig.args[0], args))
        return context.get_dummy_value()

    return signature(types.void, array, types.int64, types.int64, types.int64, types.float64), codegen


@_kernel_intrinsic
def get_lane(typingctx: Any, array: Any, row: Any, column: Any, lane: Any) -> Any:
    """One lane of an element, a number."""

    def codegen(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        return builder.load(_lane_pointer(context, builder, sig.args[0], args))

    return signature(types.float64, array, types.int64, types.int64, types.int64), codegen


def _lane_pointer(context: Any, builder: Any, kind: Any, args: Any) -> Any:
    address = _address(context, builder, kind, *args[:3])
    word = ir.IntType(64)
    address = builder.add(address, builder.mul(args[3], word(8)))
    return builder.inttoptr(address, ir.DoubleType().as_pointer())
