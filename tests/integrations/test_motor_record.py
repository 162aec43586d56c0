"""Effects of writes and polls on a motor record, without a server; the controllers are virtual."""

import asyncio
from contextlib import asynccontextmanager

import pytest

from axistwin import Bench
from axistwin.drivers import DriverError, RefusedError
from axistwin.real.integrations import of_scene
from axistwin.real.integrations.epics.motor_record import MotorRecord

from .conftest import PATIENCE

HOME_SWITCH, DONE, MOVING, SILENT = 8, 2, 1 << 10, 1 << 12


class Lab:
    """Motor records of a bench, by axis; `seen` holds all published values in their order."""

    def __init__(self, bench, machine):
        self.bench, self.machine = bench, machine
        self.seen = []
        self.records = {}
        for station in machine.stations:
            for name, axis in station.axes.items():
                record = self.records[name] = MotorRecord(axis, name, name)
                record.observers.append(self.note(name))

    def note(self, axis):
        async def post(field, value):
            self.seen.append((axis, field, value))

        return post

    def values(self, field):
        return [value for _, name, value in self.seen if name == field]

    async def until(self, axis, **wanted):
        record = self.records[axis]
        while any(record.values[field] != value for field, value in wanted.items()):
            record.axis.station.wake()
            await record.axis.station.polled()


@asynccontextmanager
async def lab(model, speed=50.0, period_s=0.01, **options):
    bench = Bench()
    bench.add(model, **options)
    async with await of_scene(bench, {model: PATIENCE}, speed=speed, period_s=period_s) as machine:
        made = Lab(bench, machine)
        polling = asyncio.create_task(machine.run())
        try:
            yield made
        finally:
            polling.cancel()
            await asyncio.wait([polling])


def run(session, model="1811", **options):
    async def whole():
        async with lab(model, **options) as made:
            await session(made)

    asyncio.run(whole())


MM = {"motor": {"units": {"per": 1000, "of": "mm"}}}


def test_a_move_ends_with_the_exact_readback_before_dmov():
    async def session(lab):
        motor = lab.records["motor"]
        await motor.put("VAL", 12.3)
        assert lab.bench["1811"].axes["motor"].position == 12300
        assert (motor.values["RBV"], motor.values["RRBV"], motor.values["DMOV"]) == (12.3, 12300, 1)
        fields = [field for _, field, _ in lab.seen]
        assert lab.values("DMOV") == [0, 1] and fields.index("DMOV") > fields.index("VAL")
        last_readback = len(fields) - 1 - fields[::-1].index("RBV")
        assert last_readback < len(fields) - 1 - fields[::-1].index("DMOV")
        lab.seen.clear()
        await motor.put("VAL", "12.3")  # the distance is 0
        assert lab.values("DMOV") == [0, 1]
        await motor.put("RLV", -2.3)
        await motor.put("TWV", 0.25)
        await motor.put("TWR", 1)
        await motor.put("TWF", 0)
        assert motor.values["RBV"] == 9.75
        await motor.put("RVAL", 500)
        await motor.put("TWF", 1)
        assert motor.values["VAL"] == motor.values["RBV"] == 0.75 and motor.values["MSTA"] & (DONE | MOVING) == DONE

    run(session, **MM)


def test_limits_of_the_record_refuse_targets_and_end_jogs():
    async def session(lab):
        motor = lab.records["motor"]
        await motor.put("HLM", 2.0)
        await motor.put("LLM", -1.0)
        assert (motor.values["DHLM"], motor.values["DLLM"]) == (2.0, -1.0)
        with pytest.raises(RefusedError, match="outside the limits: expected -1 to 2"):
            await motor.put("VAL", 2.001)
        assert motor.values["LVIO"] == 1 and motor.values["VAL"] == 0
        await motor.put("DVAL", 1.5)
        assert motor.values["LVIO"] == 0 and motor.values["RBV"] == 1.5
        await motor.put("JVEL", 5.0)
        await motor.put("JOGR", 1)
        assert motor.values["LVIO"] == 1 and motor.values["JOGR"] == 0
        assert motor.values["VAL"] == motor.values["RBV"] == -1.0
        with pytest.raises(RefusedError, match="jog in the other direction"):
            await motor.put("JOGR", 1)
        await motor.put("DIR", "Neg")
        assert (motor.values["LLM"], motor.values["HLM"]) == (-2.0, 1.0)
        await motor.put("HLM", 0.5)
        assert motor.values["DLLM"] == -0.5
        await motor.put("DHLM", -0.7)
        assert [motor.values[name] for name in ("DLLM", "DHLM", "LLM", "HLM")] == [-0.5, -0.7, 0.7, 0.5]
        await motor.put("DIR", "Pos")
        assert (motor.values["LLM"], motor.values["HLM"]) == (-0.5, -0.7)
        for field in ("JOGF", "JOGR"):
            with pytest.raises(RefusedError, match="jog in the other direction"):
                await motor.put(field, 1)

    run(session, **MM)


@pytest.mark.slow
@pytest.mark.parametrize(("model", "options"), [
    ("1811", MM), ("if1", {"self_test_s": 0.1, "X": MM["motor"]}), ("smartmotor", {"shaft": MM["motor"]})])  # fmt: skip
def test_a_jog_comes_to_rest_at_the_limit_however_seldom_the_axis_is_read(model, options):
    async def session(lab):
        record = next(iter(lab.records.values()))
        for field, value in (("HLM", 0.3), ("LLM", -0.4), ("JVEL", 2.0), ("ACCL", 2.0)):
            await record.put(field, value)
        await record.put("JOGF", 1)
        assert (record.values["RBV"], record.values["LVIO"], record.values["SEVR"]) == (0.3, 1, 0)
        await record.put("JOGR", 1)
        assert (record.values["RBV"], record.values["LVIO"], record.values["MISS"]) == (-0.4, 1, 0)

    run(session, model=model, period_s=0.4, **options)


@pytest.mark.slow
@pytest.mark.parametrize("model", ["1811", "if1", "smartmotor"])
def test_the_first_limits_are_the_switches_of_the_scene(model):
    async def session(lab):
        record = next(iter(lab.records.values()))
        assert (record.values["LLM"], record.values["HLM"], record.values["DHLM"]) == (-10.0, 6.0, 6.0)
        await record.put("VAL", 6.0)  # the switch opens beyond this position
        with pytest.raises(RefusedError, match="outside the limits: expected -10 to 6"):
            await record.put("VAL", 6.01)
        assert (record.values["RBV"], record.values["HLS"], record.values["SEVR"]) == (6.0, 0, 0)
        await record.put("HLM", 50.0)
        with pytest.raises(RefusedError, match="limit"):
            await record.put("VAL", 50.0)
        assert record.values["RBV"] > 6.0 and record.values["HLS"] == 1
        await record.put("VAL", 5.0)  # away from the switch: without CLEAR
        assert (record.values["RBV"], record.values["HLS"], record.values["MISS"]) == (5.0, 0, 0)

    axis = {"1811": "motor", "if1": "X", "smartmotor": "shaft"}[model]
    options = {"self_test_s": 0.1} if model == "if1" else {}
    run(session, model=model, **{axis: {"limits": [-1000, 600], "units": {"per": 100, "of": "mm"}}}, **options)


def test_direction_offset_resolution_and_the_set_mode_define_positions():
    async def session(lab):
        motor = lab.records["motor"]
        await motor.put("VAL", 3)
        await motor.put("DIR", 1)
        assert (motor.values["RBV"], motor.values["DRBV"]) == (-3.0, 3.0)
        await motor.put("SET", 1)
        await motor.put("VAL", 10.0)
        assert (motor.values["OFF"], motor.values["RBV"], motor.values["VAL"], motor.values["DRBV"]) == (13, 10, 10, 3)
        await motor.put("FOFF", "Frozen")
        await motor.put("VAL", 11.0)
        assert [motor.values[name] for name in ("OFF", "RBV", "DRBV", "RRBV")] == [13, 11, 2, 2000]
        await motor.put("SET", "Use")
        await motor.put("VAL", 12.0)
        assert motor.values["DRBV"] == 1.0 and lab.bench["1811"].axes["motor"].position == 2000  # 3000 was cut to 2000
        await motor.put("DIR", "Pos")
        await motor.put("OFF", 0.0)
        before = motor.values["VELO"]
        await motor.put("MRES", 0.01)
        assert (motor.values["RBV"], motor.values["VELO"], motor.values["ERES"]) == (10.0, 10 * before, 0.01)
        with pytest.raises(RefusedError, match="MRES cannot be 0"):
            await motor.put("MRES", 0)

    run(session, **MM)


@pytest.mark.parametrize("ends", ["STOP", "SPMG", "JOGF"])
def test_a_jog_ends_at_rest_by_a_write(ends):
    async def session(lab):
        motor = lab.records["motor"]
        jog = asyncio.create_task(motor.put("JOGF", 1))
        await lab.until("motor", MOVN=1, DMOV=0, JOGF=1, TDIR=1)
        with pytest.raises(RefusedError, match="during a motion"):
            await motor.put("MRES", 2)
        await motor.put("JOGR", 0)  # this is the other direction, so it has no effect
        await motor.put(ends, 0 if ends != "STOP" else 1)
        await jog
        assert motor.values["JOGF"] == 0 and motor.values["VAL"] == motor.values["RBV"] > 0
        assert motor.values["RRBV"] == lab.bench["1811"].axes["motor"].position
        if ends == "SPMG":
            for field in ("VAL", "JOGF", "HOMF"):
                with pytest.raises(RefusedError, match="set SPMG to Go"):
                    await motor.put(field, 1)

    run(session)


@pytest.mark.slow
def test_a_paused_move_continues_and_move_pauses_after_it():
    async def session(lab):
        motor = lab.records["motor"]
        await motor.put("VELO", 1)  # the move takes minutes on a fast computer and on a slow one
        move = asyncio.create_task(motor.put("VAL", 20_000))
        await lab.until("motor", MOVN=1)
        await motor.put("SPMG", "Pause")
        await lab.until("motor", MOVN=0)
        assert motor.values["DMOV"] == 0 and not move.done()
        motor.axis.core.velocity = 100_000
        await motor.put("SPMG", "Move")
        await move
        assert (motor.values["RBV"], motor.values["SPMG"]) == (20_000, 1)
        waiting = asyncio.create_task(motor.put("VAL", 0))
        await lab.until("motor", DMOV=0)
        await motor.put("STOP", 1)
        with pytest.raises(RefusedError, match="a client stopped the axis"):
            await waiting
        assert (motor.values["MISS"], motor.values["STAT"]) == (1, "STATE")
        assert (motor.values["VAL"], motor.values["RBV"], motor.values["DMOV"]) == (20_000, 20_000, 1)
        await motor.put("SPMG", "Go")
        jog = asyncio.create_task(motor.put("JOGR", 1))
        await lab.until("motor", MOVN=1)
        await motor.put("SPMG", 1)
        await jog
        assert motor.values["DMOV"] == 1

    run(session)


def test_a_new_target_replaces_the_one_before():
    async def session(lab):
        motor = lab.records["motor"]
        await motor.put("VELO", 10)
        first = asyncio.create_task(motor.put("VAL", 1_000_000))
        await lab.until("motor", MOVN=1)
        await motor.put("VAL", -100)
        with pytest.raises(RefusedError, match="another request replaced the motion"):
            await first
        assert motor.values["MISS"] == motor.values["SEVR"] == 0
        assert lab.values("DMOV") == [0, 1]
        assert motor.values["RBV"] == motor.values["VAL"] == lab.bench["1811"].axes["motor"].position == -100

    run(session)


@pytest.mark.slow
def test_axes_of_an_if1_move_one_after_the_other():
    async def session(lab):
        x, y = lab.records["X"], lab.records["Y"]
        await asyncio.gather(x.put("VAL", 900), y.put("VAL", -300))
        states = [(axis, value) for axis, field, value in lab.seen if field == "DMOV"]
        assert states == [("X", 0), ("Y", 0), ("X", 1), ("Y", 1)]
        axes = lab.bench["if1"].axes
        assert (x.values["RBV"], y.values["RBV"]) == (axes["X"].position, axes["Y"].position) == (900, -300)
        with pytest.raises(RefusedError, match="no home switch is configured"):
            await x.put("HOMF", 1)
        with pytest.raises(
            RefusedError, match="VELO=30000 is out of range: expected a value above 0 and at most 25000"
        ):
            await x.put("VELO", 30_000)

    run(session, model="if1", self_test_s=0.1)


@pytest.mark.slow
def test_a_limit_switch_a_fault_and_a_lost_position_are_alarms():
    async def session(lab):
        x, if1, core = lab.records["X"], lab.bench["if1"], lab.machine.stations[0].driver.core
        await x.put("HLM", 9000)
        with pytest.raises(RefusedError, match=r"X stopped: the target was not reached \(limit: call clear_faults"):
            await x.put("VAL", 5000)
        await lab.until("X", HLS=1, DMOV=1)
        assert x.values["VAL"] == x.values["RBV"] == if1.axes["X"].position
        assert (x.values["SEVR"], x.values["STAT"]) == (2, "STATE") and "limit" in x.values["FAULT"]
        await x.put("CLEAR", 1)
        await x.put("VAL", 0)
        assert (x.values["SEVR"], x.values["FAULT"], x.values["HLS"]) == (0, "", 0)
        patience, core.timeout = core.timeout, 0.1
        await x.axis.station.polled()  # no request waits longer now
        if1.power_cycle()
        await lab.until("X", STAT="UDF", SEVR=3)
        core.timeout = patience
        with pytest.raises(DriverError, match="the position is not known"):
            await x.put("VAL", 10)
        await x.put("SET", 1)
        await x.put("VAL", 7)
        assert (x.values["RBV"], x.values["SEVR"], x.values["OFF"]) == (7, 0, 0)

    run(session, model="if1", self_test_s=0.1, X={"limits": [-1000, 600]})


def test_home_switches_and_a_search_that_fails():
    async def session(lab):
        motor = lab.records["motor"]
        await motor.put("HOMR", 0)
        await motor.put("HOMR", 1)
        assert (motor.values["RBV"], motor.values["VAL"], motor.values["HOMR"]) == (0, 0, 0)
        assert motor.values["MSTA"] & 1 << 14
        assert abs(lab.bench["1811"].axes["motor"].position + 500) <= 100
        search = asyncio.create_task(motor.put("HOMF", 1))
        await lab.until("motor", MOVN=1)
        await motor.put("STOP", 1)
        with pytest.raises(RefusedError, match="a client stopped the axis"):
            await search

    run(session, motor={"home": [-600, -500]})


def test_a_cut_line_is_an_alarm_until_the_controller_answers():
    async def session(lab):
        motor = lab.records["motor"]
        await motor.put("VAL", 100)
        driver = lab.machine.stations[0].driver
        opening, driver._opening, driver.url = driver._opening, None, "tcp://127.0.0.1:1"
        await driver.close()
        await lab.until("motor", STAT="COMM", SEVR=3)
        assert motor.values["MSTA"] & SILENT and "cannot open" in motor.values["FAULT"]
        move = asyncio.create_task(motor.put("VAL", 200))
        await lab.until("motor", DMOV=0)
        driver._opening = opening
        with pytest.raises(RefusedError, match="cannot open"):
            await move
        await motor.put("VAL", 300)
        assert (motor.values["RBV"], motor.values["SEVR"], motor.values["MSTA"] & SILENT) == (300, 0, 0)

    run(session)


REFUSED = [
    ("RBV", 1, "RBV cannot be written: expected a writable field"),
    ("UEIP", 1, "UEIP cannot be written: expected a writable field"),
    ("VAL", "far", "invalid value 'far' for VAL: expected a double"),
    ("VAL", float("nan"), "VAL cannot be nan: expected a number"),
    ("SPMG", "Run", "expected Stop, Pause, Move, Go"),
    ("DIR", 2, "invalid value 2 for DIR: expected one of"),
    ("ACCL", 0, "ACCL=0 is out of range: expected a value above 0"),
    ("VMAX", 1e9, "at most 546133"),
]


def test_a_write_that_cannot_be_honoured_is_refused():
    async def session(lab):
        before = dict(lab.records["motor"].values)
        for field, value, message in REFUSED:
            with pytest.raises(RefusedError, match=message):
                await lab.records["motor"].put(field, value)
        assert lab.records["motor"].values == before

    run(session)


def test_writes_without_motion():
    async def session(lab):
        motor = lab.records["motor"]
        for field, value in (("DESC", "slide"), ("EGU", "mm"), ("PREC", 3), ("STUP", 1), ("PROC", 1), ("SYNC", 1)):
            await motor.put(field, value)
        assert (motor.values["DESC"], motor.values["EGU"], motor.values["PREC"]) == ("slide", "mm", 3)
        assert motor.values["NAME"] == "motor" and motor.values["RTYP"] == "motor"

    run(session)


@pytest.mark.slow
def test_motors_of_a_chain_are_axes_of_one_station():
    async def session():
        bench = Bench()
        motors = [bench.add("smartmotor", f"m{number}") for number in (1, 2)]
        bench.chain(*motors, name="chain")
        words = {"speed": 10.0, "registers": ["chain.shaft2.a"], "period_s": 0.01}
        async with await of_scene(bench, {"chain": PATIENCE}, **words) as machine:
            (station,) = machine.stations
            records = {name: MotorRecord(axis, name, name) for name, axis in station.axes.items()}
            polling = asyncio.create_task(machine.run())
            await asyncio.gather(records["shaft1"].put("VAL", 300), records["shaft2"].put("VAL", -300))
            polling.cancel()
            await asyncio.wait([polling])
        assert [motor.axes["shaft"].position for motor in motors] == [300, -300]
        names = [point.name for point in station.points]
        assert {"shaft1.A", "shaft2.G", "shaft2.a"} < set(names)

    asyncio.run(session())


@pytest.mark.slow
@pytest.mark.parametrize("model", ["1811", "if1", "smartmotor"])
def test_a_stop_by_another_host_fails_the_move_and_is_an_alarm(model):
    async def session(lab):
        (record, *_), driver = lab.records.values(), lab.machine.stations[0].driver
        axis = lab.bench[model].axes[record.name]
        stop = {
            "1811": lambda: driver.core._send_command(0x70),
            "if1": lambda: driver.core.message("#"),
            "smartmotor": lambda: driver.core.send(b"", "X"),
        }[model]
        await record.put("VELO", 10)
        move = asyncio.create_task(record.put("VAL", 90_000))
        await lab.until(record.name, MOVN=1)
        await driver.run(stop())
        with pytest.raises(RefusedError, match="another host or program stopped it"):
            await move
        assert record.values["VAL"] == record.values["RBV"] == axis.position < 90_000
        assert (record.values["SEVR"], record.values["MISS"]) == (2, 1) and "another host" in record.values["FAULT"]
        posted = [field for _, field, value in lab.seen if (field, value) in (("SEVR", 2), ("DMOV", 1))]
        assert posted[-2:] == ["SEVR", "DMOV"]  # ophyd looks at the alarm when DMOV becomes 1
        await record.put("VAL", record.values["RBV"] + 100)
        assert (record.values["SEVR"], record.values["MISS"], record.values["FAULT"]) == (0, 0, "")

    run(session, model=model)
