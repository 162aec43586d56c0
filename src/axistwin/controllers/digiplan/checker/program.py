"""Checks a program for an IF1 or IF2 without running it, line by line, with the parser of the interface.

`check` tracks the initialisation, the messages, the lock and the parameters from power-on to power-off.
"""

from collections.abc import Iterator, Sequence
from collections.abc import Set as AbstractSet

from axistwin.controllers.diagnostics import Diagnostic, Fix, Rule, Sent, Session, diagnose
from axistwin.controllers.digiplan import rules
from axistwin.controllers.digiplan.chapters.data_format import CR, LF, Frame
from axistwin.controllers.digiplan.chapters.initialise import BAUD_DETECT, ERASE, FormatReader
from axistwin.controllers.digiplan.chapters.interpolation import out_of_range
from axistwin.controllers.digiplan.chapters.speed import too_fast
from axistwin.controllers.digiplan.checker import fixes
from axistwin.controllers.digiplan.checker.sequence import Finding, follow
from axistwin.controllers.digiplan.commands import COMMANDS
from axistwin.controllers.digiplan.language import LONGEST_MESSAGE, Accept, Message, parse
from axistwin.controllers.digiplan.step import Parameters, Problem, Step


def check(sessions: Sequence[Session], battery: bool = False) -> list[Diagnostic]:
    """Return all problems in a host's messages, in order of place; `battery`: the interface is an IF2."""
    checker = _Checker(battery)
    for session in sessions:
        checker.follow(session)
    if sessions and sessions[-1].ended:
        checker.end()
    return sorted(set(checker.found))


class _Checker:
    def __init__(self, battery: bool) -> None:
        self.battery = battery
        self.found: list[Diagnostic] = []
        self.parameters = Parameters()
        self.set_in: dict[str, int] = {}
        self.sequence: Message | None = None
        self.locked_in: int | None = None
        self.frame: Frame | None = None
        self.not_started: Sequence[Sent] = ()  # The last distance without `$`, if no move has been started since.

    def end(self) -> None:
        """Report a distance that the program sets but, without a `$`, never uses."""
        if self.not_started:
            note = "without $ this message starts no move, and no later message does"
            self._say(rules.NO_START, self.not_started[-1:], note, fix=fixes.start(self.not_started))

    def follow(self, session: Session) -> None:
        characters = [sent._replace(byte=sent.byte & 0x7F) for sent in session.characters]
        self._switch_on(session.initialised, characters)
        rest = iter(characters)
        if self.frame is None:
            self._initialise(rest)
        text: list[Sent] = []
        for sent in rest:
            # The program checker assumes that all axes are at rest and that DSR is active.
            if self.locked_in is not None and sent.byte == BAUD_DETECT:
                self._data_format(sent, rest)
                text = []
            elif self.frame is not None and sent.byte == self.frame.ends_message:
                self._message(text)
                text = []
            elif sent.byte not in (CR, LF):
                text.append(sent)
        if "".join(chr(sent.byte) for sent in text).strip():
            end = "<CR>" if self.frame is None or self.frame.terminator == "U" else "<LF>"
            self._say(rules.UNENDED, text, f"this message has no end: {end} is missing")

    def _switch_on(self, initialised: bool, characters: Sequence[Sent]) -> None:
        if not self.battery or self.locked_in is None:
            self._forget()
        if initialised:
            self.frame = Frame()
        elif self.locked_in is None or (characters and characters[0].byte == BAUD_DETECT):
            self.frame = None

    def _forget(self) -> None:
        self.parameters, self.set_in, self.sequence, self.locked_in = Parameters(), {}, None, None

    def _initialise(self, rest: Iterator[Sent]) -> None:
        first = next((sent for sent in rest if sent.byte not in (CR, LF, ord(" "))), None)
        if first is not None and first.byte != BAUD_DETECT:
            self._say(rules.TOO_EARLY, [first], "characters before ( are ignored, because the baud rate is unknown")
            first = next((sent for sent in rest if sent.byte == BAUD_DETECT), None)
        if first is not None:
            self._data_format(first, rest)

    def _data_format(self, begin: Sent, rest: Iterator[Sent]) -> None:
        reader = FormatReader()
        for sent in rest:
            before = reader.text
            begin = begin if before else sent
            if sent.byte in (BAUD_DETECT, ERASE):
                reader.text = ""
                if sent.byte == ERASE:
                    self._forget()
            elif frame := reader.take(sent.byte):
                self.frame = frame
                return
            elif before and not reader.text:
                note = f"invalid data format {before!r}: U or V, frame 1 to 8, parity 1 to 9; U ends in <CR>, V in <LF>"
                self._say(rules.FORMAT, [begin], note)
        if reader.text:
            self._say(rules.FORMAT_UNENDED, [begin], "the data format message has no end")

    def _message(self, text: Sequence[Sent]) -> None:
        message = parse("".join(chr(sent.byte) for sent in text[:LONGEST_MESSAGE]), COMMANDS)
        if not message.text.strip(" "):
            return
        if self.locked_in is not None:
            self._locked(text, message)
            return
        for problem in message.problems:
            self._problem(text, message, problem)
        if message.problems:
            return
        if message.alone is not None:
            self.locked_in = text[0].line if message.alone.code == "[" else None
        elif message.sequence:
            self._sequence(text, message)
        elif message.steps[0].hand_over:
            self._hand_back(text)
        else:
            self._direct(text, message)

    def _locked(self, text: Sequence[Sent], message: Message) -> None:
        if message.alone is None or message.problems or Accept.LOCKED not in message.alone.accepted:
            note = f"ignored: locked in line {self.locked_in}, only status requests and ] are obeyed"
            self._say(rules.LOCKED, text, note)
        elif message.alone.code == "]":
            self.locked_in = None

    def _hand_back(self, text: Sequence[Sent]) -> None:
        if self.sequence is None or not any(step.hand_over for step in self.sequence.steps):
            note = "% gives control back to a sequence, but no sequence has given control to the host"
            self._say(rules.NO_INTERVENTION, text, note)

    def _direct(self, text: Sequence[Sent], message: Message) -> None:
        step = message.steps[0]
        if not message.start and _needs_start(step):
            note = "without $ at its end this message starts nothing"
            self._say(rules.NO_START, text[-1:], note, fix=fixes.start(text))
        if message.start:
            self.not_started = ()
        elif step.major and "distance" in step.settings:
            self.not_started = text
        problem = self._refused(step, starts=message.start)
        if problem is not None:
            self._values(text, step, problem)
            return
        if step.run and not step.interpolated and "distance" in step.settings:
            note = "G runs until stopped: the distance is not used and becomes 0"
            at = step.places["distance"]
            self._say(rules.UNUSED_DISTANCE, text[at:], note, fix=fixes.without_distance(text, message, at))
        self._keep(text, step)
        if message.start and step.major and not step.run and self.parameters.distance == 0:
            self._say(rules.NO_DISTANCE, text, f"nothing moves: the distance is 0{self._origin('distance')}")

    def _refused(self, step: Step, starts: bool) -> Problem | None:
        after = self.parameters.after(step)
        problem = too_fast(after) if "speed" in step.settings else None
        return problem or (out_of_range(after, step) if starts and step.major else None)

    def _keep(self, text: Sequence[Sent], step: Step) -> None:
        self.parameters = self.parameters.left_by(step)
        self.set_in |= {name: text[place].line for name, place in step.places.items()}
        if step.run:
            self.set_in["distance"] = self.set_in["minor_distance"] = text[0].line

    def _sequence(self, text: Sequence[Sent], message: Message) -> None:
        self.not_started = ()
        for step in message.steps:
            problem = self._refused(step, starts=False)
            if problem is not None:
                self._values(text, step, problem)
                return
        self.sequence = message if message.steps else self.sequence
        if self.sequence is None:
            self._say(
                rules.NOTHING_STORED,
                text,
                "no stored sequence to run again: expected a sequence before it, e.g. :X100:$",
            )
            return
        for finding in follow(self.sequence.steps, self.parameters):
            self._finding(text, message, finding)
        for step in self.sequence.steps:
            self.parameters = self.parameters.left_by(step)
        for step in message.steps:
            self._keep(text, step)

    def _finding(self, text: Sequence[Sent], message: Message, finding: Finding) -> None:
        """Report a problem of a sequence at its step; `:$` has no steps, so the report gives its number."""
        assert self.sequence is not None
        number, problem = finding.number, finding.problem
        if message.steps:
            problem = problem._replace(position=message.places[number - 1])
        else:
            problem = problem._replace(message=f"step {number}: {problem.message}")
        step = message.steps[number - 1] if message.steps else Step()
        self._values(text, step, problem, {name for each in self.sequence.steps for name in each.settings})

    def _values(
        self, text: Sequence[Sent], step: Step, problem: Problem, known: AbstractSet[str] = frozenset()
    ) -> None:
        here = [step.places[name] for name in problem.about if name in step.places]
        elsewhere = [name for name in problem.about if name not in step.places and name not in known]
        at = here[0] if here else problem.position
        self._say(problem.rule, text[at : at + 1], problem.message + self._origin(*elsewhere), problem.chapter)

    def _origin(self, *names: str) -> str:
        shown = [(name.removeprefix("speed_").replace("_", " "), name) for name in names if name in self.set_in]
        notes = [f"{text} from line {self.set_in[name]}" for text, name in shown]
        return f" ({', '.join(notes)})" if notes else ""

    def _problem(self, text: Sequence[Sent], message: Message, problem: Problem) -> None:
        here = text[problem.position : problem.end or problem.position + 1]
        if not here:
            here = [text[-1]._replace(column=text[-1].column + text[-1].width, width=0)]
        self._say(problem.rule, here, problem.message, problem.chapter, fixes.of(text, message, problem))

    def _say(
        self, rule: Rule, characters: Sequence[Sent], message: str, chapter: str = "", fix: Fix | None = None
    ) -> None:
        self.found.append(diagnose(rule, characters, message, chapter, fix))


def _needs_start(step: Step) -> bool:
    return bool(step.set or step.reset or step.run) or step.pulse is not None or not step.settings
