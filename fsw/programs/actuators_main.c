// SPDX-License-Identifier: Apache-2.0
#include "fsw/programs/executive.h"

#include <stddef.h>

int main(int argument_count, char* arguments[])
{
    return executive_main(argument_count, arguments, "actuators", actuators_open, NULL);
}
