"""The machine of the playground: functions with which a page opens a scene, advances time, acts, and reads the
state.
"""

import io
import re
import zipfile
from collections.abc import Iterator, Mapping
from math import inf
from pathlib import Path
from shutil import rmtree
from time import perf_counter
from typing import Any

from axistwin.bench import Bench, Controller
from axistwin.bench.acts import Act
from axistwin.bench.codec import CHARACTERS, codec_of
from axistwin.bench.controller import on_a_bus
from axistwin.bench.models import models
from axistwin.controllers.front import Item, Lamp, Reading, Tone, Word
from axistwin.controllers.registry import texts_of
from axistwin.core.errors import PlacedError, UsageError
from axistwin.core.units import to_ns
from axistwin.core.version import VERSION
from axistwin.devices.loading import load_texts
from axistwin.scenes.diagnostics.checking import PROGRAMS, diagnose_text
from axistwin.scenes.reasons.families import reasons_of
from axistwin.scenes.reasons.remedies import Remedies
from axistwin.scenes.scene import Scene
from axistwin.scenes.sessions.buttons import carry_out
from axistwin.scenes.sessions.condition import condition
from axistwin.scenes.sessions.saving import SCENE
from axistwin.scenes.sessions.session import Session
from axistwin.sim.serial_port import Flow
from axistwin.ui.conversation.conversation import READY, Conversation, by_hand
from axistwin.ui.conversation.first import HEAD, about, first_steps
from axistwin.ui.conversation.notes import parts
from axistwin.ui.drawings.of_axes import used_axes
from axistwin.ui.guide.shipped import examples
from axistwin.ui.playground.curves import Curves
from axistwin.ui.playground.link import LONGEST_CONTENTS, Shared, decode, encode
from axistwin.ui.playground.pictures import Pictures
from axistwin.ui.teaching.lessons import COURSES, course
from axistwin.ui.teaching.tutor import own_command

COMMANDS = ":drive, :explain, :init, :next, :show, :store, :task and :why"
CODE = ".py"  # Suffix of the files of devices.
TEXTS = (".toml", *PROGRAMS)  # Suffixes of the files that a scene in the playground can use.
_NAME = re.compile(r"[\w. -]+(/[\w. -]+)*")


class Playground:
    """The open session of a page.  `folder`: directory for the files of the scene; its contents are replaced.

    All methods return data that JSON can contain.  They raise AxistwinError for an error of the user.
    """

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._session: Session | None = None
        self._scene: Scene | None = None

    # Open

    def choices(self) -> dict[str, Any]:
        found = [one for one in examples().values() if one.scene and one.command == "axistwin run"]
        return {
            "version": VERSION, "models": list(models()),
            "examples": [{"name": one.name, "title": one.title} for one in found], "largest": LONGEST_CONTENTS,
        }  # fmt: skip

    def open_model(self, model: str) -> dict[str, Any]:
        return self.open_files({SCENE: f'[[controller]]\nmodel = "{model}"\nname = "{model}"\n'})

    def open_example(self, name: str) -> dict[str, Any]:
        example = examples()[name]
        files = (path for path in example.files if path.suffix in TEXTS)
        texts = {path.relative_to(example.root).as_posix(): path.read_text(encoding="utf-8") for path in files}
        return self.open_files(texts, example.scene)

    def open_link(self, fragment: str, trusted: bool = False) -> dict[str, Any]:
        """Open the scene of a share link.  `target_ns` of the answer is the time of the link.

        A link with devices, which are Python files, opens only if `trusted`; else the answer has their names in `asks`.
        """
        shared = decode(fragment)
        opened = self.open_files(shared.files, SCENE, trusted)
        if "asks" in opened:
            return opened
        other = shared.version != VERSION
        opened["note"] = f"made with axistwin {shared.version}; this is {VERSION}" if other else ""
        return opened | {"target_ns": shared.at_ns}

    def open_files(self, texts: Mapping[str, str], scene: str = SCENE, trusted: bool = False) -> dict[str, Any]:
        """Open a scene of several files, texts by name; only a valid scene replaces the present session.

        Files of devices run only if `trusted`, as for `open_link`.
        """
        for name in texts:
            if not _NAME.fullmatch(name) or ".." in name.split("/"):
                raise UsageError(
                    f"{name!r} is not a file name: expected letters, digits, dots and hyphens, e.g. scene.toml"
                )
        if scene not in texts:
            raise UsageError(f"the scene file is missing: expected a file named {scene}")
        code = {name: text for name, text in texts.items() if name.endswith(CODE)}
        if code and not trusted:
            return {"asks": sorted(code)}
        load_texts(code)
        fresh = self._folder / "opened"
        rmtree(fresh, ignore_errors=True)
        for name, text in texts.items():
            path = fresh / name
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(text, encoding="utf-8")
        self._start(Scene.load(fresh / scene))
        return self._overview()

    def _start(self, scene: Scene) -> None:
        session = Session(scene.build, scene=scene)
        self._scene, self._session = scene, session
        self._talk, self._counts = Conversation(session), dict.fromkeys(session.bench.controllers, 0)
        self._curves, self._pictures = Curves(session), Pictures(session)

    @property
    def _now(self) -> Session:
        if self._session is None:
            raise UsageError("no session is open: choose a model or an example")
        return self._session

    # Read

    def _overview(self) -> dict[str, Any]:
        bench, scene = self._now.bench, self._scene
        assert scene is not None, "a scene is open"
        return {
            "title": scene.title or _titles(bench), "target_ns": 0, "note": "",
            "operator": self._now.operator.model_dump(include={"button", "lamp"}),
            "controllers": [self._parts(name, controller) for name, controller in bench.controllers.items()],
            "files": {SCENE: scene.text, **scene.programs},
        }  # fmt: skip

    def _parts(self, name: str, controller: Controller) -> dict[str, Any]:
        drawn = self._pictures.drawn(name)
        pins = [(pin, found) for pin, found in controller.pins.items() if pin not in drawn]
        return {
            "name": name,
            "model": controller.product.model,
            "commands": on_a_bus(controller),
            "port": on_a_bus(controller) or name in self._now.bench.ports,
            "suffix": controller.product.suffix or ".talk",
            "axes": [
                {"name": f"{name}.{axis}", "unit": found.unit, "limits": list(found.limits) if found.limits else None}
                for axis, found in controller.axes.items()
            ],
            "drawings": self._pictures.overview(name),
            "inputs": [pin for pin, found in pins if found.drivable],
            "outputs": [pin for pin, found in pins if found.is_output],
            "front": [
                {"title": group.title, "row": group.row, "items": [_shown(item) for item in group.items]}
                for group in controller.product.front
            ],
            "first": {"title": HEAD, "about": about(controller), "steps": _first(controller)},
            "lessons": [lesson.title for lesson in course(controller.product.model)]
            if controller.product.family in COURSES
            else [],
        }

    def advance(self, until_ns: int, budget_s: float, from_ns: int = 0, running: bool = True) -> dict[str, Any]:
        """Advance to `until_ns`, for at most `budget_s` of real time; return the state with curves since `from_ns`.

        `running`: True while the page lets virtual time pass.
        """
        session = self._now
        ends_s = perf_counter() + budget_s
        if until_ns > session.bench.now:
            session.forget_rest()
            for _ in self._curves.advance(int(until_ns)):
                if perf_counter() > ends_s:
                    break
        return self.state(from_ns, running=running)

    def step(self, from_ns: int = 0) -> dict[str, Any]:
        """Advance virtual time to the next event, and return the state."""
        due_ns = self._now.bench.clock.next_event_ns()
        return self.state(from_ns) if due_ns is None else self.advance(due_ns, inf, from_ns, running=False)

    def state(self, from_ns: int = 0, points: int = 300, *, running: bool = False) -> dict[str, Any]:
        """Return the present state: time, words, positions, levels, front panels, messages and curves.

        The curves begin at `from_ns`.  Messages, and changes of drawings, are those since the last call.
        """
        session, now = self._now, condition(self._now, running=running)
        return {
            "now_ns": session.bench.now,
            "state": {**now._asdict(), "buttons": [(each.label, each.does, each.filled) for each in now.buttons]},
            "controllers": {name: self._values(controller) for name, controller in session.bench.controllers.items()},
            "entries": {name: found for name in self._counts if (found := self._entries(name))},
            "drawings": self._pictures.changes(now.pin), "curves": self._curves.window(from_ns, points),
            "interval_ns": self._curves.interval_ns,
        }  # fmt: skip

    def _entries(self, name: str) -> list[dict[str, Any]]:
        self._talk.look_at_lesson(name)
        self._counts[name], entries = self._talk.log.since(name, self._counts[name])
        return [entry.shown() for entry in entries]

    def _values(self, controller: Controller) -> dict[str, Any]:
        items = (item for group in controller.product.front for item in group.items)
        return {
            "powered": controller.powered,
            "used": used_axes(controller),
            "axes": {
                axis: {"position": found.position, "velocity": float(found.velocity), "moving": found.moving}
                for axis, found in controller.axes.items()
            },
            "pins": {pin: found.level for pin, found in controller.pins.items()},
            "front": [_value(controller, item) for item in items],
            "lesson": self._lesson(controller.name),
        }

    def _lesson(self, name: str) -> dict[str, Any] | None:
        found = self._talk.lessons.of(name)
        if found is None:
            return None
        number, pupil = found
        step = "done" if pupil.finished else f"step {pupil.step + 1} of {len(pupil.lesson.steps)}"
        return {
            "number": number, "title": f"Lesson {number}: {pupil.lesson.title}, {step}",
            "task": parts(by_hand(pupil.task)), "finished": pupil.finished,
        }  # fmt: skip

    # Act

    def send(self, name: str, text: str) -> None:
        """Send a line to a controller, to a board as a command; or obey a line such as `:why`."""
        if (command := own_command(text.strip())) is not None:
            self._obey(name, *command, typed=text.strip())
            return
        session, controller = self._now, self._now.bench[name]
        if on_a_bus(controller):
            try:
                data = codec_of(controller.product).read(text)
            except PlacedError as error:
                self._talk.refused(name, text, error)
                raise UsageError(f"invalid text in column {error.column} of the line: {error.message}") from error
        else:
            ending = controller.product.endings[0]
            data = text.encode("latin-1", "replace") + ending if ending else CHARACTERS.read(text)
            session.do(name, "flow", Flow.DTR.value)
        self._talk.say(name, data)

    def ask(self, name: str, question: str, words: str = "") -> None:
        """Answer a question to the tutor, e.g. `why`; the answer is a message."""
        self._obey(name, question, words)

    def _obey(self, name: str, command: str, words: str, typed: str = "") -> None:
        if self._talk.ask(name, command, words, typed):
            return
        if typed:
            self._talk.log.ask(name, typed, ())
        match command:
            case "init":
                self.initialise(name)
            case "drive":
                self._now.do(name, *words.partition(" ")[::2])
            case "store":
                self._now.load(name, "typed.sms", f"{words}\n")
            case _:
                raise UsageError(f"unknown command :{command}: expected one of {COMMANDS}")

    def initialise(self, name: str) -> None:
        if not self._follow(name, reasons_of(self._now.bench[name], Remedies()).initialisation()):
            self._talk.log.ask(name, "Initialise", [READY])

    def begin_lesson(self, name: str, number: int) -> None:
        """Switch a controller off and on, and begin a lesson, from 1."""
        self._follow(name, self._talk.lessons.begin(name, number))

    def end_lesson(self, name: str) -> None:
        self._talk.lessons.end(name)

    def press(self, label: str, running: bool) -> None:
        """Press a button of the present state; nothing happens if the state has changed meanwhile."""
        now = condition(self._now, running=running)
        for button in (each for each in now.buttons if each.label == label):
            if button.does == "do":
                self._follow(now.controller, iter(button.acts))
            elif button.does == "go":
                self._pass(to_ns(button.at_s))
            elif button.does == "initialise":
                self.initialise(now.controller)

    def restart(self) -> dict[str, Any]:
        """Begin again at virtual time 0 with the open scene, and return its overview."""
        assert self._scene is not None, "a scene is open"
        self._start(self._scene)
        return self._overview()

    def _follow(self, name: str, acts: Iterator[Act]) -> bool:
        """Perform acts one after the other, at full speed; return False if there are none."""
        some, session = False, self._now
        for act in acts:
            some = True
            if wait_ns := carry_out(session, name, act):
                self._pass(session.bench.now + wait_ns)
        return some

    def _pass(self, until_ns: int) -> None:
        for _ in self._curves.advance(until_ns):
            pass

    def act(self, name: str, target: str, value: str) -> None:
        """Perform an action at the machine, e.g. `act("if1", "input1", "low")` or `act("if1", "power", "off")`."""
        self._now.do(name, target, value)

    def click(self, drawing: str, part: str) -> None:
        self._pictures.click(drawing, part)

    def load(self, name: str, file: str, text: str) -> None:
        self._now.load(name, file, text)

    def check(self, name: str, suffix: str, text: str) -> list[dict[str, Any]]:
        found = diagnose_text(text, suffix, self._now.bench[name].product)
        return [
            {"line": each.line, "column": each.column, "severity": each.severity.value, "message": each.message}
            for each in found
        ]

    # Take away

    def link(self) -> str:
        return encode(Shared(self._files(), self._now.bench.now))

    def _files(self) -> dict[str, str]:
        """Return the files of a scene that repeats this session, those of its devices included."""
        code = texts_of(controller.product.model for controller in self._now.bench.controllers.values())
        return {**self._now.save(), **{Path(path).name: text for path, text in code.items()}}

    def saved(self) -> bytes:
        """Return a ZIP archive of a scene that repeats this session with `axistwin run`."""
        buffer = io.BytesIO()
        with zipfile.ZipFile(buffer, "w", zipfile.ZIP_DEFLATED) as archive:
            for name, text in self._files().items():
                archive.writestr(zipfile.ZipInfo(name), text)
        return buffer.getvalue()

    def table(self) -> str:
        return self._curves.table()


def _titles(bench: Bench) -> str:
    """Return the names of the controllers; the title of the only one, if it has the name of its model."""
    found = {name: controller.product for name, controller in bench.controllers.items()}
    return ", ".join(made.title if len(found) == 1 and name == made.model else name for name, made in found.items())


def _value(controller: Controller, item: Item) -> bool | tuple[str, str]:
    """Return if a lamp is lit, or the text of a display and its tone."""
    value = controller.read(item.source)
    if isinstance(item, Word):
        return item.shows(value), item.tones.get(value, Tone.PLAIN).value
    number = None if value is None else int(value)
    return item.shows(number) if isinstance(item, Lamp) else (item.shows(number), Tone.PLAIN.value)


def _shown(item: Item) -> dict[str, Any]:
    words = f"{item.name}.  {item.doc}".rstrip(". ") + "."
    tone = item.tone.value if isinstance(item, Lamp) else Tone.PLAIN.value
    unit = item.unit if isinstance(item, Reading) else ""
    kind = "lamp" if isinstance(item, Lamp) else "display"
    return {"kind": kind, "label": item.label or item.name, "words": words, "tone": tone, "unit": unit}


def _first(controller: Controller) -> list[dict[str, Any]]:
    steps = first_steps(controller)
    return [{"title": each.title, "words": parts(each.words), "initialises": each.initialises} for each in steps]
