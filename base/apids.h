// SPDX-License-Identifier: Apache-2.0
/// APIDs that are the same in every mission. The headers generated from the descriptors of these two
/// subsystems define the same macros, so the compiler refuses a descriptor with another value.
#ifndef BASE_APIDS_H
#define BASE_APIDS_H

#define SUPERVISOR_APID 1U    ///< The only subsystem that has the services of the whole spacecraft.
#define COMMUNICATION_APID 2U ///< The subsystem that connects the supervisor with the ground.

#endif // BASE_APIDS_H
