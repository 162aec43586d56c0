/*
 * A bridge: runs on the computer in which a real 1810 or 1811 is, and answers the requests of the bus socket
 * (docs/bus.md) at its terminal line.  Standard input and output must be a line without echo and editing.
 *
 * C of 1978, which old and new compilers accept.  The compiler's library must have in(port) and out(port, byte).
 * Set BOARD to the base address of the board, or define IN and OUT for another access, e.g. memory-mapped registers.
 */
#include <stdio.h>

#ifndef BOARD
#define BOARD 0x60
#endif
#ifndef IN
#define IN(offset) in(BOARD + (offset))
#define OUT(offset, byte) out(BOARD + (offset), byte)
#endif

#define BLOCK 256       /* most bytes of one request */
#define LONGEST 1024    /* most characters of a request */
#define RESET 0x20      /* control byte: reset the board */
#define INTERRUPT 0x80  /* status byte: the board interrupts */

static char line[LONGEST + 1];
static char *at;

/* Read a request into `line`, without blank lines.  Returns 0 at the end of the input, -1 if the line is too long. */
static int next_line()
{
    int c, length = 0;

    while ((c = getchar()) != EOF) {
        if (c == '\n' || c == '\r') {
            line[length <= LONGEST ? length : LONGEST] = '\0';
            for (at = line; *at == ' '; at++)
                ;
            if (length > LONGEST)
                return -1;
            if (*at != '\0')
                return 1;
            length = 0;
        } else {
            if (length < LONGEST)
                line[length] = c;
            length += length <= LONGEST;
        }
    }
    return 0;
}

static int digit(c)
int c;
{
    if (c >= '0' && c <= '9')
        return c - '0';
    if (c >= 'a' && c <= 'f')
        return c - 'a' + 10;
    return c >= 'A' && c <= 'F' ? c - 'A' + 10 : 16;
}

/* Read the next number of the request.  Returns -1 without a number, and for a number above `most`. */
static int number(base, most)
int base, most;
{
    int value = 0, digits = 0;

    while (*at == ' ')
        at++;
    for (; digit(*at) < base; at++, digits++)
        if ((value = value * base + digit(*at)) > most)
            return -1;
    return digits > 0 && (*at == ' ' || *at == '\0') ? value : -1;
}

/* True after the last word of the request. */
static int finished()
{
    while (*at == ' ')
        at++;
    return *at == '\0';
}

static int answer_read()
{
    int offset = number(10, 1), count = 1, i;

    if (offset < 0 || (!finished() && (count = number(10, BLOCK)) < 1) || !finished())
        return 0;
    for (i = 0; i < count; i++)
        printf(i > 0 ? " %02x" : "%02x", IN(offset) & 0xFF);
    printf("\n");
    return 1;
}

static int answer_write()
{
    static unsigned char bytes[BLOCK];
    int offset = number(10, 1), count = 0, byte, i;

    if (offset < 0 || finished())
        return 0;
    while (!finished()) {
        if (count == BLOCK || (byte = number(16, 0xFF)) < 0)
            return 0;
        bytes[count++] = byte;
    }
    for (i = 0; i < count; i++)
        OUT(offset, bytes[i]);
    printf("ok\n");
    return 1;
}

/* Execute the request in `line`, and answer it.  Returns 0 for an invalid request, which has no effect. */
static int answered()
{
    char word = *at++;

    if (word == 'r' && *at == ' ')
        return answer_read();
    if (word == 'w' && *at == ' ')
        return answer_write();
    if (word == 'i' && finished()) {
        printf(IN(1) & INTERRUPT ? "1\n" : "0\n");
        return 1;
    }
    if (word == 'i' && at[0] == 'n' && at[1] == 'i' && at[2] == 't') {
        at += 3;
        if (!finished())
            return 0;
        OUT(1, RESET);
        printf("ok\n");
        return 1;
    }
    return 0;
}

int main()
{
    int found;

    while ((found = next_line()) != 0) {
        if (found < 0 || !answered())
            printf("error: expected r OFFSET [COUNT], w OFFSET HH ..., i or init\n");
        fflush(stdout);
    }
    return 0;
}
