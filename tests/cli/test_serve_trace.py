"""`axistwin serve --trace`: the file is complete after SIGTERM."""

import signal

import pytest

from ..command import AT_ONCE, ended, serving
from ..links.serving import dial


@pytest.mark.parametrize(("number", "code"), [(signal.SIGTERM, 0), (signal.SIGINT, 130)])
def test_the_trace_of_a_session(tmp_path, number, code):
    with serving("if1", "--tcp", "127.0.0.1:0", *AT_ONCE, "--trace", "a.csv", cwd=tmp_path) as (program, [(_, url)]):
        with dial(url) as host:
            for message, end in ((b"(", b"U\r"), (b"U61\rX50@400$\rX$\rN\r", b"\r")):
                host.sendall(message)
                answer = b""
                while not answer.endswith(end):
                    answer += host.recv(100)
        assert ended(program, number)[0] == code
    rows = (tmp_path / "a.csv").read_text().splitlines()
    assert [row.rpartition(",")[2] for row in rows if ",if1.X.pulses," in row][:51] == [str(n) for n in range(51)]
    assert [file.name for file in tmp_path.iterdir()] == ["a.csv"]
