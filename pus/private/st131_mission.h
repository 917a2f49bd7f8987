// SPDX-License-Identifier: Apache-2.0
/// Mission service 131, the mission as a whole; served by the supervisor only.
///
///     TC 1 set mode {mode u8}                     TM 2 mode transition {previous u8, mode u8, cause u8}
///     TC 3 select packet log {strategy u8}        TM 4 packet log transition {previous u8, strategy u8,
///                                                      first record u64, code u16}
///     TC 5 shut down mission                      TC 6, 7 start, stop process {APID u16}
///     TC 8 report subsystems                      TM 9 {N u16 x {APID u16, process u8, state u8, phase u8,
///                                                      configuration u16, restarts u8}}
///     TC 10 report networks                       TM 11 {N u16 x {network u16, N2 u16 x {APID u16},
///                                                      N3 u16 x {link u16}}}
#ifndef PUS_PRIVATE_ST131_MISSION_H
#define PUS_PRIVATE_ST131_MISSION_H

#include "pus/core/service.h"

enum {
    PUS_MISSION_SET_MODE          = 1,
    PUS_MISSION_MODE_TRANSITION   = 2,
    PUS_MISSION_SELECT_LOG        = 3,
    PUS_MISSION_LOG_TRANSITION    = 4,
    PUS_MISSION_SHUT_DOWN         = 5,
    PUS_MISSION_START_PROCESS     = 6,
    PUS_MISSION_STOP_PROCESS      = 7,
    PUS_MISSION_REPORT_SUBSYSTEMS = 8,
    PUS_MISSION_SUBSYSTEMS        = 9,
    PUS_MISSION_REPORT_NETWORKS   = 10,
    PUS_MISSION_NETWORKS          = 11
};

/// Packet log strategies.
typedef enum {
    PUS_LOG_ASCII      = 0,
    PUS_LOG_SQLITE     = 1,
    PUS_LOG_POSTGRESQL = 2,
    PUS_LOG_RING       = 3
} pus_log_strategy_t;

/// TM[131,2].
typedef struct {
    uint8_t previous;
    uint8_t mode;
    uint8_t cause; ///< pus_cause_t of service 129.
} pus_mode_transition_t;

/// TM[131,4].
typedef struct {
    uint8_t previous; ///< pus_log_strategy_t.
    uint8_t strategy; ///< pus_log_strategy_t.
    uint64_t first_record;
    uint16_t code; ///< PUS_FAILURE_*: the reason for which the strategy was changed, or the change failed.
} pus_log_transition_t;

/// One entry of TM[131,9].
typedef struct {
    uint16_t apid;
    uint8_t process; ///< 0 stopped, 1 running, 2 lost.
    uint8_t state;
    uint8_t phase;
    uint16_t configuration;
    uint8_t restarts; ///< Restarts of the process after it was lost.
} pus_subsystem_entry_t;

/// One entry of TM[131,11]. The arrays belong to the port and are valid until its next call.
typedef struct {
    uint16_t network;
    uint16_t member_count;
    uint16_t link_count;
    const uint16_t* members; ///< APIDs.
    const uint16_t* links;   ///< Link ids.
} pus_network_entry_t;

/// Port of the service to the supervisor. All functions are mandatory.
typedef struct {
    void* context;
    pus_reply_t (*set_mode)(void* context, uint8_t mode, const pus_token_t* token, uint64_t now_ns);
    pus_reply_t (*select_log)(void* context, uint8_t strategy, const pus_token_t* token, uint64_t now_ns);
    pus_reply_t (*shut_down)(void* context, const pus_token_t* token, uint64_t now_ns);
    pus_reply_t (*start_process)(void* context, uint16_t apid, const pus_token_t* token, uint64_t now_ns);
    pus_reply_t (*stop_process)(void* context, uint16_t apid, const pus_token_t* token, uint64_t now_ns);
    /// Get entry number `index` (0, 1, ...); false after the last one. Must not send reports.
    bool (*subsystem)(void* context, uint16_t index, pus_subsystem_entry_t* out_entry);
    bool (*network)(void* context, uint16_t index, pus_network_entry_t* out_entry);
} pus_mission_port_t;

typedef struct { // Private.
    pus_mission_port_t port;
} pus_mission_t;

void pus_mission_init(pus_mission_t* mission, const pus_mission_port_t* port);
pus_service_t pus_mission_service(pus_mission_t* mission);

/// Send a report to all ground users. Status of pus_tm_post.
status_t pus_mode_transition_report(pus_app_process_t* process, const pus_mode_transition_t* transition,
                                    uint64_t now_ns);
status_t pus_log_transition_report(pus_app_process_t* process, const pus_log_transition_t* transition,
                                   uint64_t now_ns);

#endif // PUS_PRIVATE_ST131_MISSION_H
