/* Generated from snakebot.dbc by tools/make_codec.py. */
#ifndef SB_CATALOGUE_H
#define SB_CATALOGUE_H

#include <stdbool.h>
#include <stdint.h>

#define SB_CATALOGUE_HASH 0x38093afdu
#define SB_ANGLE_STEP_RAD 0.0001f
#define SB_INTERVAL_STEP_S 0.0005f
#define SB_LIMIT_STEP 0.002f

/* A frame of the catalogue: its length is right and its enumerations hold values that have a name. */
bool sb_catalogue_accepts(uint16_t id, const uint8_t *data, uint8_t length);

#endif
