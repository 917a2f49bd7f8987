// SPDX-License-Identifier: Apache-2.0
/// The launcher's part of run.json; the report adds figures and hashes of the logs.
#ifndef LAUNCHER_RUN_SUMMARY_H
#define LAUNCHER_RUN_SUMMARY_H

#include "launcher/launcher.h"

/// Reserve disk space for run.json in the run's folder (run.json.part), so that a disk that fills up later
/// does no harm. False: there is no space.
bool run_summary_reserve(const launcher_t* launcher);
/// Write run.json into that space: at any moment the file is complete or absent. False: it could not be
/// written.
MUST_USE bool run_summary_write(const launcher_t* launcher);

#endif // LAUNCHER_RUN_SUMMARY_H
