/* Port input and output that reach a board of axistwin, over the socket of `axistwin serve 1811 --bus HOST:PORT`.
 *
 * The environment variable AXISTWIN_BUS=HOST:PORT gives the address.  The first access opens the connection.  The
 * lowest address bit selects the register (even: data, odd: status and control).  The other bits are ignored, so any
 * base address works.  An error of the connection ends the program with a message and exit code 3.
 *
 * C of 1989, which compiles with old and new programs.
 */
#ifndef AXISTWIN_BUS_H
#define AXISTWIN_BUS_H

#ifdef __cplusplus
extern "C" {
#endif

/* Read a port: 0 to 255. */
int in(unsigned long address);

/* Write a byte to a port. */
void out(unsigned long address, int byte);

/* Read or write a port `count` times, in as few round trips as possible. */
void in_block(unsigned long address, unsigned char *bytes, int count);
void out_block(unsigned long address, const unsigned char *bytes, int count);

/* Return 1 while the board interrupts, otherwise 0. */
int interrupt_line(void);

/* Wait until the interrupt line is active, at most `milliseconds` (negative: for ever).  Return its level. */
int wait_interrupt(int milliseconds);

#ifdef __cplusplus
}
#endif
#endif
