"""The execution of a program, statement by statement: returns, waits, and statements per sample."""

from dataclasses import replace

from .program import Abandoned, no_value


class Runner:
    """A program of a `motor`, running or stopped."""

    def __init__(self, motor, program, per_sample):
        self.motor, self.program, self.per_sample = motor, program, per_sample
        self.state = "running"
        self.step = program.enter(program.root)
        self.number = 0
        self.left = 0
        self.returns = []
        """Steps to return to (None: the program was stopped), and the cause of each call."""
        self.switches = [0] * 11
        self.wait_until = 0
        self.held = self.c2_called = self.fault_again = False
        self.pending = set()

    def sample(self):
        """Execute the statements of one sample; return the reason to stop, if any."""
        if self.pending and self.state == "stopped":
            return "call"
        while self.left > 0 and self.state == "running" and self.motor.sample_number + 1 >= self.wait_until:
            if self.pending:
                return "call"
            result = self.statement()
            if result == "value":
                return result
            self.left -= 1
            if result == "statement":
                return result
            if result == "held":
                return None
        return None

    def statement(self):
        if self.held:
            if self.motor.flags["Bt"]:
                return "held"
            self.held = False
        step = self.step
        self.number = step.number(self.program)
        if step.fetch:
            self.step = replace(step, fetch=False)
            return "value"
        return getattr(self, "_" + step.what.replace(" ", "_"))(step)

    def _value(self, value):
        """Return the value of an expression, or None if the expression was abandoned and its error flag set."""
        try:
            return value(self.motor)
        except Abandoned as reason:
            self.motor.flags[reason.flag] = 1
            return None

    # Steps

    def _if(self, step):
        block = step.node.parts[step.part]
        self.step = self.program.enter(block) if self._value(block.value) else self.program.otherwise(step)

    _while = _if

    def _leave(self, step):
        self.step = self.program.behind(step.node)

    def _loop(self, step):
        self.step = self.program.begin(step.node)

    def _switch(self, step):
        value = self._value(step.node.value)
        if value is None:
            self.step = self.program.default(step.node)
            return
        self.switches[len(self.returns)] = value
        cases = [part for part in step.node.parts if part.value is not None]
        self.step = self.program.cases(step.node) if cases else replace(step, what="skip")

    def _skip(self, step):
        self.step = self.program.default(step.node)

    def _case(self, step):
        block = step.node.parts[step.part]
        if block.value is no_value:
            self.motor.flags["Bs"] = 1
        if self.switches[len(self.returns)] == block.value:
            self.step = self.program.enter(block)
        else:
            self.step = self.program.cases(step.node, step.part)

    def _end_of_text(self, step):
        self._forget()
        self.state = "stopped"

    def _do(self, step):
        node = step.node
        self.step = self.program.behind(node)
        word = node.keyword
        if word in ("RETURN", "RETURNF", "RETURNI", "STACK", "END", "TWAIT", "BREAK", "let", "element", "WAIT"):
            return getattr(self, "_" + word.lower())(node)
        if word.startswith(("GOTO", "GOSUB")):
            return self._go(word)
        return "statement"

    # Statements

    def _let(self, node):
        self.motor.assigning = True
        value = self._value(node.value)
        self.motor.assigning = False
        if value is not None:
            self.motor.memory[node.array] = value

    def _element(self, node):
        try:
            index = node.index(self.motor)
            self.motor.assigning = True
            for place, value in enumerate(node.value, index):
                self.motor.memory.set_element(node.array, place, value(self.motor))
        except Abandoned as reason:
            self.motor.flags[reason.flag] = 1
        self.motor.assigning = False

    def _wait(self, node):
        samples = self._value(node.value)
        if samples is not None:
            self.wait_until = self.motor.sample_number + 1 + samples * self.motor.rate

    def _twait(self, node):
        if self.motor.flags["Bt"]:
            self.held = True
            return "held"
        return None

    def _break(self, node):
        owner = node.block.owner
        while owner.keyword == "IF":
            owner = owner.block.owner
        self.step = self.program.behind(owner)

    def _go(self, word):
        target = self.program.labels.get(int(word.lstrip("GOTSUB")))
        if target is None:
            return "statement"
        if word.startswith("GOTO"):
            self.step = self.program.begin(target)
        else:
            self.call(target, self.step, "GOSUB")
        return None

    def call(self, target, back, why):
        """Call a label; an eleventh nested call sets Bs."""
        if len(self.returns) == 10:
            self.motor.flags["Bs"] = 1
            return
        self.returns.append((back, why))
        self.step = self.program.begin(target)

    def _return(self, node):
        if not self.returns:
            self.motor.flags["Bs"] = 1
            self.state = "stopped"
            return
        self.step, why = self.returns.pop()
        if why == "C1":
            self._return_from_c1()
        if self.step is None:
            self.step = self.program.enter(self.program.root)
            self.state = "stopped"

    _returnf = _return

    def _returni(self, node):
        self.c2_called = False
        self._return(node)

    def _stack(self, node):
        self._forget()

    def _end(self, node):
        self._forget()
        self.state = "stopped"

    def _forget(self):
        self.returns.clear()
        self.c2_called = False
        self._return_from_c1()

    def _return_from_c1(self):
        """Return from C1; a fault within C1 calls C1 again."""
        if self.fault_again:
            self.fault_again = False
            self.pending.add("C1")
