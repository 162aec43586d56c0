"""The state of a motor's processor: three arrays of numbers, which plain Python and the compiled kernel both use.

`i`: integers, named below.  `v`: the variables and arrays of the language.  The physics keeps its floats in `f`, see
`servo.py`.  The names are indices, as the compiled kernel uses only arrays.
"""

from itertools import count, islice

# Unless stated otherwise, positions are in encoder counts, and velocities in 1/65536 count per servo sample.
_slots = count()

# Time
SAMPLE = next(_slots)  # Number of the last computed servo sample; the number is 0 at power-up.
CLK_ZERO = next(_slots)  # Offset of the counter CLK: the value of CLK is SAMPLE minus CLK_ZERO.

# State of the running program
(
    PROGRAM,  # State of the motor's program: stopped, running or blocked.
    PC,  # Position of the next statement in the compiled program.
    STATEMENT,  # Number of the program statement that is being executed or was executed last.
    BUDGET,  # Number of statements that the program may still execute before the next servo cycle.
    STATEMENTS_PER_SAMPLE,
    WAIT_UNTIL,  # Number of the servo sample at which the command WAIT ends.
    DEPTH,  # Number of return addresses on the subroutine stack.
) = islice(_slots, 7)
RETURNS, *_ = islice(_slots, 10)  # Return addresses of up to ten nested subroutine calls.
# Value of the latest command SWITCH, stored separately for the main program and each of ten subroutine levels.
SWITCHES, *_ = islice(_slots, 11)
(
    TWAITING,  # 1 while the command TWAIT pauses the program until the motor's trajectory ends.
    PAUSED,  # Flag: 1 while the program waits for a serial character because of the command `!`.
    RUN_GIVEN,  # 1 if the command RUN has started the program; 0 if the program has started at power-up.
    C2_CALLED,  # Flag: 1 while the interrupt subroutine C2 runs, i.e. until RETURNI, STACK or END.
    C2_PLACE,  # Index of the label C2 in the code, or -1.
) = islice(_slots, 5)

# Parameters that commands set, e.g. A=100 (chapters 4 and 13 of the guide to the base language)
A, V, P, D, T, E = islice(_slots, 6)
AMPS, TH, THD = islice(_slots, 3)
KP, KI, KD, KL, KS, KV, KA, KG = islice(_slots, 8)
F = next(_slots)  # Value that the command F= has set; each bit enables a function (manual, chapter 7).
SLN, SLP, SOFT_LIMITS = islice(_slots, 3)  # SOFT_LIMITS is 1 while the software limits are enabled.
MFMUL, MFDIV = next(_slots), next(_slots)
# The commands MFR and MSR copy the gear ratio: MFMUL to RATIO_MUL, and MFDIV to RATIO_DIV.
RATIO_MUL, RATIO_DIV = next(_slots), next(_slots)
BASE, SIZE = next(_slots), next(_slots)
EPTR, ADDR = next(_slots), next(_slots)
(
    RELATIVE,  # 1 if the next position move is relative (distance D); 0 if the move is absolute (position P).
    BUFFERED_MODE,  # Motion mode, e.g. velocity mode, that the next command G starts.
    BUFFERED_FACTOR,  # Number n of the mode MFn or MCn that the next command G starts, e.g. 4 for MF4.
    AFTER_STOP,  # 1 after S and X, until G or a mode: P= or D= then selects position mode for the next G.
) = islice(_slots, 4)

# The command F activates the gains of the servo; the active gains are stored in the order KP KI KD KL KS KV KA KG.
TUNING, *_ = islice(_slots, 8)
PID_RATE = next(_slots)  # Update interval of the servo, 1, 2, 4 or 8 samples; e.g. the command PID4 sets 4 samples.

# State of the motion that the command G has started
(
    MODE,
    FACTOR,
    COMMANDED,  # Commanded position in the controller's coordinates, in 1/65536 count.
    VELOCITY,  # Present velocity of the trajectory, in 1/65536 count per servo sample.
) = islice(_slots, 4)
# TARGET is the end position of a position move, in counts.
# In the modes MFR and MSR, the motor moves by FACTOR / TARGET counts for each count of the counter CTR.
TARGET, MAX_VELOCITY, ACCELERATION = islice(_slots, 3)
# The position that the controller reports is DIRECTION * SHAFT + ORIGIN, in encoder counts.
SHAFT = next(_slots)  # Shaft position in encoder counts, relative to the position at the start of the simulation.
DIRECTION, ORIGIN = next(_slots), next(_slots)

# State of the motion modes that follow the external encoder, such as cam mode
(
    CTR,  # Counter of the external encoder, which the program reads as the variable CTR.
    MASTER,  # Edges from the external encoder: forward edges minus backward edges.
    MASTER_SEEN,  # Counts of the external encoder that have already been added to the counter CTR.
) = islice(_slots, 3)
MASTER_WAY, MASTER_STEP, MASTER_REM, MASTER_ADD, MASTER_DIV, MASTER_LEFT, MASTER_END = islice(_slots, 7)
"""A steady run of the external encoder: +1 or -1; counts per sample, and remainder; samples left; end."""
PREDICTED, PREDICTED_AT = next(_slots), next(_slots)
"""Number of samples for which the edges have been predicted, and the index of the next prediction."""
(
    SHOWN,  # Pins whose level the external encoder sets: 1 for pin A, 2 for pin B, 3 for both pins.
    PIN_EDGES,  # Edges from pulse sources that are wired to pins A and B: forward edges minus backward edges.
    STEP_UP,  # 1 if the latest pulse of an external step source was a step in the positive direction.
    RESOLUTION,  # Counts of the counter CTR per encoder period (four edges): 1 in mode MF1, 2 in MF2, otherwise 4.
    STEPS,  # 1 if pins A and B are step and direction inputs; 0 if the pins are encoder inputs.
    FOLLOW_REM,  # Fraction of a count that mode MFR or MSR carries over to the next servo sample.
) = islice(_slots, 6)
CAM_PHASE, CAM_ORIGIN, CX = islice(_slots, 3)
CAM_BASE, CAM_SIZE, CAM_DWELL, CAM_F, CAM_FACTOR = islice(_slots, 5)  # Parameters of the active cam.
MC_BASE, MC_SIZE, MC_FACTOR = islice(_slots, 3)  # Cam parameters that the next command G or CI activates.
# CI_PENDING is 1 from the command CI until the cam passes its zero point.
# CI_SPOILT is 1 if a later change of a cam parameter has cancelled the command CI.
# While CI_SPOILT is 1, the motor ignores the command CI; the command MCn, e.g. MC4, sets CI_SPOILT to 0.
CI_PENDING, CI_SPOILT = next(_slots), next(_slots)
# The cam factor, e.g. 4 in MC4, multiplies either the cam table (CAM_TABLE = 1) or the external counts (CAM_TABLE = 0).
CAM_TABLE = next(_slots)

# Host mode
# HOST_HEAD is the index of the oldest trajectory point in the buffer of host mode.
# HOST_COUNT is the number of stored trajectory points, which the host has sent for host mode.
# HOST_LEFT is the number of servo samples until the end of the present trajectory segment in host mode.
HOST_HEAD, HOST_COUNT, HOST_LEFT = islice(_slots, 3)
HOST_CLOCK, HOST_STARTED = next(_slots), next(_slots)
HOST_SIZE = next(_slots)  # Number of integers in the array of trajectory points (host mode): two integers per point.
# HOST_ARMED is 1 if the next command G starts host mode; otherwise, HOST_ARMED is 0.
HOST_ARMED = next(_slots)
HOST_FLAGS = next(_slots)  # Errors of host mode since the last MD, as Q reports them: underflow, overflow, clock.

# Each status flag of the motor, e.g. Bt (trajectory in progress), is stored as the integer 0 or 1.
BT, BR, BL, BI, BW, BE, BH, BO, BX, BP, BM, BD, BU, BS, BA, BK = islice(_slots, 16)
BB, BC, BF = islice(_slots, 3)
(
    INDEX,  # Captured position of the index mark, which the program reads as the variable I.
    INDEX_ARMED,  # Flag: 1 if the motor will capture the shaft position at the next index mark of the encoder.
    INDEX_FORCED,  # Flag: 1 while an external signal holds the index input of the motor high.
) = islice(_slots, 3)

# Protection
# LIMIT_C is 1 if pin C is a limit input.  LIMIT_D is 1 if pin D is a limit input.
LIMIT_C, LIMIT_D = next(_slots), next(_slots)
ACKNOWLEDGED_PLUS, ACKNOWLEDGED_MINUS = next(_slots), next(_slots)
(
    OVERLOAD,  # Number of consecutive servo samples in which the motor current or the temperature was too high.
    STOPPING,  # 1 while the motor decelerates after a fault; the command F=1 enables this deceleration.
    PENDING,  # Subroutines to be called next: 0 none, 1 C1 (after a fault), 2 C2 (after an input edge), 3 both.
    FAULT_AGAIN,  # 1 if a fault has occurred during the fault subroutine C1, so that C1 must be called again.
    OBSERVE_INDEX,  # 1 if each change of the index signal must be reported, e.g. to the oscilloscope.
) = islice(_slots, 5)
# INDEX_LOW and INDEX_HIGH are the positions of the nearest index marks below and above the shaft position.
INDEX_LOW, INDEX_HIGH, COUNTS_PER_REV = islice(_slots, 3)

PINS = next(_slots)
# GO_LEVEL is the debounced level of pin G.
# GO_COUNT is the number of consecutive servo samples in which pin G has differed from its debounced level.
GO_LEVEL, GO_COUNT = next(_slots), next(_slots)
(
    DEBOUNCE,  # Debounce time of pin G, in servo samples.
    LATCHES,  # Output levels set by the commands UA= to UG=, from bit 0 (pin A) to bit 6 (pin G).
    GO_PIN,  # 1 if a falling edge of pin G starts a motion, as the command G does.
    BRAKE_PIN,  # Bit mask of the pin that the command BRKC or BRKG has selected for the brake signal; 0 for no pin.
    BRAKE_READ,  # Flag: 1 if a statement, e.g. a=UG, has read the brake pin and thereby made this pin an input.
) = islice(_slots, 5)
ANALOG, *_ = islice(_slots, 7)  # Analog readings of the pins A to G, from 0 to 1023.
# No switch of the axis changes its level while the shaft is between WINDOW_LOW and WINDOW_HIGH.
WINDOW_LOW, WINDOW_HIGH = next(_slots), next(_slots)

# State and measured values of the motor's amplifier, e.g. current and supply voltage
(
    DRIVE,  # State of the motor windings: open, shorted, or driven by the amplifier.
    PWM,  # PWM value of the amplifier, -1023 to 1023; a positive value increases the encoder position.
    BRAKE,  # 1 while the static brake of the motor is engaged.
    TEMP,  # Motor temperature in whole °C, which the program reads as the variable TEMP.
    CURRENT,  # Motor current in units of 0.01 A, which the program reads as the variable UIA.
    BUS_VOLTAGE,  # Supply voltage in units of 0.1 V, which the program reads as the variable UJA.
    IDEAL,  # Flag: 1 if the simulated shaft follows the trajectory exactly; 0 if inertia and friction are simulated.
) = islice(_slots, 7)

# Internal state of the servo law and of the physical model
INTEGRAL, ERROR_BEFORE, DIFFERENCE, VELOCITY_BEFORE = islice(_slots, 4)
# CURRENT_SUM / 16 is the filtered motor current in units of 0.01 A.
# HEAT is the sum of the squared motor currents since the last update of the temperatures, in units of (0.01 A)².
# HEAT_SAMPLES is the number of servo samples since the last update of the motor temperatures.
CURRENT_SUM, HEAT, HEAT_SAMPLES = islice(_slots, 3)
SLIPPED = next(_slots)  # Real shaft position minus the position that the encoder reports, in counts.
# A defective encoder reports COUNTS_OF counts for every COUNTS_OUT_OF counts of the shaft, e.g. 9 for every 10.
COUNTS_OF, COUNTS_OUT_OF = next(_slots), next(_slots)
UNCOUNTED = next(_slots)  # Fraction of a count that a defective encoder carries over to the next servo sample.
ENERGY = next(_slots)  # Electrical energy taken by the windings since the start of the simulation, in nJ.
HOT = next(_slots)  # Flag: 1 while the motor cools down after an overload.

# Number of received bytes that the program has not read yet: LEN for serial channel 0, LEN1 for channel 1.
LENGTHS, *_ = islice(_slots, 2)
ARRAY_BASE = next(_slots)  # Index of the first array element, al[0], in the memory of the program's variables.

INTS = next(_slots)

STOPPED, RUNNING, BLOCKED = range(3)
"""States of the program.  BLOCKED: a statement waits for an external event, such as room in the transmitter."""
NOTHING_YET = -1  # Value in place of a statement number before the first statement of a started program.
DEPTH_MOST, SWITCH_MOST = 10, 4

MODES = (
    M_OFF, M_BRAKE, M_ERROR, M_HOLD, M_POSITION, M_VELOCITY, M_TORQUE, M_STOP, M_FOLLOW, M_RATIO, M_STEP, M_STEP_RATIO,
    M_CAM, M_HOST,
) = range(14)  # fmt: skip
"""OFF, mode torque brake, error, servo in place, MP, MV, MT, X, MF1/2/4, MFR, MS, MSR, MC…, MD."""
M_RELATIVE = len(MODES)  # Value reported instead of M_POSITION while D gave the target.
NO_POWER = -1  # Mode that is reported while the power is off.

CALL_GOSUB, CALL_FAULT, CALL_INPUT = 0, 1, 2
"""The reason for a return address on the stack: GOSUB, a call of C1 by a fault, a call of C2 by pin G."""

DRIVE_OPEN, DRIVE_SHORTED, DRIVE_ON = range(3)
"""Windings open (the shaft coasts), shorted (mode torque brake), driven by PWM."""

STATUS = (BT, BR, BL, BI, BW, BE, BH, BO, BX, BP, BM, BD, BU, BS, BA, BK)  # The status word W from bit 0 on.

USER_PINS = "ABCDEFG"  # The user pins, from bit 0 of PINS on.

LETTERS = 0  # Index of the variable a in the memory of the program's variables; the variables b to z follow.
DOUBLES = 26  # Index of the variable aa in the memory of the program's variables; the variables bb to zz follow.
TRIPLES = 52  # Index of the variable aaa in the memory of the program's variables; the variables bbb to zzz follow.
ALONE = 78  # First free index after the variable zzz in the memory of the program's variables.
HIDDEN = ALONE + 51
HIDDEN_MOST = 16
VARIABLES = HIDDEN + HIDDEN_MOST
"""al[] shares the memory of aa…zz and aaa…yyy (ARRAY_BASE = DOUBLES), or is separate (ARRAY_BASE = ALONE).

HIDDEN: values fetched from outside (GETCHR, AINpc, DINpc…) for the statement in hand."""
LONGS, WORDS, BYTES = 51, 102, 204
