"""Fault injection: the kinds of faults, their places, and their begin and end in virtual time."""

from axistwin.fault_injection.injector import Fault
from axistwin.fault_injection.kinds import KINDS
from axistwin.fault_injection.table import Kind, On, Parameter, Sort

__all__ = ["KINDS", "Fault", "Kind", "On", "Parameter", "Sort"]
