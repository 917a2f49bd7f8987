// SPDX-License-Identifier: Apache-2.0
#include "fsw/programs/component_instance.h"

#include <string.h>

component_open_t component_find(const char* const executable)
{
    static const struct {
        const char* name;
        component_open_t open;
    } programs[] = {
#define COMPONENT(name, executable) {executable, name##_open},
#include "generated/programs.h"
#undef COMPONENT
    };
    for (size_t i = 0U; i < (sizeof programs / sizeof programs[0]); i++) {
        if (strcmp(programs[i].name, executable) == 0) {
            return programs[i].open;
        }
    }
    return NULL;
}
