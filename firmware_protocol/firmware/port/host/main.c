/* The reference board as a Linux program: the same core, behind a pseudo-terminal, with simulated joints. */
#include <errno.h>
#include <getopt.h>
#include <math.h>
#include <poll.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/random.h>
#include <time.h>
#include <unistd.h>

#include "core/board.h"
#include "core/generated/snakebot.h"
#include "core/hal.h"
#include "model/simulated_joints.h"
#include "parameters.h"
#include "pty.h"
#include "slcan.h"

#define LONGEST_SLEEP_US 5000u

static const char usage[] =
    "usage: snakebot_board [options]\n"
    "  --slcan                 speak CAN as a serial CAN adapter does, not the serial protocol\n"
    "  --joints N              1 to 16 (5)\n"
    "  --angle-limit DEG       built-in limits of every joint (95)\n"
    "  --speed-limit RAD_S     (8)\n"
    "  --acceleration-limit RAD_S2  (60)\n"
    "  --counts N              encoder counts a turn, 16 to 65535 (8192)\n"
    "  --time-constant S       of the simulated servos (0.03)\n"
    "  --start DEG             where the joints are (0)\n"
    "  --serial-number N       (1)\n"
    "  --clock-offset US       what the board's clock shows at the start (0)\n"
    "  --seed N                repeatable boot ids\n"
    "  --parameters FILE       keep trims and zeros there; without it they are kept until the program ends\n"
    "SIGUSR1 resets the board, SIGUSR2 is its emergency stop button. The first line printed is the port to use.\n";

static struct sb_board board;
static struct sb_config config;
static struct pty pty;
static struct slcan slcan;
static bool speaks_can;
static uint8_t can_bytes[4096]; /* of the line that carries CAN: not yet looked at */
static uint32_t can_first;
static uint32_t can_end;
static uint8_t can_out[4096];
static uint32_t can_out_length;
static uint64_t start_us;
static uint32_t clock_offset_us;
static bool seeded;
static uint32_t random_state;
static const char *parameters_file;
static struct sb_parameters kept;
static bool is_kept;
static bool parameters_lost; /* there is a file, and it cannot be used */
static volatile sig_atomic_t reset_wanted;
static volatile sig_atomic_t stop_pressed;
static volatile sig_atomic_t end_wanted;

static uint64_t monotonic_us(void)
{
    struct timespec now;
    (void)clock_gettime(CLOCK_MONOTONIC, &now);
    return (uint64_t)now.tv_sec * 1000000u + (uint64_t)now.tv_nsec / 1000u;
}

/* -- the HAL (servos and encoders are in simulated_joints.c) ------------------------------------------------------- */

uint32_t hal_time_us(void)
{
    return (uint32_t)(monotonic_us() - start_us) + clock_offset_us;
}

uint32_t hal_random(void)
{
    uint32_t drawn = 0u;
    if (!seeded && (getrandom(&drawn, sizeof drawn, 0) == (ssize_t)sizeof drawn)) {
        return drawn;
    }
    random_state = random_state * 1664525u + 1013904223u;
    return random_state >> 8;
}

uint32_t hal_serial_read(uint8_t *data, uint32_t most)
{
    return speaks_can ? 0u : pty_read(&pty, data, most);
}

void hal_serial_write(const uint8_t *data, uint32_t length)
{
    if (!speaks_can) {
        pty_write(&pty, data, length);
    }
}

bool hal_can_read(struct sb_frame *frame)
{
    if (!speaks_can) {
        return false;
    }
    for (;;) {
        if (can_first == can_end) {
            can_first = 0u;
            can_end = pty_read(&pty, can_bytes, sizeof can_bytes);
            if (can_end == 0u) {
                return false;
            }
        }
        switch (slcan_feed(&slcan, (char)can_bytes[can_first++], frame)) {
        case SLCAN_FRAME:
            return true;
        case SLCAN_OK:
            pty_write(&pty, "\r", 1u);
            break;
        case SLCAN_ERROR:
            pty_write(&pty, "\a", 1u);
            break;
        default:
            break;
        }
    }
}

void hal_can_write(const struct sb_frame *frame)
{
    if (speaks_can && slcan.open && (can_out_length + SLCAN_LINE <= sizeof can_out)) {
        can_out_length += slcan_print(frame, (char *)&can_out[can_out_length]);
    }
}

/*
 * Without its trims and zeros a board takes its joints to be where they are not, and jumps when it is armed. So where a
 * file is there that cannot be used, arming is refused (a fault of the hardware: internal) until somebody has put it
 * right or taken it away, and the board has been reset. It is not written over: what can be saved of it is saved by hand.
 */
bool hal_parameters_load(struct sb_parameters *parameters)
{
    if (parameters_file != NULL) {
        const enum parameters_state state = parameters_read(parameters_file, &kept);
        const char *wrong = parameters_say(state);
        parameters_lost = wrong != NULL;
        if (wrong != NULL) {
            (void)fprintf(stderr,
                          "snakebot_board: %s: %s; trims and zeros are lost: arming is refused until it is restored or "
                          "removed and the board is reset\n",
                          parameters_file, wrong);
        }
        is_kept = state == PARAMETERS_LOADED;
    }
    *parameters = kept;
    return is_kept;
}

void hal_parameters_save(const struct sb_parameters *parameters)
{
    if (parameters_lost) {
        (void)fprintf(stderr, "snakebot_board: %s: not written over, it could not be used\n", parameters_file);
        return;
    }
    kept = *parameters;
    is_kept = true;
    if ((parameters_file != NULL) && !parameters_write(parameters_file, &kept)) {
        (void)fprintf(stderr, "snakebot_board: %s: not stored: %s\n", parameters_file, strerror(errno));
    }
}

/* -- the program --------------------------------------------------------------------------------------------------- */

static void on_signal(int which)
{
    if (which == SIGUSR1) {
        reset_wanted = 1;
    } else if (which == SIGUSR2) {
        stop_pressed = 1;
    } else {
        end_wanted = 1;
    }
}

/* A number within its range, or the end of the program with one line that names the option. */
static double number(const char *name, const char *text, double lowest, double highest)
{
    char *end = NULL;
    const double value = strtod(text, &end);
    if ((end == text) || (*end != '\0') || !(value >= lowest) || !(value <= highest)) {
        (void)fprintf(stderr, "snakebot_board: --%s %s: must be a number from %.10g to %.10g\n", name, text, lowest,
                      highest);
        exit(2);
    }
    return value;
}

static float start_rad[SB_MAX_JOINTS];
static float time_constant_s = 0.03f;

static void parse(int count, char **arguments)
{
    static const struct option options[] = {
        {"slcan", no_argument, NULL, 'c'},
        {"joints", required_argument, NULL, 'j'},
        {"angle-limit", required_argument, NULL, 'a'},
        {"speed-limit", required_argument, NULL, 'v'},
        {"acceleration-limit", required_argument, NULL, 'b'},
        {"counts", required_argument, NULL, 'n'},
        {"time-constant", required_argument, NULL, 't'},
        {"start", required_argument, NULL, 's'},
        {"serial-number", required_argument, NULL, 'i'},
        {"clock-offset", required_argument, NULL, 'o'},
        {"seed", required_argument, NULL, 'r'},
        {"parameters", required_argument, NULL, 'p'},
        {"help", no_argument, NULL, 'h'},
        {NULL, 0, NULL, 0},
    };
    struct sb_limits limits = {(float)(95.0 * M_PI / 180.0), 8.0f, 60.0f};
    double joints = 5.0;
    double counts = 8192.0;
    double serial_number = 1.0;
    double start_deg = 0.0;
    int index = 0;
    for (int option; (option = getopt_long(count, arguments, "h", options, &index)) != -1;) {
        const char *name = (option == 'h') ? "help" : options[index].name;
        switch (option) {
        case 'c':
            speaks_can = true;
            break;
        case 'j':
            joints = floor(number(name, optarg, 1.0, SB_MAX_JOINTS));
            break;
        case 'a':
            limits.angle_rad = (float)(number(name, optarg, 0.2, 180.0) * M_PI / 180.0);
            break;
        case 'v':
            limits.speed_rad_s = (float)number(name, optarg, 0.002, 262.0);
            break;
        case 'b':
            limits.acceleration_rad_s2 = (float)number(name, optarg, 0.002, 262.0);
            break;
        case 'n':
            counts = floor(number(name, optarg, 16.0, 65535.0));
            break;
        case 't':
            time_constant_s = (float)number(name, optarg, 0.0, 60.0);
            break;
        case 's':
            start_deg = number(name, optarg, -180.0, 180.0);
            break;
        case 'i':
            serial_number = floor(number(name, optarg, 0.0, 9007199254740992.0));
            break;
        case 'o':
            clock_offset_us = (uint32_t)number(name, optarg, 0.0, 4294967295.0);
            break;
        case 'r':
            random_state = (uint32_t)number(name, optarg, 0.0, 4294967295.0);
            seeded = true;
            break;
        case 'p':
            parameters_file = optarg;
            break;
        case 'h':
            (void)fputs(usage, stdout);
            exit(0);
        default:
            (void)fputs(usage, stderr);
            exit(2);
        }
    }
    if (optind < count) {
        (void)fprintf(stderr, "snakebot_board: %s: takes options only\n%s", arguments[optind], usage);
        exit(2);
    }
    config = simulated_board((uint8_t)joints, (uint64_t)serial_number);
    config.counts_per_rev = (uint16_t)counts;
    for (uint32_t i = 0u; i < SB_MAX_JOINTS; i++) {
        config.limits[i] = limits;
        start_rad[i] = (float)(start_deg * M_PI / 180.0);
    }
}

/* What is wrong with this board while no button is pressed. */
static void show_hardware(void)
{
    const uint8_t code =
        parameters_lost ? SNAKEBOT_FAULT_EVENT_CODE_INTERNAL_CHOICE : SNAKEBOT_FAULT_EVENT_CODE_NONE_CHOICE;
    simulated_joints_fault(code, 0u, 0);
}

static void flush_can(void)
{
    if (can_out_length > 0u) {
        pty_write(&pty, can_out, can_out_length);
        can_out_length = 0u;
    }
}

static void sleep_until_due(void)
{
    struct pollfd line = {pty.master, POLLIN, 0};
    uint32_t sleep_us = sb_board_idle_us(&board);
    sleep_us = (sleep_us < LONGEST_SLEEP_US) ? sleep_us : LONGEST_SLEEP_US;
    const struct timespec timeout = {0, (long)sleep_us * 1000L};
    (void)ppoll(&line, 1u, &timeout, NULL);
}

int main(int count, char **arguments)
{
    const struct sigaction action = {.sa_handler = on_signal};
    start_us = monotonic_us();
    parse(count, arguments);
    (void)sigaction(SIGUSR1, &action, NULL);
    (void)sigaction(SIGUSR2, &action, NULL);
    (void)sigaction(SIGTERM, &action, NULL);
    (void)sigaction(SIGINT, &action, NULL);
    if (!pty_open(&pty)) {
        (void)fprintf(stderr, "snakebot_board: no pseudo-terminal: %s\n", strerror(errno));
        return 3;
    }
    simulated_joints_start(&config, start_rad, time_constant_s);
    sb_board_reset(&board, &config);
    show_hardware();
    if (speaks_can) {
        (void)printf("can:slcan/%s?bitrate=1000000&sleep_after_open=0\n", pty.path);
    } else {
        (void)printf("serial:%s\n", pty.path);
    }
    (void)fflush(stdout);
    while (end_wanted == 0) {
        if (reset_wanted != 0) {
            reset_wanted = 0;
            sb_board_reset(&board, &config);
            show_hardware();
        }
        if (stop_pressed != 0) {
            stop_pressed = 0;
            simulated_joints_fault(SNAKEBOT_FAULT_EVENT_CODE_EMERGENCY_STOP_CHOICE, 0u, 0);
        }
        sb_board_step(&board);
        show_hardware();
        flush_can();
        sleep_until_due();
    }
    return 0;
}
