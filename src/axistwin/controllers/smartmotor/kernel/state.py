"""The state of a motor's processor: three arrays of numbers, which plain Python and the compiled kernel both use.

`i`: integers, named below.  `v`: the variables and arrays of the language.  The physics keeps its floats in `f`, see
`servo.py`.  The names are indices, as the compiled kernel uses only arrays.
"""

from itertools import count, islice

# Integers: positions in encoder counts; trajectory positions and velocities in 1/65536 count (per sample)
_slots = count()

# Time
SAMPLE = next(_slots)  # number of the last computed sample, from 0 at power-up
CLK_ZERO = next(_slots)  # CLK = SAMPLE - CLK_ZERO

# The running program (interpreter.py)
(
    PROGRAM,  # STOPPED, RUNNING, BLOCKED
    PC,  # index into `code` of the next statement
    STATEMENT,  # number of the statement that was begun last
    BUDGET,  # statements left in this sample
    STATEMENTS_PER_SAMPLE,
    WAIT_UNTIL,  # WAIT: no statement before this sample
    DEPTH,  # number of return addresses on the stack
) = islice(_slots, 7)
RETURNS, *_ = islice(_slots, 10)  # ten of them
SWITCHES, *_ = islice(_slots, 11)  # the value of the SWITCH in progress, at each depth of the stack
(
    TWAITING,  # 1: TWAIT holds the program until Bt is 0
    PAUSED,  # 1: ! holds the program (BLOCKED) until a serial character arrives
    RUN_GIVEN,  # 1: the program was started by RUN, so that RUN? is skipped
    C2_CALLED,  # 1: C2 has been called, and RETURNI, STACK or END has not completed the call
) = islice(_slots, 4)

# Buffered parameters (4, 13 of the base language)
A, V, P, D, T, E = islice(_slots, 6)
AMPS, TH, THD = islice(_slots, 3)
KP, KI, KD, KL, KS, KV, KA, KG = islice(_slots, 8)
F = next(_slots)  # the option bits set by F= (chapter 7)
SLN, SLP, SOFT_LIMITS = islice(_slots, 3)  # chapter 3.2; SOFT_LIMITS: 1 enabled
MFMUL, MFDIV = next(_slots), next(_slots)
RATIO_MUL, RATIO_DIV = next(_slots), next(_slots)  # the ratio, put in force by MFR and MSR
BASE, SIZE = next(_slots), next(_slots)
EPTR, ADDR = next(_slots), next(_slots)
(
    RELATIVE,  # 1: D was assigned later than P
    BUFFERED_MODE,  # the mode that the next G starts
    BUFFERED_FACTOR,  # variant of BUFFERED_MODE: MF1/2/4, MC1/2/4/8
) = islice(_slots, 3)

# The tuning in force, which the command F copies from the buffered one; KS: number of samples between two errors
TUNING, *_ = islice(_slots, 8)  # KP KI KD KL KS KV KA KG in force, in this order
PID_RATE = next(_slots)  # PID1, 2, 4, 8

# The trajectory that G has started
(
    MODE,  # a MODE
    FACTOR,
    COMMANDED,  # 48.16 fixed point, controller's coordinates
    VELOCITY,  # trajectory velocity now, 16.16 per sample
) = islice(_slots, 4)
TARGET, MAX_VELOCITY, ACCELERATION = islice(_slots, 3)  # P, V and A in force; a ratio is FACTOR / TARGET
# Position of the shaft: controller's position = DIRECTION * shaft + ORIGIN
SHAFT = next(_slots)  # shaft position in counts since the bench was made, machine's direction
DIRECTION, ORIGIN = next(_slots), next(_slots)

# Modes follow and cam
(
    CTR,  # external counter, which the program can read as CTR
    MASTER,  # edges received from the external encoder, counted as in `axis.master`
    MASTER_SEEN,  # number of external encoder edges that the trajectory has followed
) = islice(_slots, 3)
MASTER_WAY, MASTER_STEP, MASTER_REM, MASTER_ADD, MASTER_DIV, MASTER_LEFT, MASTER_END = islice(_slots, 7)
"""A steady run of the external encoder: +1 or -1; counts per sample, and remainder; samples left; end."""
PREDICTED, PREDICTED_AT = next(_slots), next(_slots)
"""Number of samples for which the edges have been predicted, and the index of the next prediction."""
(
    SHOWN,  # pins with the level of the external encoder: 1 for A, 2 for B, 3 for both
    PIN_EDGES,  # edges in MASTER that come from levels driven on the pins
    STEP_UP,  # 1: the latest step of the external source was in the positive direction
    RESOLUTION,  # counted edges per encoder period: 1, 2, 4 (MF1, MF2, MF4); for steps 4
    STEPS,  # 1: pins A and B are step and direction
    FOLLOW_REM,  # remainder of MFMUL/MFDIV
) = islice(_slots, 6)
CAM_PHASE, CAM_ORIGIN, CX = islice(_slots, 3)
CAM_BASE, CAM_SIZE, CAM_DWELL, CAM_F, CAM_FACTOR = islice(_slots, 5)  # in force
MC_BASE, MC_SIZE, MC_FACTOR = islice(_slots, 3)  # set by MCn, put in force by CI
CI_PENDING, CI_SPOILT = next(_slots), next(_slots)  # CI waits for the zero point; CI is invalid until MCn
CAM_TABLE = next(_slots)  # 1: MCn multiplies the table instead of the external encoder's counts

# Host mode
HOST_HEAD, HOST_COUNT, HOST_LEFT = islice(_slots, 3)  # ring of points: first, number; samples left in a segment
HOST_CLOCK, HOST_STARTED = next(_slots), next(_slots)
HOST_SIZE = next(_slots)  # capacity of the ring buffer, in numbers
HOST_ARMED = next(_slots)  # 1: the next G starts MD

# Status word W, bit by bit (0 or 1), and the three flags outside W
BT, BR, BL, BI, BW, BE, BH, BO, BX, BP, BM, BD, BU, BS, BA, BK = islice(_slots, 16)
BB, BC, BF = islice(_slots, 3)
(
    INDEX,  # captured index position, `I`
    INDEX_ARMED,  # 1: the next mark is captured; 0 until the captured position has been read
    INDEX_FORCED,  # 1: the index line is forced high from outside
) = islice(_slots, 3)

# Protection
LIMIT_C, LIMIT_D = next(_slots), next(_slots)  # 1: pin C, or D, is a limit switch input
ACKNOWLEDGED_PLUS, ACKNOWLEDGED_MINUS = next(_slots), next(_slots)
(
    OVERLOAD,  # samples with too high a current or temperature
    STOPPING,  # 1: decelerating because of a fault with F=1
    PENDING,  # C1 and C2 calls that wait for the end of a statement: bits CALL_FAULT, CALL_INPUT
    FAULT_AGAIN,  # 1: a fault has occurred within C1, which is called again after its return
    OBSERVE_INDEX,  # 1: every change of Bx must be reported
) = islice(_slots, 5)
INDEX_LOW, INDEX_HIGH, COUNTS_PER_REV = islice(_slots, 3)  # index marks around the shaft

# Pins: bit 0 = A … bit 6 = G, 1 = high; analog in 0…1023; window of shaft positions in which no switch changes
PINS = next(_slots)
GO_LEVEL, GO_COUNT = next(_slots), next(_slots)  # pin G as polled and debounced; number of samples with another level
(
    DEBOUNCE,  # samples for which a new level of pin G must last
    LATCHES,  # levels set by UA= … UG=, bit by bit; an output pin has this level
    GO_PIN,  # 1: a falling edge of pin G acts as the command G (UG)
    BRAKE_PIN,  # the pin that carries the brake's signal (BRKC, BRKG), as its bit of PINS; 0: none
    BRAKE_READ,  # 1: an assignment has read BRAKE_PIN (5.1, note 2)
) = islice(_slots, 5)
ANALOG, *_ = islice(_slots, 7)  # seven values
WINDOW_LOW, WINDOW_HIGH = next(_slots), next(_slots)

# State of the drive, for the physics
(
    DRIVE,  # a DRIVE
    PWM,  # -1023 … 1023, machine's direction
    BRAKE,  # 1: static brake engaged
    TEMP,  # whole °C, for TEMP
    CURRENT,  # 0.01 A, for UIA
    BUS_VOLTAGE,  # 0.1 V, for UJA
    IDEAL,  # 1: the shaft follows the trajectory exactly
) = islice(_slots, 7)

# Memory of the servo law and the physics (servo.py)
INTEGRAL, ERROR_BEFORE, DIFFERENCE, VELOCITY_BEFORE = islice(_slots, 4)
CURRENT_SUM, HEAT, HEAT_SAMPLES = islice(_slots, 3)  # filter of CURRENT; sum of (0.01 A)², number of summands
SLIPPED = next(_slots)  # difference in counts between the encoder's reading (SHAFT) and the real shaft position
COUNTS_OF, COUNTS_OUT_OF = next(_slots), next(_slots)  # defective encoder: OF counts per OUT_OF; 0 of 0: no defect
UNCOUNTED = next(_slots)  # remainder of a defective encoder's count
ENERGY = next(_slots)  # nJ taken from the supply by the windings since the bench was made
HOT = next(_slots)  # 1: overheated, and not yet cool enough to move again

LENGTHS, *_ = islice(_slots, 2)  # LEN, LEN1: received bytes that GETCHR has not read
ARRAY_BASE = next(_slots)  # index of al[0] in `v`

INTS = next(_slots)

STOPPED, RUNNING, BLOCKED = range(3)
"""States of the program.  BLOCKED: a statement waits for an external event, such as room in the transmitter."""
NOTHING_YET = -1
"""Value in place of a statement number before the first statement of a started program."""
DEPTH_MOST, SWITCH_MOST = 10, 4

MODES = (
    M_OFF, M_BRAKE, M_ERROR, M_HOLD, M_POSITION, M_VELOCITY, M_TORQUE, M_STOP, M_FOLLOW, M_RATIO, M_STEP, M_STEP_RATIO,
    M_CAM, M_HOST,
) = range(14)  # fmt: skip
"""OFF, mode torque brake, error, servo in place, MP, MV, MT, X, MF1/2/4, MFR, MS, MSR, MC…, MD."""
M_RELATIVE = len(MODES)
"""Value reported instead of M_POSITION while D gave the target."""
NO_POWER = -1
"""Mode that is reported while the power is off."""

CALL_GOSUB, CALL_FAULT, CALL_INPUT = 0, 1, 2
"""The reason for a return address on the stack: GOSUB, a call of C1 by a fault, a call of C2 by pin G."""

DRIVE_OPEN, DRIVE_SHORTED, DRIVE_ON = range(3)
"""Windings open (the shaft coasts), shorted (mode torque brake), driven by PWM."""

STATUS = (BT, BR, BL, BI, BW, BE, BH, BO, BX, BP, BM, BD, BU, BS, BA, BK)
"""The status word W from bit 0 on."""

USER_PINS = "ABCDEFG"
"""The user pins, from bit 0 of PINS on."""

# Variables `v`: a…z, aa…zz, aaa…zzz, then al[], if `array_overlay=False`.
LETTERS, DOUBLES, TRIPLES, ALONE = 0, 26, 52, 78
HIDDEN = ALONE + 51
HIDDEN_MOST = 16
VARIABLES = HIDDEN + HIDDEN_MOST
"""al[] shares the memory of aa…zz and aaa…yyy (ARRAY_BASE = DOUBLES), or is separate (ARRAY_BASE = ALONE).

HIDDEN: values fetched from outside (GETCHR, AINpc, DINpc…) for the statement in hand."""
LONGS, WORDS, BYTES = 51, 102, 204
