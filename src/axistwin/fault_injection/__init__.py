"""What can go wrong on a bench, in virtual time: which faults there are, where they act, when they begin and end."""

from axistwin.fault_injection.injector import Fault, Faults
from axistwin.fault_injection.kinds import KINDS
from axistwin.fault_injection.table import Kind, Parameter

__all__ = ["KINDS", "Fault", "Faults", "Kind", "Parameter"]
