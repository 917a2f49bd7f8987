// SPDX-License-Identifier: Apache-2.0
#define _GNU_SOURCE
#include "osal/include/osal/serial.h"

#include "base/assertion.h"

#include <errno.h>
#include <stddef.h>
#include <sys/ioctl.h>
#include <termios.h>

typedef struct {
    uint32_t baud;
    speed_t speed;
} rate_t;

static const rate_t rates[] = {
    {1200U, B1200},     {2400U, B2400},       {4800U, B4800},       {9600U, B9600},       {19200U, B19200},
    {38400U, B38400},   {57600U, B57600},     {115200U, B115200},   {230400U, B230400},   {460800U, B460800},
    {921600U, B921600}, {1000000U, B1000000}, {2000000U, B2000000}, {3000000U, B3000000},
};

static const rate_t* rate_of(const uint32_t baud)
{
    for (size_t i = 0U; i < (sizeof rates / sizeof rates[0]); i++) {
        if (rates[i].baud == baud) {
            return &rates[i];
        }
    }
    return NULL;
}

/// Set the line raw, with this bit rate. False if the line does not accept the settings.
static bool make_raw(const int descriptor, const speed_t speed)
{
    struct termios line = {0};
    if (tcgetattr(descriptor, &line) != 0) {
        return false;
    }
    cfmakeraw(&line);
    line.c_cflag &= (tcflag_t) ~(PARENB | CSTOPB | CRTSCTS);
    line.c_cflag |= CLOCAL | CREAD | CS8; // CLOCAL: the carrier signal of a modem is ignored.
    line.c_cc[VMIN]  = 1U;                // With 0, "no data" and "hung up" could not be distinguished.
    line.c_cc[VTIME] = 0U;
    return (cfsetispeed(&line, speed) == 0) && (cfsetospeed(&line, speed) == 0) &&
           (tcsetattr(descriptor, TCSANOW, &line) == 0) && (tcflush(descriptor, TCIFLUSH) == 0);
}

status_t osal_serial_open(osal_device_t* const line, const char* const path, const uint32_t baud)
{
    FSW_ASSERT((line != NULL) && (path != NULL));
    const rate_t* const rate = rate_of(baud);
    *line                    = (osal_device_t)OSAL_DEVICE_CLOSED;
    if (rate == NULL) {
        return STATUS_OUT_OF_RANGE;
    }
    status_t status = osal_device_open(line, path, OSAL_DEVICE_BOTH);
    if (status != STATUS_OK) {
        return status;
    }
    if (!make_raw(line->descriptor, rate->speed)) {
        status = ((errno == ENOTTY) || (errno == EINVAL)) ? STATUS_INVALID : STATUS_IO;
        osal_device_close(line);
        return status;
    }
    (void)ioctl(line->descriptor, TIOCEXCL); // Excludes other programs, except privileged ones.
    return STATUS_OK;
}
