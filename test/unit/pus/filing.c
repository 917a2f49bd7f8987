// SPDX-License-Identifier: Apache-2.0
#include "test/unit/pus/filing.h"

#include "test/support/disk.h"
#include "test/unit/pus/records.h"
#include "test/unit/pus/reports.h"
#include "unity.h"

#include <string.h>

filing_t filing;

void filing_restart(void)
{
    pus_files_init(&filing.files, &(pus_files_config_t){.store        = disk_store(),
                                                        .process      = &bench.process,
                                                        .locks        = filing.locks,
                                                        .lock_count   = LOCKS,
                                                        .copies       = filing.copies,
                                                        .copy_count   = COPIES,
                                                        .searches     = filing.searches,
                                                        .search_count = SEARCHES,
                                                        .size_max     = SIZE_MAX_OF_FILE,
                                                        .slices       = filing.slices,
                                                        .persistence  = filing.persistence});
    bench_serve(pus_files_service(&filing.files));
}

void filing_start(void)
{
    bench_start();
    disk_start();
    records_start();
    filing.persistence = records_port();
    filing.slices      = 1U;
    filing.cycle       = 100U;
    filing_restart();
    pus_dispatcher_persist(&bench.dispatcher, filing.persistence);
    disk_directory("a");
    disk_directory("a/b");
    (void)disk_file("a/one", 10U, 1U);
    (void)disk_file("a/b/two", 20U, 2U);
}

void filing_begin(void)
{
    filing.writer = octet_writer(filing.data, sizeof(filing.data));
}

void filing_text(const char* const text)
{
    octet_write_u16(&filing.writer, (uint16_t)strlen(text));
    octet_write_octets(&filing.writer, (const uint8_t*)text, strlen(text));
}

void filing_send(const uint8_t subtype)
{
    bench_clear();
    TEST_ASSERT_FALSE(filing.writer.failed);
    TEST_ASSERT_EQUAL(STATUS_OK, bench_request(subtype, filing.data, filing.writer.position));
}

void filing_request(const uint8_t subtype, const char* const path, const char* const name)
{
    filing_begin();
    filing_text(path);
    filing_text(name);
    filing_send(subtype);
}

void filing_create(const char* const path, const char* const name, const uint32_t room, const uint8_t flag)
{
    filing_begin();
    filing_text(path);
    filing_text(name);
    octet_write_u32(&filing.writer, room);
    octet_write_u8(&filing.writer, flag);
    filing_send(1U);
}

void filing_order(const uint8_t subtype, const uint16_t id, const char* const path, const char* const name,
                  const char* const new_path, const char* const new_name)
{
    filing_begin();
    octet_write_u16(&filing.writer, id);
    filing_text(path);
    filing_text(name);
    filing_text(new_path);
    filing_text(new_name);
    filing_send(subtype);
}

void filing_change(const uint8_t subtype, const uint16_t id)
{
    filing_begin();
    octet_write_u8(&filing.writer, 1U);
    octet_write_u16(&filing.writer, id);
    filing_send(subtype);
}

void filing_change_path(const uint8_t subtype, const char* const path)
{
    filing_begin();
    filing_text(path);
    filing_send(subtype);
}

void filing_rename(const char* const path, const char* const name, const char* const new_name)
{
    filing_begin();
    filing_text(path);
    filing_text(name);
    filing_text(new_name);
    filing_send(11U);
}

void filing_step(void)
{
    bench_clear();
    filing.cycle++;
    pus_dispatcher_step(&bench.dispatcher, TEST_NOW_NS, filing.cycle);
}

void filing_done(void)
{
    EXPECT_MESSAGES(1, 1, 1, 3, 1, 7);
}

void filing_refused(const uint16_t code, const uint32_t detail)
{
    EXPECT_MESSAGES(1, 1, 1, 4);
    expect_failure(1U, 4U, code, 0U, detail);
}

void filing_failed(const uint16_t code, const uint32_t detail)
{
    EXPECT_MESSAGES(1, 1, 1, 3, 1, 8);
    expect_failure(2U, 8U, code, 0U, detail);
}

void filing_text_is(octet_reader_t* const reader, const char* const expected)
{
    const uint16_t size        = octet_read_u16(reader);
    const uint8_t* const found = octet_read_octets(reader, size);
    TEST_ASSERT_NOT_NULL(found);
    TEST_ASSERT_EQUAL_UINT16(strlen(expected), size);
    TEST_ASSERT_EQUAL_MEMORY(expected, found, size);
}

static status_t restore(void* const self, const uint32_t key, const uint8_t* const octets, const size_t size)
{
    const status_t status = pus_files_restore(self, key, octets, size);
    TEST_ASSERT_EQUAL(STATUS_OK, status);
    return status;
}

void filing_power_cut(void)
{
    records_cut();
    filing_restart();
    (void)records_replay(PUS_SERVICE_FILES, restore, &filing.files);
}
