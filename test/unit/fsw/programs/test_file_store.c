// SPDX-License-Identifier: Apache-2.0
// The file service on a real directory: requests with hostile names affect nothing outside it. The numbers of
// requests and reports are subtypes; pus/catalogue/st23_files.txt has their names and fields.
#define _GNU_SOURCE
#include "fsw/programs/file_store.h"

#include "osal/include/osal/file.h"
#include "pus/st23/st23_files.h"
#include "unity.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

static char base[64];
static osal_directory_t root;
static pus_app_process_t process;
static pus_dispatcher_t dispatcher;
static pus_service_t services[1];
static pus_files_t files;
static pus_file_lock_t locks[2];
static pus_file_copy_t copies[2];
static pus_file_search_t searches[2];
static uint8_t data[PUS_TC_DATA_MAX];
static octet_writer_t writer;
static uint8_t last_subtype;           // Subtype of the last report of verification.
static uint8_t answer[PUS_PACKET_MAX]; // The last report of the service.
static size_t answer_size;

static status_t take(void* const context, const uint8_t* const packet, const size_t size)
{
    pus_tm_t tm;
    pus_failure_t failure;
    (void)context;
    TEST_ASSERT_EQUAL(STATUS_OK, pus_tm_decode(packet, size, &tm, &failure));
    if (tm.service == PUS_SERVICE_FILES) {
        memcpy(answer, tm.data, tm.size);
        answer_size = tm.size;
    } else {
        last_subtype = tm.subtype;
    }
    return STATUS_OK;
}

static const char* real(const char* const path)
{
    static char whole[256];
    (void)snprintf(whole, sizeof whole, "%s/%s", base, path);
    return whole;
}

static void put_file(const char* const path, const char* const text)
{
    osal_file_t file;
    TEST_ASSERT_EQUAL(STATUS_OK, osal_file_create(&file, real(path)));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_file_write(&file, text, strlen(text)));
    osal_file_close(&file);
}

static void expect_content(const char* const path, const char* const expected)
{
    char content[64];
    size_t size = 0U;
    TEST_ASSERT_EQUAL(STATUS_OK, osal_file_load(real(path), content, sizeof content, &size));
    TEST_ASSERT_EQUAL_UINT64(strlen(expected), size);
    TEST_ASSERT_EQUAL(0, memcmp(expected, content, size));
}

void setUp(void)
{
    (void)snprintf(base, sizeof base, "/tmp/file-store-test-%d", (int)getpid());
    TEST_ASSERT_EQUAL(STATUS_OK, osal_file_create_directory(real("root")));
    put_file("secret", "secret");
    TEST_ASSERT_EQUAL(STATUS_OK, osal_directory_open(&root, real("root")));
    pus_app_process_init(&process, 1U, 0U, &(pus_port_t){.send = take});
    pus_dispatcher_init(&dispatcher, &process, services, 1U);
    pus_files_init(&files, &(pus_files_config_t){.store        = file_store(&root),
                                                 .process      = &process,
                                                 .locks        = locks,
                                                 .lock_count   = 2U,
                                                 .copies       = copies,
                                                 .copy_count   = 2U,
                                                 .searches     = searches,
                                                 .search_count = 2U,
                                                 .size_max     = 1000000U,
                                                 .slices       = 1U});
    services[0] = pus_files_service(&files);
}

void tearDown(void)
{
    char command[128];
    osal_directory_close(&root);
    (void)snprintf(command, sizeof command, "rm -rf %s", base);
    TEST_ASSERT_EQUAL(0, system(command)); // NOLINT: a fixed command.
}

static void begin(void)
{
    writer      = octet_writer(data, sizeof data);
    answer_size = 0U;
}

static void add_text(const char* const text)
{
    octet_write_u16(&writer, (uint16_t)strlen(text));
    octet_write_octets(&writer, (const uint8_t*)text, strlen(text));
}

/// Send the request and wait for its end. Returns the subtype of the verification report that ended the
/// request.
static uint8_t send(const uint8_t subtype)
{
    uint8_t packet[PUS_PACKET_MAX];
    size_t size       = 0U;
    const pus_tc_t tc = {.apid    = 1U,
                         .ack     = PUS_ACK_ALL,
                         .service = PUS_SERVICE_FILES,
                         .subtype = subtype,
                         .source  = 1U,
                         .data    = data,
                         .size    = writer.position};
    TEST_ASSERT_EQUAL(STATUS_OK, pus_tc_encode(&tc, packet, sizeof packet, &size));
    TEST_ASSERT_EQUAL(STATUS_OK, pus_dispatch(&dispatcher, packet, size, 0U));
    for (unsigned i = 0U; pus_files_is_busy(&files); i++) {
        TEST_ASSERT_TRUE(i < 1000U);
        (void)pus_dispatcher_resume(&dispatcher, 0U);
        services[0].step(services[0].self, 0U, i);
    }
    return last_subtype;
}

/// Send a request whose data begin with the path and name of a file. Returns the subtype of its last report.
static uint8_t request(const uint8_t subtype, const char* const path, const char* const name)
{
    begin();
    add_text(path);
    add_text(name);
    if (subtype == 1U) {
        octet_write_u32(&writer, 1000U);
        octet_write_u8(&writer, 0U);
    }
    return send(subtype);
}

/// Copy or move a file by operation 1. Returns the subtype of the last report.
static uint8_t request_with_target(const uint8_t subtype, const char* const path, const char* const name,
                                   const char* const new_path, const char* const new_name)
{
    begin();
    octet_write_u16(&writer, 1U);
    add_text(path);
    add_text(name);
    add_text(new_path);
    add_text(new_name);
    return send(subtype);
}

static void requests_are_performed_on_the_disk(void)
{
    TEST_ASSERT_EQUAL_UINT8(7U, request(9U, "/", "logs"));
    TEST_ASSERT_EQUAL_UINT8(7U, request(1U, "/logs", "new"));
    expect_content("root/logs/new", "");
    put_file("root/one", "content");
    TEST_ASSERT_EQUAL_UINT8(7U, request_with_target(14U, "/", "one", "/logs", "copy"));
    expect_content("root/logs/copy", "content");
    TEST_ASSERT_EQUAL_UINT8(4U, request_with_target(14U, "/", "one", "/logs", "copy"));
    TEST_ASSERT_EQUAL_UINT8(7U, request_with_target(15U, "/logs", "copy", "/", "moved"));
    expect_content("root/moved", "content");
    TEST_ASSERT_EQUAL_UINT8(7U, request(2U, "", "one"));
    TEST_ASSERT_FALSE(osal_file_exists(real("root/one")));
    TEST_ASSERT_EQUAL_UINT8(7U, request(3U, "", "moved"));
    TEST_ASSERT_EQUAL_UINT8(7U, answer[answer_size - 2U]); // The size of the file.
    TEST_ASSERT_EQUAL_UINT8(7U, request(7U, "", "*"));
    static const char found[] = "\0\1/\0\1*\0\2\0\x9/logs/new\0\6/moved";
    TEST_ASSERT_EQUAL_UINT64(sizeof found - 1U, answer_size);
    TEST_ASSERT_EQUAL_MEMORY(found, answer, answer_size);
    TEST_ASSERT_EQUAL_UINT8(4U, request(10U, "", "logs"));
    TEST_ASSERT_EQUAL_UINT8(7U, request(2U, "logs", "new"));
    TEST_ASSERT_EQUAL_UINT8(7U, request(10U, "", "logs"));
    TEST_ASSERT_FALSE(osal_file_exists(real("root/logs")));
}

static void hostile_requests_change_no_file(void)
{
    static const char* const hostile[][2] = {{"..", "secret"},
                                             {"", "../secret"},
                                             {"/..", "secret"},
                                             {"logs/..", "x"},
                                             {"logs/../..", "secret"},
                                             {"link", "secret"},
                                             {"", "linked"},
                                             {"/etc", "passwd"},
                                             {"//etc", "passwd"},
                                             {".", "x"},
                                             {"", "."},
                                             {"", ".."},
                                             {"", ""},
                                             {"logs", "/x"},
                                             {"logs//", "x"},
                                             {"no", "x"},
                                             {"logs", "a/b"},
                                             {"../root/logs", "new"}};
    TEST_ASSERT_EQUAL_UINT8(7U, request(9U, "/", "logs"));
    TEST_ASSERT_EQUAL_UINT8(7U, request(1U, "/logs", "one"));
    TEST_ASSERT_EQUAL(0, symlink("..", real("root/link")));
    TEST_ASSERT_EQUAL(0, symlink("../secret", real("root/linked")));
    for (size_t i = 0U; i < (sizeof hostile / sizeof hostile[0]); i++) {
        static const uint8_t subtypes[] = {1, 2, 3, 5, 6, 9, 10};
        const char* const path          = hostile[i][0];
        const char* const name          = hostile[i][1];
        for (size_t k = 0U; k < sizeof subtypes; k++) {
            TEST_ASSERT_EQUAL_UINT8_MESSAGE(4U, request(subtypes[k], path, name), name);
        }
        TEST_ASSERT_EQUAL_UINT8_MESSAGE(4U, request_with_target(14U, path, name, "", "stolen"), name);
        TEST_ASSERT_EQUAL_UINT8_MESSAGE(4U, request_with_target(15U, path, name, "", "stolen"), name);
        // A symbolic link at the place of the target is detected when the copy gets its name.
        TEST_ASSERT_NOT_EQUAL_MESSAGE(7U, request_with_target(14U, "logs", "one", path, name), name);
        TEST_ASSERT_EQUAL_UINT8_MESSAGE(4U, request_with_target(15U, "logs", "one", path, name), name);
    }
    expect_content("secret", "secret");
    TEST_ASSERT_FALSE(osal_file_exists(real("root/stolen")));
    TEST_ASSERT_EQUAL_UINT8(7U, request(7U, "", "*"));
    static const char found[] = "\0\1/\0\1*\0\1\0\x9/logs/one";
    TEST_ASSERT_EQUAL_UINT64(sizeof found - 1U, answer_size);
    TEST_ASSERT_EQUAL_MEMORY(found, answer, answer_size);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(requests_are_performed_on_the_disk);
    RUN_TEST(hostile_requests_change_no_file);
    return UNITY_END();
}
