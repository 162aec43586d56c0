"""All possible changes of a module; each replaces one node of the syntax tree."""

import ast
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from random import Random

COMPARISONS = {
    ast.Lt: ast.LtE, ast.LtE: ast.Lt, ast.Gt: ast.GtE, ast.GtE: ast.Gt, ast.Eq: ast.NotEq, ast.NotEq: ast.Eq,
    ast.Is: ast.IsNot, ast.IsNot: ast.Is, ast.In: ast.NotIn, ast.NotIn: ast.In,
}  # fmt: skip
ARITHMETIC = {
    ast.Add: ast.Sub, ast.Sub: ast.Add, ast.Mult: ast.FloorDiv, ast.Div: ast.Mult, ast.FloorDiv: ast.Mult,
    ast.Mod: ast.FloorDiv, ast.LShift: ast.RShift, ast.RShift: ast.LShift, ast.BitAnd: ast.BitOr, ast.BitXor: ast.BitOr,
}  # fmt: skip
TIMES = {"US": "MS", "MS": "S", "S": "MS"}
"""Units of time, which are attributes of `axistwin.core.units` or imported from there."""
STATES = {
    "I": "V", "V": "I", "Q": "I", "S": "Q", "C": "I", "W": "V", "D": "I", "ANY": "I", "ASK": "I",
    "PART": "DIRECT", "SETUP": "DIRECT", "DIRECT": "STEP", "STEP": "DIRECT", "MOVE": "DIRECT", "ALONE": "DIRECT",
    "BOTH": "INSIDE", "INSIDE": "HOST", "HOST": "INSIDE", "BLOCK": "HOST", "GONE": "BOTH",
}  # fmt: skip
"""Names of states in the command tables, with their replacements."""
ENTRY_PARTS, ACCEPTED = 5, 4
"""Index of the states in an entry of a command table; an entry has at least five parts."""


@dataclass(frozen=True)
class Mutant:
    """One change.

    `node`: number of the node in the syntax tree; `variant`: number of the change at this node; `occurrence`: number
    of the same change in one function.
    """

    file: str
    line: int
    function: str
    before: str
    after: str
    node: int
    variant: int
    occurrence: int = 1

    @property
    def key(self) -> str:
        """Return a name without the line number, because later edits could change the number."""
        again = f" ({self.occurrence})" if self.occurrence > 1 else ""
        return f"{self.file}: {self.function}: {self.before} -> {self.after}{again}"

    @property
    def name(self) -> str:
        """Return a name for users."""
        return f"{self.file}:{self.line}: {self.key.partition(': ')[2]}"


def mutants(file: str, source: str) -> list[Mutant]:
    """Return every change of a module, in the order of its syntax tree."""
    found, seen = [], Counter[tuple[str, str, str]]()
    for number, place in enumerate(_places(ast.parse(source))):
        for variant, new in enumerate(_variants(place)):
            change = place.function, _text(place.node), _text(new)
            seen[change] += 1
            found.append(Mutant(file, place.node.lineno, *change, number, variant, seen[change]))
    return found


def apply(source: str, mutant: Mutant) -> ast.Module:
    """Return the syntax tree of a module with one change made."""
    tree = ast.parse(source)
    place = _places(tree)[mutant.node]
    new = list(_variants(place))[mutant.variant]
    for part in ast.walk(new):
        ast.copy_location(part, place.node)
    value = getattr(place.parent, place.field)
    if isinstance(value, list):
        value[next(n for n, item in enumerate(value) if item is place.node)] = new
    else:
        setattr(place.parent, place.field, new)
    return ast.fix_missing_locations(tree)


def sample(found: list[Mutant], size: int, random: Random) -> list[Mutant]:
    """Return `size` of the changes, in the order of the files."""
    return sorted(random.sample(found, min(size, len(found))), key=found.index)


@dataclass(frozen=True)
class _Place:
    """A node with its surrounding nodes."""

    node: ast.AST
    parent: ast.AST
    field: str
    function: str
    skipped: bool


def _places(tree: ast.Module) -> list[_Place]:
    found: list[_Place] = []
    _visit(tree, "module", skipped=False, found=found)
    return found


def _visit(node: ast.AST, function: str, *, skipped: bool, found: list[_Place]) -> None:
    for field, value in ast.iter_fields(node):
        for child in value if isinstance(value, list) else [value]:
            if isinstance(child, ast.AST):
                inside = skipped or _is_no_behaviour(node, field, child)
                found.append(_Place(child, node, field, function, inside))
                _visit(child, _function(child, function), skipped=inside, found=found)


def _function(node: ast.AST, outer: str) -> str:
    if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef):
        return node.name if outer == "module" else f"{outer}.{node.name}"
    return outer


def _is_no_behaviour(parent: ast.AST, field: str, node: ast.AST) -> bool:
    """True for annotations, decorators, docstrings, assertions and texts of exceptions."""
    if field in ("annotation", "returns", "decorator_list", "type_params", "bases"):
        return True
    if isinstance(node, ast.Assert | ast.Import | ast.ImportFrom | ast.JoinedStr) or isinstance(parent, ast.Raise):
        return True
    if isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant):
        return True
    return isinstance(node, ast.If) and "TYPE_CHECKING" in ast.dump(node.test)


def _text(node: ast.AST) -> str:
    if isinstance(node, ast.If | ast.While):
        return f"{type(node).__name__.lower()} {_text(node.test)}"
    text = " ".join(ast.unparse(node).split()) if not isinstance(node, ast.Pass) else "nothing"
    return text if len(text) <= 120 else f"{text[:117]}..."


def _variants(place: _Place) -> Iterator[ast.AST]:
    """Yield every replacement of one node."""
    node = place.node
    if place.skipped:
        return
    if isinstance(node, ast.Compare):
        yield from _compared(node)
    elif isinstance(node, ast.BinOp):
        yield from _calculated(node, place)
    elif isinstance(node, ast.BoolOp):
        yield ast.BoolOp(ast.Or() if isinstance(node.op, ast.And) else ast.And(), node.values)
    elif isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.Not | ast.USub | ast.Invert):
        yield node.operand
    elif isinstance(node, ast.Constant):
        yield from _other_constants(node, place)
    elif isinstance(node, ast.If | ast.IfExp):
        yield from (type(node)(ast.Constant(value), node.body, node.orelse) for value in (True, False))
    elif isinstance(node, ast.While):
        yield ast.While(ast.Constant(value=False), node.body, node.orelse)
    elif isinstance(node, ast.comprehension) and node.ifs:
        return  # the condition of this statement is changed as a comparison
    elif isinstance(node, ast.stmt):
        yield from _other_statements(node)
    elif isinstance(node, ast.Attribute | ast.Name):
        yield from _other_names(node, place)


def _compared(node: ast.Compare) -> Iterator[ast.AST]:
    for number, operator in enumerate(node.ops):
        operators = [*node.ops]
        operators[number] = COMPARISONS[type(operator)]()
        yield ast.Compare(node.left, operators, node.comparators)


def _calculated(node: ast.BinOp, place: _Place) -> Iterator[ast.AST]:
    if isinstance(node.op, ast.BitOr):
        if place.function != "module" or _in_entry(place):
            yield from (node.left, node.right)
    elif type(node.op) in ARITHMETIC and not isinstance(node.left, ast.JoinedStr):
        yield ast.BinOp(node.left, ARITHMETIC[type(node.op)](), node.right)


def _other_constants(node: ast.Constant, place: _Place) -> Iterator[ast.AST]:
    value = node.value
    if isinstance(value, bool):
        yield ast.Constant(not value)
    elif isinstance(value, int | float):
        yield from (ast.Constant(value + 1), ast.Constant(value - 1))
    elif isinstance(value, str) and (len(value) == 1 or _is_unit(node, place)):
        yield ast.Constant("furlongs" if _is_unit(node, place) else "~")


def _is_unit(node: ast.Constant, place: _Place) -> bool:
    """True for a unit: at module level, the second argument of a parameter or the argument `unit`."""
    if place.function != "module" or not node.value:
        return False
    if isinstance(place.parent, ast.keyword):
        return place.parent.arg == "unit"
    call = place.parent
    return isinstance(call, ast.Call) and call.args[1:2] == [node] and not _is_entry(call)


def _is_entry(call: ast.Call) -> bool:
    return isinstance(call.func, ast.Name) and len(call.args) > ENTRY_PARTS


def _in_entry(place: _Place) -> bool:
    """True if the node gives the states in which a command of a table is accepted."""
    return isinstance(place.parent, ast.BinOp) or (isinstance(place.parent, ast.Call) and _is_entry(place.parent))


def _other_statements(node: ast.stmt) -> Iterator[ast.AST]:
    if isinstance(node, ast.Expr | ast.Raise):
        yield ast.Pass()
    elif isinstance(node, ast.Assign | ast.AnnAssign):
        target = node.targets[0] if isinstance(node, ast.Assign) else node.target
        if isinstance(target, ast.Attribute | ast.Subscript) and node.value is not None:
            yield ast.Pass()
    elif isinstance(node, ast.AugAssign):
        yield ast.Pass()
        if type(node.op) in ARITHMETIC:
            yield ast.AugAssign(node.target, ARITHMETIC[type(node.op)](), node.value)
    elif isinstance(node, ast.Return) and node.value is not None and not _is_none(node.value):
        yield ast.Return(ast.Constant(None))
    elif isinstance(node, ast.Break):
        yield ast.Pass()
    elif isinstance(node, ast.Continue):
        yield ast.Break()


def _is_none(node: ast.AST) -> bool:
    return isinstance(node, ast.Constant) and node.value is None


def _other_names(node: ast.Attribute | ast.Name, place: _Place) -> Iterator[ast.AST]:
    if not isinstance(node.ctx, ast.Load):
        return
    if isinstance(node, ast.Attribute):
        if isinstance(node.value, ast.Name) and node.value.id == "units" and node.attr in TIMES:
            yield ast.Attribute(node.value, TIMES[node.attr], ast.Load())
        return
    call = place.parent
    if isinstance(call, ast.Call) and _is_entry(call) and call.args[ACCEPTED] is node and node.id in STATES:
        yield ast.Name(STATES[node.id], ast.Load())
    elif place.function != "module" and node.id in ("MS", "US"):
        yield ast.BinOp(node, ast.Mult(), ast.Constant(1000))
