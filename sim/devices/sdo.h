// SPDX-License-Identifier: Apache-2.0
/// SDO server of CiA 301: expedited and segmented upload and download. Block transfer is refused.
///
/// Implements the protocol only: a request of eight octets gives a reply of eight octets. It needs neither
/// time nor bus.
#ifndef SIM_DEVICES_SDO_H
#define SIM_DEVICES_SDO_H

#include "sim/devices/dictionary.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define SDO_OCTETS 8U

#define SDO_ABORT_TOGGLE 0x05030000U
#define SDO_ABORT_COMMAND 0x05040001U
#define SDO_ABORT_WRITE_ONLY 0x06010001U
#define SDO_ABORT_READ_ONLY 0x06010002U
#define SDO_ABORT_NO_OBJECT 0x06020000U
#define SDO_ABORT_NOT_MAPPABLE 0x06040041U
#define SDO_ABORT_PDO_LENGTH 0x06040042U
#define SDO_ABORT_LENGTH 0x06070010U
#define SDO_ABORT_TOO_LONG 0x06070012U
#define SDO_ABORT_TOO_SHORT 0x06070013U
#define SDO_ABORT_NO_SUBINDEX 0x06090011U
#define SDO_ABORT_VALUE 0x06090030U
#define SDO_ABORT_TOO_HIGH 0x06090031U
#define SDO_ABORT_TOO_LOW 0x06090032U
#define SDO_ABORT_STATE 0x08000022U

/// Checks and reactions of the device to an access.
typedef struct {
    /// Returns the abort code for setting a number to `value`; 0 if it may be set. May be null.
    uint32_t (*check)(void* context, const object_t* object, int64_t value);
    /// The object has been written. May be null.
    void (*written)(void* context, object_t* object);
    /// Update an object that is about to be read. May be null.
    void (*read)(void* context, object_t* object);
    void* context;
} sdo_access_t;

typedef enum {
    SDO_IDLE,
    SDO_UPLOADING,
    SDO_DOWNLOADING
} sdo_state_t;

typedef struct { // All fields are private.
    sdo_state_t state;
    object_t* object;
    uint8_t toggle;
    bool has_size;
    size_t size; // Octets announced by the client, or to be sent.
    size_t offset;
    uint8_t buffer[OBJECT_TEXT_MAX];
} sdo_server_t;

void sdo_server_reset(sdo_server_t* server);

/// Serve one request. Returns true if `reply` is to be sent (a client's abort has no reply).
bool sdo_server_request(sdo_server_t* server, const dictionary_t* dictionary, const sdo_access_t* access,
                        const uint8_t request[SDO_OCTETS], uint8_t reply[SDO_OCTETS]);

#endif // SIM_DEVICES_SDO_H
