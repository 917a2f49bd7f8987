// SPDX-License-Identifier: Apache-2.0
/// Test bench of the file service: one on a disk in memory, with lasting records, behind a dispatcher.
#ifndef TEST_UNIT_PUS_FILING_H
#define TEST_UNIT_PUS_FILING_H

#include "pus/st23_files.h"

#define LOCKS 3U
#define COPIES 3U
#define SEARCHES 2U
#define SIZE_MAX_OF_FILE 1000000U

typedef struct {
    pus_files_t files;
    pus_file_lock_t locks[LOCKS];
    pus_file_copy_t copies[COPIES];
    pus_file_search_t searches[SEARCHES];
    octet_writer_t writer; ///< Application data in the making.
    uint32_t cycle;
    uint16_t slices;                      ///< Of the next service.
    const pus_persistence_t* persistence; ///< The same.
    uint8_t data[PUS_TC_DATA_MAX];
} filing_t;

extern filing_t filing;

/// A disk with the directories a and a/b, the files a/one (10 octets) and a/b/two (20), and the service.
void filing_start(void);
/// The service anew, on the disk as it is.
void filing_restart(void);
/// Cut the power; the service takes back what is lasting.
void filing_power_cut(void);

/// Application data of a request, and sending it.
void filing_begin(void);
void filing_text(const char* text);
void filing_send(uint8_t subtype);
/// Requests of a path and a name, of a creation, a copy, a copy's id, a path.
void filing_request(uint8_t subtype, const char* path, const char* name);
void filing_create(const char* path, const char* name, uint32_t room, uint8_t flag);
void filing_order(uint8_t subtype, uint16_t id, const char* path, const char* name, const char* new_path,
                  const char* new_name);
void filing_change(uint8_t subtype, uint16_t id);
void filing_change_path(uint8_t subtype, const char* path);
void filing_rename(const char* path, const char* name, const char* new_name);
/// One cycle.
void filing_step(void);

/// The request was performed at once, refused with TM[1,4], or ended with TM[1,8].
void filing_done(void);
void filing_refused(uint16_t code, uint32_t detail);
void filing_failed(uint16_t code, uint32_t detail);
/// The next text of a report.
void filing_text_is(octet_reader_t* reader, const char* expected);

#endif // TEST_UNIT_PUS_FILING_H
