"""The report of a probe as a page of HTML."""

from html import escape

from axistwin.real.hosts.end import Answer
from axistwin.real.probing.comparing import Probe, Result, Verdict

STYLE = """
body { font: 15px/1.5 system-ui, sans-serif; max-width: 72rem; margin: 2rem auto; padding: 0 1rem; color: #1b1f24 }
table { border-collapse: collapse; width: 100% } th, td { text-align: left; padding: .2rem .6rem; vertical-align: top }
tr { border-bottom: 1px solid #d8dde3 } code { font-size: 13px; overflow-wrap: anywhere }
.differs { background: #fde8e6 } .inconclusive { background: #fdf6e0 }
"""


def html(probe: Probe) -> str:
    counts = ", ".join(f"{len(probe.of(verdict))} {verdict}" for verdict in Verdict)
    facts = "".join(
        f"<li>{escape(name)}: {escape(repr(text)[1:-1])}</li>" for name, text in probe.condition.facts.items()
    )
    fits = "".join(f"<li>the controller fits option <code>{escape(text)}</code></li>" for text in probe.fits)
    times = (
        "Times were compared." if probe.times_judged else "Times were not compared: the port does not keep real time."
    )
    order = sorted(probe.results, key=lambda result: list(Verdict).index(result.verdict) or 9)
    rows = "".join(map(_row, order))
    title = escape(f"Probe of an {probe.model}")
    return (
        f'<!doctype html><html lang="en"><meta charset="utf-8"><title>{title}</title><style>{STYLE}</style>'
        f"<h1>{title}</h1><p><b>{counts}.</b> {times}</p><ul>{facts}{fits}</ul>"
        "<table><tr><th>verdict</th><th>case</th><th>section</th><th>moves</th><th>sent</th><th>twin</th>"
        f"<th>controller</th></tr>{rows}</table></html>\n"
    )


def _row(result: Result) -> str:
    case = result.case
    reason = f"<br>{escape(result.reason)}" if result.reason else ""
    cells = (
        f"{result.verdict}{reason}", escape(case.name), escape(case.section), "yes" if case.moves else "no",
        _bytes(case.says), _answers(result.expected), _answers(result.received),
    )  # fmt: skip
    return f'<tr class="{result.verdict}">' + "".join(f"<td>{cell}</td>" for cell in cells) + "</tr>"


def _answers(answers: tuple[Answer, ...]) -> str:
    return _bytes(tuple(answer.data for answer in answers))


def _bytes(parts: tuple[bytes, ...]) -> str:
    return "<br>".join(f"<code>{escape(_shown(part))}</code>" for part in parts)


def _shown(data: bytes) -> str:
    readable = all(byte in b"\r\n" or 0x20 <= byte < 0x7F for byte in data)
    return repr(data)[2:-1] if readable else data.hex(" ")
