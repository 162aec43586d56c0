"""Reproducible pseudo-random numbers by the algorithm splitmix64; the seed determines the sequence."""

_MASK = (1 << 64) - 1
_STEP = 0x9E3779B97F4A7C15


class Chance:
    """A generator of pseudo-random numbers; its seed is 0 or more."""

    def __init__(self, seed: int) -> None:
        self._state = seed & _MASK

    def bits(self) -> int:
        """Return the next 64 random bits."""
        self._state = (self._state + _STEP) & _MASK
        mixed = self._state
        mixed = (mixed ^ (mixed >> 30)) * 0xBF58476D1CE4E5B9 & _MASK
        mixed = (mixed ^ (mixed >> 27)) * 0x94D049BB133111EB & _MASK
        return mixed ^ (mixed >> 31)

    def unit(self) -> float:
        """Return a random number, at least 0 and less than 1."""
        return (self.bits() >> 11) / (1 << 53)

    def below(self, most: int) -> int:
        """Return a random integer from 0 to `most` - 1."""
        return self.bits() % most
