// SPDX-License-Identifier: Apache-2.0
#include "fsw/programs/program.h"

#include <string.h>

program_open_t program_find(const char* const executable)
{
    static const struct {
        const char* name;
        program_open_t open;
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
