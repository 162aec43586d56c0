"""The state of a motor's processor: three arrays of numbers, which plain Python and the compiled kernel both use.

`i`: integers, named below.  `v`: the variables and arrays of the language.  The physics keeps its floats in `f`, see
`servo.py`.  The names are indices, as the compiled kernel uses only arrays.
"""

from itertools import count, islice

# Positions are in counts, trajectory positions in 1/65536 count, and velocities in 1/65536 count/sample.
_slots = count()

# Time
SAMPLE = next(_slots)  # Number of the last computed sample; the number is 0 at power-up.
CLK_ZERO = next(_slots)  # Value of SAMPLE when the counter CLK was 0, so that CLK = SAMPLE - CLK_ZERO.

# State of the running program
(
    PROGRAM,  # State of the program: STOPPED, RUNNING or BLOCKED.
    PC,  # Program counter: index of the next statement in the array `code`.
    STATEMENT,  # Number of the program statement that is being executed or was executed last.
    BUDGET,  # Number of statements that the program may still execute in the present servo sample.
    STATEMENTS_PER_SAMPLE,
    WAIT_UNTIL,  # Number of the sample at which a WAIT ends.
    DEPTH,  # Number of return addresses on the stack.
) = islice(_slots, 7)
RETURNS, *_ = islice(_slots, 10)  # Stack of ten return addresses.
SWITCHES, *_ = islice(_slots, 11)  # Values that SWITCH compares: one for the main program, and one for each subroutine.
(
    TWAITING,  # 1 while the command TWAIT pauses the program until the trajectory ends (flag Bt = 0).
    PAUSED,  # 1 while the command ! pauses the program; the pause ends when a serial character arrives.
    RUN_GIVEN,  # 1 if the command RUN has started the program; RUN? then has no effect.
    C2_CALLED,  # 1 while a call of C2 is in progress; RETURNI, STACK or END ends the call.
) = islice(_slots, 4)

# Buffered parameters, see chapters 4 and 13 of the guide to the base language
A, V, P, D, T, E = islice(_slots, 6)
AMPS, TH, THD = islice(_slots, 3)
KP, KI, KD, KL, KS, KV, KA, KG = islice(_slots, 8)
F = next(_slots)  # The bits that the command F= has set (manual, chapter 7).
SLN, SLP, SOFT_LIMITS = islice(_slots, 3)  # SOFT_LIMITS is 1 while the software limits are enabled.
MFMUL, MFDIV = next(_slots), next(_slots)
RATIO_MUL, RATIO_DIV = next(_slots), next(_slots)  # Values of MFMUL and MFDIV at the last command MFR or MSR.
BASE, SIZE = next(_slots), next(_slots)
EPTR, ADDR = next(_slots), next(_slots)
(
    RELATIVE,  # 1: the next position move is relative, by the distance D.  0: the move goes to the position P.
    BUFFERED_MODE,  # The mode that the next command G starts.
    BUFFERED_FACTOR,  # Number n of the mode MFn or MCn that the next command G starts, e.g. 4 for MF4.
) = islice(_slots, 3)

# The command F copies the buffered gains to TUNING.
TUNING, *_ = islice(_slots, 8)  # Gains that the servo uses, in the order KP KI KD KL KS KV KA KG.
PID_RATE = next(_slots)  # Number of samples between two servo updates, set by PIDn: 1, 2, 4 or 8.

# State of the trajectory that the command G has started
(
    MODE,  # One of MODES.
    FACTOR,
    COMMANDED,  # Commanded position in the controller's coordinates, as a 48.16 fixed-point number.
    VELOCITY,  # Present trajectory velocity in counts per sample, as a 16.16 fixed-point number.
) = islice(_slots, 4)
# TARGET is the position at which a position move ends.
# In the modes MFR and MSR, the motor moves by FACTOR / TARGET counts for each count of the counter CTR.
TARGET, MAX_VELOCITY, ACCELERATION = islice(_slots, 3)
# The position that the controller reports is DIRECTION * SHAFT + ORIGIN.
SHAFT = next(_slots)  # Shaft position in encoder counts since the start of the simulation.
DIRECTION, ORIGIN = next(_slots), next(_slots)

# Values for the modes that follow the external encoder, such as cam mode
(
    CTR,  # External counter, which the program can read as CTR.
    MASTER,  # Number of edges received from the external encoder.
    MASTER_SEEN,  # External encoder counts that have already been added to CTR.
) = islice(_slots, 3)
MASTER_WAY, MASTER_STEP, MASTER_REM, MASTER_ADD, MASTER_DIV, MASTER_LEFT, MASTER_END = islice(_slots, 7)
"""A steady run of the external encoder: +1 or -1; counts per sample, and remainder; samples left; end."""
PREDICTED, PREDICTED_AT = next(_slots), next(_slots)
"""Number of samples for which the edges have been predicted, and the index of the next prediction."""
(
    SHOWN,  # Pins that the external encoder drives: 1 is pin A, 2 is pin B, 3 is both pins.
    PIN_EDGES,  # Counts on pins A and B from other sources than the external encoder, e.g. from a wire.
    STEP_UP,  # 1 if the latest step of the external source was in the positive direction.
    RESOLUTION,  # Change of CTR after four edges or four steps: 1 in mode MF1, 2 in mode MF2, 4 in other modes.
    STEPS,  # 1 if pins A and B are step and direction inputs.
    FOLLOW_REM,  # Remainder of the division by MFDIV in the modes MFR and MSR.
) = islice(_slots, 6)
CAM_PHASE, CAM_ORIGIN, CX = islice(_slots, 3)
CAM_BASE, CAM_SIZE, CAM_DWELL, CAM_F, CAM_FACTOR = islice(_slots, 5)  # Cam parameters that are in use.
MC_BASE, MC_SIZE, MC_FACTOR = islice(_slots, 3)  # Cam parameters that the next command CI activates.
# CI_PENDING is 1 while the command CI waits for the zero point of the cam.
# CI_SPOILT is 1 if a cam parameter was changed while a command CI was waiting.
# While CI_SPOILT is 1, the command CI has no effect.  The next command MCn sets CI_SPOILT to 0.
CI_PENDING, CI_SPOILT = next(_slots), next(_slots)
# CAM_TABLE is 1 if the factor n of the command MCn (e.g. 4 in MC4) multiplies the entries of the cam table.
# CAM_TABLE is 0 if the factor n of the command MCn (e.g. 4 in MC4) multiplies the counts of the external encoder.
CAM_TABLE = next(_slots)

# Host mode
# HOST_HEAD is the index of the first trajectory point in the buffer of host mode.
# HOST_COUNT is the number of trajectory points in the buffer of host mode.
# HOST_LEFT is the number of samples left in the present segment of the trajectory.
HOST_HEAD, HOST_COUNT, HOST_LEFT = islice(_slots, 3)
HOST_CLOCK, HOST_STARTED = next(_slots), next(_slots)
HOST_SIZE = next(_slots)  # Number of integers in the buffer of host mode: two for each trajectory point.
HOST_ARMED = next(_slots)  # 1 if the next command G starts host mode (MD).

# Each flag is stored as an integer, 0 or 1.
# The first 16 flags are the bits of the status word W.
BT, BR, BL, BI, BW, BE, BH, BO, BX, BP, BM, BD, BU, BS, BA, BK = islice(_slots, 16)
BB, BC, BF = islice(_slots, 3)
(
    INDEX,  # Captured index position, the variable `I`.
    INDEX_ARMED,  # 1: the next index mark captures the position.  0: the captured position has not been read yet.
    INDEX_FORCED,  # 1 while an external source forces the index line high.
) = islice(_slots, 3)

# Protection
# LIMIT_C is 1 if pin C is a limit input.  LIMIT_D is 1 if pin D is a limit input.
LIMIT_C, LIMIT_D = next(_slots), next(_slots)
ACKNOWLEDGED_PLUS, ACKNOWLEDGED_MINUS = next(_slots), next(_slots)
(
    OVERLOAD,  # Number of consecutive samples in which the current or the temperature was too high.
    STOPPING,  # 1 while the motor decelerates after a fault (only if F=1 is set).
    PENDING,  # Pending calls of C1 (bit CALL_FAULT) and C2 (bit CALL_INPUT).
    FAULT_AGAIN,  # 1 if a fault has occurred during the fault routine C1; C1 is then called a second time.
    OBSERVE_INDEX,  # 1 if an observer of the index line, e.g. a trace, needs each change of the flag Bx.
) = islice(_slots, 5)
# INDEX_LOW and INDEX_HIGH are the positions of the nearest index marks below and above the shaft position.
INDEX_LOW, INDEX_HIGH, COUNTS_PER_REV = islice(_slots, 3)

# Levels of the user pins, from bit 0 (pin A) to bit 6 (pin G)
PINS = next(_slots)
# GO_LEVEL is the debounced level of pin G.
# GO_COUNT is the number of consecutive samples in which the level of pin G differs from GO_LEVEL.
GO_LEVEL, GO_COUNT = next(_slots), next(_slots)
(
    DEBOUNCE,  # Debounce time of pin G: number of servo samples after which a new level is accepted.
    LATCHES,  # Levels that the commands UA= to UG= have set; bit 0 is pin A, and bit 6 is pin G.
    GO_PIN,  # 1 if pin G is the go input: a falling edge has the effect of the command G.
    BRAKE_PIN,  # Bit mask of the pin that carries the brake signal (BRKC, BRKG), or 0.
    BRAKE_READ,  # 1 after an assignment has read the brake pin, e.g. a=UG (manual, section 5.1, note 2).
) = islice(_slots, 5)
ANALOG, *_ = islice(_slots, 7)  # Analog values of pins A to G, 0 to 1023.
# No switch changes its level while the shaft is between WINDOW_LOW and WINDOW_HIGH.
WINDOW_LOW, WINDOW_HIGH = next(_slots), next(_slots)

# State of the drive, which the physical model reads and updates
(
    DRIVE,  # State of the amplifier: DRIVE_OPEN, DRIVE_SHORTED or DRIVE_ON.
    PWM,  # Output of the servo law, -1023 to 1023; a positive value increases SHAFT.
    BRAKE,  # 1 if the static brake is engaged.
    TEMP,  # Motor temperature in whole °C, reported as TEMP.
    CURRENT,  # Current in 0.01 A, reported as UIA.
    BUS_VOLTAGE,  # Supply voltage in 0.1 V, reported as UJA.
    IDEAL,  # 1 for an ideal motor, whose shaft follows the trajectory exactly.
) = islice(_slots, 7)

# Internal state of the servo law and of the physical model
INTEGRAL, ERROR_BEFORE, DIFFERENCE, VELOCITY_BEFORE = islice(_slots, 4)
# CURRENT_SUM / 16 is the filtered current in units of 0.01 A.
# HEAT is the sum of the squared currents of HEAT_SAMPLES samples, in units of (0.01 A)².
CURRENT_SUM, HEAT, HEAT_SAMPLES = islice(_slots, 3)
SLIPPED = next(_slots)  # The real shaft position is SHAFT + SLIPPED, in counts.
# A defective encoder reports COUNTS_OF counts instead of COUNTS_OUT_OF counts, e.g. 9 instead of 10.
# COUNTS_OF and COUNTS_OUT_OF are both 0 if no defect of the encoder is simulated.
COUNTS_OF, COUNTS_OUT_OF = next(_slots), next(_slots)
UNCOUNTED = next(_slots)  # Remainder of the division by COUNTS_OUT_OF in the simulation of a defective encoder.
ENERGY = next(_slots)  # Energy in nJ that the windings have taken since the start of the simulation.
HOT = next(_slots)  # 1 if the motor was overheated and is still too hot to move.

# Number of received bytes that GETCHR has not read yet, for each serial channel (LEN, LEN1).
LENGTHS, *_ = islice(_slots, 2)
ARRAY_BASE = next(_slots)  # Index of the array element al[0] in the array `v`.

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

# First index of each group of variables in the array `v`
# The groups of variables are a…z, aa…zz and aaa…zzz.  al[] is a fourth group if al[] has its own memory.
LETTERS, DOUBLES, TRIPLES, ALONE = 0, 26, 52, 78
HIDDEN = ALONE + 51
HIDDEN_MOST = 16
VARIABLES = HIDDEN + HIDDEN_MOST
"""al[] shares the memory of aa…zz and aaa…yyy (ARRAY_BASE = DOUBLES), or is separate (ARRAY_BASE = ALONE).

HIDDEN: values fetched from outside (GETCHR, AINpc, DINpc…) for the statement in hand."""
LONGS, WORDS, BYTES = 51, 102, 204
