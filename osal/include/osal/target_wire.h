// SPDX-License-Identifier: Apache-2.0
/// Protocol between a program on a processor without network and the process that serves it: records in each
/// direction, on two pipes. They carry the one stream of the program, the datagrams of sockets that the
/// serving process has, and requests to force files to the disk of that process.
///
/// A record is the number of octets that follow (u32), its kind (u8) and its content; numbers are big-endian.
#ifndef OSAL_TARGET_WIRE_H
#define OSAL_TARGET_WIRE_H

#define TARGET_WIRE_HEADER_OCTETS 5U    ///< Number of octets and kind.
#define TARGET_WIRE_DATAGRAM_MAX 8192U  ///< Octets of a datagram in one record.
#define TARGET_WIRE_DATAGRAM_OCTETS 10U ///< Socket and address, before the octets of a datagram.
#define TARGET_WIRE_STREAM_MAX 16384U   ///< Octets of the stream in one record.
/// Longest content of a record.
#define TARGET_WIRE_CONTENT_MAX TARGET_WIRE_STREAM_MAX
/// In place of the number of a socket: a socket that only sends, from the address of the component's
/// computer.
#define TARGET_WIRE_SENDER 0xFFFFFFFFU

#define TARGET_WIRE_SYNC_CONTENT 0U ///< Sync the content of the file.
#define TARGET_WIRE_SYNC_NAMES 1U   ///< Sync the names of all files in its directory.
#define TARGET_WIRE_PATH_MAX 511U   ///< Longest path [octets].

typedef enum {
    TARGET_WIRE_STREAM = 1, ///< Both directions: octets of the stream.
    /// Both directions: number of the socket (u32), address (u32, u16), octets of the datagram.
    TARGET_WIRE_DATAGRAM = 2,
    TARGET_WIRE_ADOPT    = 3, ///< From the program: serve the inherited socket of this number (u32).
    /// From the program: wait for datagrams to a socket (u32), at most this time [ms] (u32).
    TARGET_WIRE_WAIT = 4,
    /// To the program: the wait is over. Datagrams that arrived during the wait were sent before this record.
    TARGET_WIRE_WAITED = 5,
    /// From the program: force a file to the disk. TARGET_WIRE_SYNC_* (u8), path without a zero at its end.
    TARGET_WIRE_SYNC   = 6,
    TARGET_WIRE_SYNCED = 7 ///< To the program: 1 if the disk has it, otherwise 0 (u8).
} target_wire_kind_t;

#endif // OSAL_TARGET_WIRE_H
