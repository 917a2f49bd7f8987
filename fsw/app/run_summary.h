// SPDX-License-Identifier: Apache-2.0
/// run.json as the launcher knows it; the report adds figures and hashes of the logs.
#ifndef FSW_APP_RUN_SUMMARY_H
#define FSW_APP_RUN_SUMMARY_H

#include "fsw/app/launcher.h"

/// Have room for run.json in the run's folder (run.json.part), whatever fills the disk later. False: there is
/// none.
bool run_summary_reserve(const launcher_t* launcher);
/// Write run.json there: at any moment it is whole, or is not there. False: it could not be written.
MUST_USE bool run_summary_write(const launcher_t* launcher);

#endif // FSW_APP_RUN_SUMMARY_H
