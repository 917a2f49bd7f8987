// SPDX-License-Identifier: Apache-2.0
#include "osal/freertos/port.h"
#include "osal/freertos/wire.h"

#include <string.h>

#define WIRE "wire="

const char* port_take_arguments(char* const line, char* list[PORT_ARGUMENTS_MAX + 1], int* const out_count)
{
    char* at   = line;
    *out_count = 0;
    while (*at != '\0') {
        char* const end  = strchr(at, ' ');
        char* const next = (end != NULL) ? &end[1] : &at[strlen(at)];
        if (end != NULL) {
            *end = '\0';
        }
        if (strncmp(at, WIRE, strlen(WIRE)) == 0) {
            if (!wire_set(&at[strlen(WIRE)])) {
                return "the argument wire= needs the numbers of two descriptors: wire=IN:OUT";
            }
        } else if (*at == '\0') {
            // Two spaces follow each other: no argument.
        } else if (*out_count == PORT_ARGUMENTS_MAX) {
            return "the command line has more than 16 arguments";
        } else {
            list[(*out_count)++] = at;
        }
        at = next;
    }
    list[*out_count] = NULL;
    return NULL;
}
