// SPDX-License-Identifier: Apache-2.0
/// The permission matrix of a mission as a pure function.
///
/// Context  Any; reads the mission only.
#ifndef FSW_SUPERVISOR_PERMISSION_MATRIX_H
#define FSW_SUPERVISOR_PERMISSION_MATRIX_H

#include "fsw/framework/descriptor/mission_descriptor.h"

typedef struct { // The properties of a telecommand that permissions check.
    uint8_t service;
    uint8_t subtype;
    const char* select; ///< Function name (TC[8,1]) without padding; otherwise NULL.
    /// Target state (129,1), configuration (129,3), mission_link_t.number (130,x), first octet of the
    /// arguments (131,x); otherwise 0.
    uint16_t number;
    uint16_t target; ///< APID of the target.
    uint8_t mode;    ///< Present mode id.
    uint8_t state;   ///< Present state of the target.
} permission_request_t;

#define PERMISSION_RULE_NONE (-1)   ///< Denied: no rule permits the request.
#define PERMISSION_RULE_ALWAYS (-2) ///< Permitted by the built-in set.

/// Decide whether a telecommand is permitted: it is denied unless a rule permits it. Always permitted, in
/// every mode and state: ST[17]; requests that only report data (TC[3,9], [11,17], [20,1] and so on: those
/// for which the catalogue of messages has an answer, except those that read memories or devices, or reset or
/// abort what they report); TC[129,1] for OFFLINE, for ERROR_OPERATIONAL, and from a state up to OPERATIONAL
/// for the same or a lower one (not below PRE_OPERATIONAL); closing a link (TC[130,7]); shutting the mission
/// down (TC[131,5]). It takes O(rules).
/// STATUS_OK or STATUS_FORBIDDEN; *out_rule is an index in `rules`, or one of the values above.
MUST_USE status_t supervisor_permission_check(const mission_descriptor_t* mission,
                                              const permission_request_t* request, int* out_rule);

#endif // FSW_SUPERVISOR_PERMISSION_MATRIX_H
