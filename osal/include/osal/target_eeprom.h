// SPDX-License-Identifier: Apache-2.0
/// What a program on an emulated board and the proxy that starts the emulator agree on: the EEPROM of the
/// board.
#ifndef OSAL_TARGET_EEPROM_H
#define OSAL_TARGET_EEPROM_H

#define TARGET_EEPROM_OCTETS 131072U
/// Paths that begin with this name and a slash are files on the EEPROM.
#define TARGET_EEPROM_DIRECTORY "/eeprom"

#endif // OSAL_TARGET_EEPROM_H
