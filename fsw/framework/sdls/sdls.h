// SPDX-License-Identifier: Apache-2.0
/// Receiver of authenticated telecommands: TC transfer frames (CCSDS 232.0-B) with Space Data Link Security
/// (CCSDS 355.0-B), AES-256 in Galois/Counter mode. Layout of a frame: docs/ground-link-security.md.
///
/// A number (session, count) is accepted once. A session belongs to one connection. The first frame of the
/// connection has count 0 and a session number higher than any before; the number is written to the disk
/// before the frame is accepted. After that only the next count is accepted. So no frame is accepted twice,
/// late or out of order, even after a restart or a power cut. A frame that cannot be accepted (another kind
/// of frame, a full disk) is refused and counted.
///
/// Ownership  The caller provides receiver and sessions.
/// Context    One task; the first frame of a session waits for the disk.
/// Time       O(frame). Nothing is allocated.
#ifndef FSW_FRAMEWORK_SDLS_SDLS_H
#define FSW_FRAMEWORK_SDLS_SDLS_H

#include "base/status.h"
#include "fsw/framework/sdls/session_mark.h"

#include <nettle/gcm.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define SDLS_SPACECRAFT 1U ///< Spacecraft identifier of the frames.
#define SDLS_SPI 1U        ///< Security parameter index: number of the security association.
#define SDLS_KEY_OCTETS 32U
#define SDLS_VECTOR_OCTETS 12U
#define SDLS_MAC_OCTETS 16U
#define SDLS_HEADER_OCTETS 5U
/// Octets in front of the ciphertext, which are authenticated but not encrypted.
#define SDLS_CLEAR_OCTETS 20U
#define SDLS_FRAME_MAX 1024U
#define SDLS_FRAME_MIN (SDLS_CLEAR_OCTETS + 1U + SDLS_MAC_OCTETS)
#define SDLS_PACKET_MAX 4096U

typedef enum {
    SDLS_REFUSED_FRAME = 0,   ///< Not a frame of this link: its length cannot be trusted.
    SDLS_REFUSED_ASSOCIATION, ///< Another security parameter index.
    SDLS_REFUSED_FORGED,      ///< The MAC is wrong.
    SDLS_REFUSED_REPLAYED,    ///< The frame is authentic, but its number is not the next one.
    SDLS_REFUSED_PARTS,       ///< The parts do not form one packet, or are longer than a packet can be.
    /// The session number could not be written to the disk, or the receiver is closed.
    SDLS_REFUSED_NOT_KEPT,
    SDLS_REFUSALS
} sdls_refusal_t;

typedef struct { // Private, except the counters.
    struct gcm_aes256_ctx cipher;
    bool is_open; // False: every frame is refused.
    sdls_session_mark_t mark;
    uint32_t accepted;               ///< Frames accepted [wraps].
    uint32_t refused[SDLS_REFUSALS]; ///< Frames refused, by reason [wraps].
} sdls_receiver_t;

typedef struct { // Private: one connection.
    bool is_bound;
    uint32_t session;
    uint32_t next;    // Count that the next frame must have.
    bool is_spent;    // The highest possible count was used: no further frame is accepted in this session.
    size_t held;      // Octets of the packet received so far.
    size_t candidate; // Octets of the frame that sdls_look returned and that is not accepted yet.
    bool is_last;     // The candidate ends the packet.
    uint8_t packet[SDLS_PACKET_MAX];
} sdls_session_t;

typedef struct {
    size_t taken; ///< Octets of the frame, accepted or refused; 0: the start of the next one is unknown.
    const uint8_t* packet; ///< Null: more parts of the packet follow. Valid until the session is used again.
    size_t size;
} sdls_frame_t;

/// Make a receiver without a key, which refuses every frame (SDLS_REFUSED_NOT_KEPT).
void sdls_close(sdls_receiver_t* receiver);
/// Set the key, and open the session mark of the key. The caller wipes its copy of the key afterwards.
/// STATUS_OK; STATUS_INVALID, STATUS_FULL, STATUS_IO as sdls_session_mark_open: the receiver stays closed.
MUST_USE status_t sdls_open(sdls_receiver_t* receiver, const uint8_t key[SDLS_KEY_OCTETS],
                            const medium_t* medium);
/// Prepare a session for a new connection.
void sdls_begin(sdls_session_t* session);
/// Check the frame at the start of `octets`. STATUS_OK: the frame is authentic and the next one; call
/// sdls_accept to accept it, or check the same octets again later. STATUS_TRUNCATED: the frame is
/// incomplete. Refused and counted: STATUS_INVALID (frame), STATUS_NOT_FOUND (association), STATUS_CHECKSUM
/// (forged), STATUS_STALE (replayed), STATUS_OUT_OF_RANGE (parts), STATUS_IO (not kept).
MUST_USE status_t sdls_look(sdls_receiver_t* receiver, sdls_session_t* session, const uint8_t* octets,
                            size_t size, sdls_frame_t* out_frame);
/// Accept the frame that sdls_look has just returned.
void sdls_accept(sdls_receiver_t* receiver, sdls_session_t* session);

/// Overwrite a secret; the compiler cannot remove this write.
void sdls_wipe(void* secret, size_t size);

#endif // FSW_FRAMEWORK_SDLS_SDLS_H
