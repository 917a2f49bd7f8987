// SPDX-License-Identifier: Apache-2.0
// Proves: if the mission has a key, dividing the TCP stream of a ground user into protected frames
//     accesses nothing after the received octets; only the content of an authentic frame is read as a
//     packet, and only content that is exactly one packet is returned; the stream always advances by a
//     frame, waits for the rest of an incomplete one, or is closed; it is closed if and only if the start
//     of the next frame is unknown or a third frame of the connection is refused.
// Bounds: one frame of 0..42 octets of any content; the second of two clients (8 in flight) in every
//     state with less than three refused frames, by induction any number of frames; frames of up to 40
//     octets instead of 1024, packets of up to 8 instead of 4096.
// Replaced: the cipher decrypts to any octets, and the comparison of the MAC has any result; the
//     session mark may fail to be written (fsw/framework/sdls/replaced_cipher.h). The size in the header
//     of a packet is any size (pus/core/packet is in the proof ground_framing).
// Sources: fsw/subsystems/communication/ground_security.c fsw/framework/sdls/sdls.c base/octets.c
// Options: --unwind 7
// Reduced: fsw/framework/sdls/sdls.h
//   - #define SDLS_FRAME_MAX 1024U
//   + #define SDLS_FRAME_MAX 40U
// Reduced: fsw/framework/sdls/sdls.h
//   - #define SDLS_PACKET_MAX 4096U
//   + #define SDLS_PACKET_MAX 8U
// Reduced: fsw/subsystems/communication/ground_security.h
//   - #define GROUND_CLIENTS 8U
//   + #define GROUND_CLIENTS 2U
// Fault: fsw/subsystems/communication/ground_security.c
//   - (packet_size != frame.size)) {
//   + (packet_size > frame.size)) {
// Fault: fsw/subsystems/communication/ground_security.c
//   - return ((taken == 0U) || (self->refusals[client] >= GROUND_REFUSALS_MAX)) ? STATUS_CLOSED : STATUS_OK;
//   + return (self->refusals[client] >= GROUND_REFUSALS_MAX) ? STATUS_CLOSED : STATUS_OK;
// Fault: fsw/framework/sdls/sdls.c
//   - if (!is_authentic(self, session, octets, content)) {
//   + if (!is_authentic(self, session, octets, content) && session->is_bound) {
#include "fsw/subsystems/communication/ground_security.h"
#include "test/proof/fsw/framework/sdls/replaced_cipher.h"

#define RECEIVED (SDLS_FRAME_MAX + 2U)
#define CLIENT 1U

static communication_ground_security_t security;
static sdls_receiver_t receiver;
static size_t stated_size; // Size of the packet as its header states it.

status_t pus_packet_frame(const uint8_t* const octets, const size_t size, size_t* const out_size)
{
    static const status_t statuses[] = {STATUS_OK, STATUS_TRUNCATED, STATUS_TOO_LARGE};
    PROVE(cipher_is_authentic, "only the content of an authentic frame is read as a packet");
    PROVE(__CPROVER_r_ok(octets, size), "the content is there");
    stated_size = nondet_size();
    *out_size   = stated_size;
    return statuses[any_size(2U)];
}

void proof(void)
{
    const size_t size = any_size(RECEIVED);
    uint8_t octets[size];
    communication_ground_security_init(&security, &receiver);
    sdls_session_t* const session = &security.sessions[CLIENT];
    sdls_session_t any;
    __CPROVER_havoc_object(&any);
    *session                  = any;
    receiver.is_open          = nondet_bool();
    receiver.mark.session     = nondet_u32();
    security.refusals[CLIENT] = nondet_u8();
    ASSUME((session->held <= SDLS_PACKET_MAX) && (security.refusals[CLIENT] < GROUND_REFUSALS_MAX));
    const uint8_t refusals = security.refusals[CLIENT];

    communication_ground_unit_t unit;
    cipher_examine(octets);
    const status_t status = communication_ground_security_next(&security, CLIENT, octets, size, &unit);
    const bool is_refused = (security.refusals[CLIENT] != refusals);
    PROVE((status == STATUS_OK) || (status == STATUS_TRUNCATED) || (status == STATUS_CLOSED),
          "the status is one of the contract");
    PROVE(unit.taken <= size, "the stream advances inside what was received");
    PROVE(IMPLIES(status == STATUS_OK, unit.taken > 0U), "the stream advances");
    PROVE(IMPLIES(status == STATUS_TRUNCATED, (unit.packet == NULL) && !is_refused),
          "an incomplete frame waits and is not refused");
    PROVE((status == STATUS_CLOSED) ==
              (is_refused && ((unit.taken == 0U) || (security.refusals[CLIENT] == GROUND_REFUSALS_MAX))),
          "the connection is closed if and only if a start is lost or a third frame is refused");
    PROVE(security.refusals[CLIENT] == (refusals + (is_refused ? 1U : 0U)), "refused frames are counted");
    if (unit.packet != NULL) {
        PROVE(cipher_is_authentic && (status == STATUS_OK) && !is_refused,
              "a packet is the content of an authentic frame");
        PROVE((unit.packet == session->packet) && (unit.size <= SDLS_PACKET_MAX) &&
                  (unit.size == stated_size),
              "a packet has the size that its header states");
        communication_ground_security_accept(&security, CLIENT);
        PROVE(session->held == 0U, "the next frame begins a packet");
    }
}
