// SPDX-License-Identifier: Apache-2.0
/// Number of repetitions of tests that repeat the same with many values. With the sanitizers
/// (RESOURCE_CHECKS, set with SANITIZE=1), which make programs several times as slow, a tenth of the
/// repetitions is run; `make check-tests` runs all.
#ifndef TEST_SUPPORT_REPETITIONS_H
#define TEST_SUPPORT_REPETITIONS_H

#ifdef RESOURCE_CHECKS
#define REPETITIONS(all) ((all) / 10U)
#else
#define REPETITIONS(all) (all)
#endif

#endif
