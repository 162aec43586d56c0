"""The bits of the status word W (10 of the base language)."""

BITS = {letter: 1 << bit for bit, letter in enumerate("trliwehoxpmdusak")}
BT, BR, BL, BI, BW, BE, BH, BO, BX, BP, BM, BD, BU, BS, BA, BK = BITS.values()
