"""Decisions of docs/fidelity.md on single commands: definitions, requests, events, streaming, closed loop."""

import pytest

from ..scripts import scripts
from .programs import ALL, AT_ONCE, enter, number, sequence, tracked, velocities, words
from .scripts import play
from .talking import ask, complete, default, i32, messages, position, ready, send, send_all

STREAMED = 0x0400  # of the effective clock 4,369,066.67 / 4 Hz, this is 17,066.67 pulses/s

# Definitions


@scripts({
    '91h, 31h: "After power up or reset the default velocity and acceleration are set to zero"; its type is CEh':
    "91 00 -> CE; 52 01 04 =never #10; 91 00 -> CE",
    'C8h: acceleration 0 is stored; specifications: 0.00001 steps/s² "to infinity", so it is not performed (1)':
    "C8 01 00 00 00 13 88 00 00 00 00 00 00 00 64; 91 01 -> C8 01 00 00 00 13 88 00 00 00 00 00 00 00 64; 40 01; "
    "1 s; pulses 0; 8C -> 00",
    'C8h: acceleration 0 is stored; specifications: 0.00001 steps/s² "to infinity", so it is not performed (2)':
    "CE 01 00 00 00 13 88 00 00 00 00 00; 91 01 -> CE 01 00 00 00 13 88; 40 01; 1 s; pulses 0; 8C -> 00",
    '91h: a response "match[es] the ... original define move command"; without one, 91h reports no parameters':
    "91 {01|32|33|FF}; 40 {01|32|33|FF}; D7 {01|32|33|FF}; 0.1 s; says nothing; pulses 0",
    "the highest velocity of the specifications: the highest velocity of 1,092,267 steps/s is 1,092,266.67 "
    "(resolution 33.333): half of 4,369,066.67 / 2":
    "default 1092267 at_once 80; 32 00; 0.1 s; velocity 1092266.66 to 1092266.67; 85 -> 50 00 10 AA AB",
    'Syntax: "Unrequired parameter bytes may be filled with zeros. Using any other character ..."  (1)':
    "01 07 {00|01} -> {07|nothing}",
    'Syntax: "Unrequired parameter bytes may be filled with zeros. Using any other character ..."  (2)':
    "01 07 00 00 00 00 00 00 00 00 00 00 00 00 00 {00|01} -> {07|nothing}",
    "surplus zeros are not kept in a sequence":
    "sequence 1: 09 02 00 00 00 00 00 00 00 00 00 00 00 00 00 00; E2: 598; 92 01; says 92 09 02, 92 00",
    "the lowest velocity of the specifications: the lowest velocity, 0.017 steps/s, is 17 in range 3, whose "
    "resolution is 0.016667: one step per minute": "default 17 at_once 48; 32 00; 601 s; steps 10",
    'Reading and writing: the buffers are "16 bytes deep": a non-zero 17th byte is ignored, a 16th one is invalid':
    "IDB 01 07 00 00 00 00 00 00 00 00 00 00 00 00 00 00 01; CB 10; next 01 07; "
    "IDB 01 07 00 00 00 00 00 00 00 00 00 00 00 00 00 01; CB 10; next nothing",
})  # fmt: skip
def test_definitions(bench, script):
    play(bench, script)


@pytest.mark.parametrize("command", [(0x32, 0), (0x33, *i32(5)), (0x34, *i32(5)), (0x39, 0)])
@pytest.mark.parametrize(("velocity", "acceleration"), [(0, 0), (0, 5_000), (5_000, 0)])
def test_a_default_move_without_velocity_or_acceleration_is_not_performed(
    bench, board, velocity, acceleration, command
):
    """32h: "If the default move has not been defined no move will be performed"; acceleration 0 counts as undefined."""
    send_all(bench, board, (0xA1, 1), (0x38, 1, 0, 50, 0))
    default(bench, board, velocity, acceleration)
    send(bench, board, *command, seconds=1)
    assert messages(bench, board) == [] and board.axes["motor"].pulses == 0
    assert ask(bench, board, 0x91, 0)[4:12] == bytes((*i32(velocity), *i32(acceleration)))


def test_the_lowest_acceleration_of_the_specifications(bench, board):
    """0.00001 steps/s² is 1 in ranges 3 and 2: the first level, 1/60 steps/s, lasts until 0.025 is reached, 1,667 s."""
    default(bench, board, 1_000, 1, ranges=0x32)
    send(bench, board, 0x32, 0)
    levels = []
    for seconds in (1, 1_665, 2):
        bench.run(seconds)
        levels.append(board.axes["motor"].velocity * 60)
    assert levels == pytest.approx([1, 1, 2], rel=1e-9)


# Strings


# Requests whose lists of attributes are lost


@pytest.mark.parametrize("request_", [(0x83,), (0x88,), (0x89,), (0x8C,), (0x90,), (0xE2,), (0x91, 0)])
def test_requests_with_lost_lists_are_as_their_siblings(bench, board, request_):
    """83h, 88h, 89h, 8Ch, 90h, 91h and E2h are valid as 80h to 8Bh are: in both modes and during a sequence."""
    sequence(bench, board, 1, (0x28, 0))
    assert ask(bench, board, *request_)[0] == request_[0]
    send(bench, board, 0x41, 1)
    assert ask(bench, board, *request_)[0] == request_[0]
    send(bench, board, 0x79)
    enter(bench, board, 0x52, 1, 4, rate=1_000)
    assert ask(bench, board, *request_)[0] == request_[0]
    velocities(bench, board, *(STREAMED,) * 7)
    send(bench, board, 0x42)
    answered = ask(bench, board, *request_)[:1] == bytes(request_[:1])
    assert answered is (request_[0] != 0x91)  # 91h is not valid for defined moves in this mode


@scripts({
    'G.2 prints 83h in a sequence; 80h and others are not marked "within-a-SEQUENCE-buffer" (1)':
    "sequence 1: {88|89|8C|90|E2|80|97}, 83; 92 01; says 92 83, 92 00",
    'G.2 prints 83h in a sequence; 80h and others are not marked "within-a-SEQUENCE-buffer" (2)':
    "sequence 1: 91 00, 83; 92 01; says 92 83, 92 00",
    "trigger commands with lost lists stand in sequences and beside them: 74h to 76h and 7Dh are valid in "
    "sequences and beside them, like 77h, 7Ch and 7Eh, whose lists are printed":
    "sequence 1: {74|75|76|7D} 06 01 01, 28 00; 41 01; 0.05 s; trigger 6; says {74|75|76|7D} 06; 79; {74|75|76|"
    "7D} 06 00 00; 41 01; {74|75|76|7D} 06 00 00",
    '01h: "to indicate a location within a sequence buffer"; its list is cut off at the end of the printed page':
    "sequence 1: 28 00, 01 09; 41 01; 01 01 -> 01; 48; says 01 09",
    'Option interrupt_command="printed": 01h is valid in both modes, and neither in nor beside sequences':
    "1811 interrupt_command='printed'; sequence 1: 28 00, 01 09; 92 01; says 92 28, 92 00; 41 01; "
    "01 01 -> nothing; 79; 01 02 -> 02; 52 01 04 =never #10; 01 03 -> 03; EE #32767 01 04 00; "
    "velocities 32767 32767; 42; 01 05 -> nothing; 1 s; says nothing",
    '8Ah: "active" is what 38h defines; before 38h a high input is active, in 88h too':
    "home {high|low}; 8A -> {FF|00}; 88 & 04 is {04|00}; 38 00 00 32 00; 8A -> {00|FF}",
})  # fmt: skip
def test_requests_whose_lists_of_attributes_are_lost(bench, script):
    play(bench, script)


# 01h


# Streaming


def run_dry(bench, board):
    enter(bench, board, 0x52, 1, 4, rate=10)
    velocities(bench, board, STREAMED)
    send(bench, board, 0x42, seconds=0.2)
    assert board.axes["motor"].velocity == pytest.approx(17_066.67, abs=0.01)


def moved(bench, board):
    default(bench, board, 10_000, 100_000)
    complete(bench, board, 0x33, *i32(100))


def test_70h_after_a_stream_has_run_dry_is_a_ramp_of_the_last_move(bench, board):
    """70h: "at the most recent acceleration/deceleration rate": from 17,066.67 pps at 100,000 pps² in 0.17 s."""
    moved(bench, board)
    run_dry(bench, board)
    send(bench, board, 0x70)
    began = bench.now
    assert bench.run_until(lambda: not board.axes["motor"].velocity, 1) and 0.166 < (bench.now - began) / 1e9 <= 0.172


@scripts({
    "70h after a stream without any move since reset ends the pulses: 70h uses the most recent acceleration; "
    "without any move since reset there is none, so the pulses end at once":
    "52 01 04 =never #10; velocities 1024; 42; 0.2 s; velocity 17066.66 to 17066.68; 70; at rest",
    'Option; 70h: "motion due to the performance of a move"; 7Bh names only a streamed zero and 78h':
    "1811 stop_after_stream='ignored'; default 10000 100000; 33 =100; idle; 52 01 04 =never #10; velocities 1024; "
    "42; 0.2 s; velocity 17066.66 to 17066.68; 70; 1 s; velocity 17066.66 to 17066.68; 78; "
    "at rest; 33 =30000; 0.5 s; 70; idle; 81: over 0",
    '51h: an alarm is sent if the bytes left go below its value after "3) Begin velocity streaming", not before. '
    '51h: "the alarm will only be sent once", so 7Bh after it sends no second one (1)':
    "52 01 04 =4 #1000; velocities 1024 1024 1024 1024 1024 1024 1024; 42; 0.5 s; says nothing; 7B; "
    "says 52 01 04 00 00 00 04 03 E8; 7B; says nothing; 7B",
    '51h: an alarm is sent if the bytes left go below its value after "3) Begin velocity streaming", not before. '
    '51h: "the alarm will only be sent once", so 7Bh after it sends no second one (2)':
    "52 01 04 =12 #1000; velocities 1024 1024 1024 1024 1024 1024 1024; 42; 0.5 s; "
    "says 52 01 04 00 00 00 0C 03 E8; 7B; says nothing; 7B; says nothing; 7B",
    '51h: an alarm is sent if the bytes left go below its value after "3) Begin velocity streaming", not before. '
    '51h: "the alarm will only be sent once", so 7Bh after it sends no second one (3)':
    "52 01 04 =4 #1000; velocities 1024 1024 1024 1024 1024 1024 1024; says nothing; 7B; says nothing; 7B; "
    "says nothing; 7B",
    'A2h: only moves are reported; A4h: "when the motor arrives at zero velocity", so A5h reports each stop':
    "A1 01; A2 01; A3 01; A5 01; 52 01 04 =65535 #10; velocities 1024 1024 0 1024 1024 1024 0; 42; 1 s; "
    "says A5 00, A5 00; A5 00; velocities 1024 1024 1024 1024 1024 1024 0; 42; 1 s; says A5 00",
})  # fmt: skip
def test_streaming(bench, script):
    play(bench, script)


# Closed loop


@pytest.mark.parametrize("way", [+1, -1])
def test_81h_after_a_correction_has_the_sign_of_the_move(bench, way):
    """X25: positive means short of the end.  Pushed on by 100 counts, the motor corrects by about 620 pulses back."""
    board = tracked(bench)
    motor = board.axes["motor"]
    send(bench, board, 0x18, 1)
    complete(bench, board, 0x35, *i32(way * 4_000))
    motor.encoder.displace(way * 100)
    bench.run(5)
    assert number(bench, board, 0x99) == 0
    assert 24_374 <= way * motor.position <= 24_382 and position(bench, board, 0x81) == 25_000 - way * motor.position


@pytest.mark.parametrize(("ratio", "target", "begins"), [
    ((1, 2), 0x7FFF_FFFF, True), ((1, 2), -0x8000_0000, True), ((1, 1), 0x7FFF_FFFF, True),
    ((1, 1), -0x7FFF_FFFF, True), ((1, 1), -0x8000_0000, False), ((2, 1), 0x3FFF_FFFF, True),
    ((2, 1), 0x4000_0000, False)])  # fmt: skip
@pytest.mark.parametrize("opcode", [0xD4, 0xD5])
def test_closed_loop_moves_are_limited_by_their_motor_pulses(bench, opcode, ratio, target, begins):
    """D4h, D5h: the distance "must be less than or equal to 7FFFFFFFh divided by the ... ratio", starting at 0."""
    board = tracked(bench)
    send_all(bench, board, (0xB0, *words(*ratio)), (opcode, 7, 0x00, *i32(5_000), *i32(AT_ONCE), *i32(target)))
    assert ask(bench, board, 0x91, 7)[12:16] == bytes(i32(target))
    send_all(bench, board, (0xA1, 1), (0x40, 7))
    assert messages(bench, board) == (["a1 00"] if begins else [])


@scripts({
    "D5h is measured from the encoder: from -1 to 7FFFFFFFh the distance is 80000000h, which is too large":
    "tracked; B0 #1 #1; A1 01; D5 07 00 =5000 =at_once =at_once; 2F =-1; 40 07; says nothing; 2F =0; 40 07; "
    "says A1 00",
    "37h beyond 32h bits goes where the move was to end":
    "tracked; 2F =at_once; start 35 =1600; 1 s; 78; 37; idle; 9A: -2147482049",
    "relative closed loop moves there and back end where they began: a relative move of half a pulse and its "
    "reverse are rounded alike, so they end where they began":
    "tracked; B0 #1 #2; 35 =3; idle; at 2; 35 =-3; idle; at 0; 35 =-3; idle; at -2; 35 =3; idle; at 0",
    '19h: it ends moves only; 18h: a correction "always attempts to maintain a zero deadband". 100 counts times K '
    "= 20 are 2,000 pulses/s, as long as the shaft is held":
    "tracked; 18 01; 19 {00|01}; A7 01; jam; displace 100; 2 s; velocity -2000; 99: -100; 8C -> FF; says nothing; "
    "free; 5 s; 99: 0; at rest",
    "18h ends the correction of a jammed motor": "tracked; 18 01; jam; displace 100; 1 s; 18 00; at rest",
    "9Ah has 32 bits: 16 beyond 7FFFFFFFh is -80000000h + 15, and an absolute move to that position moves nothing":
    "tracked; 2F =at_once; 35 =16; idle; 9A: -2147483633; 36 =-2147483633; idle; 9A: -2147483633; 99: 0; at 100; "
    "36 =-2147483617; idle; 9A: -2147483617; 99: 0; at 200; 36 =-2147483633; idle; 9A: -2147483633; 99: 0; at 100",
})  # fmt: skip
def test_closed_loop(bench, script):
    play(bench, script)


@pytest.mark.parametrize(("target", "stops"), [(3, 2), (-3, -2), (5, 3), (-5, -3)])
def test_an_absolute_closed_loop_move_stops_at_the_same_place_from_either_side(bench, target, stops):
    """At two counts per pulse, 3 is 1.5 pulses: rounded away from absolute zero, whichever side the move comes from."""
    found = set()
    for first in (0, 10 * (1 if target > 0 else -1)):
        board = ready(bench, motor={"encoder": {"counts_per_rev": 200, "pulses_per_rev": 100}})
        for command in (*ALL, (0xB0, *words(1, 2))):
            send(bench, board, *command)
        default(bench, board, 5_000, AT_ONCE)
        for place in (first, target):
            complete(bench, board, 0x36, *i32(place))
        found.add(board.axes["motor"].position)
    assert found == {stops}


@pytest.mark.parametrize("ratio", [(0, 1), (1, 0), (0, 0)])
def test_a_ratio_is_of_two_positive_numbers(bench, ratio):
    """B0h: "interpreted as positive sixteen bit numbers"."""
    board = tracked(bench)
    send(bench, board, 0xB0, *words(*ratio))
    assert ask(bench, board, 0x9C)[1:5] == bytes.fromhex("61A8 0FA0")


# An 1810


@scripts({
    'Addendum: "The software used in the 1810 is identical": definitions are kept; only B5h "will be ignored"':
    "tracked 1810; {D4|D5} 07 00 =5000 =at_once =100; 91 07 -> {D4|D5} 07 00 =5000 =at_once =100; 40 07; 1 s; "
    "pulses 0; 2F =1000; 9A: 1000",
    "an 1810 may perform them with an encoder that stays at 0":
    "tracked 1810 options={'encoder_commands':'performed'}; D4 07 00 =5000 =at_once =100; 40 07; idle; 35 =100; "
    "idle; 36 =100; idle; at 1875; 9A: 0; 0F 03 80 01; B5 =1000; output1 is low",
    "B0h: 1 to 1; the encoder stays at 0, and one of 50 teeth is 500 of 25,000 pulses; 19h ends the move there":
    "tracked 1810 options={'encoder_commands':'performed'}; B0 00 01 00 01; 19 01; 33 ={25000|-25000}; 6 s; "
    "at {500|-500}",
    "an 1810 may ignore them all":
    "tracked 1810 options={'encoder_commands':'ignored'}; D4 07 00 =5000 =at_once =100; 2F =1000; "
    "91 07 -> nothing; 9A: 0",
    "an 1811 obeys them whatever an 1810 would":
    "tracked options={'encoder_commands':'{ignored|kept|performed}'}; 35 =100; idle; at 625; 9A: 100",
})  # fmt: skip
def test_an_1810(bench, script):
    play(bench, script)
