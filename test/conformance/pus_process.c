// SPDX-License-Identifier: Apache-2.0
/// A process of APID 16 on standard input and output, for peers in other languages. Lines in:
///
///     <hex>      dispatch this packet
///     complete   progress step 7, then completion, of the function that was started last
///     raise      raise event 3 with data 010203
///     ask        send a request [17,1] to APID 17 as the on-board user of APID 16
///     cuc, cds   report the time once as a spacecraft time packet of that format, at the rate of one in 4 s
///
/// Each report or request is printed as a line of hexadecimal digits; a line "." ends the answer to a line.
#include "pus/core/requester.h"
#include "pus/st01/st01_verification.h"
#include "pus/st05/st05_events.h"
#include "pus/st08/st08_functions.h"
#include "pus/st09/st09_time.h"
#include "pus/st17/st17_test.h"
#include "pus/st20/st20_parameters.h"

#include <stdio.h>
#include <string.h>

#define APID 16U
#define EPOCH_S 2000000000U
#define NOW_NS 42500000000ULL

static pus_token_t started; // Request of the function that was started last.

static status_t print(void* const context, const uint8_t* const packet, const size_t size)
{
    (void)context;
    for (size_t i = 0U; i < size; i++) {
        (void)printf("%02x", packet[i]);
    }
    (void)printf("\n");
    return STATUS_OK;
}

static pus_reply_t perform(void* const context, const uint16_t index, const void* const arguments,
                           const pus_token_t* const token, const uint64_t now_ns)
{
    (void)context;
    (void)arguments;
    (void)now_ns;
    started = *token;
    return (index == 0U) ? pus_later() : pus_failed(PUS_FAILURE_TIMEOUT, 250U);
}

static status_t find(void* const context, const uint32_t id, uint16_t* const out_handle,
                     uint16_t* const out_size)
{
    (void)context;
    *out_handle = 0U;
    *out_size   = 4U;
    return (id == 0x02020001U) ? STATUS_OK : STATUS_NOT_FOUND;
}

static void read(void* const context, const uint16_t handle, octet_writer_t* const writer)
{
    (void)handle;
    octet_write_u32(writer, *(const uint32_t*)context);
}

static status_t write(void* const context, const uint16_t handle, const uint8_t* const octets,
                      const size_t size)
{
    octet_reader_t reader = octet_reader(octets, size);
    (void)handle;
    *(uint32_t*)context = octet_read_u32(&reader);
    return STATUS_OK;
}

/// Convert a line of hexadecimal digits to octets. Returns their number.
static size_t read_hex(const char* line, uint8_t* const octets, const size_t capacity)
{
    size_t size    = 0U;
    unsigned octet = 0U;
    while ((size < capacity) && (sscanf(line, "%2x", &octet) == 1)) {
        octets[size] = (uint8_t)octet;
        size++;
        line += 2;
    }
    return size;
}

static void ask(void)
{
    static pus_requester_t requester;
    const pus_port_t port = {.send = print};
    pus_requester_init(&requester, APID, &port);
    octet_writer_t writer = pus_tc_begin(&requester, 17U, PUS_SERVICE_TEST, 1U, PUS_ACK_ALL);
    if (pus_tc_send(&requester, &writer, NULL) != STATUS_OK) {
        (void)printf("failed\n");
    }
}

static void report_time(const pus_time_format_t format)
{
    static pus_time_t service;
    const pus_time_config_t config = {
        .epoch_s = EPOCH_S, .format = format, .exponent = 2U, .status = 1U, .port = {.send = print}};
    pus_time_init(&service, &config);
    pus_time_step(&service, NOW_NS);
}

int main(void)
{
    static pus_app_process_t process;
    static pus_events_t events;
    static pus_functions_t functions;
    static pus_test_t test;
    static pus_parameters_t parameters;
    static pus_event_state_t states[1];
    static uint64_t area[1];
    static uint32_t value                             = 7U;
    static const pus_event_definition_t definitions[] = {
        {.id = 3U, .severity = PUS_SEVERITY_MEDIUM, .aux_size = 3U}};
    static const pus_function_t table[]   = {{.name = "SLOW"}, {.name = "BROKEN"}};
    const pus_port_t port                 = {.send = print};
    const pus_function_port_t performing  = {.perform = perform};
    const pus_parameter_port_t dictionary = {.context = &value, .find = find, .read = read, .write = write};
    pus_app_process_init(&process, APID, EPOCH_S, &port);
    pus_events_init(&events, &process, definitions, states, 1U);
    pus_functions_init(&functions, table, 2U, &performing, area, sizeof area);
    pus_test_init(&test, NULL);
    pus_parameters_init(&parameters, &dictionary);
    const pus_service_t services[] = {pus_events_service(&events), pus_functions_service(&functions),
                                      pus_test_service(&test), pus_parameters_service(&parameters)};
    pus_dispatcher_t dispatcher;
    pus_dispatcher_init(&dispatcher, &process, services, 4U);

    static char line[(2U * PUS_PACKET_MAX) + 256U];
    while (fgets(line, sizeof line, stdin) != NULL) {
        if (strcmp(line, "complete\n") == 0) {
            pus_verify_progress(&process, &started, 7U, NOW_NS);
            pus_verify_completed(&process, &started, NOW_NS);
        } else if (strcmp(line, "raise\n") == 0) {
            (void)pus_event_raise(&events, 3U, (const uint8_t*)"\x01\x02\x03", 3U, NOW_NS);
        } else if (strcmp(line, "ask\n") == 0) {
            ask();
        } else if (strcmp(line, "cuc\n") == 0) {
            report_time(PUS_TIME_CUC);
        } else if (strcmp(line, "cds\n") == 0) {
            report_time(PUS_TIME_CDS);
        } else {
            static uint8_t packet[PUS_PACKET_MAX + 64U];
            (void)pus_dispatch(&dispatcher, packet, read_hex(line, packet, sizeof packet), NOW_NS);
        }
        (void)printf(".\n");
        (void)fflush(stdout);
    }
    return 0;
}
