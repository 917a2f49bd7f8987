// SPDX-License-Identifier: Apache-2.0
#include "test/support/subsystem_double.inc"
