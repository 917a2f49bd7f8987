// SPDX-License-Identifier: Apache-2.0
/// Text of `simulator --help`.
#ifndef SIM_APP_USAGE_H
#define SIM_APP_USAGE_H

extern const char simulator_usage[];

#endif // SIM_APP_USAGE_H
