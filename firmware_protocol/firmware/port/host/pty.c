#include "pty.h"

#include <fcntl.h>
#include <stdlib.h>
#include <sys/ioctl.h>
#include <termios.h>
#include <time.h>
#include <unistd.h>

#define UNREAD_US 250000u
#define MOST_WAITING 3500 /* a pty takes 4 KiB: a batch goes in whole or not at all */

static uint64_t monotonic_us(void)
{
    struct timespec now;
    (void)clock_gettime(CLOCK_MONOTONIC, &now);
    return (uint64_t)now.tv_sec * 1000000u + (uint64_t)now.tv_nsec / 1000u;
}

bool pty_open(struct pty *pty)
{
    struct termios settings;
    pty->waiting = 0;
    pty->read_us = monotonic_us();
    pty->master = posix_openpt(O_RDWR | O_NOCTTY);
    if ((pty->master < 0) || (grantpt(pty->master) != 0) || (unlockpt(pty->master) != 0) ||
        (ptsname_r(pty->master, pty->path, sizeof pty->path) != 0)) {
        return false;
    }
    /* The slave stays open here: a master whose last host has gone answers every read with an error. */
    pty->slave = open(pty->path, O_RDWR | O_NOCTTY);
    if ((pty->slave < 0) || (tcgetattr(pty->slave, &settings) != 0)) {
        return false;
    }
    cfmakeraw(&settings);
    return (tcsetattr(pty->slave, TCSANOW, &settings) == 0) && (fcntl(pty->master, F_SETFL, O_NONBLOCK) == 0);
}

uint32_t pty_read(struct pty *pty, void *data, uint32_t most)
{
    const ssize_t length = read(pty->master, data, most);
    return (length > 0) ? (uint32_t)length : 0u;
}

void pty_write(struct pty *pty, const void *data, uint32_t length)
{
    int unread = 0;
    (void)ioctl(pty->slave, FIONREAD, &unread);
    const uint64_t now_us = monotonic_us();
    if ((unread == 0) || (unread < pty->waiting)) {
        pty->read_us = now_us;
    } else if (now_us - pty->read_us > UNREAD_US) {
        (void)tcflush(pty->slave, TCIFLUSH);
        unread = 0;
    } else {
        /* somebody may still come for it */
    }
    if (unread < MOST_WAITING) {
        const ssize_t written = write(pty->master, data, length);
        unread += (written > 0) ? (int)written : 0;
    }
    pty->waiting = unread;
}
