"""OPC UA: axes, pins, registers and faults as an address space, and methods for motions; by asyncua."""
