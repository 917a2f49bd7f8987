// SPDX-License-Identifier: Apache-2.0
/// The version of the project, defined only here: all programs print it with --version, run.json records it,
/// and the ground segment reads it from here. CHANGELOG.md lists the changes of each version; `-dev` marks a
/// version that is not complete yet.
#ifndef BASE_VERSION_H
#define BASE_VERSION_H

#define HIROSCO_VERSION "0.2.0-dev"

#endif // BASE_VERSION_H
