"""The arithmetic of every servo sample: plain Python that Numba can compile."""
