/* One revolution of an 1811's motor, 25,000 pulses; prints the position. */
#include <stdio.h>

#define DATA 0x60
#define CONTROL 0x61

#define MESSAGE_HERE 0x08 /* status byte: the output data buffer holds a message */
#define READY 0x10        /* status byte: the board accepts a command */
#define COMMAND 0x10      /* control byte: the command is complete */
#define TAKEN 0x80        /* control byte: the message has been read */

char speed[] = {0x31, 0, 0, 0, 0, 0x61, 0xA8, 0, 3, 0xD0, 0x90};
char signal_end[] = {0xA4, 1};
char move[] = {0x33, 0, 0, 0x61, 0xA8};
char request[] = {0x83};

wait_for(bit)
int bit;
{
    while (!(in(CONTROL) & bit))
        ;
}

send(bytes, count)
char *bytes;
int count;
{
    wait_for(READY);
    while (count--)
        out(DATA, *bytes++ & 255);
    out(CONTROL, COMMAND);
}

long receive()
{
    int i;
    long value = 0;

    wait_for(MESSAGE_HERE);
    in(DATA); /* the opcode of the command that is answered */
    for (i = 0; i < 6; i++)
        value = value << 8 | in(DATA);
    out(CONTROL, TAKEN);
    return value;
}

main()
{
    send(speed, sizeof speed);
    send(signal_end, sizeof signal_end);
    send(move, sizeof move);
    receive(); /* the end of the move */
    send(request, sizeof request);
    printf("%ld\n", receive());
    return 0;
}
