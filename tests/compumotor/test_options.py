"""Options for figures that the manual gives as "about", and units of the parameters of commands."""

import pytest

from axistwin import Bench
from axistwin.bench import product
from axistwin.core.errors import UsageError

from ..scripts import scripts
from .scripts import play
from .talking import messages, send

TIMES = (
    "initialisation_s", "drain_ms", "reply_ms", "start_ms", "calculation_ms", "step_ms", "next_message_ms", "limit_us",
    "trigger1_us", "trigger6_us", "trigger1_hold_us", "trigger6_hold_us", "home_ms", "marker_ms",
)  # fmt: skip
SWITCHES = ("test_switch", "invert_z", "invert_encoder", "high_impedance")
BAD = [
    *((name, value) for name in TIMES for value in (-0.001, -1, 60_000.5, 60_001, "1", None, True)),
    *((name, value) for name in SWITCHES for value in (0, 1, "yes", None)),
    *(("buffer_bytes", value) for value in (15, 0x1_0000, 600.0, "600", False)),
    *((name, value) for name in ("command_queue", "message_queue") for value in (0, 1001, 1.0, "1", True)),
    ("step_ms", 0),
    ("interrupts", ("message",)),
    ("interrupts", ("message_ready", "nothing")),
    ("interrupt_command", "nowhere"),
    ("encoder_commands", "some"),
    ("stop_after_stream", "kill"),
    *(("part_number", text) for text in ("94-003657-01", "94-003657-01ABC", "94-003657-01Å")),
]


@pytest.mark.parametrize(("name", "value"), BAD)
def test_a_bad_value_is_refused_in_one_line_that_names_the_option(name, value):
    with pytest.raises(UsageError) as caught:
        Bench().add("1811", **{name: value})
    assert name in str(caught.value) and "\n" not in str(caught.value)


GOOD = [
    *((name, value) for name in TIMES if name != "step_ms" for value in (0, 0.5, 60_000)),
    *((name, value) for name in SWITCHES for value in (True, False)),
    *(("buffer_bytes", value) for value in (16, 0xFFFF)),
    *((name, value) for name in ("command_queue", "message_queue") for value in (1, 1000)),
    ("step_ms", 0.001), ("step_ms", 60_000),
    ("interrupts", ()), ("interrupts", ("message_ready", "input_ready", "failed")),
    ("part_number", "94-003657-01A"), ("part_number", "94-003657-01AB"),
]  # fmt: skip


@pytest.mark.parametrize(("name", "value"), GOOD)
@pytest.mark.parametrize("model", ["1810", "1811"])
def test_the_ends_of_the_ranges_are_taken(model, name, value):
    Bench().add(model, **{name: value})


def test_a_message_says_between_what_a_number_must_lie():
    for name, span in (
        ("drain_ms", "from 0 to 60000"),
        ("buffer_bytes", "16 to 65535"),
        ("message_queue", "1 to 1000"),
    ):
        with pytest.raises(UsageError, match=span):
            Bench().add("1811", **{name: -1})
    with pytest.raises(UsageError, match=r"from 0\.001 to"):
        Bench().add("1811", step_ms=0)
    for name, known in (("encoder_commands", "'kept', 'performed'"), ("interrupt_command", "'everywhere', 'printed'")):
        with pytest.raises(UsageError, match=known):
            Bench().add("1811", **{name: "x"})
    with pytest.raises(UsageError, match="message_ready, input_ready, failed"):
        Bench().add("1811", interrupts=("x",))


# Figures that the manual gives


@scripts({
    "a command queue of one":
    "1811 reply_ms=10000.0 command_queue=1; 84; 09 00; IDB 09 01; CB 10; 1 s; SB & 10 is 0",
    'Reading responses: "waiting to send additional messages"; here two messages wait besides the one in the ODB':
    "1811 message_queue=2; 01 01; 0.01 s; 01 02; 0.01 s; 01 03; 0.01 s; 01 04; 0.01 s; 01 05; 0.01 s; says 01 01, "
    "01 02, 01 03",
    'Reading responses: after CB bit 7, "if the Motor Controller has been waiting ... it will do so then"':
    "1811 next_message_ms={0.0|1.0|7.0}; 01 01; 01 02; 0.02 s; next 01 01; clock; until SB & 8 is 8; {0|1|"
    "7} ms later",
    'E2h: the reply has four bytes, the first two "always zero"; the others are the size of option buffer_bytes':
    "1811 buffer_bytes={16|100|65535}; E2 -> 00 00 {00|00|FF} {10|64|FF}; 52 01 04 00 00 00 00 00 02; "
    "E2 -> 00 00 {00|00|FF} {10|64|FF}",
    "Interrupts: JU18 connects MR, JU20 connects IR, JU19 connects CF; SB bit 7 is set by a connected one only (1)":
    "new 1811 interrupts=({|'failed',}); 1.01 s; CB 40; IDB 01 09; CB 50; 0.02 s; SB 18; no interrupt",
    "Interrupts: JU18 connects MR, JU20 connects IR, JU19 connects CF; SB bit 7 is set by a connected one only (2)":
    "new 1811 interrupts=('{message_ready',|input_ready',|input_ready','failed'}); 1.01 s; CB 40; IDB 01 09; "
    "CB 50; 0.02 s; SB 98; interrupt",
    'Writing commands: "Commands are placed into a command buffer internal to the Motor Controller", of sixteen':
    "1811 reply_ms=10000.0; 84; 09 00; 09 00; 09 00; 09 00; 09 00; 09 00; 09 00; 09 00; 09 00; 09 00; 09 00; "
    "09 00; 09 00; 09 00; 09 00; 09 00; IDB 09 01; CB 10; 1 s; SB & 10 is 0; 10 s; SB & 13 is 13",
})  # fmt: skip
def test_options(bench, script):
    play(bench, script)


def test_by_default_sixty_four_messages_wait(bench, board):
    for identifier in range(70):
        send(bench, board, 0x01, identifier, seconds=0.005)
    assert len(messages(bench, board)) == 65


# Units


@pytest.mark.parametrize(("opcode", "units"), [
    (0xB1, ["pulses/rev"]), (0xB2, ["motor steps"]), (0xB5, ["encoder pulses"]), (0xD6, ["pulses/s"]),
    (0xB3, ["units of range"]), (0x31, ["units of range"] * 2),
    *((opcode, ["units of range"] * 2 + ["pulses"]) for opcode in (0xC8, 0xCB)),
    *((opcode, ["units of range"] * 2 + ["encoder pulses"]) for opcode in (0xD4, 0xD5)),
    (0xCE, ["units of range"] * 2),
    (0xE0, ["effective clock/65536", "pulses"] * 3), (0xE1, ["effective clock/65536"] * 7), (0xE3, ["pulses"] * 7),
    *((opcode, ["bytes"]) for opcode in (0x51,)), *((opcode, ["bytes", "ms"]) for opcode in (0x52, 0x53))])  # fmt: skip
def test_the_units_in_which_a_command_is_given(opcode, units):
    """C8h: velocity "units", distance in pulses; B1h: pulses of one revolution; B2h: motor steps; D6h: pulses per
    second; E0h: V / 65,536 of the effective clock; 51h: alarm in bytes, update rate in milliseconds.
    """
    assert [field.unit for field in product("1811").commands.get(opcode).parameters if field.unit] == units


@pytest.mark.parametrize(("code", "good", "bad"), [
    ("E3", ("01" + "00" * 14, "07" + "FF" * 14), ("00" * 15, "08" + "00" * 14, "01" + "00" * 13)),
    ("E0", ("00" * 12, "FF" * 12), ("00" * 11,)),
    ("E1", ("00" * 14, "FF" * 14), ("00" * 13,)),
    ("B0", ("00010001", "FFFFFFFF"), ("00000001", "00010000", "000100")),
    ("B1", ("00000000", "0000FFFF"), ("00010000", "FFFFFFFF")),
    ("B2", ("00000000", "7FFFFFFF"), ("80000000", "FFFFFFFF")),
    ("B3", ("01000000000000", "03FF5F7FFFFFFF"), ("00" * 7, "04" + "00" * 6, "01006000000000", "01000080000000")),
    ("B4", ("00000000", "0000FFFF"), ("00010000", "FFFFFFFF")),
    ("B5", ("00000000", "FFFFFFFF"), ("000000",)),
    ("31", ("00" * 10, "FF52" + "7FFFFFFF" * 2), ("0060" + "00" * 8, "0003" + "00" * 8, "000080" + "00" * 7)),
    *((code, ("00", "01", "FF"), ("", "0001")) for code in ("12", "13", "14", "18", "19", "28", "32", "39", "3A")),
    *((f"A{n:X}", ("00", "01", "FF"), ("", "0001")) for n in range(12)),
    *((code, ("010000", "06FFFF"), ("000000", "020000", "050000", "070000")) for code in ("76", "77", "7D")),
    *((code, ("", "00"), ("01",)) for code in ("10", "11", "30", "37", "42", "48", "50", "70", "80", "AF"))
])  # fmt: skip
def test_parameter_bytes_are_in_the_correct_range(code, good, bad):
    """Command definitions: the printed ranges, such as "01 -> 07, number of significant distance values"."""
    command = product("1811").commands.get(int(code, 16))
    assert all(command.decode(bytes.fromhex(text)) is not None for text in good)
    assert [text for text in bad if command.decode(bytes.fromhex(text)) is not None] == []
