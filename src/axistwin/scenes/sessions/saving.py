"""Save a session as a scene: actions of users become a script, actions of hosts become conversations.

All acts of one nanosecond are written to one file, to keep their order.  Acts of users on one controller are written to
the script, all other acts to the conversation of an endpoint that a host has used.  No script is added to a scene with
conversations of an earlier session, because the script could act before these conversations at the same virtual time.
"""

import re
from collections.abc import Iterable, Iterator
from itertools import groupby

from axistwin.bench import Bench, endpoints
from axistwin.bench.action_runner import LOAD
from axistwin.bench.actions import BUS_ACTS, LINE_ACTS
from axistwin.bench.acts import Act, Comment, Do, Say, Wait
from axistwin.bench.codec import CHARACTERS, Codec
from axistwin.bench.faults.kinds import KINDS
from axistwin.bench.talk.conversation import write
from axistwin.core.units import to_seconds
from axistwin.scenes.copying import Copy, Files, entry
from axistwin.scenes.hosting import OUTSIDE, rank_of
from axistwin.scenes.scene import Scene
from axistwin.scenes.sessions.journal import Journal, Moment

SCENE = "scene.toml"
_HEADER = re.compile(r"^; host: (.+)$", re.MULTILINE)


def files(
    scene: Scene | None, served: bool, bench: Bench, journal: Journal, programs: dict[str, str], end_ns: int
) -> dict[str, str]:
    """Return a saved session's scene, programs and conversations.  Raises UsageError for an impossible action."""
    found = Files()
    if scene is not None:
        # Keep the file names of the scene's programs, because actions contain these names, e.g. `load a.if1`.
        found.texts.update(scene.programs)
    renamed = {name: found.add(name, text) for name, text in programs.items()}
    headers = (header[1] for text in found.texts.values() if (header := _HEADER.search(text)))
    highest_rank = max(map(rank_of, headers), default=0)
    has_recording = highest_rank > 0
    copy, conversations = Copy(bench, found), _Conversations(bench, highest_rank + 1)
    for time_ns, together in groupby(journal, lambda moment: moment.time_ns):
        moments = [_renamed(moment, renamed) for moment in together]
        if not has_recording and all(map(_is_script, moments)):
            for moment in moments:
                acts = [f"{act.target} {act.value}" for act in moment.acts if isinstance(act, Do)]
                copy.script.append(entry(to_seconds(moment.time_ns), moment.acts[0].controller, acts))
        else:
            conversations.add(time_ns, moments)
    for name, text in conversations.texts():
        host = name if name in bench.controllers or name in bench.lines else name.rpartition(".")[0]
        copy.add_host(host, f"{name}.talk", text)
    note = f"What was done in a session: axistwin run {SCENE} --for {to_seconds(end_ns):.9g}"
    text = copy.of_bench(note) if scene is None else scene.copied(copy, served, note)
    return {SCENE: text, **found.texts}


def _renamed(moment: Moment, names: dict[str, str]) -> Moment:
    acts = (
        Do(LOAD, names[act.value], controller=act.controller) if isinstance(act, Do) and act.target == LOAD else act
        for act in moment.acts
    )
    return Moment(moment.time_ns, tuple(acts))


def _is_script(moment: Moment) -> bool:
    return len({act.controller for act in moment.acts}) == 1 and all(
        isinstance(act, Do) and act.target not in (*LINE_ACTS, *BUS_ACTS) and not _names_a_fault(act)
        for act in moment.acts
    )


def _names_a_fault(act: Do) -> bool:
    """True if the action refers to a fault by its name.  A script would have to define that fault first."""
    if act.target == "mend":
        return act.value.strip("\"'") not in (*KINDS, "all")
    return act.target == "fault" and (" begins" in act.value or " ends" in act.value)


class _Conversations:
    def __init__(self, bench: Bench, rank: int) -> None:
        self.bench = bench
        self._host = OUTSIDE if rank == 1 else f"{OUTSIDE} {rank}"
        self._acts: dict[str, list[Act]] = {}
        self._end_ns: dict[str, int] = {}

    def add(self, time_ns: int, moments: Iterable[Moment]) -> None:
        """Append actions of one time, which a replay performs after all other events of this time."""
        moments = list(moments)
        name = self._endpoint_of(act for moment in moments for act in moment.acts)
        acts = self._acts.setdefault(name, [])
        for moment in moments:
            acts.append(Wait(time_ns - self._end_ns.get(name, 0)))
            acts += [self._addressed(name, act) for act in moment.acts]
            self._end_ns[name] = time_ns

    def texts(self) -> Iterator[tuple[str, str]]:
        for name, acts in self._acts.items():
            yield name, write((Comment(f"host: {self._host}"), *acts), self._codec(name))

    def _endpoint_of(self, acts: Iterable[Say | Do]) -> str:
        named = [act.controller for act in acts if act.controller]
        serial = (name for name in named if not endpoints.at_a_bus(self.bench, name))
        return next(serial, named[0] if named else next(iter(self.bench.controllers)))

    def _addressed(self, name: str, act: Say | Do) -> Act:
        who = "" if act.controller == name and name in (*self.bench.controllers, *self.bench.lines) else act.controller
        return Say(act.data, controller=who) if isinstance(act, Say) else Do(act.target, act.value, controller=who)

    def _codec(self, name: str) -> Codec:
        return endpoints.codec_at(self.bench, name) if endpoints.at_a_bus(self.bench, name) else CHARACTERS
