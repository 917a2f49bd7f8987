// SPDX-License-Identifier: Apache-2.0
/// run.json as the launcher knows it; the report adds figures and hashes of the logs.
#ifndef FSW_APP_RUN_SUMMARY_H
#define FSW_APP_RUN_SUMMARY_H

#include "fsw/app/launcher.h"

/// Write run.json into the run's folder; complains on the console if it cannot.
void run_summary_write(const launcher_t* launcher);

#endif // FSW_APP_RUN_SUMMARY_H
