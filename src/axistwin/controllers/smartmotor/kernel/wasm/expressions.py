"""The expressions of a sampled function, compiled to WebAssembly: their types and their instructions."""

import ast
import builtins
import inspect
import math
from collections.abc import Callable, Collection, MutableSequence, Sequence
from textwrap import dedent
from types import FunctionType, ModuleType
from typing import Any

from axistwin.controllers.smartmotor.kernel.wasm import code as w

_ARRAYS = {MutableSequence[int]: w.I64, Sequence[int]: w.I64, MutableSequence[float]: w.F64}
"""Types of the numbers in an array, by the annotation of a parameter."""
_NUMBERS = {int: w.I64, bool: w.I64, float: w.F64}
_BUILT_IN: tuple[Callable[..., Any], ...] = abs, min, max, int, math.floor, math.sqrt, range
_ARITHMETIC = {
    ast.Add: (b"\x7c", b"\xa0"), ast.Sub: (b"\x7d", b"\xa1"), ast.Mult: (b"\x7e", b"\xa2"), ast.Div: (b"", b"\xa3"),
    ast.BitAnd: (b"\x83", b""), ast.BitOr: (b"\x84", b""), ast.BitXor: (b"\x85", b""),
    ast.LShift: (b"\x86", b""), ast.RShift: (b"\x87", b""),
}  # fmt: skip
"""Instructions for integers and for floats."""
_COMPARISONS = {
    ast.Eq: (b"\x51", b"\x61"), ast.NotEq: (b"\x52", b"\x62"), ast.Lt: (b"\x53", b"\x63"),
    ast.Gt: (b"\x55", b"\x64"), ast.LtE: (b"\x57", b"\x65"), ast.GtE: (b"\x59", b"\x66"),
}  # fmt: skip


class Expressions:
    """Compiles expressions.  `functions`: all sampled ones; `order`: the module's, to which called ones are added."""

    def __init__(self, function: FunctionType, functions: Collection[FunctionType], order: list[FunctionType]) -> None:
        definition = ast.parse(dedent(inspect.getsource(function))).body[0]
        assert isinstance(definition, ast.FunctionDef), "a sampled function"
        self._definition, self._globals = definition, function.__globals__
        self._functions, self._order = functions, order
        annotations = inspect.get_annotations(function)
        self._result = _NUMBERS.get(annotations.pop("return"))
        self._arrays = {name: _ARRAYS[kind] for name, kind in annotations.items() if kind in _ARRAYS}
        self._parameters = tuple(w.I32 if name in self._arrays else _NUMBERS[annotations[name]] for name in annotations)
        self._places = {name: place for place, name in enumerate(annotations)}
        self._types = [*self._parameters]
        self._code = bytearray()

    def _emit(self, *instructions: bytes) -> None:
        for each in instructions:
            self._code += each

    def _new(self, kind: int) -> int:
        self._types.append(kind)
        return len(self._types) - 1

    # Types

    def _kind(self, node: ast.expr) -> int:
        match node:
            case ast.Name(id=name) if name in self._places:
                return self._types[self._places[name]]
            case ast.Constant() | ast.Name() | ast.Attribute():
                return w.F64 if isinstance(self._constant(node), float) else w.I64
            case ast.Subscript(value=ast.Name(id=name)):
                return self._arrays[name]
            case ast.BinOp(op=ast.Div()):
                return w.F64
            case ast.BinOp(left=left, right=right):
                return self._common(left, right)
            case ast.UnaryOp(op=ast.USub() | ast.Invert(), operand=operand):
                return self._kind(operand)
            case ast.BoolOp(values=values):
                return self._common(*values)
            case ast.IfExp(body=body, orelse=orelse):
                return self._common(body, orelse)
            case ast.Call():
                return self._kind_of_call(node)
        return w.I64  # The result of a comparison or of the operator `not` is an integer.

    def _kind_of_call(self, node: ast.Call) -> int:
        called = self._called(node)
        if called in (abs, min, max):
            return self._common(*node.args)
        if called is math.sqrt:
            return w.F64
        return w.I64 if called in (int, math.floor) else _NUMBERS[inspect.get_annotations(called)["return"]]

    def _common(self, *nodes: ast.expr) -> int:
        return w.F64 if w.F64 in [self._kind(node) for node in nodes] else w.I64

    def _constant(self, node: ast.expr) -> int | float:
        value = self._global(node)
        if not isinstance(value, int | float):
            name, function, type_name = ast.unparse(node), self._definition.name, type(value).__name__
            raise NotImplementedError(
                f"the value of {name} in the function {function} has the type {type_name}: expected int or float"
            )
        return value

    def _global(self, node: ast.expr) -> Any:
        match node:
            case ast.Constant(value=value):
                return value
            case ast.Name(id=name):
                return self._globals[name] if name in self._globals else getattr(builtins, name)
            case ast.Attribute(value=ast.Name(id=owner), attr=name) if isinstance(self._globals[owner], ModuleType):
                return getattr(self._globals[owner], name)
        expression, function = ast.unparse(node), self._definition.name
        raise NotImplementedError(
            f"cannot compile {expression} in {function}: expected a number, a global variable or a function"
        )

    def _called(self, node: ast.Call) -> Callable[..., Any]:
        called: Callable[..., Any] = self._global(node.func)
        if called not in _BUILT_IN and called not in self._functions:
            raise NotImplementedError(
                f"cannot compile the call of {ast.unparse(node.func)} in {self._definition.name}: "
                "expected a function with the decorator @sampled"
            )
        return called

    # Instructions

    def _value(self, node: ast.expr, kind: int) -> None:
        own = self._kind(node)
        match node:
            case ast.Name(id=name) if name in self._places:
                self._emit(w.local_get(self._places[name]))
            case ast.Constant() | ast.Name() | ast.Attribute():
                value = self._constant(node)
                self._emit(w.f64_const(value) if isinstance(value, float) else w.i64_const(int(value)))
            case ast.Subscript():
                self._emit(w.load(own, self._address(node)))
            case ast.BinOp():
                self._operation(node, own)
            case ast.UnaryOp(op=ast.USub(), operand=operand):
                self._emit(*([] if own == w.F64 else [w.i64_const(0)]))
                self._value(operand, own)
                self._emit(w.F64_NEG if own == w.F64 else w.I64_SUB)
            case ast.UnaryOp(op=ast.Invert(), operand=operand):
                self._value(operand, own)
                self._emit(w.i64_const(-1), w.I64_XOR)
            case ast.BoolOp():
                self._either(node, own)
            case ast.IfExp(test=test, body=body, orelse=orelse):
                self._condition(test)
                self._emit(w.IF, bytes((own,)))
                self._value(body, own)
                self._emit(w.ELSE)
                self._value(orelse, own)
                self._emit(w.END)
            case ast.Call():
                self._call(node)
            case _:
                self._condition(node)
                self._emit(w.I64_EXTEND)
        self._convert(own, kind)

    def _address(self, node: ast.Subscript) -> int:
        """Push the address of an array element, less a constant offset, which is returned."""
        assert isinstance(node.value, ast.Name), "an array is a parameter"
        array, index = w.local_get(self._places[node.value.id]), node.slice
        if isinstance(index, ast.Constant | ast.Attribute) or (
            isinstance(index, ast.Name) and index.id not in self._places
        ):
            self._emit(array)
            return 8 * int(self._constant(index))
        self._value(index, w.I64)
        self._emit(w.I32_WRAP, w.i32_const(3), w.I32_SHL, array, w.I32_ADD)
        return 0

    def _convert(self, own: int, kind: int) -> None:
        if own != kind:
            assert own == w.I64, "a float becomes an integer by int() or floor() only"
            self._emit(w.F64_CONVERT)

    def _operation(self, node: ast.BinOp, kind: int) -> None:
        self._value(node.left, kind)
        self._value(node.right, kind)
        if isinstance(node.op, ast.FloorDiv | ast.Mod):
            self._division(modulo=isinstance(node.op, ast.Mod))
            return
        instruction = _ARITHMETIC[type(node.op)][kind == w.F64]
        assert instruction, "an operation for this type"
        self._emit(instruction)

    def _division(self, *, modulo: bool) -> None:
        """Divide two integers, rounding down; a quotient by 0 is 0, as in Numba."""
        left, right, result = self._new(w.I64), self._new(w.I64), self._new(w.I64)
        a, b, q = w.local_get(left), w.local_get(right), w.local_get(result)
        self._emit(w.local_set(right), w.local_set(left), b, w.I64_EQZ, w.IF, bytes((w.I64,)), w.i64_const(0), w.ELSE)
        self._emit(a, b, w.I64_DIV, w.local_tee(result))
        self._emit(q, b, w.I64_MUL, a, w.I64_NE, a, b, w.I64_XOR, w.i64_const(0), w.I64_LT, w.I32_AND)
        self._emit(w.I64_EXTEND, w.I64_SUB, w.END)
        if modulo:
            self._emit(b, w.I64_MUL, w.local_set(result), a, q, w.I64_SUB)

    def _either(self, node: ast.BoolOp, kind: int) -> None:
        """Compile `and` or `or`; as in Python, the result is one of the operands."""
        *before, last = node.values
        decides = self._new(kind)
        for value in before:
            self._value(value, kind)
            self._emit(w.local_tee(decides))
            self._nonzero(kind)
            self._emit(w.IF, bytes((kind,)))
            if isinstance(node.op, ast.Or):
                self._emit(w.local_get(decides), w.ELSE)
        self._value(last, kind)
        for _ in before:
            self._emit(*([w.ELSE, w.local_get(decides)] if isinstance(node.op, ast.And) else []), w.END)

    def _nonzero(self, kind: int) -> None:
        self._emit(*((w.f64_const(0.0), w.F64_NE) if kind == w.F64 else (w.i64_const(0), w.I64_NE)))

    def _condition(self, node: ast.expr) -> None:
        match node:
            case ast.Compare():
                self._compare(node)
            case ast.UnaryOp(op=ast.Not(), operand=operand):
                self._condition(operand)
                self._emit(w.I32_EQZ)
            case ast.BoolOp(op=op, values=[*before, last]):
                for value in before:
                    self._condition(value)
                    self._emit(w.IF, bytes((w.I32,)), *([w.i32_const(1), w.ELSE] if isinstance(op, ast.Or) else []))
                self._condition(last)
                for _ in before:
                    self._emit(*([w.ELSE, w.i32_const(0)] if isinstance(op, ast.And) else []), w.END)
            case _:
                self._value(node, self._kind(node))
                self._nonzero(self._kind(node))

    def _compare(self, node: ast.Compare) -> None:
        """Compile a comparison or a chain `a < b < c`: b is evaluated once, c only if a < b."""
        left, pairs = node.left, list(zip(node.ops, node.comparators, strict=True))
        for n, (op, right) in enumerate(pairs):
            if isinstance(op, ast.In):
                left = self._kept(left)
                assert isinstance(right, ast.Tuple), "`in` takes a tuple"
                equal: list[ast.expr] = [ast.Compare(left, [ast.Eq()], [each]) for each in right.elts]
                self._condition(ast.BoolOp(ast.Or(), equal))
            else:
                kind = self._common(left, right)
                kept = self._kept(right) if n < len(pairs) - 1 else right
                self._value(left, kind)
                self._value(kept, kind)
                self._emit(_COMPARISONS[type(op)][kind == w.F64])
                left = kept
            if n < len(pairs) - 1:
                self._emit(w.IF, bytes((w.I32,)))
        for _ in pairs[1:]:
            self._emit(w.ELSE, w.i32_const(0), w.END)

    def _kept(self, node: ast.expr) -> ast.expr:
        kind = self._kind(node)
        place = self._new(kind)
        self._value(node, kind)
        self._emit(w.local_set(place))
        name = f" {place}"
        self._places[name] = place
        return ast.Name(name)

    def _call(self, node: ast.Call) -> None:
        called, kind = self._called(node), None
        if called in (abs, min, max):
            self._choice(called, node.args, self._common(*node.args))
        elif called is math.sqrt:
            self._value(node.args[0], w.F64)
            self._emit(w.F64_SQRT)
        elif called in (int, math.floor):
            kind = self._kind(node.args[0])
            self._value(node.args[0], kind)
            rounded = [w.F64_FLOOR] if called is math.floor else []
            self._emit(*([*rounded, w.I64_TRUNCATE] if kind == w.F64 else []))
        else:
            self._call_sampled(called, node.args)

    def _call_sampled(self, called: Any, arguments: Sequence[ast.expr]) -> None:
        kinds = [kind for name, kind in inspect.get_annotations(called).items() if name != "return"]
        for kind, value in zip(kinds, arguments, strict=True):
            self._value(value, w.I32 if kind in _ARRAYS else _NUMBERS[kind])
        if called not in self._order:
            self._order.append(called)
        self._emit(w.call(self._order.index(called)))

    def _choice(self, called: Callable[..., Any], arguments: Sequence[ast.expr], kind: int) -> None:
        """Compile a call of `abs`, `min` or `max`.  Of equal values, `min` and `max` return the first."""
        if called is abs:
            if kind == w.F64:
                self._value(arguments[0], kind)
                self._emit(w.F64_ABS)
                return
            arguments = [arguments[0], ast.UnaryOp(ast.USub(), arguments[0])]
        less = w.F64_LT if kind == w.F64 else w.I64_LT
        best, other = self._new(kind), self._new(kind)
        self._value(arguments[0], kind)
        for value in arguments[1:]:
            self._emit(w.local_set(best))
            self._value(value, kind)
            one, two = (other, best) if called is min else (best, other)
            self._emit(w.local_set(other), w.local_get(other), w.local_get(best))
            self._emit(w.local_get(one), w.local_get(two), less, w.SELECT)
