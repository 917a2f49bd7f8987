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
    uint16_t
        number; ///< Target state (129,1), configuration (129,3), mission_link_t.number (130,x); otherwise 0.
    uint16_t target; ///< APID.
    uint8_t mode;    ///< Present mode id.
    uint8_t state;   ///< Present state of the target.
} permission_request_t;

#define PERMISSION_RULE_NONE (-1)   ///< Denied: nothing allows it.
#define PERMISSION_RULE_ALWAYS (-2) ///< Allowed by the built-in set.

/// Deny by default. Always allowed, in every mode and state: ST[17]; requests that only report data (3,9
/// 11,17 20,1 and so on: the catalogue of messages gives each an answer; those that read memories or devices,
/// or reset or abort what they report, are not among them); requests for a lower state (129,1 to a lower rest
/// state among 0, 3, 4, 5, or to 0) and for ERROR_OPERATIONAL; closing a link (130,7); shutting the mission
/// down (131,5). Pure; O(rules). STATUS_OK or STATUS_FORBIDDEN; *out_rule = index in `rules`, or one of the
/// above.
MUST_USE status_t supervisor_permission_check(const mission_descriptor_t* mission,
                                              const permission_request_t* request, int* out_rule);

#endif // FSW_SUPERVISOR_PERMISSION_MATRIX_H
