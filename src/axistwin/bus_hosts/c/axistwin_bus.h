/* Port input and output that reach a board of axistwin, over the socket of `axistwin serve 1811 --bus HOST:PORT`.
 *
 * The environment says where: AXISTWIN_BUS=HOST:PORT.  The connection is made at the first access and kept.  The lowest
 * address bit selects the register (even: data, odd: status and control); the rest of an address is the board's
 * jumpers' affair, so any base address does.  What goes wrong with the connection ends the program with a message
 * and exit code 3: there is nothing that a host could do about a bus that is gone.
 *
 * Plain C of 1989, so that it compiles with old programs as well as new ones.
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

/* Whether the board interrupts: 0 or 1. */
int interrupt_line(void);

/* Wait until the interrupt line is active, at most so many milliseconds, or for ever if that is negative; returns it. */
int wait_interrupt(int milliseconds);

#ifdef __cplusplus
}
#endif
#endif
