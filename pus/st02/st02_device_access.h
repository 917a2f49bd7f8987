// SPDX-License-Identifier: Apache-2.0
/// ST[02] device access, all 11 messages: direct access to on/off devices, registers, command pulses,
/// physical and logical devices, without the application that normally drives them. Rules and refusals:
/// docs/services/st02.md.
///
/// A request is a list of instructions. A port performs them one after the other. Each instruction is started
/// and then polled in every step until it has ended. Several requests can be in progress at the same time.
///
/// Protocol-specific data are four octets; the port knows their meaning. The port defines the return codes of
/// acquisitions; 0xFFFF is the time-out.
///
/// Ownership  The caller provides operations.
/// Context    The loop of the process.
/// Time       A step is O(requests in progress).
#ifndef PUS_ST02_ST02_DEVICE_ACCESS_H
#define PUS_ST02_ST02_DEVICE_ACCESS_H

#include "pus/core/service.h"

#define PUS_DEVICE_DATA_MAX 512U          ///< Maximum size of the data of one acquisition [octets].
#define PUS_DEVICE_PROTOCOL_SIZE 4U       ///< Protocol-specific data [octets].
#define PUS_DEVICE_INSTRUCTIONS_MAX 2048U ///< More than any request can contain.
/// Registers of one TC[2,5]: their addresses and values fit one report.
#ifndef PUS_DEVICE_REGISTERS_MAX
#define PUS_DEVICE_REGISTERS_MAX PUS_COUNT_OF(PUS_TM_DATA_MAX - 2U, 8U)
#endif
#define PUS_DEVICE_TIMED_OUT 0xFFFFU ///< Return code of an acquisition that timed out.

/// Kind of an instruction: the subtype of its request.
enum {
    PUS_DEVICE_SWITCH          = 1,
    PUS_DEVICE_LOAD_REGISTER   = 2,
    PUS_DEVICE_PULSE           = 4,
    PUS_DEVICE_DUMP_REGISTER   = 5,
    PUS_DEVICE_COMMAND         = 7,
    PUS_DEVICE_ACQUIRE         = 8,
    PUS_DEVICE_LOGICAL_COMMAND = 10,
    PUS_DEVICE_LOGICAL_ACQUIRE = 11
};

/// One instruction; valid during the call.
typedef struct {
    uint8_t kind;
    uint8_t exponent;        ///< PULSE: its length is the basic duration times 2^exponent.
    uint16_t device;         ///< On/off address, CPDU, physical or logical device. Registers: 0.
    uint16_t command;        ///< LOGICAL_COMMAND: command id. PULSE: output line.
    uint32_t address;        ///< Register address; LOGICAL_ACQUIRE: parameter id.
    const uint8_t* protocol; ///< COMMAND, ACQUIRE: PUS_DEVICE_PROTOCOL_SIZE octets.
    const uint8_t* data;     ///< LOAD_REGISTER (4 octets), COMMAND, LOGICAL_COMMAND.
    uint16_t size;           ///< Size of data [octets].
} pus_device_action_t;

typedef struct {
    uint16_t return_code; ///< Code of an acquisition; not 0 if it failed.
    uint32_t detail;      ///< Detail of the failure in TM[1,6] and TM[1,8], if it failed.
    uint16_t size;        ///< Size of the data that were read; a register has 4.
    uint8_t data[PUS_DEVICE_DATA_MAX];
} pus_device_result_t;

typedef struct {
    void* context;
    /// Check an instruction without effect. STATUS_OK, STATUS_NOT_FOUND (device), STATUS_OUT_OF_RANGE
    /// (another field), STATUS_FORBIDDEN (not permitted now).
    status_t (*check)(void* context, const pus_device_action_t* action);
    /// Begin an instruction in a free `slot`, 0..operations - 1. STATUS_OK, STATUS_FULL (try again in the
    /// next step), STATUS_IO (failed: *out_result is the reason).
    status_t (*begin)(void* context, uint8_t slot, const pus_device_action_t* action,
                      pus_device_result_t* out_result);
    /// Poll the instruction of a slot. STATUS_BUSY, STATUS_OK (performed, *out_result has the data),
    /// STATUS_IO (failed).
    status_t (*poll)(void* context, uint8_t slot, pus_device_result_t* out_result);
    /// Called at the time-out: abort the instruction and free its slot.
    void (*abandon)(void* context, uint8_t slot);
} pus_device_port_t;

typedef struct { // Private: position in the instructions of a request.
    octet_reader_t reader;
    uint8_t kind;
    uint8_t left;  // Remaining instructions, or remaining CPDUs.
    uint8_t inner; // Remaining pulses of the CPDU.
    uint16_t cpdu;
    uint16_t transaction;
    uint16_t number; // Number of the instruction, from 1.
    uint32_t offset; // Octet offset of the instruction in the application data.
} pus_device_cursor_t;

typedef struct {   // Private: a request in progress.
    uint8_t phase; // 0: the structure is free.
    pus_device_cursor_t cursor;
    pus_device_action_t action;
    pus_device_result_t result;
    uint64_t deadline_ns;
    uint16_t refused;
    pus_failure_t failure; // First failure of the request.
    pus_token_t token;
    uint8_t left_out[PUS_DEVICE_INSTRUCTIONS_MAX / 8U]; // Bit n - 1: instruction n was refused, or failed.
    uint32_t values[PUS_DEVICE_REGISTERS_MAX];          // Values of registers.
    uint8_t data[PUS_TC_DATA_MAX];
    size_t size;
} pus_device_operation_t;

typedef struct {
    pus_app_process_t* process;
    pus_device_port_t port;
    pus_device_operation_t* operations;
    uint8_t operation_count;
    uint64_t timeout_ns; ///< Longest duration of one instruction.
} pus_device_config_t;

typedef struct { // Private, except `counters`: read-only, for telemetry.
    pus_device_config_t config;
    uint8_t running;
    struct {
        uint32_t performed; ///< Instructions performed.
        uint32_t failed;    ///< Instructions that failed.
        uint32_t refused;   ///< Instructions refused.
        uint32_t timed_out; ///< Failed instructions that timed out.
    } counters;
} pus_device_access_t;

void pus_device_access_init(pus_device_access_t* access, const pus_device_config_t* config);
/// Entry of the service for a dispatcher, with subtypes and step.
pus_service_t pus_device_access_service(pus_device_access_t* access);
/// Continue all requests.
void pus_device_access_step(pus_device_access_t* access, uint64_t now_ns);

#endif // PUS_ST02_ST02_DEVICE_ACCESS_H
