"""The machine of the playground: functions with which a page opens a scene, advances time, acts, and reads the
state.
"""

import io
import re
import zipfile
from collections.abc import Mapping
from math import inf
from pathlib import Path
from shutil import rmtree
from time import perf_counter
from typing import Any

from axistwin.bench import Bench, Controller
from axistwin.bench.codec import CHARACTERS, codec_of, unpadded
from axistwin.bench.controller import on_a_bus
from axistwin.bench.models import models
from axistwin.controllers.front import Item, Lamp
from axistwin.controllers.registry import texts_of
from axistwin.core.errors import PlacedError, UsageError
from axistwin.core.version import VERSION
from axistwin.devices.loading import load_texts
from axistwin.scenes.diagnostics.checking import PROGRAMS, diagnose_text
from axistwin.scenes.scene import Scene
from axistwin.scenes.sessions.saving import SCENE
from axistwin.scenes.sessions.session import Session
from axistwin.sim.serial_port import Flow
from axistwin.ui.drawings.of_axes import used_axes
from axistwin.ui.guide.shipped import examples
from axistwin.ui.playground.curves import Curves
from axistwin.ui.playground.link import LONGEST_CONTENTS, Shared, decode, encode
from axistwin.ui.playground.pictures import Pictures
from axistwin.ui.teaching.tutor import Tutor

MOST_MESSAGES = 2000  # Largest number of messages that are stored until the page reads them; the oldest are deleted.
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
        self._messages: list[dict[str, Any]] = []
        self._tutors: dict[str, Tutor] = {}
        self._curves, self._pictures = Curves(session), Pictures(session)
        for name in session.bench.controllers:
            self._listen(session.bench, name)

    @property
    def _now(self) -> Session:
        if self._session is None:
            raise UsageError("no session is open: choose a model or an example")
        return self._session

    def _listen(self, bench: Bench, name: str) -> None:
        controller = bench.controllers[name]
        self._tutors[name] = Tutor(controller)
        if on_a_bus(controller):
            codec = codec_of(controller.product)

            def message(data: bytes) -> None:
                shown = codec.show(unpadded(data))
                self._receive(name, data, f"< {shown}   {codec.words(data, by_host=False)}\n")

            controller.bus.subscribe_received(message)
        elif name in bench.ports:
            port = bench.port(name)
            port.subscribe_received(lambda byte, _: self._receive(name, bytes([byte]), chr(byte)))
            port.subscribe_sent(lambda data: self._add(name, "host", data.decode("latin-1")))

    def _receive(self, name: str, data: bytes, shown: str) -> None:
        self._add(name, "controller", shown)
        for line in self._tutors[name].received(data):
            self._add(name, "tutor", line)

    def _add(self, name: str, who: str, text: str) -> None:
        last = self._messages[-1] if self._messages else None
        if (
            last
            and who == "controller"
            and (last["name"], last["who"]) == (name, who)
            and not last["text"].endswith("\n")
        ):
            last["text"] += text
        elif len(self._messages) < MOST_MESSAGES:
            self._messages.append({"name": name, "who": who, "text": text, "at_ns": self._now.bench.now})

    # Read

    def _overview(self) -> dict[str, Any]:
        bench, scene = self._now.bench, self._scene
        assert scene is not None, "a scene is open"
        return {
            "title": scene.title or ", ".join(bench.controllers), "target_ns": 0, "note": "",
            "controllers": [self._parts(name, controller) for name, controller in bench.controllers.items()],
            "files": {SCENE: scene.text, **scene.programs},
        }  # fmt: skip

    def _parts(self, name: str, controller: Controller) -> dict[str, Any]:
        drawn = self._pictures.drawn(name)
        pins = [(pin, found) for pin, found in controller.pins.items() if pin not in drawn]
        lamps = [(group, item) for group in controller.product.front for item in group.items if isinstance(item, Lamp)]
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
            "lamps": [
                {"label": item.label or item.name, "group": group.title, "words": _words(item), "tone": item.tone.value}
                for group, item in lamps
            ],
        }

    def advance(self, until_ns: int, budget_s: float, from_ns: int = 0) -> dict[str, Any]:
        """Advance to `until_ns`, for at most `budget_s` of real time; return the state with curves since `from_ns`."""
        session = self._now
        ends_s = perf_counter() + budget_s
        if until_ns > session.bench.now:
            session.forget_rest()
            for _ in self._curves.advance(int(until_ns)):
                if perf_counter() > ends_s:
                    break
        return self.state(from_ns)

    def step(self, from_ns: int = 0) -> dict[str, Any]:
        """Advance virtual time to the next event, and return the state."""
        due_ns = self._now.bench.clock.next_event_ns()
        return self.state(from_ns) if due_ns is None else self.advance(due_ns, inf, from_ns)

    def state(self, from_ns: int = 0, points: int = 300) -> dict[str, Any]:
        """Return the present state: time, positions, levels, lamps, messages and curves.

        The curves begin at `from_ns`.  Messages, and changes of drawings, are those since the last call.
        """
        bench = self._now.bench
        messages, self._messages = self._messages, []
        return {
            "now_ns": bench.now,
            "controllers": {name: self._values(controller) for name, controller in bench.controllers.items()},
            "drawings": self._pictures.changes(), "messages": messages, "curves": self._curves.window(from_ns, points),
            "interval_ns": self._curves.interval_ns,
        }  # fmt: skip

    def _values(self, controller: Controller) -> dict[str, Any]:
        lamps = (item for group in controller.product.front for item in group.items if isinstance(item, Lamp))
        tutor = self._tutors[controller.name]
        return {
            "powered": controller.powered,
            "used": used_axes(controller),
            "axes": {
                axis: {"position": found.position, "velocity": float(found.velocity), "moving": found.moving}
                for axis, found in controller.axes.items()
            },
            "pins": {pin: found.level for pin, found in controller.pins.items()},
            "lamps": [item.shows(_value(controller, item)) for item in lamps],
            "reason": next((str(reason) for reason in tutor.guide.reasons()), ""),
        }

    # Act

    def send(self, name: str, text: str) -> list[str]:
        """Send a line to a controller, to a board as a command; return explanations of the line."""
        session, controller = self._now, self._now.bench[name]
        tutor = self._tutors[name]
        if on_a_bus(controller):
            try:
                data = codec_of(controller.product).read(text)
            except PlacedError as error:
                return [str(error.message), *tutor.unreadable(error)]
            comments = tutor.sending(data)
            self._add(name, "host", f"{text}\n")
        else:
            ending = controller.product.endings[0]
            data = text.encode("latin-1", "replace") + ending if ending else CHARACTERS.read(text)
            comments = tutor.sending(data)
            session.do(name, "flow", Flow.DTR.value)
        session.say(name, data)
        return comments

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


def _value(controller: Controller, item: Item) -> int | None:
    value = controller.read(item.source)
    return None if value is None else int(value)


def _words(item: Lamp) -> str:
    return f"{item.name}.  {item.doc}".rstrip(". ") + "."
