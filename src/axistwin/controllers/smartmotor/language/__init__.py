"""The SmartMotor language: lexer, parser, expressions, compiled programs."""

from typing import TYPE_CHECKING

from axistwin.lazy import lazy

if TYPE_CHECKING:
    from axistwin.controllers.smartmotor.language.expressions import Expression, Malformed, Reader
    from axistwin.controllers.smartmotor.language.forms import Accept, Form
    from axistwin.controllers.smartmotor.language.image import Decoder, encode, labels, strip, sums
    from axistwin.controllers.smartmotor.language.language import Statement, command, read
    from axistwin.controllers.smartmotor.language.program import OPENS, Program, digits, word
else:
    __getattr__ = lazy(
        __name__,
        expressions="Expression Malformed Reader",
        forms="Accept Form",
        image="Decoder encode labels strip sums",
        language="Statement command read",
        program="OPENS Program digits word",
    )

__all__ = [
    "OPENS", "Accept", "Decoder", "Expression", "Form", "Malformed", "Program", "Reader", "Statement", "command",
    "digits", "encode", "labels", "read", "strip", "sums", "word",
]  # fmt: skip
