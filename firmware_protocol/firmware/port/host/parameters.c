#include "parameters.h"

#include <errno.h>
#include <fcntl.h>
#include <stddef.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

#include "core/crc.h"

#define MARK 0x50534253u /* "SBSP"; another byte order is another file */
#define VERSION 1u
#define LONGEST_PATH 4096u

/* The file, byte by byte. */
struct image {
    uint32_t mark;
    uint16_t version;
    uint16_t length; /* of the parameters */
    struct sb_parameters parameters;
    uint32_t crc32; /* of all before it */
};

static uint32_t checksum(const struct image *image)
{
    return sb_crc32((const uint8_t *)image, offsetof(struct image, crc32));
}

enum parameters_state parameters_read(const char *path, struct sb_parameters *parameters)
{
    struct image image;
    FILE *file = fopen(path, "rb");
    if (file == NULL) {
        return (errno == ENOENT) ? PARAMETERS_NONE : PARAMETERS_UNREADABLE;
    }
    const bool whole = fread(&image, sizeof image, 1u, file) == 1u;
    const bool readable = ferror(file) == 0;
    const bool ends = fgetc(file) == EOF;
    (void)fclose(file);
    if (!readable) {
        return PARAMETERS_UNREADABLE;
    }
    if (!whole || !ends || (image.mark != MARK)) {
        return PARAMETERS_NO_FILE_OF_OURS;
    }
    if (image.crc32 != checksum(&image)) {
        return PARAMETERS_DAMAGED;
    }
    if ((image.version != VERSION) || (image.length != sizeof image.parameters)) {
        return PARAMETERS_OTHER_VERSION;
    }
    *parameters = image.parameters;
    return PARAMETERS_LOADED;
}

/* A name that was changed is on the disk when its folder is. */
static void settle_folder(const char *path)
{
    char folder[LONGEST_PATH];
    const char *slash = strrchr(path, '/');
    const size_t length = (slash == NULL) ? 0u : (size_t)(slash - path) + 1u;
    (void)snprintf(folder, sizeof folder, "%.*s.", (int)length, path);
    const int fd = open(folder, O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    if (fd >= 0) {
        (void)fsync(fd);
        (void)close(fd);
    }
}

bool parameters_write(const char *path, const struct sb_parameters *parameters)
{
    struct image image;
    char temporary[LONGEST_PATH];
    memset(&image, 0, sizeof image);
    image.mark = MARK;
    image.version = VERSION;
    image.length = (uint16_t)sizeof image.parameters;
    image.parameters = *parameters;
    image.crc32 = checksum(&image);
    if (snprintf(temporary, sizeof temporary, "%s.new", path) >= (int)sizeof temporary) {
        errno = ENAMETOOLONG;
        return false;
    }
    const int fd = open(temporary, O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644);
    if (fd < 0) {
        return false;
    }
    errno = EIO; /* what a short write means */
    bool done = write(fd, &image, sizeof image) == (ssize_t)sizeof image;
    done = done && (fsync(fd) == 0);
    done = (close(fd) == 0) && done;
    done = done && (rename(temporary, path) == 0);
    if (!done) {
        const int why = errno;
        (void)unlink(temporary);
        errno = why;
        return false;
    }
    settle_folder(path);
    return true;
}

const char *parameters_say(enum parameters_state state)
{
    switch (state) {
    case PARAMETERS_UNREADABLE:
        return strerror(errno);
    case PARAMETERS_NO_FILE_OF_OURS:
        return "cut short, or no file of parameters";
    case PARAMETERS_OTHER_VERSION:
        return "written by another version";
    case PARAMETERS_DAMAGED:
        return "damaged: its checksum is wrong";
    default:
        return NULL;
    }
}
