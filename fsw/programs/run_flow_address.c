// SPDX-License-Identifier: Apache-2.0
#include "fsw/programs/run_flow_address.h"

#include "base/text.h"

#include <string.h>

#define SHARED_DIRECTORY "/dev/shm" // The launcher and the simulator use the same directory.

static void add_ipv4(text_t* const text, const uint32_t ipv4)
{
    for (uint32_t shift = 24U;; shift -= 8U) {
        text_add_unsigned(text, (ipv4 >> shift) & 0xFFU);
        if (shift == 0U) {
            return;
        }
        text_add(text, ".");
    }
}

/// Add "/RUN.flow."; the name of a flow follows.
static void add_prefix(text_t* const text, const run_state_t* const run)
{
    text_add_words(text, (const char* const[]){"/", run->identity, ".flow.", NULL});
}

/// Add a path as part of a name: without the first slash, and with dots instead of the other slashes.
static void add_path(text_t* const text, const char* const path)
{
    for (const char* next = &path[(path[0] == '/') ? 1U : 0U]; *next != '\0'; next++) {
        text_add_character(text, (*next == '/') ? '.' : *next);
    }
}

static status_t status_of(const text_t* const address, const text_t* const counts)
{
    return (address->cut || counts->cut) ? STATUS_NOT_FOUND : STATUS_OK;
}

static status_t queue_address(run_state_t* const run, const char* const name,
                              flow_endnode_address_t* const out_address)
{
    text_t text = text_in(out_address->address, sizeof out_address->address);
    add_prefix(&text, run);
    text_add(&text, name);
    if (text.cut) {
        return STATUS_NOT_FOUND;
    }
    return (run_state_note_flow(run, out_address->address) == STATUS_OK) ? STATUS_OK : STATUS_NOT_FOUND;
}

static status_t socket_address(const run_state_t* const run, const flow_endnode_kind_t kind,
                               const char* const name, flow_endnode_address_t* const out_address)
{
    const char* const colon = strrchr(name, ':');
    const char* const port  = (colon != NULL) ? colon : "";
    // ":PORT" names the socket of the flight software, "HOST:PORT" that of the device.
    const bool is_own = (colon == name);
    text_t text       = text_in(out_address->address, sizeof out_address->address);
    text_t counts     = text_in(out_address->counts, sizeof out_address->counts);
    if (run->has_simulator) {
        add_ipv4(&text, is_own ? OSAL_IPV4_OF_FLIGHT(run->instance) : OSAL_IPV4_OF_DEVICES(run->instance));
        text_add(&text, port);
    } else {
        text_add_words(&text, (const char* const[]){is_own ? "0.0.0.0" : "", name, NULL});
    }
    if (run->has_simulator && run->is_stepped && !is_own && (port[0] != '\0')) {
        add_prefix(&counts, run);
        text_add_words(&counts,
                       (const char* const[]){(kind == ENDNODE_UDP) ? "udp." : "tcp.", &port[1], ".n", NULL});
    }
    return status_of(&text, &counts);
}

static status_t device_address(const run_state_t* const run, const char* const path,
                               flow_endnode_address_t* const out_address)
{
    text_t text   = text_in(out_address->address, sizeof out_address->address);
    text_t counts = text_in(out_address->counts, sizeof out_address->counts);
    if (!run->has_simulator) {
        text_add(&text, path);
        return status_of(&text, &counts);
    }
    text_add(&text, SHARED_DIRECTORY);
    add_prefix(&text, run);
    add_path(&text, path);
    if (run->is_stepped) {
        add_prefix(&counts, run);
        add_path(&counts, path);
        text_add(&counts, ".n");
    }
    return status_of(&text, &counts);
}

status_t run_flow_address(run_state_t* const run, const flow_endnode_kind_t kind, const char* const name,
                          flow_endnode_address_t* const out_address)
{
    if ((kind == ENDNODE_SHM) || (kind == ENDNODE_MQUEUE)) {
        return queue_address(run, name, out_address);
    }
    if ((kind == ENDNODE_UDP) || (kind == ENDNODE_TCP)) {
        return socket_address(run, kind, name, out_address);
    }
    return device_address(run, name, out_address);
}
