/* Stored parameters in a file: whole or not at all, and never taken for what they are not. */
#ifndef PARAMETERS_H
#define PARAMETERS_H

#include "core/hal.h"

enum parameters_state {
    PARAMETERS_LOADED,
    PARAMETERS_NONE,      /* there is no such file: nothing was ever stored */
    PARAMETERS_UNREADABLE, /* errno says why */
    PARAMETERS_NO_FILE_OF_OURS, /* too short, too long, or without our mark: cut, or another file */
    PARAMETERS_OTHER_VERSION,
    PARAMETERS_DAMAGED, /* the checksum is wrong */
};

/* Read a file. `parameters` is changed only where the answer is LOADED. */
enum parameters_state parameters_read(const char *path, struct sb_parameters *parameters);

/* Replace the file: what was there stays until the new one is on the disk. False with errno set where that failed. */
bool parameters_write(const char *path, const struct sb_parameters *parameters);

/* One line for people; NULL where all is well. */
const char *parameters_say(enum parameters_state state);

#endif
