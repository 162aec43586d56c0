"""The SmartMotor driver of synApps itself, in its own IOC, controls a virtual motor.

`AXISTWIN_SYNAPPS=DIR pytest tests/integrations/test_synapps.py`: DIR is the directory `iocs/smartMotorIOC` of
motorSmartMotor after it was built, with `bin` and `dbd`.  The IOC runs in its own process; ophyd and pyepics are its
clients.  The driver waits 0.25 s of real time for an answer, and takes a later one for the answer to its next request:
so these tests need a computer that is not overloaded.
"""

import os
import re
import subprocess
from contextlib import contextmanager
from pathlib import Path

import pytest

import axistwin

from ..test_tutorials import EXCHANGE, page
from .conftest import client, environment, free_port

SCENE = {"controller": [{"model": "smartmotor", "name": "slide", "axes": {"shaft": {"limits": [-500, 9000]}}}]}
ASYN = {
    "tcp": ("drvAsynIPPort", 'drvAsynIPPortConfigure("L0", "{}", 0, 0, 0)'),
    "pty": ("drvAsynSerialPort", 'drvAsynSerialPortConfigure("L0", "{}", 0, 0, 0)'),
}
"""Support of asyn for a port, and the lines of the start-up script."""
START = """dbLoadDatabase "{dbd}"
smartMotor_registerRecordDeviceDriver pdbbase
{port}
SmartMotorSetup(1, 20)
SmartMotorConfig(0, "L0")
dbLoadRecords "motor.db"
iocInit
"""
RECORD = """record(motor, "LAB:slide") {
  field(DTYP, "SmartMotor") field(OUT, "#C0 S0 @") field(MRES, "0.0005") field(EGU, "mm") field(PREC, "4")
  field(VELO, "4") field(VMAX, "10") field(ACCL, "0.1") field(JVEL, "0.02") field(JAR, "20") field(RDBD, "0.0005")
  field(DHLM, "6") field(DLLM, "-1")
}
"""


@pytest.fixture(scope="module")
def built():
    directory = os.environ.get("AXISTWIN_SYNAPPS")
    if not directory:
        pytest.skip("AXISTWIN_SYNAPPS does not name the directory of a built IOC of motorSmartMotor")
    programs = sorted(Path(directory).glob("bin/*/smartMotor"))
    assert programs, f"{directory}/bin/*/smartMotor does not exist: AXISTWIN_SYNAPPS names no built IOC"
    return programs[0], Path(directory) / "dbd" / "smartMotor.dbd"


@contextmanager
def running(program, script, port):
    """Run the IOC on this computer only, from the end of its start-up to the end of the block."""
    servers = {"EPICS_CAS_INTF_ADDR_LIST": "127.0.0.1", "EPICS_CAS_AUTO_BEACON_ADDR_LIST": "NO"}
    ioc = subprocess.Popen(
        [program, script.name],
        cwd=script.parent,
        env=environment(port) | servers,
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
    )
    shown = []
    try:
        while "All initialization complete" not in (line := ioc.stdout.readline()):
            shown.append(line)
            assert line, "".join(shown)
        yield
    finally:
        ioc.stdin.close()  # the shell of the IOC ends at the end of its input
        ioc.stdout.read()
        ioc.stdout.close()
        code = ioc.wait(20)
    assert code == 0, "".join(shown)


@pytest.fixture(scope="module", params=ASYN)
def lab(request, built, tmp_path_factory):
    program, dbd = built
    support, configured = ASYN[request.param]
    if support not in dbd.read_text():
        pytest.skip(f"this IOC was built without {support}.dbd")
    directory, port = tmp_path_factory.mktemp("synapps"), free_port()
    with axistwin.serve(SCENE, speed=5.0, scheme=request.param, record=directory / "slide.talk") as twin:
        url = twin.ports["slide"]
        script = directory / "st.cmd"
        address = url.address if request.param == "tcp" else url
        script.write_text(START.format(dbd=dbd, port=configured.format(address)))
        (directory / "motor.db").write_text(RECORD)
        with running(program, script, port):
            yield port, directory, lambda: twin.do(lambda: twin.bench["slide"].axes["shaft"].position)


SCAN = """
import json
from bluesky import RunEngine
from bluesky.plans import scan
from ophyd import EpicsMotor
motor = EpicsMotor("LAB:slide", name="slide", settle_time=0.1)  # see test_epics.py
motor.wait_for_connection(timeout=300)
engine, found = RunEngine(), []
engine.subscribe(lambda kind, document: found.append(document["data"]["slide"]) if kind == "event" else None)
engine(scan([], motor, 0, 4, 11))
print(json.dumps(found))
"""


def test_a_scan_of_11_points_has_exact_positions(lab):
    for library in ("bluesky", "ophyd", "epics"):
        pytest.importorskip(library, reason=f"{library} is not installed")
    port, _, position = lab
    assert [round(2000 * found) for found in client(port, SCAN)] == [800 * n for n in range(11)]
    assert position() == 8000


ENDINGS = """
import json, time
import epics
motor = epics.Motor("LAB:slide")
def until(name, wanted):
    while epics.caget(f"LAB:slide.{name}", use_monitor=False) != wanted:
        time.sleep(0.01)
def place():
    return [round(2000 * epics.caget(f"LAB:slide.{name}", use_monitor=False)) for name in ("RBV", "VAL")]
motor.move(0, wait=True, timeout=300)
found = {"moved": place()}
epics.caput("LAB:slide.JOGF", 1)
until("MOVN", 1)
epics.caput("LAB:slide.JOGF", 0)
until("DMOV", 1)
found["jogged"] = place()
motor.move(1, wait=True, timeout=300)
found["after the jog"] = place()
epics.caput("LAB:slide.VELO", 0.05, wait=True)
epics.caput("LAB:slide", 4)
until("MOVN", 1)
epics.caput("LAB:slide.STOP", 1)
until("DMOV", 1)
found["stopped"] = place()
epics.caput("LAB:slide.VELO", 4, wait=True)
motor.move(5, wait=True, timeout=300)
found["limit"] = epics.caget("LAB:slide.HLS", use_monitor=False)
motor.move(2, wait=True, timeout=300)
found["back"] = place()
print(json.dumps(found))
"""


def test_jogs_stops_and_a_limit_switch(lab):
    pytest.importorskip("epics", reason="pyepics is not installed")
    port, _, position = lab
    found = client(port, ENDINGS)
    (jogged, _), (stopped, target) = found.pop("jogged"), found.pop("stopped")
    assert jogged > 0 and 2000 <= stopped == target < 8000
    assert found == {"moved": [0, 0], "after the jog": [2000, 2000], "limit": 1, "back": [4000, 4000]}
    assert position() == 4000


REST = """
import time
import epics
for name, value in (("SET", 1), ("DVAL", 0), ("SET", 0), ("CNEN", 0), ("CNEN", 1), ("RLV", 1)):
    epics.caput(f"LAB:slide.{name}", value, wait=True, timeout=300)
epics.caput("LAB:slide.JOGR", 1)
while epics.caget("LAB:slide.MOVN", use_monitor=False) != 1:
    time.sleep(0.01)
epics.caput("LAB:slide.JOGR", 0)
while epics.caget("LAB:slide.DMOV", use_monitor=False) != 1:
    time.sleep(0.01)
print(epics.caget("LAB:slide.LVIO", use_monitor=False))
"""


def test_the_messages_are_those_of_the_tutorial(lab):
    pytest.importorskip("epics", reason="pyepics is not installed")
    port, directory, _ = lab
    assert client(port, REST) == 0

    def without_numbers(message):
        return re.sub(r"=-?\d+", "=…", message)

    sent = re.findall(r"^> (.*)$", (directory / "slide.talk").read_text(), re.MULTILINE)
    messages = {without_numbers(message) for text in sent for message in text.split(r"\n") if message}
    shown = {without_numbers(message) for message, _ in EXCHANGE.findall(page("epics"))}
    assert messages - {"Zr", "Zl"} == shown
