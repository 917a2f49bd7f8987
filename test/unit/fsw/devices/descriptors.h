// SPDX-License-Identifier: Apache-2.0
/// Descriptors of subsystems with stream devices, written to a file and loaded.
#ifndef TEST_UNIT_FSW_DEVICES_DESCRIPTORS_H
#define TEST_UNIT_FSW_DEVICES_DESCRIPTORS_H

#include "fsw/framework/descriptor/descriptor.h"

/// Beginning of a subsystem whose first <Device> is in line 6.
#define BEGIN                                                                                                \
    "<Subsystem name='DOG' id='40' samplingTime='1ms'>\n"                                                    \
    "<Events><Event name='DEVICE_REFUSED' id='4' severity='LOW'><ParamRef name='D' type='UINT8'/>"           \
    "<ParamRef name='C' type='UINT8'/></Event>\n"                                                            \
    "<Event name='DEVICE_LOST' id='5' severity='MEDIUM'><ParamRef name='D' type='UINT8'/>"                   \
    "<ParamRef name='C' type='UINT8'/></Event>\n"                                                            \
    "<Event name='DEVICE_RETURNED' id='6' severity='LOW'><ParamRef name='D' type='UINT8'/></Event></Events>" \
    "\n<Configuration name='ONE' id='1' priority='60' samplingTime='1ms'><Devices>\n"
#define NEXT_CONFIGURATION                                                                                   \
    "</Devices></Configuration>\n<Configuration name='TWO' id='2' priority='60' "                            \
    "samplingTime='1ms'><Devices>\n"
#define END "</Devices></Configuration></Subsystem>\n"
#define AXIS(name, endnode)                                                                                  \
    "<Device name='" name "' type='stream'>"                                                                 \
    "<Field name='COUNT' direction='IN' type='UINT16'/>"                                                     \
    "<Field name='VALUE' direction='IN' type='INT16' scale='0.5' offset='1'/>"                               \
    "<Field name='ENABLE' direction='OUT' type='UINT8' safe='0'/>"                                           \
    "<Field name='TARGET' direction='OUT' type='INT16' scale='0.5' offset='1' safe='3'/>\n" endnode          \
    "</Device>\n"

/// Load a document; a descriptor that cannot be read fails the test.
void load_document(const char* document, subsystem_descriptor_t* out_descriptor);

#endif // TEST_UNIT_FSW_DEVICES_DESCRIPTORS_H
