// SPDX-License-Identifier: Apache-2.0
#include "fsw/subsystems/communication/ground_security.h"

#include "base/assertion.h"
#include "pus/core/packet.h"

#include <string.h>

void communication_ground_security_init(communication_ground_security_t* const self,
                                        sdls_receiver_t* const receiver)
{
    FSW_ASSERT(self != NULL);
    (void)memset(self, 0, sizeof *self);
    self->receiver = receiver;
}

void communication_ground_security_connected(communication_ground_security_t* const self,
                                             const unsigned client)
{
    FSW_ASSERT((self != NULL) && (client < GROUND_CLIENTS));
    sdls_begin(&self->sessions[client]);
    self->refusals[client] = 0U;
    self->since[client]    = self->cycle;
}

unsigned communication_ground_security_unauthenticated(const communication_ground_security_t* const self,
                                                       const unsigned spared)
{
    FSW_ASSERT(self != NULL);
    unsigned found = GROUND_CLIENTS;
    // A client with age 0 is not chosen: it was accepted in this cycle and could not send yet.
    uint32_t longest = 0U;
    for (unsigned client = 0U; (self->receiver != NULL) && (client < GROUND_CLIENTS); client++) {
        const uint32_t age = self->cycle - self->since[client];
        if ((client != spared) && !self->sessions[client].is_bound && (age > longest)) {
            found   = client;
            longest = age;
        }
    }
    return found;
}

static status_t next_packet(const uint8_t* const octets, const size_t size,
                            communication_ground_unit_t* const out_unit)
{
    size_t packet_size    = 0U;
    const status_t status = pus_packet_frame(octets, size, &packet_size);
    *out_unit             = (communication_ground_unit_t){octets, packet_size, packet_size};
    return ((status == STATUS_OK) || (status == STATUS_TRUNCATED)) ? status : STATUS_CLOSED;
}

/// Count a refused frame. STATUS_CLOSED if its end is unknown, or after too many refused frames.
static status_t refused(communication_ground_security_t* const self, const unsigned client,
                        const size_t taken)
{
    self->refusals[client]++;
    return ((taken == 0U) || (self->refusals[client] >= GROUND_REFUSALS_MAX)) ? STATUS_CLOSED : STATUS_OK;
}

static status_t next_frame(communication_ground_security_t* const self, const unsigned client,
                           const uint8_t* const octets, const size_t size,
                           communication_ground_unit_t* const out_unit)
{
    sdls_frame_t frame;
    size_t packet_size    = 0U;
    const status_t status = sdls_look(self->receiver, &self->sessions[client], octets, size, &frame);
    *out_unit             = (communication_ground_unit_t){frame.packet, frame.size, frame.taken};
    if (status != STATUS_OK) {
        return (status == STATUS_TRUNCATED) ? status : refused(self, client, frame.taken);
    }
    if (frame.packet == NULL) { // Further parts of the packet follow.
        sdls_accept(self->receiver, &self->sessions[client]);
    } else if ((pus_packet_frame(frame.packet, frame.size, &packet_size) != STATUS_OK) ||
               (packet_size != frame.size)) {
        // The sender has the key, but the content is not one telecommand packet.
        sdls_accept(self->receiver, &self->sessions[client]);
        self->receiver->refused[SDLS_REFUSED_PARTS]++;
        out_unit->packet = NULL;
        return refused(self, client, frame.taken);
    } else {
        // The caller accepts the frame when it has processed the packet.
    }
    return STATUS_OK;
}

status_t communication_ground_security_next(communication_ground_security_t* const self,
                                            const unsigned client, const uint8_t* const octets,
                                            const size_t size, communication_ground_unit_t* const out_unit)
{
    FSW_ASSERT((self != NULL) && (client < GROUND_CLIENTS) && (octets != NULL) && (out_unit != NULL));
    return (self->receiver == NULL) ? next_packet(octets, size, out_unit)
                                    : next_frame(self, client, octets, size, out_unit);
}

void communication_ground_security_accept(communication_ground_security_t* const self, const unsigned client)
{
    FSW_ASSERT((self != NULL) && (client < GROUND_CLIENTS));
    if (self->receiver != NULL) {
        sdls_accept(self->receiver, &self->sessions[client]);
    }
}

void communication_ground_security_publish(const communication_ground_security_t* const self,
                                           communication_security_t* const out_parameter)
{
    FSW_ASSERT((self != NULL) && (out_parameter != NULL));
    const sdls_receiver_t* const receiver = self->receiver;
    if (receiver == NULL) {
        return;
    }
    out_parameter->is_on       = 1U;
    out_parameter->accepted    = receiver->accepted;
    out_parameter->no_frame    = receiver->refused[SDLS_REFUSED_FRAME];
    out_parameter->unknown_spi = receiver->refused[SDLS_REFUSED_ASSOCIATION];
    out_parameter->forged      = receiver->refused[SDLS_REFUSED_FORGED];
    out_parameter->replayed    = receiver->refused[SDLS_REFUSED_REPLAYED];
    out_parameter->bad_parts   = receiver->refused[SDLS_REFUSED_PARTS];
    out_parameter->not_kept    = receiver->refused[SDLS_REFUSED_NOT_KEPT];
}

void communication_ground_security_report(communication_ground_security_t* const self,
                                          subsystem_t* const generic)
{
    FSW_ASSERT((self != NULL) && (generic != NULL));
    self->cycle++;
    if (self->receiver == NULL) {
        return;
    }
    uint32_t all = 0U;
    for (unsigned reason = 0U; reason < (unsigned)SDLS_REFUSALS; reason++) {
        all += self->receiver->refused[reason];
    }
    self->quiet -= (self->quiet > 0U) ? 1U : 0U;
    if ((self->quiet > 0U) || (all == self->reported)) {
        return;
    }
    const uint32_t lost  = self->receiver->refused[SDLS_REFUSED_NOT_KEPT];
    const uint16_t event = (lost != self->lost) ? (uint16_t)COMMUNICATION_EVENT_TC_NOT_KEPT
                                                : (uint16_t)COMMUNICATION_EVENT_TC_NOT_AUTHENTIC;
    self->quiet          = GROUND_EVENT_CYCLES;
    self->reported       = all;
    self->lost           = lost;
    (void)subsystem_raise(generic, event, NULL, 0U); // The event samples the counters of all refusals so far.
}
