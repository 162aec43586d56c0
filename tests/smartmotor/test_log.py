"""Numbers followed inside the motor: the values reported later are those read after each sample."""

import ast
import inspect

from axistwin import Bench
from axistwin.controllers.smartmotor.kernel import jit, log, state
from axistwin.controllers.smartmotor.kernel.core import SAMPLE_NS
from axistwin.controllers.smartmotor.kernel.interpreter import COMPUTED, SLOT, VARIABLE
from axistwin.controllers.smartmotor.registers import numbers

SAMPLES = 600
PROGRAM = b"C1 a=a+1 P=a*90 E=900+a ab[3]=a G TWAIT IF a&1 WAIT=2 ENDIF GOSUB5 GOTO1 C5 bbb=@P RETURN "


def at_work() -> Bench:
    """Return a motor that runs a program, at a whole sample."""
    bench = Bench()
    motor = bench.add("smartmotor", "motor", shaft={"motor": "frame23"})
    bench.run(5000 * SAMPLE_NS / 1e9)
    motor.serial.write(b"UCI UDI ZS A=900 V=900000 MP O=7 LOAD ")
    data = PROGRAM + b"\xff\xff"
    for at in range(0, len(data), 8):
        bench.run(500 * SAMPLE_NS / 1e9)
        motor.serial.write(data[at : at + 8])
    bench.run(500 * SAMPLE_NS / 1e9)
    motor.serial.write(b" RUN ")
    bench.run(100 * SAMPLE_NS / 1e9)
    assert motor.registers["Ra"].read() > 0
    return bench


def told(bench: Bench) -> dict[str, list[tuple[int, int]]]:
    """Return the changes that a follower of the registers receives: for each register, times and new values."""
    names, found = tuple(numbers()), {}

    def follower(times, which, values):
        for time_ns, k, value in zip(times, which, values, strict=True):
            found.setdefault(names[k], []).append((time_ns, value))

    end = bench["motor"].follow(names, follower)
    bench.run(SAMPLES * SAMPLE_NS / 1e9)
    end()
    return found


def looked_at(bench: Bench) -> dict[str, list[tuple[int, int]]]:
    """Return the changes found by reading every register after each sample."""
    registers, found = bench["motor"].registers, {}
    known = {name: register.read() for name, register in registers.items()}
    for _ in range(SAMPLES):
        bench.run(SAMPLE_NS / 1e9)
        for name, register in registers.items():
            if (value := register.read()) != known[name]:
                found.setdefault(name, []).append((bench.now, value))
                known[name] = value
    return found


def test_what_is_told_is_what_one_finds_after_each_sample():
    found = told(at_work())
    assert found == looked_at(at_work()) and found.keys() > {"Ra", "Rbbb", "Raa", "P", "RE", "RP", "RV", "RBt", "RW"}


def test_a_sample_without_statements_changes_no_number_that_is_not_compared():
    """Only the interpreter stores variables and buffered parameters, which are compared only after statements."""
    stored = set()
    for function in jit._sampled.values():
        if not function.__module__.endswith((".interpreter", ".log")):
            stored |= stores(function)
    assert {("i", "BX"), ("i", "COMMANDED"), ("f", "WINDING_C")} <= stored
    for array, place in stored:
        assert array != "v"
        assert array != "i" or log.moving(SLOT, getattr(state, place)), place


def stores(function) -> set[tuple[str, str]]:
    """Return, for each store in a function, the array and the name of the index."""
    found = set()
    for node in ast.walk(ast.parse(inspect.getsource(function))):
        if isinstance(node, ast.Subscript) and isinstance(node.ctx, ast.Store):
            names = [part.attr for part in ast.walk(node.slice) if isinstance(part, ast.Attribute)]
            found.add((ast.unparse(node.value), names[0] if names else ""))
    return found


def test_those_that_move_come_first():
    given = [(VARIABLE, 3), (SLOT, state.P), (SLOT, state.BT), (COMPUTED, 0), (VARIABLE, 0)]
    made = log.following(given, [0] * state.INTS, [0] * state.VARIABLES, {})
    assert made[log.MOVING] == 2 and list(made[log.HEAD : log.head(made).stop][3 :: log.NUMBER]) == [3, 2, 1, 0, 4]
