"""An event loop with a clock that the test sets, for tests of pacing."""


class Handle:
    def __init__(self, at_s, action):
        self.at_s, self.action, self.cancelled = at_s, action, False

    def cancel(self):
        self.cancelled = True


class Loop:
    """An event loop with a clock that only the test advances; `woken` counts the executed callbacks."""

    def __init__(self):
        self.now_s, self.handles, self.woken = 0.0, [], 0

    def time(self):
        return self.now_s

    def call_at(self, at_s, action):
        self.handles.append(Handle(at_s, action))
        return self.handles[-1]

    def call_soon(self, action):
        return self.call_at(self.now_s, action)

    def run_to(self, end_s):
        while due := [handle for handle in self.handles if not handle.cancelled and handle.at_s <= end_s]:
            handle = min(due, key=lambda handle: handle.at_s)
            self.handles.remove(handle)
            self.now_s = max(self.now_s, handle.at_s)
            self.woken += 1
            handle.action()
        self.now_s = end_s
