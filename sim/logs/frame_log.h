// SPDX-License-Identifier: Apache-2.0
/// Log of the frames on one bus, in two files: text like that of `candump -L` (simulated time, microseconds),
/// and pcap with link type 227 (SocketCAN, nanoseconds). can-utils and tshark read them.
///
/// Lines and records are formatted without printf, each kind into its own buffer; one system call writes a
/// full buffer.
///
/// Ownership  frame_log_open allocates, frame_log_close writes the rest and frees.
/// Context    One task; frame_log_flush may also be called from the signal handler of a program that crashes.
/// Time       About 0.1 us per frame.
#ifndef SIM_LOGS_FRAME_LOG_H
#define SIM_LOGS_FRAME_LOG_H

#include "base/status.h"
#include "osal/include/osal/can.h"
#include "osal/include/osal/can_interface.h"

#include <stddef.h>
#include <stdint.h>

#define FRAME_LOG_LINE_MAX 200U  ///< Octets of the longest line: 64 octets of data, with line end.
#define FRAME_LOG_RECORD_MAX 96U ///< Octets of the longest pcap record.
#define FRAME_LOG_INTERFACE_MAX (OSAL_CAN_INTERFACE_NAME_MAX + 1U)

typedef struct frame_log frame_log_t;

/// Create `<folder>/can-<interface>.log` and `.pcap`. Returns STATUS_OK; else *out_log is null: STATUS_IO (a
/// file cannot be created), STATUS_EXHAUSTED (memory), STATUS_INVALID (name too long).
MUST_USE status_t frame_log_open(const char* folder, const char* interface, frame_log_t** out_log);
/// Append a data or error frame with its time.
void frame_log_write(frame_log_t* log, const osal_can_frame_t* frame);
/// Pass buffered records to the operating system.
void frame_log_flush(frame_log_t* log);
/// Write the rest, close the files and free the log. Null is allowed. Returns STATUS_OK, STATUS_IO: some
/// records were not written.
status_t frame_log_close(frame_log_t* log);

/// Write the line for a frame, with line end, into text[FRAME_LOG_LINE_MAX]. Returns its length.
size_t frame_log_line(const osal_can_frame_t* frame, const char* interface, char* text);
/// Write the pcap record for a frame into octets[FRAME_LOG_RECORD_MAX]. Returns its length.
size_t frame_log_record(const osal_can_frame_t* frame, uint8_t* octets);

#endif // SIM_LOGS_FRAME_LOG_H
