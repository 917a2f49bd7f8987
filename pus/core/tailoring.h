// SPDX-License-Identifier: Apache-2.0
/// The tailoring of ECSS-E-ST-70-41C: every constant that the standard leaves to the mission, in one table.
/// Widths are fixed for the whole mission: counts 8 bits in requests and 16 in reports, identifiers 16,
/// parameter ids 32, statuses 8, names 8 octets padded with NUL. All numbers are big-endian.
#ifndef PUS_CORE_TAILORING_H
#define PUS_CORE_TAILORING_H

#include "base/apids.h"

/// Packet structure [octets].
#ifndef PUS_PACKET_MAX
#define PUS_PACKET_MAX 4096U ///< Largest packet, headers and CRC included. A build may define less.
#endif
#define PUS_LARGE_MAX 65542U ///< Limit of the length field; packets longer than PUS_PACKET_MAX use ST[13].
#define PUS_PRIMARY_HEADER_SIZE 6U
#define PUS_TC_HEADER_SIZE 11U ///< Primary and secondary header of a request.
#define PUS_TM_HEADER_SIZE 21U ///< Primary and secondary header of a report, time included.
#define PUS_CRC_SIZE 2U
#define PUS_TC_MIN (PUS_TC_HEADER_SIZE + PUS_CRC_SIZE)
#define PUS_TM_MIN (PUS_TM_HEADER_SIZE + PUS_CRC_SIZE)
#define PUS_TC_DATA_MAX (PUS_PACKET_MAX - PUS_TC_MIN) ///< Largest application data field.
#define PUS_TM_DATA_MAX (PUS_PACKET_MAX - PUS_TM_MIN) ///< Largest source data field.

/// Header values.
#define PUS_PACKET_VERSION 0U
#define PUS_VERSION 2U     ///< PUS-C.
#define PUS_UNSEGMENTED 3U ///< Sequence flags; every packet is unsegmented.
#define PUS_SEQUENCE_COUNT 16384U
#define PUS_APID_IDLE 2047U
#define PUS_APID_MAX 2046U
#define PUS_APID_TIME 0U

/// Acknowledgement flags of a request. Acceptance is the LEAST significant bit; some tools reverse the order.
#define PUS_ACK_ACCEPTANCE 0x1U
#define PUS_ACK_START 0x2U
#define PUS_ACK_PROGRESS 0x4U
#define PUS_ACK_COMPLETION 0x8U
#define PUS_ACK_ALL 0xFU

/// Absolute time: CUC, 4 octets of seconds and 3 of fraction after the P-field, TAI since 1958-01-01.
#define PUS_TIME_P_FIELD 0x1FU
#define PUS_TIME_SIZE 8U ///< P-field included [octets].
/// Relative time: 4 octets of seconds and 3 of fraction as one number in two's complement.
#define PUS_RELATIVE_TIME_SIZE 7U
#define PUS_TIME_TICKS_PER_S 16777216U ///< 2^24: resolution of absolute and relative time [1/s].

/// Users: source ids of requests, destination ids of reports.
#define PUS_USER_GROUND 0U       ///< Destination of unsolicited reports: all ground users.
#define PUS_USER_CLI 1U          ///< Command line and operator script.
#define PUS_USER_ONBOARD 0x8000U ///< Bit of the user id of an on-board user, combined with its APID.
/// The supervisor as a user: it reacts to event notices, TM[129,7].
#define PUS_USER_SUPERVISOR (PUS_USER_ONBOARD | SUPERVISOR_APID)

#define PUS_NAME_SIZE 8U   ///< Size of a function id: the name of the function, padded with NUL [octets].
#define PUS_COUNT_MAX 255U ///< Largest count in a request.
/// Number of entries of `each` octets for which `octets` have room, at most PUS_COUNT_MAX.
#define PUS_COUNT_OF(octets, each)                                                                           \
    ((((octets) / (each)) < PUS_COUNT_MAX) ? ((octets) / (each)) : PUS_COUNT_MAX)

/// Service types.
#define PUS_SERVICE_VERIFICATION 1U
#define PUS_SERVICE_DEVICE_ACCESS 2U
#define PUS_SERVICE_HOUSEKEEPING 3U
#define PUS_SERVICE_STATISTICS 4U
#define PUS_SERVICE_EVENTS 5U
#define PUS_SERVICE_MEMORY 6U
#define PUS_SERVICE_FUNCTIONS 8U
#define PUS_SERVICE_TIME 9U
#define PUS_SERVICE_TIME_SCHEDULE 11U
#define PUS_SERVICE_MONITORING 12U
#define PUS_SERVICE_LARGE_PACKETS 13U
#define PUS_SERVICE_FORWARDING 14U
#define PUS_SERVICE_STORAGE 15U
#define PUS_SERVICE_TEST 17U
#define PUS_SERVICE_PROCEDURES 18U
#define PUS_SERVICE_EVENT_ACTION 19U
#define PUS_SERVICE_PARAMETERS 20U
#define PUS_SERVICE_SEQUENCES 21U
#define PUS_SERVICE_POSITION_SCHEDULE 22U
#define PUS_SERVICE_FILES 23U
#define PUS_SERVICE_MANAGEMENT 129U
#define PUS_SERVICE_RTLINK 130U
#define PUS_SERVICE_MISSION 131U

/// Failure codes of ST[01]; the high octet is the stage. The comment of each gives the meaning of its 32-bit
/// detail.
enum {
    PUS_FAILURE_NONE = 0,
    // Routing, TM[1,10].
    PUS_FAILURE_NO_ROUTE    = 0x0001, ///< APID
    PUS_FAILURE_UNAVAILABLE = 0x0002, ///< APID
    // Acceptance, TM[1,2].
    PUS_FAILURE_LENGTH           = 0x0101, ///< received octets
    PUS_FAILURE_CHECKSUM         = 0x0102, ///< computed checksum
    PUS_FAILURE_PUS_VERSION      = 0x0103, ///< version
    PUS_FAILURE_APID             = 0x0104, ///< APID
    PUS_FAILURE_SERVICE          = 0x0105, ///< service
    PUS_FAILURE_SUBTYPE          = 0x0106, ///< service << 8 | subtype
    PUS_FAILURE_SOURCE           = 0x0107, ///< source id
    PUS_FAILURE_DATA             = 0x0108, ///< octet offset in the application data
    PUS_FAILURE_QUEUE_FULL       = 0x0109, ///< 0
    PUS_FAILURE_PACKET_VERSION   = 0x010A, ///< version
    PUS_FAILURE_PACKET_TYPE      = 0x010B, ///< type bit
    PUS_FAILURE_SECONDARY_HEADER = 0x010C, ///< flag
    PUS_FAILURE_SEQUENCE_FLAGS   = 0x010D, ///< flags
    PUS_FAILURE_PERMISSION       = 0x0110, ///< mode << 8 | state
    PUS_FAILURE_LINK_MISSING     = 0x0111, ///< consumer APID << 16 | port
    PUS_FAILURE_RESOURCES        = 0x0112, ///< missing amount, in the resource's unit
    PUS_FAILURE_MEMBER_ACTIVE    = 0x0113, ///< APID of a network member that is operational
    PUS_FAILURE_INTERFACE        = 0x0114, ///< APID whose interface hash is not the supervisor's
    PUS_FAILURE_STATE_IN_DOUBT   = 0x0115, ///< APID that was silent and has not reported its state since
    // Start of execution, TM[1,4].
    PUS_FAILURE_UNKNOWN_ID   = 0x0201, ///< identifier
    PUS_FAILURE_EXISTS       = 0x0202, ///< identifier
    PUS_FAILURE_OUT_OF_RANGE = 0x0203, ///< octet offset in the application data
    PUS_FAILURE_STATE        = 0x0204, ///< identifier
    PUS_FAILURE_TABLE_FULL   = 0x0205, ///< maximum
    PUS_FAILURE_ACCESS  = 0x0206, ///< parameter id: not readable or not settable; event id: it has other data
    PUS_FAILURE_ADDRESS = 0x0207, ///< address
    PUS_FAILURE_PROTECTED     = 0x0208, ///< memory id, or id of a definition
    PUS_FAILURE_PAST          = 0x0209, ///< 0
    PUS_FAILURE_EMBEDDED      = 0x020A, ///< octet offset
    PUS_FAILURE_DUPLICATE     = 0x020B, ///< identifier
    PUS_FAILURE_MODE          = 0x020C, ///< mode
    PUS_FAILURE_DATA_CHECKSUM = 0x020D, ///< computed checksum
    // Progress of execution, TM[1,6].
    PUS_FAILURE_STEP = 0x0301, ///< step id
    // Completion of execution, TM[1,8].
    PUS_FAILURE_VERIFY       = 0x0401, ///< computed checksum
    PUS_FAILURE_NO_ANSWER    = 0x0402, ///< device id
    PUS_FAILURE_DEVICE       = 0x0403, ///< return code
    PUS_FAILURE_IO           = 0x0404, ///< system code, or status of the failed storage
    PUS_FAILURE_ABORTED      = 0x0405, ///< 0
    PUS_FAILURE_TIMEOUT      = 0x0406, ///< time that was waited [ms]
    PUS_FAILURE_SOME_FAILED  = 0x0407, ///< number of instructions failed
    PUS_FAILURE_LOST         = 0x0408, ///< APID of the addressee
    PUS_FAILURE_LINK_REFUSED = 0x0409, ///< reason << 8 | offending field, as in TM[130,5]
    PUS_FAILURE_PROCEDURE    = 0x040A, ///< line of the error, 0 unknown
    PUS_FAILURE_RESTARTED    = 0x040B  ///< number of the supervisor's life in this run
};

/// Added to the id of a failure that the descriptor of the sender defines (<Failure>); any stage.
#define PUS_FAILURE_OWN 0x8000U

#endif // PUS_CORE_TAILORING_H
