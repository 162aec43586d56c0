"""A processor that does nothing but run a program: the interpreter on plain lists or compiled, sample by sample."""

from array import array

from axistwin.controllers.smartmotor.kernel import jit, state
from axistwin.controllers.smartmotor.kernel.interpreter import FETCH, HELD, STACK, TRAP, statement
from axistwin.controllers.smartmotor.language.program import Program


class Processor:
    """Carries out one statement per sample; statements that Python would perform are only noted, in `performed`."""

    def __init__(self, text, *, compiled=False, overlay=True):
        self.program = Program.compile(text)
        self.i, self.v = array("q", [0] * state.INTS), array("q", [0] * state.VARIABLES)
        self.stack, self.code = array("q", [0] * STACK), array("q", self.program.code)
        self.i[state.DIRECTION] = self.i[state.PID_RATE] = 1
        self.i[state.ARRAY_BASE] = state.DOUBLES if overlay else state.ALONE
        self.i[state.PROGRAM] = state.RUNNING
        self.statement = jit.best(statement) if compiled else statement
        self.carried_out = []
        """The text of each statement, in the order of the samples; None: a sample in which nothing was done."""
        self.performed = []
        self.fetched = lambda text: 0

    def run(self, samples=1000):
        """So many samples, or until the program ends."""
        for _ in range(samples):
            if self.i[state.PROGRAM] != state.RUNNING:
                break
            self.carried_out.append(self._sample())
            self.i[state.SAMPLE] += 1
        return self

    def _sample(self):
        if self.i[state.SAMPLE] + 1 < self.i[state.WAIT_UNTIL]:
            return None
        result = self.statement(self.i, self.v, self.stack, self.code)
        if result == FETCH:
            text = self.program.statements[self.i[state.STATEMENT]].text
            self.v[state.HIDDEN] = self.fetched(text)
            result = self.statement(self.i, self.v, self.stack, self.code)
        if result == HELD:
            return None
        number = self.i[state.STATEMENT]
        text = self.program.statements[number].text if number < len(self.program.statements) else "(end)"
        if result == TRAP:
            self.performed.append(text)
        return text

    def __getitem__(self, letters):
        """A variable: a…z, aa…zz, aaa…zzz."""
        return self.v[26 * (len(letters) - 1) + ord(letters[0]) - ord("a")]
