/* The board: a tick, and the host that emulates it. */
#ifndef BOARD_H
#define BOARD_H

#include <stdbool.h>
#include <stdint.h>

/* A tick is a millisecond. */
#define TICKS_PER_SECOND 1000

/* Starts the ticks. */
void start_ticks(void);
/* Ticks since then; grows in the interrupt. */
uint32_t ticks(void);
/* Sleeps until an interrupt. */
void sleep_until_interrupt(void);
/* Bytes of stack that were used so far, and that there are. */
uint32_t stack_used(void);
uint32_t stack_size(void);
/* Prints on the host. */
void print(const char *text);
/* Prints a number, in so many places. */
void print_number(uint32_t number, int places);
/* Whether this word is in the command line. */
bool was_told(const char *word);
/* Ends the emulator with this status. */
_Noreturn void leave(uint32_t status);

#endif
