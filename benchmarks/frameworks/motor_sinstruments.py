"""lewis' example motor for sinstruments, which has no clock and no motion of its own."""

import time

from sinstruments.simulator import BaseDevice

SPEED = 2.0


class Motor(BaseDevice):
    newline = b"\r\n"

    def __init__(self, name, **options):
        super().__init__(name, **options)
        self.start = self.target = 0.0
        self.began = time.monotonic()

    @property
    def position(self):
        way = SPEED * (time.monotonic() - self.began)
        return min(self.start + way, self.target) if self.target >= self.start else max(self.start - way, self.target)

    def handle_message(self, message):
        answer = self.answer(message.decode().strip())
        return None if answer is None else f"{answer}\r\n".encode()

    def answer(self, text):
        match text.split("="):
            case ["S?"]:
                return "idle" if self.position == self.target else "moving"
            case ["P?"]:
                return self.position
            case ["T?"]:
                return self.target
            case ["H"]:
                self.start = self.target = self.position
                return f"T={self.target},P={self.position}"
            case ["T", number]:
                return self.move(float(number))
        return None

    def move(self, target):
        if self.position != self.target:
            return "err: not idle"
        if not 0 <= target <= 250:
            return "err: not 0<=T<=250"
        self.start, self.target, self.began = self.position, target, time.monotonic()
        return f"T={target}"
