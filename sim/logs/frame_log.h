// SPDX-License-Identifier: Apache-2.0
/// Log of the frames on one bus, in two files: text like that of `candump -L` (simulated time, microseconds),
/// and pcap with link type 227 (SocketCAN, nanoseconds). can-utils and tshark read them.
///
/// A task of the log formats lines and records, without printf, and writes them (write_behind.h).
///
/// Ownership  frame_log_open allocates, frame_log_close writes the rest and frees.
/// Context    One task; frame_log_flush may also be called from the signal handler of a crash.
/// Time       Passing a frame to the task takes about 10 ns, formatting it there about 0.1 us.
#ifndef SIM_LOGS_FRAME_LOG_H
#define SIM_LOGS_FRAME_LOG_H

#include "base/status.h"
#include "osal/include/osal/can.h"
#include "osal/include/osal/can_interface.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define FRAME_LOG_LINE_MAX 200U  ///< Octets of the longest line: 64 octets of data, with line end.
#define FRAME_LOG_RECORD_MAX 96U ///< Octets of the longest pcap record.
#define FRAME_LOG_INTERFACE_MAX (OSAL_CAN_INTERFACE_NAME_MAX + 1U)

typedef struct frame_log frame_log_t;

/// Create `<directory>/can-<interface>.log` and `.pcap`. Returns STATUS_OK; else *out_log is null: STATUS_IO
/// (a file cannot be created), STATUS_EXHAUSTED (memory), STATUS_INVALID (name too long).
MUST_USE status_t frame_log_open(const char* directory, const char* interface, frame_log_t** out_log);
/// Append a data or error frame with its time.
void frame_log_write(frame_log_t* log, const osal_can_frame_t* frame);
/// Let the task of the log write the frames so far. With `waits` it returns when the operating system has
/// them.
void frame_log_flush(frame_log_t* log, bool waits);
/// Write the rest, close the files and free the log. Null is allowed. Returns STATUS_OK, STATUS_IO: some
/// records were not written.
status_t frame_log_close(frame_log_t* log);

/// Write the line for a frame, with line end, into text[FRAME_LOG_LINE_MAX]. Returns its length.
size_t frame_log_line(const osal_can_frame_t* frame, const char* interface, char* text);
/// Write the pcap record for a frame into octets[FRAME_LOG_RECORD_MAX]. Returns its length.
size_t frame_log_record(const osal_can_frame_t* frame, uint8_t* octets);

#endif // SIM_LOGS_FRAME_LOG_H
