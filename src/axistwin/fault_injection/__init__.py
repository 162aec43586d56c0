"""Fault injection: the kinds of faults, where they act, and when they begin and end, in virtual time."""

from axistwin.fault_injection.injector import Fault, Faults
from axistwin.fault_injection.kinds import KINDS
from axistwin.fault_injection.table import Kind, On, Parameter, Sort

__all__ = ["KINDS", "Fault", "Faults", "Kind", "On", "Parameter", "Sort"]
