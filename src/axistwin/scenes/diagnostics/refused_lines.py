"""Tell the lines of hosts that controllers refuse, each once, with the reason and the remedy."""

from collections.abc import Callable
from contextlib import ExitStack
from dataclasses import dataclass
from functools import partial
from logging import getLogger

from axistwin.bench import Bench, Controller
from axistwin.controllers.diagnostics import Rule, Severity, check_last
from axistwin.controllers.product import Product, Refusal

log = getLogger("axistwin")
MOST_LINES = 100  # Number of different lines of a port that are told; further lines are only counted.
LONGEST_LINE = 60  # Number of bytes of a line that are shown.
FURTHER = b"", ""


@dataclass
class _Line:
    """A refused line as text, and how often it has been refused."""

    text: str
    count: int = 0

    @property
    def due(self) -> bool:
        """True at the 10th, 100th, 1000th, … refusal."""
        return self.count > 1 and str(self.count).rstrip("0") == "1"

    @property
    def words(self) -> str:
        if not self.text:
            return f"refused {self.count} further lines"
        return f"refused {self.text} (the same {f'{self.count - 1} times' if self.count > 2 else 'once'} more)"


class RefusedLines:
    """Tells each refused line once; repetitions are counted, and told at the 10th, 100th, 1000th, … and at the end.

    `tell` receives each text; by default it is a warning of the logger `axistwin`.
    """

    def __init__(self, tell: Callable[[str], object] = log.warning) -> None:
        self._tell = tell
        self._refused: dict[str, dict[tuple[bytes, str], _Line]] = {}  # By port, and by line and reason.

    def watch(self, bench: Bench) -> Callable[[], None]:
        """Begin to tell the refused lines of all controllers of a bench.  Return an unsubscribe function."""
        stack = ExitStack()
        for controller in bench.controllers.values():
            stack.callback(controller.subscribe_refusals(partial(self._note, controller)))
        return stack.close

    def close(self) -> None:
        for port, lines in self._refused.items():
            for line in lines.values():
                if (line.count > 1 or not line.text) and not line.due:
                    self._tell(f"{port}: {line.words}")
        self._refused.clear()

    def _note(self, controller: Controller, refusal: Refusal) -> None:
        port = controller.port_name(refusal.channel)
        if not port.startswith(controller.name):
            port = f"{port} ({controller.name})"
        lines, key = self._refused.setdefault(port, {}), (refusal.data, refusal.why)
        if key not in lines and len(lines) >= MOST_LINES:
            key = FURTHER
        if key not in lines:
            lines[key] = _Line("" if key is FURTHER else shown(controller.product, refusal.data))
        line = lines[key]
        line.count += 1
        if line.count == 1 and line.text:
            self._tell(f"{port}: refused {line.text}: {explain(controller.product, refusal)}")
        elif line.due:
            self._tell(f"{port}: {line.words}")


def shown(product: Product, data: bytes) -> str:
    from axistwin.bench.codec import codec_of  # a server needs it only for a refused line

    return codec_of(product).show(data[:LONGEST_LINE]) + "…" * (len(data) > LONGEST_LINE)


def explain(product: Product, refusal: Refusal) -> str:
    if refusal.why:
        return refusal.why if refusal.rule is None else f"{refusal.why} [{refusal.rule.code}]: {_said(refusal.rule)}"
    if product.check is None:
        return "no command of this controller matches"
    line = refusal.data if product.language is not None else refusal.data + product.endings[0]
    found = check_last(product.check, [line])
    errors = [each for each in found if each.severity is Severity.ERROR] or found
    if not errors:
        return "it is not accepted in the present state"
    first = errors[0]
    rule = next(rule for rule in product.rules if rule.code == first.code)
    return first.words if first.fix is not None else f"{first.words}: {_said(rule)}"


def _said(rule: Rule) -> str:
    return rule.explanation.replace("  ", " ")


def prepare(bench: Bench) -> None:
    """Import the checkers of the controllers, so that the first refused line costs no more time than later ones."""
    for controller in bench.controllers.values():
        if controller.product.check is not None:
            controller.product.check([])
