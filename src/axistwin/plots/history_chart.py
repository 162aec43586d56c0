"""A chart of a run on a bench, as drawn by `run --plot`; stepper curves are exact."""

from axistwin.bench import endpoints
from axistwin.plots import chart, curves
from axistwin.plots.chart import BACKGROUND, HIDDEN, LOW, TALL, Chart, Line, Panel, Word
from axistwin.plots.curves import Curve
from axistwin.plots.history import History, Move
from axistwin.plots.servo_record import ServoRecord
from axistwin.units import S


def of_history(history: History, title: str = "") -> Chart:
    """Return a chart of the time with motion or level changes, or else of the whole run."""
    return _Drawn(history, title).chart


class _Drawn:
    def __init__(self, history: History, title: str) -> None:
        self.history = history
        from_ns, to_ns, edge_ns = chart.span(history.began_ns, history.bench.now, self._times())
        self.chart = Chart(title, from_ns, to_ns, edge_ns)
        colours = chart.colours()
        moves: dict[str, list[Move]] = {}
        for move in history.strokes():
            moves.setdefault(self._name(move.controller, move.axis), []).append(move)
        for name, of_one in moves.items():
            self._add_stepper(name, of_one, next(colours))
        for servo in history.servos:
            if len(servo.points()):
                self._add_servo(self._name(servo.controller, servo.name), servo, next(colours))
        self.chart.lanes = self._lanes()
        self.chart.add_faults(history.faults)
        self._add_words()

    def _name(self, controller: str, name: str) -> str:
        return f"{controller}.{name}" if len(self.history.bench.controllers) > 1 else name

    def _times(self) -> list[int]:
        moves, now_ns = self.history.moves(), self.history.bench.now
        changes = [change.time_ns for change in self.history.changes if change.pin not in BACKGROUND]
        return [*(move.start_ns for move in moves), *(move.end_ns or now_ns for move in moves), *changes]

    def _add_stepper(self, name: str, moves: list[Move], colour: int) -> None:
        from_ns, to_ns = self.chart.from_ns, self.chart.to_ns
        velocity = Line(curves.velocity(moves, from_ns, to_ns), steps=True)
        position = Line(curves.position(moves, from_ns, to_ns))
        self.chart.panels += [
            Panel(f"{name}  velocity\npulses/s", [velocity], TALL, filled=True, colour=colour),
            Panel(f"{name}  position\npulses", [position], colour=colour),
        ]

    def _add_servo(self, name: str, servo: ServoRecord, colour: int) -> None:
        from_ns, to_ns, points = self.chart.from_ns, self.chart.to_ns, servo.points()
        position, commanded, error = curves.servo(points, from_ns, to_ns)
        velocity = chart.rate(points[:, 0], points[:, 1], from_ns, to_ns)
        self.chart.panels += servo_panels(name, velocity, position, commanded, error, colour)

    def _lanes(self) -> dict[str, Curve]:
        """Return the levels that change in the drawn time."""
        history, from_ns, to_ns = self.history, self.chart.from_ns, self.chart.to_ns
        levels = dict(history.levels)
        found: dict[tuple[str, str], Curve] = {}
        for change in history.changes:
            key = change.controller, change.pin
            if change.pin not in HIDDEN and from_ns <= change.time_ns <= to_ns:
                if key not in found:
                    found[key] = Curve([from_ns / S], [levels[key]])
                found[key].add(change.time_ns, change.level)
            levels[key] = change.level
        for key, lane in found.items():
            lane.add(to_ns, levels[key])
        return {self._name(*key): lane for key, lane in sorted(found.items())}

    def _add_words(self) -> None:
        bench = self.history.bench
        several = endpoints.several(bench)
        self.chart.words = {} if several else {"host": [], "controller": []}
        for said in self.history.said:
            if self.chart.from_ns <= said.time_ns <= self.chart.to_ns:
                text = endpoints.codec_at(bench, said.controller).show(bytes(said.data))
                who = speaker(said.controller if several else "", said.by_host)
                self.chart.words.setdefault(who, []).append(Word(said.time_ns, text))


def speaker(name: str, by_host: bool) -> str:
    """Return the label of a sender: `host`, `controller`; with several controllers, `host to table` and `table`."""
    if not name:
        return "host" if by_host else "controller"
    return f"host to {name}" if by_host else name


def servo_panels(
    name: str, velocity: Curve, position: Curve, commanded: Curve, error: Curve, colour: int, *, steps: bool = False
) -> list[Panel]:
    """Return panels for velocity, actual and commanded position, following error.  `steps`: values hold."""
    places = [Line(position, steps, legend="position"), Line(commanded, steps, faint=True, legend="commanded")]
    return [
        Panel(f"{name}  velocity\ncounts/s", [Line(velocity, steps=True)], TALL, filled=True, colour=colour),
        Panel(f"{name}  position\ncounts", places, TALL, colour=colour),
        Panel(f"{name}  following\nerror, counts", [Line(error, steps)], LOW, filled=True, colour=colour),
    ]
