"""What can go wrong on a bench, in virtual time: which faults there are, where they act, when they begin and end."""

from axistwin.faults.desk import Fault, Faults
from axistwin.faults.kinds import KINDS
from axistwin.faults.table import Kind, Parameter

__all__ = ["KINDS", "Fault", "Faults", "Kind", "Parameter"]
