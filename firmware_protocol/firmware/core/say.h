/* What the board says: messages packed into frames, for both carriers. */
#ifndef SB_SAY_H
#define SB_SAY_H

#include "board.h"

/* The stop or fault that the board is in, with the number of its latch. */
void sb_say_fault(struct sb_board *board);

/* The heartbeat; with it the fault, while there is one. */
void sb_say_beat(struct sb_board *board);

/* The answers to an InfoRequest. */
void sb_say_info(struct sb_board *board);

/* The limits in force, joint by joint. */
void sb_say_limits(struct sb_board *board);

/* A sample of all joints as they were read last. */
void sb_say_sample(struct sb_board *board, uint32_t now_us);

/* What is said once a second: counters, and supplies where they are measured. */
void sb_say_second(struct sb_board *board);

void sb_say_pong(struct sb_board *board, uint32_t nonce, uint32_t now_us);

/* The acknowledgement of a request of this host. */
void sb_say_answer(struct sb_board *board, uint8_t token, uint16_t request, uint32_t host, struct sb_answer answer);

/* Everything that was said so far goes onto the serial line. */
void sb_say_out(struct sb_board *board);

#endif
