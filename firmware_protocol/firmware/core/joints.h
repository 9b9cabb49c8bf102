/* The set-point register and what stands behind it: joint modes, limits, trims, servos, encoders. */
#ifndef SB_JOINTS_H
#define SB_JOINTS_H

#include <stdbool.h>
#include <stdint.h>

#include "hal.h"
#include "limiter.h"
#include "setpoint.h"

/*
 * Largest trim, in steps of the wire (0.3 rad). A servo horn sits on a spline of 21 to 25 teeth: the nearest tooth is at
 * most 0.15 rad off, and the servo's own centre about as much again. More is a horn on the wrong tooth.
 */
#define SB_MOST_TRIM 3000

/* How a servo's pulse follows the angle. A negative slope turns a servo that is mounted the other way round. */
struct sb_servo {
    uint32_t centre_ns; /* pulse at angle 0 */
    int32_t ns_per_rad;
    uint32_t shortest_ns; /* what the servo understands */
    uint32_t longest_ns;
};

/* What the board is: filled in by the port, never changed after. */
struct sb_config {
    uint8_t joints;
    bool simulated; /* no real joint moves */
    uint16_t counts_per_rev;
    uint64_t serial_number;
    struct sb_limits limits[SB_MAX_JOINTS]; /* built in: no request exceeds them */
    struct sb_servo servos[SB_MAX_JOINTS];
};

struct sb_joints {
    const struct sb_config *config;
    struct sb_parameters parameters;
    int16_t trim[SB_MAX_JOINTS]; /* in force: as stored when the joint got power last */
    struct sb_limiter limiter;   /* of what the servos are told: a joint's angle and its trim */
    uint8_t mode[SB_MAX_JOINTS]; /* SNAKEBOT_JOINT_MODE_REQUEST_MODE_... */
    float hold_rad[SB_MAX_JOINTS]; /* rigid: where to */
    bool powered[SB_MAX_JOINTS];
    bool reading[SB_MAX_JOINTS]; /* of the encoders, when they were read last */
    bool known[SB_MAX_JOINTS]; /* read at least once: without that a joint gets no power */
    int32_t counts[SB_MAX_JOINTS]; /* from the zero */
};

/* After a reset: all active, all without power, built-in limits, stored trims and zeros. */
void sb_joints_reset(struct sb_joints *joints, const struct sb_config *config);

/* Read all encoders; the register follows those of joints without power. */
void sb_joints_read(struct sb_joints *joints);

/* The board has power for its servos or not; each joint's mode decides on the rest. */
void sb_joints_power(struct sb_joints *joints, bool powered);

/* Send the register to the servos that have power. */
void sb_joints_command(struct sb_joints *joints);

/* Move the register towards a set-point; false if it comes too early. `clamped`: a limit has changed it. */
bool sb_joints_execute(struct sb_joints *joints, const struct sb_tick *tick, uint32_t gap, uint32_t elapsed_us,
                       bool *clamped);

/* The register in joint angles, without trims, in steps of the wire. */
int16_t sb_joints_applied(const struct sb_joints *joints, uint8_t joint);

/* The reading as the wire carries it. */
int16_t sb_joints_measured(const struct sb_joints *joints, uint8_t joint);

/* A limit by its kind on the wire. */
float *sb_limit(struct sb_limits *limits, uint8_t kind);

#endif
