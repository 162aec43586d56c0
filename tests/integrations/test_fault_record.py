"""What the record FAULT says leads out: each text is obeyed by writes to records and work at the machine alone."""

import re
from typing import NamedTuple

import pytest

from axistwin.bench import action
from axistwin.drivers import DriverError

from .test_motor_record import run


class Scene(NamedTuple):
    """Actions at the machine that stop an axis, and a piece of the text in FAULT."""

    model: str
    axis: str
    says: str
    actions: tuple[str, ...]
    by_hand: str = ""
    """An action at the machine, which the text asks for."""
    target: float = 100.0
    options: dict[str, object] = {}  # noqa: RUF012  # never changed


SET_POSITION = (("SET", 1), ("VAL", 7), ("SET", 0))
WRITTEN = {
    "clear_faults": (("CLEAR", 1),), "move away": (("VAL", 0),), "set_position": SET_POSITION,
    "set the position": SET_POSITION, "home the axis": (("HOMR", 1),),
}  # fmt: skip
"""The writes to records that do what a remedy says (`docs/ioc.md`)."""
WRITES = re.compile("|".join(WRITTEN))
SWITCHES = {"limits": [-1000, 600]}
SCENES = (
    Scene("if1", "X", "limit: call clear_faults and move away", (), target=900.0),
    Scene("if1", "X", "emergency stop: release the button", ("estop low",), "estop release"),
    Scene("if1", "X", "drive fault: check the drive", ("fault drive_fault X",), "mend all"),
    Scene("smartmotor", "shaft", "positive limit: call clear_faults", (), target=900.0),
    Scene("smartmotor", "shaft", "negative limit: call clear_faults", (), target=-1900.0),
    Scene("smartmotor", "shaft", "position error: remove the load that blocks the shaft", ("shaft.jam on",),
          "shaft.jam off", target=5000.0, options={"motor": "frame23"}),
    Scene("1811", "motor", "call reset, or switch its power off and on", ("write 0 FF", "write 1 10"), "power",
          options={"limits": [-99_000, 99_000]}),
    Scene("if1", "X", "home the axis, or set the position", ("power off", "power on")),
    Scene("1811", "motor", "home the axis, or set the position", ("power off", "power on")),
    Scene("1811", "motor", "home the axis", ("power off", "power on"), options={"home": [-600, -500]}),
    Scene("smartmotor", "shaft", "home the axis, or set the position", ("power off", "power on")),
)  # fmt: skip


async def told(record, words):
    while words not in record.values["FAULT"]:
        record.axis.station.wake()
        await record.axis.station.polled()


@pytest.mark.parametrize("scene", [
    pytest.param(scene, id=f"{scene.model} {scene.says.partition(':')[0]}",
        marks=[pytest.mark.slow] * (scene.model == "if1"))
    for scene in SCENES
])  # fmt: skip
def test_what_the_record_says_leads_out(scene):
    async def session(lab):
        record, machine = lab.records[scene.axis], lab.bench[scene.model]
        core = lab.machine.stations[0].driver.core
        for field, value in (("HLM", 9000), ("LLM", -9000)):
            await record.put(field, value)
        patience, core.timeout = core.timeout, 0.3
        for act in scene.actions:
            action(machine, *act.split(" ", 1))()
        with pytest.raises(DriverError):
            await record.put("VAL", scene.target)
        core.timeout = patience
        await told(record, scene.says)
        if scene.by_hand == "power":
            machine.power_cycle()
            await told(record, "set the position")
        elif scene.by_hand:
            action(machine, *scene.by_hand.split(" ", 1))()
        ways = record.values["FAULT"].split(", or ")
        for instruction in WRITES.findall(ways[0] if "home" in scene.options else ways[-1]):
            for field, value in WRITTEN[instruction]:
                await record.put(field, value)
        await record.put("VAL", 50)
        assert (record.values["RBV"], record.values["SEVR"], record.values["FAULT"]) == (50, 0, "")

    options = {"self_test_s": 0.1} if scene.model == "if1" else {}
    run(session, model=scene.model, **options, **{scene.axis: SWITCHES | scene.options})
