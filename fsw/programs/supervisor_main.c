// SPDX-License-Identifier: Apache-2.0
#include "fsw/programs/executive.h"

int main(int argument_count, char* arguments[])
{
    return executive_main(argument_count, arguments, "supervisor", supervisor_open,
                          &descriptor_mission_whole);
}
