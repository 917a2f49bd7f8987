// SPDX-License-Identifier: Apache-2.0
#include "fsw/framework/dataflow/endnode.h"

#include "base/assertion.h"

#include <stddef.h>
#include <string.h>

status_t flow_endnode_resolve(const flow_resolver_t* const resolver, const flow_endnode_kind_t kind,
                              const char* const name, flow_endnode_address_t* const out_address)
{
    FSW_ASSERT((resolver != NULL) && (resolver->resolve != NULL) && (name != NULL) && (out_address != NULL));
    *out_address = (flow_endnode_address_t){.is_fd = false};
    if (resolver->resolve(resolver->context, kind, name, out_address) != STATUS_OK) {
        return STATUS_NOT_FOUND;
    }
    const bool ends = (memchr(out_address->address, '\0', ENDNODE_ADDRESS_MAX) != NULL) &&
                      (memchr(out_address->counts, '\0', ENDNODE_ADDRESS_MAX) != NULL);
    return ends ? STATUS_OK : STATUS_INVALID;
}

/// Read a decimal number up to `limit` at *text, and move *text past it. False if there is none or it is
/// too large.
static bool take_number(const char** const text, const uint32_t limit, uint32_t* const out_number)
{
    const char* digit = *text;
    uint32_t number   = 0U;
    while ((*digit >= '0') && (*digit <= '9') && (number <= limit)) {
        number = (number * 10U) + (uint32_t)(*digit - '0');
        digit++;
    }
    const bool is_number = (digit != *text) && (number <= limit);
    *text                = digit;
    *out_number          = number;
    return is_number;
}

status_t flow_endnode_socket_address(const char* const text, osal_address_t* const out_address)
{
    FSW_ASSERT((text != NULL) && (out_address != NULL));
    static const char separators[] = {'.', '.', '.', ':'};
    const char* rest               = text;
    uint32_t ipv4                  = 0U;
    uint32_t number                = 0U;
    for (unsigned i = 0U; i < sizeof separators; i++) {
        if (!take_number(&rest, 255U, &number) || (*rest != separators[i])) {
            return STATUS_INVALID;
        }
        ipv4 = (ipv4 << 8) | number;
        rest++;
    }
    if (!take_number(&rest, 65535U, &number) || (*rest != '\0')) {
        return STATUS_INVALID;
    }
    *out_address = (osal_address_t){.ipv4 = ipv4, .port = (uint16_t)number};
    return STATUS_OK;
}

status_t flow_endnode_open_counts(const flow_endnode_address_t* const address,
                                  osal_hand_over_t* const out_counts)
{
    FSW_ASSERT((address != NULL) && (out_counts != NULL));
    *out_counts = (osal_hand_over_t)OSAL_HAND_OVER_CLOSED;
    return (address->counts[0] != '\0') ? osal_hand_over_open(out_counts, address->counts) : STATUS_OK;
}

status_t flow_endnode_resolve_socket(const flow_resolver_t* const resolver, const flow_endnode_kind_t kind,
                                     const char* const name, osal_address_t* const out_address,
                                     osal_hand_over_t* const out_counts)
{
    flow_endnode_address_t address;
    status_t status = flow_endnode_resolve(resolver, kind, name, &address);
    if (status == STATUS_OK) {
        status = flow_endnode_socket_address(address.address, out_address);
    }
    return (status == STATUS_OK) ? flow_endnode_open_counts(&address, out_counts) : status;
}
