/* A pseudo-terminal as a board's serial line. */
#ifndef PTY_H
#define PTY_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

struct pty {
    int master;
    int slave;
    int waiting; /* bytes on their way to the host after the last write */
    uint64_t read_us; /* when somebody last took bytes */
    char path[128];
};

/* False, with errno set, where the system has none left. */
bool pty_open(struct pty *pty);

/* What has come in: up to `most` bytes, and how many. */
uint32_t pty_read(struct pty *pty, void *data, uint32_t most);

/* All bytes or none. What nobody reads for 0.25 s is thrown away: a host that comes late hears of now. */
void pty_write(struct pty *pty, const void *data, uint32_t length);

#endif
