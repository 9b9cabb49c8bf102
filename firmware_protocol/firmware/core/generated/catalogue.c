/* Generated from snakebot.dbc by tools/make_codec.py. */
#include "catalogue.h"

#define ENUMERATIONS 2u
#define MESSAGES 28u

struct enumeration {
    uint8_t start; /* bit */
    uint8_t bits;
    uint8_t named; /* values 0 to named - 1 have a name */
};

struct definition {
    uint16_t id;
    uint8_t length;
    struct enumeration enumerations[ENUMERATIONS];
};

static const struct definition definitions[MESSAGES] = {
    {1u, 5u, {{0u, 8u, 4u}, {0u, 0u, 1u}}}, /* EmergencyStop */
    {2u, 8u, {{0u, 5u, 9u}, {0u, 0u, 1u}}}, /* FaultEvent */
    {16u, 8u, {{0u, 0u, 1u}, {0u, 0u, 1u}}}, /* Setpoint */
    {17u, 8u, {{0u, 0u, 1u}, {0u, 0u, 1u}}}, /* Latch */
    {32u, 8u, {{28u, 4u, 5u}, {0u, 0u, 1u}}}, /* State */
    {33u, 8u, {{0u, 0u, 1u}, {0u, 0u, 1u}}}, /* Measured */
    {34u, 8u, {{0u, 0u, 1u}, {0u, 0u, 1u}}}, /* Applied */
    {48u, 6u, {{0u, 0u, 1u}, {0u, 0u, 1u}}}, /* HostHeartbeat */
    {49u, 8u, {{16u, 4u, 5u}, {24u, 8u, 9u}}}, /* BoardHeartbeat */
    {64u, 6u, {{8u, 8u, 5u}, {0u, 0u, 1u}}}, /* ModeRequest */
    {65u, 8u, {{13u, 3u, 4u}, {0u, 0u, 1u}}}, /* JointModeRequest */
    {66u, 8u, {{13u, 2u, 3u}, {0u, 0u, 1u}}}, /* LimitRequest */
    {67u, 8u, {{0u, 0u, 1u}, {0u, 0u, 1u}}}, /* TrimRequest */
    {68u, 8u, {{0u, 0u, 1u}, {0u, 0u, 1u}}}, /* ZeroRequest */
    {69u, 6u, {{0u, 0u, 1u}, {0u, 0u, 1u}}}, /* ClearRequest */
    {78u, 7u, {{0u, 0u, 1u}, {0u, 0u, 1u}}}, /* JointLimits */
    {79u, 8u, {{8u, 4u, 7u}, {12u, 4u, 5u}}}, /* Acknowledge */
    {80u, 4u, {{0u, 0u, 1u}, {0u, 0u, 1u}}}, /* Ping */
    {81u, 8u, {{0u, 0u, 1u}, {0u, 0u, 1u}}}, /* Pong */
    {88u, 4u, {{0u, 0u, 1u}, {0u, 0u, 1u}}}, /* InfoRequest */
    {89u, 8u, {{0u, 0u, 1u}, {0u, 0u, 1u}}}, /* InfoProtocol */
    {90u, 8u, {{0u, 0u, 1u}, {0u, 0u, 1u}}}, /* InfoFirmware */
    {91u, 8u, {{0u, 0u, 1u}, {0u, 0u, 1u}}}, /* InfoSerial */
    {96u, 6u, {{0u, 0u, 1u}, {0u, 0u, 1u}}}, /* Supply */
    {97u, 6u, {{0u, 0u, 1u}, {0u, 0u, 1u}}}, /* JointSupply */
    {104u, 8u, {{0u, 0u, 1u}, {0u, 0u, 1u}}}, /* Counters */
    {112u, 8u, {{0u, 0u, 1u}, {0u, 0u, 1u}}}, /* PosePosition */
    {113u, 8u, {{0u, 0u, 1u}, {0u, 0u, 1u}}}, /* PoseMotion */
};

bool sb_catalogue_accepts(uint16_t id, const uint8_t *data, uint8_t length)
{
    for (uint32_t m = 0u; m < MESSAGES; m++) {
        const struct definition *definition = &definitions[m];
        if (definition->id != id) {
            continue;
        }
        if (definition->length != length) {
            return false;
        }
        for (uint32_t e = 0u; e < ENUMERATIONS; e++) {
            const struct enumeration *enumeration = &definition->enumerations[e];
            const uint32_t mask = (1u << enumeration->bits) - 1u;
            const uint32_t value = ((uint32_t)data[enumeration->start / 8u] >> (enumeration->start % 8u)) & mask;
            if (value >= enumeration->named) {
                return false;
            }
        }
        return true;
    }
    return false;
}
