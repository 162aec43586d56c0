"""Axes of real and virtual controllers for the systems of laboratories and plants: EPICS and OPC UA.

A `Station` is a controller with its driver; `Machine` finds the stations of a scene or of a port.  `DrivenAxis` gives
each axis one motion at a time.  The packages below serve these axes.
"""

from axistwin.real.hosts.inner_port import InnerPort
from axistwin.real.integrations.driven_axis import DrivenAxis, Goal
from axistwin.real.integrations.driven_scene import Machine, at_port, driver_inside, of_scene
from axistwin.real.integrations.pins_and_registers import Point
from axistwin.real.integrations.station import Station

__all__ = ["DrivenAxis", "Goal", "InnerPort", "Machine", "Point", "Station", "at_port", "driver_inside", "of_scene"]
