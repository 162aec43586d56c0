"""The computation of each servo sample, in plain Python that Numba can compile."""
