// SPDX-License-Identifier: Apache-2.0
#include "pus/core/tailoring.h"
#include "pus/tool/pusdump_messages.h"

static const struct {
    uint16_t code;
    const char* words;
} failures[] = {
    {PUS_FAILURE_NO_ROUTE, "no route to the APID"},
    {PUS_FAILURE_UNAVAILABLE, "destination not available"},
    {PUS_FAILURE_LENGTH, "length wrong"},
    {PUS_FAILURE_CHECKSUM, "checksum wrong"},
    {PUS_FAILURE_PUS_VERSION, "PUS version not supported"},
    {PUS_FAILURE_APID, "APID unknown"},
    {PUS_FAILURE_SERVICE, "service not supported"},
    {PUS_FAILURE_SUBTYPE, "subtype not supported"},
    {PUS_FAILURE_SOURCE, "source not authorised"},
    {PUS_FAILURE_DATA, "application data too short, too long or inconsistent"},
    {PUS_FAILURE_QUEUE_FULL, "queue full"},
    {PUS_FAILURE_PACKET_VERSION, "packet version not supported"},
    {PUS_FAILURE_PACKET_TYPE, "packet type wrong"},
    {PUS_FAILURE_SECONDARY_HEADER, "no secondary header"},
    {PUS_FAILURE_SEQUENCE_FLAGS, "segmented"},
    {PUS_FAILURE_PERMISSION, "not permitted"},
    {PUS_FAILURE_LINK_MISSING, "required link missing"},
    {PUS_FAILURE_RESOURCES, "resources not sufficient"},
    {PUS_FAILURE_MEMBER_ACTIVE, "network member operational"},
    {PUS_FAILURE_INTERFACE, "interface differs"},
    {PUS_FAILURE_UNKNOWN_ID, "identifier unknown"},
    {PUS_FAILURE_EXISTS, "identifier exists already"},
    {PUS_FAILURE_OUT_OF_RANGE, "value out of range"},
    {PUS_FAILURE_STATE, "not allowed in the present state"},
    {PUS_FAILURE_TABLE_FULL, "table full"},
    {PUS_FAILURE_ACCESS, "parameter not readable or not settable"},
    {PUS_FAILURE_ADDRESS, "outside the memory"},
    {PUS_FAILURE_PROTECTED, "write protected"},
    {PUS_FAILURE_PAST, "in the past"},
    {PUS_FAILURE_EMBEDDED, "embedded request malformed"},
    {PUS_FAILURE_DUPLICATE, "duplicated in the request"},
    {PUS_FAILURE_MODE, "forbidden in this mode"},
    {PUS_FAILURE_STEP, "step failed"},
    {PUS_FAILURE_VERIFY, "checksum mismatch after load"},
    {PUS_FAILURE_NO_ANSWER, "device did not answer"},
    {PUS_FAILURE_DEVICE, "device returned an error"},
    {PUS_FAILURE_IO, "input/output error"},
    {PUS_FAILURE_ABORTED, "aborted"},
    {PUS_FAILURE_TIMEOUT, "time-out"},
    {PUS_FAILURE_SOME_FAILED, "some instructions failed"},
    {PUS_FAILURE_LOST, "addressee lost"},
    {PUS_FAILURE_LINK_REFUSED, "link refused"},
    {PUS_FAILURE_RESTARTED, "supervisor restarted"},
};

const char* failure_words(const uint16_t code)
{
    for (size_t i = 0U; i < (sizeof(failures) / sizeof(failures[0])); i++) {
        if (failures[i].code == code) {
            return failures[i].words;
        }
    }
    return "unknown failure";
}
