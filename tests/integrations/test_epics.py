"""The IOC and EPICS clients of other projects."""

import importlib.util

import pytest

from .conftest import SLOW_COMPUTER, client, free_port, running


def installed(library):
    return importlib.util.find_spec(library) is not None


def needs(*libraries):
    for library in libraries:
        pytest.importorskip(library, reason=f"{library} is not installed")


@pytest.fixture(scope="module")
def ioc(scene_file):
    needs("caproto")
    port = free_port()
    words = ["--prefix", "LAB:", "--port", str(port), "--speed", "20", "--rate", "20", "--registers", "motor.a"]
    with running("ioc", str(scene_file), *words, *SLOW_COMPUTER, *(["--pva"] if installed("p4p") else [])) as made:
        assert made["address"] == f"127.0.0.1:{port}"
        assert {"LAB:if1:X", "LAB:if1:input1", "LAB:board:motor", "LAB:motor:shaft", "LAB:motor:a"} < {*made["records"]}
        yield port


BLUESKY = """
import asyncio, json
from bluesky import RunEngine
from bluesky.plans import scan
engine, found = RunEngine(), {}
for name, prefix, unit in (("x", "LAB:if1:X", 1), ("m", "LAB:board:motor", 1), ("s", "LAB:motor:shaft", 1000)):
    motor = make(engine, prefix, name)
    token = engine.subscribe(
        lambda kind, document: found.setdefault(name, []).append(document["data"][name]) if kind == "event" else None
    )
    engine(scan([], motor, 0, 5 * unit, 11))
    engine.unsubscribe(token)
print(json.dumps(found))
"""
OPHYD = """
from ophyd import EpicsMotor
def make(engine, prefix, name):
    # Without settle_time, ophyd may forget a move that begins as the last one ends (bluesky/ophyd#783).
    for remaining in (2, 1, 0):
        motor = EpicsMotor(prefix, name=name, settle_time=0.1)
        try:
            motor.wait_for_connection(timeout=12)
        except TimeoutError:  # on a very slow computer, ophyd may miss the first value of a connected channel
            if not remaining:
                raise
        else:
            return motor
"""
OPHYD_ASYNC = """
from ophyd_async.epics.motor import Motor
def make(engine, prefix, name):
    motor = Motor(f"SCHEME://{prefix}", name=name)
    async def connect(): await motor.connect(timeout=300)
    asyncio.run_coroutine_threadsafe(connect(), engine.loop).result(300)
    return motor
"""


@pytest.mark.slow
@pytest.mark.parametrize(("make", "libraries"), [
    (OPHYD, ["ophyd", "epics"]), (OPHYD_ASYNC.replace("SCHEME", "ca"), ["ophyd_async", "aioca"]),
    (OPHYD_ASYNC.replace("SCHEME", "pva"), ["ophyd_async", "p4p"])
], ids=["ophyd", "ophyd-async by Channel Access", "ophyd-async by PV Access"])  # fmt: skip
def test_a_scan_of_11_points_has_exact_positions(ioc, make, libraries):
    needs("bluesky", *libraries)
    found = client(ioc, f"import asyncio{make}{BLUESKY}")
    assert found["x"] == found["m"] == [0.5 * n for n in range(11)] and found["s"] == [500 * n for n in range(11)]


PYEPICS = """
import json, time
import epics
motor = epics.Motor("LAB:if1:Y")
motor.move(250, wait=True, timeout=300)
found = {"moved": motor.get_position(readback=True), "unit": motor.units, "done": motor.done_moving}
motor.move(300, relative=True, wait=True, timeout=300)
found["relative"] = motor.get_position(readback=True)
rights = epics.PV("LAB:if1:Y.UEIP", connection_timeout=300)
found["rights"] = [rights.wait_for_connection(300), rights.read_access, rights.write_access]
epics.PV("LAB:if1:Y.JOGF").put(1)
while epics.caget("LAB:if1:Y.MOVN", use_monitor=False) != 1:
    time.sleep(0.01)
motor.stop()
while epics.caget("LAB:if1:Y.DMOV", use_monitor=False) != 1:
    time.sleep(0.01)
found["stopped"] = motor.get_position() == motor.get_position(readback=True) > 550
found["limits"] = [motor.put("HLM", 600, wait=True), motor.put("LLM", -600, wait=True)]
found["within"] = [motor.within_limits(600), motor.within_limits(601)]
print(json.dumps(found))
"""


@pytest.mark.slow
def test_pyepics_moves_jogs_and_stops(ioc):
    needs("epics")
    found = client(ioc, PYEPICS)
    assert found == {
        "moved": 250, "unit": "counts", "done": 1, "relative": 550, "limits": [1, 1], "within": [True, False],
        "rights": [True, True, False], "stopped": True,
    }  # fmt: skip


CAPROTO = """
import json
from caproto.sync.client import read, write
def get(name, **words): return read(name, timeout=300, **words).data.tolist()[0]
def refused(name, value):
    try:
        write(name, value, notify=True, timeout=300)
    except Exception as error:
        return str(error)
write("LAB:board:motor.VELO", 20.0, notify=True)
write("LAB:board:motor.VAL", 2.0, notify=True, timeout=300)
found = {"position": get("LAB:board:motor.RBV"), "refused": [refused("LAB:board:motor.VELO", 1e9)]}
write("LAB:board:motor.DHLM", 3.0, notify=True)
found["refused"].append(refused("LAB:board:motor.VAL", 3.5))
found["violation"] = get("LAB:board:motor.LVIO")
limits = read("LAB:board:motor.VAL", data_type="control", timeout=300).metadata
found["control"] = [limits.lower_ctrl_limit, limits.upper_ctrl_limit, limits.units.decode(), limits.precision]
write("LAB:motor:a", 42, notify=True)
write("LAB:motor:A", "No", notify=True)
found["register"], found["pin"] = get("LAB:motor:a"), get("LAB:motor:A", data_type="native")
found["fault"] = bytes(read("LAB:motor:shaft:FAULT").data).decode()
print(json.dumps(found))
"""


@pytest.mark.slow
def test_caproto_reads_and_writes_fields_pins_and_registers(ioc):
    found = client(ioc, CAPROTO)
    too_fast, too_far = found.pop("refused")
    assert "VELO=1e+09 is out of range: expected a value above 0 and at most 546.133" in too_fast
    assert "position 3.5 is outside the limits: expected -2.14748e+06 to 3" in too_far
    assert found == {
        "position": 2.0, "violation": 1, "control": [-2147483.647, 3, "mm", 3], "register": 42, "pin": 0, "fault": "",
    }  # fmt: skip


P4P = """
import json
from p4p.client.thread import Context
found = {}
with Context("pva") as context:
    context.put("LAB:motor:shaft", 1234, timeout=300)
    rbv = context.get("LAB:motor:shaft.RBV")
    found["moved"] = [rbv, context.get("LAB:motor:shaft.DMOV"), rbv.severity]
    found["menu"] = str(context.get("LAB:motor:shaft.SPMG"))
    for name, value in (("LAB:motor:shaft.RBV", 1), ("LAB:motor:shaft.VELO", -1)):
        try:
            context.put(name, value, timeout=300)
        except Exception as error:
            found[name] = str(error)
    context.put("LAB:motor:B", 1, timeout=300)
    found["pin"] = int(context.get("LAB:motor:B"))
print(json.dumps(found))
"""


@pytest.mark.slow
def test_p4p_moves_by_pv_access(ioc):
    needs("p4p")
    found = client(ioc, P4P)
    assert found["moved"] == [1234, 1, 0] and found["menu"] == "Go" and found["pin"] == 1
    assert found["LAB:motor:shaft.RBV"] == "this field can only be read"
    assert found["LAB:motor:shaft.VELO"].startswith("VELO=-1 is out of range: expected a value above 0")


CLIENT = """
import json, subprocess, sys, time
from caproto.sync.client import read, write
X = "LAB:if1:X"
def get(field): return read(f"{X}.{field}", timeout=300).data.tolist()[0]
def put(field, value): write(f"{X}.{field}", value, notify=True, timeout=300)
def until(condition):
    end = time.monotonic() + 300
    while not condition():
        if time.monotonic() > end: raise TimeoutError(str(get("RBV")))
        time.sleep(0.02)
"""
STOP = f"""{CLIENT}
until(lambda: get("MOVN") and get("RBV") > 0.2)
put("STOP", 1)
"""
OUTCOMES = f"""{CLIENT}
found = {{}}
put("HLM", 100)  # beyond the switch at 30
for case, target, speed in (("arrives", 5, 2.5), ("switch", 50, 2.5), ("stopped", 25, 0.02)):
    for field, value in (("VELO", 2.5), ("VAL", 0), ("VELO", speed)): put(field, value)
    other = subprocess.Popen([sys.executable, "-W", "ignore", "-c", {STOP!r}]) if case == "stopped" else None
    try:
        found[case] = move(target) or "success"
    except Exception as error:
        found[case] = "error"
    assert other is None or other.wait(300) == 0
    until(lambda: get("DMOV"))
    position, (low, high) = get("RBV"), {{"arrives": (5, 5), "switch": (30, 35), "stopped": (0.2, 24)}}[case]
    assert low <= position <= high, (case, position)
    assert get("MISS") == (case != "arrives")
put("HLM", 30)
print(json.dumps(found))
"""
"""A move that arrives, one into a switch, and one that another program stops; `move` is the client library's."""
MOVE = {
    "pyepics": """
import epics
motor = epics.Motor("LAB:if1:X")
def move(target):
    code = motor.move(target, wait=True, timeout=300)
    assert epics.caget("LAB:if1:X.MISS", use_monitor=False) == (target != 5)
    return {0: "success"}.get(code, code)
""",
    "ophyd": OPHYD
    + """
motor = make(None, "LAB:if1:X", "x")
def move(target):
    until(lambda: not motor.moving and abs(motor.position) < 0.001)  # it has heard of the end of the last move
    motor.set(target, timeout=300).wait(300)
""",
    "ophyd-async by Channel Access": OPHYD_ASYNC.replace("SCHEME", "ca")
    + """
from aioca import caget
async def miss(): return await caget("LAB:if1:X.MISS")
""",
    "ophyd-async by PV Access": OPHYD_ASYNC.replace("SCHEME", "pva")
    + """
async def miss(): return 0
""",
    "caproto": """
from caproto.sync.client import write
def move(target): write("LAB:if1:X", target, notify=True, timeout=300)
""",
    "aioca": """
import asyncio
from aioca import caput
def move(target): asyncio.run(caput("LAB:if1:X", target, wait=True, timeout=300))
""",
    "p4p": """
from p4p.client.thread import Context
context = Context("pva")
def move(target): context.put("LAB:if1:X", target, wait=True, timeout=300)
""",
}
ASYNC_MOVE = """
import asyncio, threading
from types import SimpleNamespace
loop = asyncio.new_event_loop()
threading.Thread(target=loop.run_forever, daemon=True).start()
motor = make(SimpleNamespace(loop=loop), "LAB:if1:X", "x")
async def set(target):
    await motor.set(target, timeout=300)
    assert await miss() == (target != 5)
def move(target): asyncio.run_coroutine_threadsafe(set(target), loop).result(300)
"""
NEEDS = {
    "pyepics": ["epics"], "ophyd": ["ophyd", "epics"], "caproto": [], "p4p": ["p4p"], "aioca": ["aioca"],
    "ophyd-async by Channel Access": ["ophyd_async", "aioca"], "ophyd-async by PV Access": ["ophyd_async", "p4p"],
}  # fmt: skip
SEEN = {
    "pyepics": ({"success"}, {"success", -3}, {"success"}),  # -3 if the monitor of HLS comes before the answer
    "ophyd": ({"success"}, {"error"}, {"error"}),
    "caproto": ({"success"}, {"error"}, {"error"}),
    "aioca": ({"success"}, {"error"}, {"error"}),
    "p4p": ({"success"}, {"error"}, {"error"}),
    "ophyd-async by Channel Access": ({"success"}, {"success"}, {"success"}),
    "ophyd-async by PV Access": ({"success"}, {"error"}, {"error"}),
}
"""What a client library makes of the answers, as in the table of `docs/ioc.md`."""


@pytest.mark.slow
@pytest.mark.parametrize("library", SEEN)
def test_each_client_library_and_the_outcome_of_a_move(ioc, library):
    needs(*NEEDS[library])
    more = ASYNC_MOVE if library.startswith("ophyd-async") else ""
    found = client(ioc, f"import asyncio{MOVE[library]}{more}{OUTCOMES}")
    for (case, outcome), seen in zip(found.items(), SEEN[library], strict=True):
        assert outcome in seen, case


def test_a_port_needs_a_model_that_answers(tmp_path, capsys):
    needs("caproto")
    from axistwin.cli.program import main

    for words, message in (
        (["COM3"], "the model of the controller at the port is missing: add --model"),
        (["tcp://127.0.0.1:1", "--model", "if1"], "if1: cannot open tcp://127.0.0.1:1"),
        (["COM3", "--model", "if3"], "no model 'if3'"),
        (["COM3", "--model", "if1", "--units", "W=1 per mm"], "no axis 'W': expected one of X, Y, Z"),
        (["COM3", "--model", "if1", "--registers", "a"], "an IF1 has no registers"),
        (
            ["COM3", "--model", "if1", "--option", "echoes=1"],
            "unknown option 'echoes' for the model if1: expected one of timeout, echo, speed_range",
        ),
        (["COM3", "--model", "if1", "--speed", "2"], "--speed cannot be used with a PORT"),
        (["lab.toml", "--model", "if1"], "--model and --baud cannot be used with a scene file"),
    ):
        with pytest.raises(SystemExit) as ended:
            main(["ioc", *words, "--prefix", "LAB:"])
        assert ended.value.code == 2 and message in capsys.readouterr().err


def test_a_scene_without_axes_for_others_is_told(tmp_path, capsys):
    needs("caproto")
    from axistwin.cli.program import main

    scene = tmp_path / "scene.toml"
    scene.write_text('[[controller]]\nmodel = "if1"\nhost = "a.if1"\n')
    (tmp_path / "a.if1").write_text("X100$\n")
    with pytest.raises(SystemExit) as ended:
        main(["ioc", str(scene), "--prefix", "LAB:"])
    assert ended.value.code == 2 and "every controller of" in capsys.readouterr().err
