// SPDX-License-Identifier: Apache-2.0
/// The EEPROM of an emulated board: names that the program on the board shares with the proxy, which starts
/// the emulator.
#ifndef OSAL_TARGET_EEPROM_H
#define OSAL_TARGET_EEPROM_H

#define TARGET_EEPROM_OCTETS 131072U
/// Paths that begin with this name and a slash are files on the EEPROM.
#define TARGET_EEPROM_DIRECTORY "/eeprom"

#endif // OSAL_TARGET_EEPROM_H
