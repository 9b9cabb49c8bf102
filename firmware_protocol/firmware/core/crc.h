/* The two checks of the protocol. */
#ifndef SB_CRC_H
#define SB_CRC_H

#include <stdint.h>

/* CRC-16/CCITT-FALSE; "123456789" gives 0x29B1. */
uint16_t sb_crc16(const uint8_t *data, uint32_t length);

/* CRC-32 as in zlib; "123456789" gives 0xCBF43926. */
uint32_t sb_crc32(const uint8_t *data, uint32_t length);

#endif
