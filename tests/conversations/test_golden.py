"""Golden conversations: `tests/conversations/*.talk`.  Each names its model, or a scene, in its first comments.

With `--record-conversations`, differences are written into the files instead, for a review with git.
"""

from dataclasses import replace
from pathlib import Path

import pytest

from axistwin import Bench
from axistwin.bench import CHARACTERS, Expect, Hear
from axistwin.bench.programs.running import options
from axistwin.bench.talk.conversation import Conversation, load, write
from axistwin.bench.talk.player import Difference, play
from axistwin.cli.common.target import bench_for

FILES = sorted((Path(__file__).parent).glob("*.talk"))
MOST_CORRECTIONS = 1000


def bench_of(conversation: Conversation, state: Path) -> Bench:
    model = conversation.headers["model"]
    if model.endswith(".toml"):
        return bench_for(str(Path(__file__).parent / model))
    return bench_for(model, options(conversation), state)


def corrected(conversation: Conversation, difference: Difference) -> Conversation:
    place = next(n for n, act in enumerate(conversation.acts) if act.line == difference.line)
    act = conversation.acts[place]
    got = CHARACTERS.read(difference.got) if not isinstance(act, Expect) else b""
    message = (got.splitlines(keepends=True) or [b""])[0]
    if isinstance(act, Expect):
        acts = [replace(act, value=difference.got)]
    elif isinstance(act, Hear) and act.data:
        acts = [replace(act, data=message)] if message else []
    else:  # data were received that the conversation does not contain
        acts = [Hear(message), act] if isinstance(act, Hear) else [act, Hear(message)]
    changed = (*conversation.acts[:place], *acts, *conversation.acts[place + 1 :])
    return Conversation(tuple(replace(a, line=n) for n, a in enumerate(changed, start=1)), conversation.file)


@pytest.mark.parametrize("file", FILES, ids=lambda file: file.stem)
def test_conversation(file: Path, tmp_path: Path, request: pytest.FixtureRequest):
    conversation = load(file)
    difference = play(conversation, bench_of(conversation, tmp_path))
    if request.config.getoption("--record-conversations"):
        for attempt in range(MOST_CORRECTIONS):
            if difference is None:
                break
            conversation = corrected(conversation, difference)
            difference = play(conversation, bench_of(conversation, tmp_path / str(attempt)))
        file.write_text(write(conversation.acts))
    assert difference is None, str(difference)


def test_there_are_conversations():
    assert FILES
