/* What hosts may set, and what each request is answered: the checks of PROTOCOL.md, in its order. */
#ifndef SB_REQUESTS_H
#define SB_REQUESTS_H

#include "generated/snakebot.h"
#include "joints.h"
#include "modes.h"

struct sb_answer sb_request_joint_mode(struct sb_joints *joints, const struct sb_modes *modes,
                                       const struct snakebot_joint_mode_request_t *request);
struct sb_answer sb_request_limit(struct sb_joints *joints, const struct sb_modes *modes,
                                  const struct snakebot_limit_request_t *request);
struct sb_answer sb_request_trim(struct sb_joints *joints, const struct sb_modes *modes,
                                 const struct snakebot_trim_request_t *request);
struct sb_answer sb_request_zero(struct sb_joints *joints, const struct sb_modes *modes,
                                 const struct snakebot_zero_request_t *request);

#endif
