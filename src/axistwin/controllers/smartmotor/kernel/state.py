"""The state of a motor's processor: three arrays of numbers, which plain Python and the compiled kernel both use.

`i`: integers, named below.  `v`: the variables and arrays of the language.  The physics keeps its floats in `f`, see
`servo.py`.  The names are indices, as the compiled kernel uses only arrays.
"""

from itertools import count

# Integers.  Positions in encoder counts, trajectory positions and velocities in 1/65536 count (and per sample).
_slots = count()

# Time
SAMPLE = next(_slots)  # number of the last sample done, from 0 at power-up
CLK_ZERO = next(_slots)  # CLK = SAMPLE - CLK_ZERO

# The running program (interpreter.py)
PROGRAM = next(_slots)  # STOPPED, RUNNING, BLOCKED
PC = next(_slots)  # index into `code` of the next statement
STATEMENT = next(_slots)  # number of the statement that was begun last
BUDGET = next(_slots)  # statements left in this sample
STATEMENTS_PER_SAMPLE = next(_slots)
WAIT_UNTIL = next(_slots)  # WAIT: no statement before this sample
DEPTH = next(_slots)  # return addresses on the stack
RETURNS = next(_slots)  # ten of them
for _ in range(9):
    next(_slots)
SWITCHES = next(_slots)  # the value of the SWITCH in progress, at each depth of the stack
for _ in range(10):
    next(_slots)
TWAITING = next(_slots)  # 1: TWAIT holds the program until Bt is 0
PAUSED = next(_slots)  # 1: ! holds the program (BLOCKED) until a serial character arrives
RUN_GIVEN = next(_slots)  # 1: the program was started by RUN, so that RUN? is skipped
C2_CALLED = next(_slots)  # 1: C2 has been called, and RETURNI, STACK or END has not completed the call

# Buffered parameters (4, 13 of the base language)
A, V, P, D, T, E = (next(_slots) for _ in range(6))
AMPS, TH, THD = (next(_slots) for _ in range(3))
KP, KI, KD, KL, KS, KV, KA, KG = (next(_slots) for _ in range(8))
F = next(_slots)  # the function word, chapter 7
SLN, SLP, SOFT_LIMITS = (next(_slots) for _ in range(3))  # chapter 3.2; SOFT_LIMITS: 1 enabled
MFMUL, MFDIV = next(_slots), next(_slots)
RATIO_MUL, RATIO_DIV = next(_slots), next(_slots)  # the ratio, put in force by MFR and MSR
BASE, SIZE = next(_slots), next(_slots)
EPTR, ADDR = next(_slots), next(_slots)
RELATIVE = next(_slots)  # 1: D was assigned later than P
BUFFERED_MODE = next(_slots)  # what G starts: a MODE
BUFFERED_FACTOR = next(_slots)  # variant of that mode: MF1/2/4, MC1/2/4/8

# The tuning in force (F without = copies the buffered one); KS is the number of samples between two errors
TUNING = next(_slots)  # KP KI KD KL KS KV KA KG in force, in this order
for _ in range(7):
    next(_slots)
PID_RATE = next(_slots)  # PID1, 2, 4, 8

# The trajectory in force
MODE = next(_slots)  # a MODE
FACTOR = next(_slots)
COMMANDED = next(_slots)  # 48.16 fixed point, controller's coordinates
VELOCITY = next(_slots)  # trajectory velocity now, 16.16 per sample
TARGET, MAX_VELOCITY, ACCELERATION = (
    next(_slots) for _ in range(3)
)  # P, V and A in force; of a ratio: FACTOR / TARGET
# The shaft: controller's position = DIRECTION * shaft + ORIGIN
SHAFT = next(_slots)  # encoder counts from 0 when the bench was made, in the machine's own direction
DIRECTION, ORIGIN = next(_slots), next(_slots)

# Follow and cam
CTR = next(_slots)  # external counter
MASTER = next(_slots)  # edges of the external encoder that have arrived, in the counting of `axis.master`
MASTER_SEEN = next(_slots)  # number of these edges that the trajectory has followed
MASTER_WAY, MASTER_STEP, MASTER_REM, MASTER_ADD, MASTER_DIV, MASTER_LEFT, MASTER_END = (next(_slots) for _ in range(7))
"""A steady run of the external encoder: +1 or -1; counts per sample, and remainder; samples left; end."""
PREDICTED, PREDICTED_AT = next(_slots), next(_slots)
"""Number of samples for which the edges have been predicted, and the index of the next prediction."""
SHOWN = next(_slots)  # pins whose levels are the external encoder's: 1 A, 2 B
BY_HAND = next(_slots)  # edges in MASTER that have come through the pins
STEP_UP = next(_slots)  # 1: the latest step of the external source was in the positive direction
RESOLUTION = next(_slots)  # edges of four that count: 1, 2, 4 (MF1, MF2, MF4); steps count whole: 4
STEPS = next(_slots)  # 1: pins A and B are step and direction
FOLLOW_REM = next(_slots)  # remainder of MFMUL/MFDIV
CAM_PHASE, CAM_ORIGIN, CX = (next(_slots) for _ in range(3))
CAM_BASE, CAM_SIZE, CAM_DWELL, CAM_F, CAM_FACTOR = (next(_slots) for _ in range(5))  # in force
MC_BASE, MC_SIZE, MC_FACTOR = (next(_slots) for _ in range(3))  # put in force by MCn; waiting for CI
CI_PENDING, CI_SPOILT = next(_slots), next(_slots)  # CI waits for the zero point; CI is invalid until MCn
CAM_TABLE = next(_slots)  # 1: MCn multiplies the table instead of the external encoder's counts

# Host mode
HOST_HEAD, HOST_COUNT, HOST_LEFT = (next(_slots) for _ in range(3))  # ring of points; samples left in this segment
HOST_CLOCK, HOST_STARTED = next(_slots), next(_slots)
HOST_SIZE = next(_slots)  # numbers in the ring
HOST_ARMED = next(_slots)  # 1: the next G starts MD

# Status word W, bit by bit (0 or 1), and the three flags outside W
BT, BR, BL, BI, BW, BE, BH, BO, BX, BP, BM, BD, BU, BS, BA, BK = (next(_slots) for _ in range(16))
BB, BC, BF = (next(_slots) for _ in range(3))
INDEX = next(_slots)  # captured index position, `I`
INDEX_ARMED = next(_slots)  # 1: the next mark is captured; 0 until the captured position has been read
INDEX_FORCED = next(_slots)  # 1: a person holds the index line high

# Protection
LIMIT_C, LIMIT_D = next(_slots), next(_slots)  # 1: the pin has its limit role
ACKNOWLEDGED_PLUS, ACKNOWLEDGED_MINUS = next(_slots), next(_slots)
OVERLOAD = next(_slots)  # samples with too high a current or temperature
STOPPING = next(_slots)  # 1: decelerating because of a fault with F=1
PENDING = next(_slots)  # C1 and C2 calls that wait for the end of a statement: bits CALL_FAULT, CALL_INPUT
FAULT_AGAIN = next(_slots)  # 1: a fault has occurred within C1, which is called again after its return
OBSERVE_INDEX = next(_slots)  # 1: every change of Bx must be reported
INDEX_LOW, INDEX_HIGH, COUNTS_PER_REV = (next(_slots) for _ in range(3))  # index marks around the shaft

# Pins: bit 0 = A … bit 6 = G, 1 = high; analog in 0…1023; window of shaft positions in which no switch changes
PINS = next(_slots)
GO_LEVEL, GO_COUNT = next(_slots), next(_slots)  # pin G as polled and debounced; number of samples with another level
DEBOUNCE = next(_slots)  # samples for which a new level of pin G must last
LATCHES = next(_slots)  # levels set by UA= … UG=, bit by bit; an output pin has this level
GO_PIN = next(_slots)  # 1: pin G has its go role (UG)
BRAKE_PIN = next(_slots)  # the pin that carries the brake's signal (BRKC, BRKG), as its bit of PINS; 0: none
BRAKE_READ = next(_slots)  # 1: an assignment has read that pin (5.1, note 2)
ANALOG = next(_slots)  # seven values
for _ in range(6):
    next(_slots)
WINDOW_LOW, WINDOW_HIGH = next(_slots), next(_slots)

# State of the drive, for the physics
DRIVE = next(_slots)  # a DRIVE
PWM = next(_slots)  # -1023 … 1023, machine's direction
BRAKE = next(_slots)  # 1: static brake engaged
TEMP = next(_slots)  # whole °C, for TEMP
CURRENT = next(_slots)  # 0.01 A, for UIA
BUS_VOLTAGE = next(_slots)  # 0.1 V, for UJA
IDEAL = next(_slots)  # 1: the shaft follows the trajectory exactly

# Memory of the servo law and the physics (servo.py)
INTEGRAL, ERROR_BEFORE, DIFFERENCE, VELOCITY_BEFORE = (next(_slots) for _ in range(4))
CURRENT_SUM, HEAT, HEAT_SAMPLES = (next(_slots) for _ in range(3))  # the filter of CURRENT; (0.01 A)² and their number
SLIPPED = next(_slots)  # counts by which the shaft is beyond SHAFT, the encoder's reading
COUNTS_OF, COUNTS_OUT_OF = next(_slots), next(_slots)  # defective: counts OF for each OUT_OF; 0 of 0: no defect
UNCOUNTED = next(_slots)  # remainder of that count
HOT = next(_slots)  # 1: overheated, and not yet cool enough to move again

LENGTHS = next(_slots)  # LEN, LEN1: bytes waiting
next(_slots)
ARRAY_BASE = next(_slots)  # index of al[0] in `v`

INTS = next(_slots)
"""Number of integers."""

PROGRAM_STATES = STOPPED, RUNNING, BLOCKED = range(3)
"""BLOCKED: a statement is waiting for something outside, such as room in the transmitter."""
NOTHING_YET = -1
"""Instead of the number of a statement: none has begun since the program was started."""
DEPTH_MOST, SWITCH_MOST = 10, 4

MODES = (
    M_OFF, M_BRAKE, M_ERROR, M_HOLD, M_POSITION, M_VELOCITY, M_TORQUE, M_STOP, M_FOLLOW, M_RATIO, M_STEP, M_STEP_RATIO,
    M_CAM, M_HOST,
) = range(14)  # fmt: skip
"""OFF, mode torque brake, error, servo in place, MP, MV, MT, X, MF1/2/4, MFR, MS, MSR, MC…, MD."""
M_RELATIVE = len(MODES)
"""Value reported instead of M_POSITION while D gave the target."""
NO_POWER = -1
"""Mode reported without power."""

CALL_GOSUB, CALL_FAULT, CALL_INPUT = 0, 1, 2
"""Why a return address lies on the stack: GOSUB, a fault's call of C1, pin G's call of C2."""

DRIVES = DRIVE_OPEN, DRIVE_SHORTED, DRIVE_ON = range(3)
"""Windings open (the shaft coasts), shorted (mode torque brake), driven by PWM."""

STATUS = (BT, BR, BL, BI, BW, BE, BH, BO, BX, BP, BM, BD, BU, BS, BA, BK)
"""The status word W from bit 0 on."""

USER_PINS = "ABCDEFG"
"""The user pins, from bit 0 of PINS on."""

# Variables `v`: a…z, aa…zz, aaa…zzz, then (with `array_overlay=False`) al[] by itself.
LETTERS, DOUBLES, TRIPLES, ALONE = 0, 26, 52, 78
HIDDEN = ALONE + 51
HIDDEN_MOST = 16
VARIABLES = HIDDEN + HIDDEN_MOST
"""al[] lies over aa…zz and aaa…yyy (ARRAY_BASE = DOUBLES), or by itself (ARRAY_BASE = ALONE).

HIDDEN: values fetched from outside (GETCHR, AINpc, DINpc…) for the statement in hand."""
LONGS, WORDS, BYTES = 51, 102, 204
