"""`axistwin serve --trace`: the file is whole when the server is asked to end."""

import signal
import socket
import subprocess
import sys

import pytest


@pytest.mark.parametrize(("ends", "code"), [(signal.SIGTERM, 0), (signal.SIGINT, 130)])
def test_the_trace_of_a_session(tmp_path, ends, code):
    program = "from axistwin.cli.main import main; main()"
    options = ("--tcp", "127.0.0.1:0", "--speed", "max", "--line", "instant", "--trace", "a.csv")
    server = subprocess.Popen(
        [sys.executable, "-c", program, "serve", "if1", *options], stdout=subprocess.PIPE, text=True, cwd=tmp_path
    )
    assert server.stdout is not None
    try:
        port = int(server.stdout.readline().rsplit(":", 1)[1])
        with socket.create_connection(("127.0.0.1", port), timeout=20) as host:
            for message, end in ((b"(", b"U\r"), (b"U61\rX50@400$\rX$\rN\r", b"\r")):
                host.sendall(message)
                answer = b""
                while not answer.endswith(end):
                    answer += host.recv(100)
    finally:
        server.send_signal(ends)
        assert server.wait(20) == code
        server.stdout.close()
    rows = (tmp_path / "a.csv").read_text().splitlines()
    assert [row.rpartition(",")[2] for row in rows if ",if1.X.pulses," in row][:51] == [str(n) for n in range(51)]
    assert [file.name for file in tmp_path.iterdir()] == ["a.csv"]
