"""Compile the functions of a sample to WebAssembly, for browsers, where Numba is not available.

The functions are those that `@sampled` marks (`jit.py`).  They use the subset of Python that Numba compiles, and the
results are those of Numba. An integer is an i64, a float an f64, a bool the integer 0 or 1; an array is the address of
its first number.  A construct outside the subset raises NotImplementedError at compilation, so the tests detect it.
"""

import ast
import inspect
from collections.abc import Collection, Sequence
from types import FunctionType

from axistwin.controllers.smartmotor.kernel.wasm import code as w
from axistwin.controllers.smartmotor.kernel.wasm.expressions import Expressions


def compiled(entry: FunctionType, functions: Collection[FunctionType]) -> bytes:
    """Create a WebAssembly module that contains the function `entry` and all functions called by `entry`."""
    order = [entry]
    found: list[w.Function] = []
    while len(found) < len(order):
        found.append(_Function(order[len(found)], functions, order).function())
    return w.module(found, entry.__name__)


class _Function(Expressions):
    def __init__(self, function: FunctionType, functions: Collection[FunctionType], order: list[FunctionType]) -> None:
        super().__init__(function, functions, order)
        self._blocks: list[str] = []
        """Open blocks, the innermost last: "if", or "exit" and "next" of a loop, the targets of break and continue."""

    def function(self) -> w.Function:
        self._declare(self._definition.body)
        self._statements(self._definition.body)
        if self._result is not None:
            # A WebAssembly function must end with a result or with the instruction `unreachable`.
            self._emit(w.UNREACHABLE)
        results = () if self._result is None else (self._result,)
        return w.Function(self._parameters, results, tuple(self._types[len(self._parameters) :]), bytes(self._code))

    def _declare(self, statements: Sequence[ast.stmt]) -> None:
        """Give each variable the type of the first value that is assigned to it."""
        for each in statements:
            if isinstance(each, ast.Assign):
                for target, value in _pairs(each):
                    if isinstance(target, ast.Name):
                        self._declare_one(target.id, self._kind(value))
            elif isinstance(each, ast.For):
                assert isinstance(each.target, ast.Name), "a loop has one variable"
                self._declare_one(each.target.id, w.I64)
            for block in ("body", "orelse"):
                self._declare(getattr(each, block, ()))

    def _declare_one(self, name: str, kind: int) -> None:
        if name not in self._places:
            self._places[name] = self._new(kind)
        elif self._types[self._places[name]] != kind:
            raise NotImplementedError(
                f"the variable {name} in the function {self._definition.name} gets values of several types: "
                "expected one type, e.g. int"
            )

    # Statements

    def _statements(self, statements: Sequence[ast.stmt]) -> None:
        for each in statements:
            self._statement(each)

    def _statement(self, node: ast.stmt) -> None:
        match node:
            case ast.Pass() | ast.Expr(value=ast.Constant()):
                pass
            case ast.Expr(value=ast.Call() as called):
                self._call(called)
                if inspect.get_annotations(self._called(called))["return"] is not None:
                    self._emit(w.DROP)
            case ast.Assign():
                self._assign(node)
            case ast.AugAssign():
                self._change(node)
            case ast.Return(value=value):
                if value is not None and self._result is not None:
                    self._value(value, self._result)
                self._emit(w.RETURN)
            case ast.If():
                self._if(node)
            case ast.While() | ast.For():
                self._loop(node)
            case ast.Break():
                self._emit(w.br(self._depth("exit")))
            case ast.Continue():
                self._emit(w.br(self._depth("next")))
            case _:
                statement, function = ast.unparse(node), self._definition.name
                raise NotImplementedError(
                    f"cannot compile {statement} in {function}: expected e.g. an assignment, if, while or for"
                )

    def _depth(self, block: str) -> int:
        return self._blocks[::-1].index(block)

    def _if(self, node: ast.If) -> None:
        self._condition(node.test)
        self._emit(w.IF, bytes((w.NO_RESULT,)))
        self._blocks.append("if")
        self._statements(node.body)
        if node.orelse:
            self._emit(w.ELSE)
            self._statements(node.orelse)
        self._blocks.pop()
        self._emit(w.END)

    def _loop(self, node: ast.While | ast.For) -> None:
        """Compile a while loop or a for loop to nested WebAssembly blocks.

        The blocks are exit { again { leave at the end; next { body } step; go to again } }.
        """
        counter, stop, step = self._range(node) if isinstance(node, ast.For) else (0, 0, 0)
        void = bytes((w.NO_RESULT,))
        self._emit(w.BLOCK, void, w.LOOP, void)
        if isinstance(node, ast.While):
            self._condition(node.test)
        else:
            self._emit(w.local_get(counter), w.local_get(stop), w.I64_LT)
        self._emit(w.I32_EQZ, w.br_if(1))
        if isinstance(node, ast.For) and isinstance(node.target, ast.Name):
            self._emit(w.local_get(counter), w.local_set(self._places[node.target.id]))
        self._emit(w.BLOCK, void)
        self._blocks += ["exit", "again", "next"]
        self._statements(node.body)
        del self._blocks[-3:]
        self._emit(w.END)
        if isinstance(node, ast.For):
            self._emit(w.local_get(counter), w.i64_const(step), w.I64_ADD, w.local_set(counter))
        self._emit(w.br(0), w.END, w.END)

    def _range(self, node: ast.For) -> tuple[int, int, int]:
        assert isinstance(node.iter, ast.Call) and self._called(node.iter) is range, "a loop over a range"
        first, *others = node.iter.args
        begin, end = (first, others[0]) if others else (ast.Constant(0), first)
        counter, stop = self._new(w.I64), self._new(w.I64)
        for place, value in ((counter, begin), (stop, end)):
            self._value(value, w.I64)
            self._emit(w.local_set(place))
        step = int(self._constant(others[1])) if len(others) > 1 else 1
        assert step > 0, "a loop counts up"
        return counter, stop, step

    def _assign(self, node: ast.Assign) -> None:
        """Evaluate all values, and then store them from left to right."""
        values = {id(value): value for _, value in _pairs(node)}
        places = {}
        for key, value in values.items():
            places[key] = self._new(self._kind(value))
            self._value(value, self._kind(value))
            self._emit(w.local_set(places[key]))
        for target, value in _pairs(node):
            self._store(target, places[id(value)])

    def _store(self, target: ast.expr, place: int) -> None:
        if isinstance(target, ast.Name):
            self._emit(w.local_get(place), w.local_set(self._places[target.id]))
            return
        assert isinstance(target, ast.Subscript), "a variable or a number in an array"
        kind, offset = self._kind(target), self._address(target)
        self._emit(w.local_get(place))
        self._convert(self._types[place], kind)
        self._emit(w.store(kind, offset))

    def _change(self, node: ast.AugAssign) -> None:
        """Compile an assignment such as `x += 1`.  The address of an array element is calculated once."""
        changed = ast.BinOp(node.target, node.op, node.value)
        kind = self._kind(node.target)
        assert self._kind(changed) == kind, "an assignment does not change the type"
        if isinstance(node.target, ast.Name):
            self._value(changed, kind)
            self._emit(w.local_set(self._places[node.target.id]))
            return
        assert isinstance(node.target, ast.Subscript), "a variable or a number in an array"
        address, offset = self._new(w.I32), self._address(node.target)
        self._emit(w.local_tee(address), w.local_get(address), w.load(kind, offset))
        before = self._new(kind)
        self._emit(w.local_set(before))
        self._places[""], name = before, ast.Name("")
        self._value(ast.BinOp(name, node.op, node.value), kind)
        self._emit(w.store(kind, offset))


def _pairs(node: ast.Assign) -> list[tuple[ast.expr, ast.expr]]:
    pairs: list[tuple[ast.expr, ast.expr]] = []
    for target in node.targets:
        if isinstance(target, ast.Tuple):
            assert isinstance(node.value, ast.Tuple), "as many values as variables"
            pairs += zip(target.elts, node.value.elts, strict=True)
        else:
            pairs.append((target, node.value))
    return pairs
