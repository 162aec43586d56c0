"""A simulation tool that calls the C functions of FMI 3.0 in the library of an FMU.

    python c_tool.py FOLDER CALLS

FOLDER is an unpacked FMU.  CALLS is a list in JSON: each call is `["step", BEGIN_S, STEP_S]`, `["set", REFERENCE,
VALUE]` or `["get", REFERENCE]`.  Prints a list of [status, value, messages] for the calls.
"""

import ctypes
import json
import sys
from ctypes import byref, c_bool, c_char_p, c_double, c_int, c_size_t, c_uint32, c_void_p
from pathlib import Path
from xml.etree import ElementTree as ET

folder, calls = Path(sys.argv[1]), json.loads(sys.argv[2])
library = ctypes.CDLL(str(folder / "binaries" / "x86_64-linux" / "machine.so"))
library.fmi3InstantiateCoSimulation.restype = c_void_p
told = []


@ctypes.CFUNCTYPE(None, c_void_p, c_int, c_char_p, c_char_p)
def log(_, status, category, message):
    told.append([status, message.decode()])


def call(name, *arguments):
    """Call a function; return its status and the messages that it logs."""
    told.clear()
    return getattr(library, f"fmi3{name}")(instance, *arguments), list(told)


token = ET.parse(folder / "modelDescription.xml").getroot().attrib["instantiationToken"].encode()
resources = f"{folder / 'resources'}/".encode()
instance = c_void_p(
    library.fmi3InstantiateCoSimulation(
        b"one", token, resources, c_bool(), c_bool(True), c_bool(), c_bool(), None, c_size_t(), None, log, None
    )
)
assert instance.value
assert call("EnterInitializationMode", c_bool(), c_double(), c_double(), c_bool(), c_double())[0] == 0
assert call("ExitInitializationMode")[0] == 0
found = []
for kind, *values in calls:
    number = c_double(values[-1])
    reference = byref(c_uint32(int(values[0]) if kind != "step" else 0))
    if kind == "step":
        flags = [byref(c_bool()) for _ in range(3)]
        status, messages = call("DoStep", c_double(values[0]), number, c_bool(True), *flags, byref(number))
    else:
        function = "SetFloat64" if kind == "set" else "GetFloat64"
        status, messages = call(function, reference, c_size_t(1), byref(number), c_size_t(1))
    found.append([status, number.value, messages])
assert call("Terminate")[0] == 0
library.fmi3FreeInstance(instance)
print(json.dumps(found))
