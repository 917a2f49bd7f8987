// SPDX-License-Identifier: Apache-2.0
/// Writes the launcher's part of run.json. The report adds figures and hashes of the logs.
#ifndef LAUNCHER_RUN_SUMMARY_H
#define LAUNCHER_RUN_SUMMARY_H

#include "launcher/launcher.h"

/// Reserve disk space for run.json in the run's directory (run.json.part), so that it can be written even if
/// the disk becomes full. False if there is no space.
bool run_summary_reserve(const launcher_t* launcher);
/// Write run.json into that space; the file is complete or absent at any moment. False if it could not be
/// written.
MUST_USE bool run_summary_write(const launcher_t* launcher);

#endif // LAUNCHER_RUN_SUMMARY_H
