// SPDX-License-Identifier: Apache-2.0
#include "fsw/framework/subsystem/endnode_name.h"

#include "base/assertion.h"
#include "base/text.h"

status_t subsystem_endnode_name(const descriptor_endnode_t* const endnode,
                                flow_endnode_kind_t* const out_kind, char out_name[ENDNODE_ADDRESS_MAX])
{
    static const flow_endnode_kind_t kinds[] = {
        [DESCRIPTOR_ENDNODE_CAN] = ENDNODE_CAN,       [DESCRIPTOR_ENDNODE_SHM] = ENDNODE_SHM,
        [DESCRIPTOR_ENDNODE_MQUEUE] = ENDNODE_MQUEUE, [DESCRIPTOR_ENDNODE_UDP] = ENDNODE_UDP,
        [DESCRIPTOR_ENDNODE_TCP] = ENDNODE_TCP,       [DESCRIPTOR_ENDNODE_SERIAL] = ENDNODE_SERIAL,
        [DESCRIPTOR_ENDNODE_FILE] = ENDNODE_FILE,
    };
    FSW_ASSERT((endnode != NULL) && (out_kind != NULL) && (out_name != NULL));
    *out_kind   = kinds[endnode->type];
    text_t text = text_in(out_name, ENDNODE_ADDRESS_MAX);
    if (endnode->type == DESCRIPTOR_ENDNODE_CAN) {
        text_add(&text, endnode->bus);
    } else if ((endnode->type == DESCRIPTOR_ENDNODE_UDP) || (endnode->type == DESCRIPTOR_ENDNODE_TCP)) {
        text_add(&text, endnode->address);
        text_add(&text, ":");
        text_add_unsigned(&text, endnode->port);
    } else {
        text_add(&text, endnode->name);
    }
    if (text.cut) {
        out_name[0] = '\0';
        return STATUS_TOO_LARGE;
    }
    return STATUS_OK;
}
