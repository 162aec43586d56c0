"""Values that a driver, the IOC and the OPC UA server all refuse, each with the error of its own protocol.

The units of the axis do not matter: a value out of range is out of range in counts and in millimetres.
"""

from math import inf, nan

HUGE = 1e300
BAD = {
    "move_to": (nan, inf, -inf, HUGE, 2.0**63), "move_by": (nan, inf, -inf, HUGE, 2.0**63),
    "move_at": (nan, inf, -inf, HUGE, 1e9, -1e9), "home": (nan, inf, 0, 2, -2, 0.5),
    "set_position": (nan, inf, -inf, HUGE, 2.0**63), "speed": (nan, inf, HUGE, 1e9, 0, -1),
    "acceleration": (nan, inf, HUGE, 0, -1),
}  # fmt: skip
"""Numbers by function; `move_at(0)` is no bad value, but a stop."""
NOT_NUMBERS = (True, "five", None)
"""Bad for every function, where the protocol can transfer them at all."""
TABLE = [(function, value) for function, values in BAD.items() for value in values]
