// SPDX-License-Identifier: Apache-2.0
// The socketcand server: handshake of python-can, frames in both directions, slow and malformed clients.
#include "osal/include/osal/socket.h"
#include "sim/socketcand/socketcand.h"
#include "test/support/clients.h"
#include "unity.h"

#include <stdio.h>
#include <string.h>

#define MS 1000000U

static bus_t* bus;
static socketcand_t* server;
static unsigned node; // A device on the bus.
static osal_can_frame_t heard;
static unsigned heard_count;
static char answer[300000];

static void hear(void* context, const osal_can_frame_t* frame)
{
    (void)context;
    heard = *frame;
    heard_count++;
}

void setUp(void)
{
    const bus_config_t config       = {.nominal_bit_rate = 1000000U, .data_bit_rate = 5000000U, .seed = 1U};
    const bus_callbacks_t callbacks = {.on_frame = hear};
    heard_count                     = 0U;
    bus                             = bus_create(&config);
    TEST_ASSERT_EQUAL_INT(STATUS_OK, bus_add_node(bus, &callbacks, &node));
    const socketcand_bus_t buses[] = {{"robot", bus}};
    TEST_ASSERT_EQUAL_INT(STATUS_OK, socketcand_open(0U, buses, 1U, &server));
    TEST_ASSERT_TRUE(socketcand_port(server) != 0U);
}

void tearDown(void)
{
    socketcand_close(server);
    bus_destroy(bus);
}

static osal_socket_t join(void)
{
    osal_socket_t client    = OSAL_SOCKET_CLOSED;
    const osal_address_t to = {.ipv4 = OSAL_IPV4_LOOPBACK, .port = socketcand_port(server)};
    TEST_ASSERT_EQUAL_INT(STATUS_OK, connect_tcp(&client, to));
    return client;
}

/// Let the server check for clients, which it does only once in several calls, and let the bus run.
static void serve(void)
{
    for (unsigned i = 0U; i < 70U; i++) {
        (void)socketcand_receive(server);
        bus_run_until(bus, bus_now_ns(bus) + MS);
        socketcand_send(server);
    }
}

/// Returns the received octets, as text.
static const char* take(osal_socket_t* client)
{
    size_t total = 0U;
    size_t size  = 0U;
    while ((total < (sizeof answer - 1U)) && (osal_socket_wait_readable(client, 50U) == STATUS_OK) &&
           (osal_stream_receive(client, (uint8_t*)&answer[total], sizeof answer - 1U - total, &size) ==
            STATUS_OK)) {
        total += size;
    }
    answer[total] = '\0';
    return answer;
}

static void say(osal_socket_t* client, const char* text)
{
    size_t sent = 0U;
    TEST_ASSERT_EQUAL_INT(STATUS_OK, osal_stream_send(client, (const uint8_t*)text, strlen(text), &sent));
    TEST_ASSERT_EQUAL_UINT(strlen(text), sent);
    serve();
}

static osal_socket_t join_raw(void)
{
    osal_socket_t client = join();
    serve();
    TEST_ASSERT_EQUAL_STRING("< hi >", take(&client));
    say(&client, "< open robot >");
    TEST_ASSERT_EQUAL_STRING("< ok >", take(&client));
    say(&client, "< rawmode >");
    TEST_ASSERT_EQUAL_STRING("< ok >", take(&client));
    return client;
}

static void frames_pass_in_both_directions(void)
{
    osal_socket_t client = join_raw();
    say(&client, "< send 123 3 a bc ff >");
    TEST_ASSERT_EQUAL_UINT(1U, heard_count);
    TEST_ASSERT_EQUAL_HEX32(0x123U, heard.id);
    TEST_ASSERT_EQUAL_UINT8(3U, heard.length);
    TEST_ASSERT_EQUAL_HEX8(0x0AU, heard.data[0]);
    TEST_ASSERT_EQUAL_STRING("", take(&client)); // A client does not receive its own frame.
    const osal_can_frame_t frame = {.id = 0x591U, .length = 2U, .data = {0x4BU, 0x17U}};
    TEST_ASSERT_EQUAL_INT(STATUS_OK, bus_submit(bus, node, &frame, 0U));
    serve();
    TEST_ASSERT_NOT_NULL(strstr(take(&client), "< frame 591 "));
    TEST_ASSERT_NOT_NULL(strstr(answer, " 4B17 >"));
    osal_socket_close(&client);
    serve();
}

static void messages_may_arrive_in_pieces_and_several_at_once(void)
{
    osal_socket_t client = join_raw();
    say(&client, "< send 12");
    say(&client, "3 1 7 ><send 124 0 >noise< send 125 1 ");
    TEST_ASSERT_EQUAL_UINT(2U, heard_count);
    say(&client, "9 >");
    TEST_ASSERT_EQUAL_UINT(3U, heard_count);
    TEST_ASSERT_EQUAL_HEX32(0x125U, heard.id);
    char heap[16U * 100U + 1U] = "";
    for (unsigned i = 0U; i < 100U; i++) {
        (void)strcat(heap, "< send 7 1 5 >");
    }
    say(&client, heap);
    TEST_ASSERT_EQUAL_UINT(103U, heard_count); // The full transmit queue has lost no frame.
    osal_socket_close(&client);
}

static void wrong_words_are_answered_with_an_error(void)
{
    osal_socket_t client = join();
    serve();
    (void)take(&client);
    say(&client, "< rawmode >");
    // The client has not opened a bus yet.
    TEST_ASSERT_EQUAL_STRING("< error unknown command >", take(&client));
    say(&client, "< open wheel >");
    TEST_ASSERT_EQUAL_STRING("< error could not open bus >", take(&client));
    say(&client, "< echo >");
    TEST_ASSERT_EQUAL_STRING("< echo >", take(&client));
    say(&client, "< open robot >");
    (void)take(&client);
    say(&client, "< send 123 0 >");
    // The client is not in raw mode yet.
    TEST_ASSERT_EQUAL_STRING("< error unknown command >", take(&client));
    say(&client, "< rawmode >");
    (void)take(&client);
    static const char* const bad[] = {"< send 123 9 1 2 3 4 5 6 7 8 9 >",
                                      "< send 800 0 >",
                                      "< send 123 2 1 >",
                                      "< send 123 1 100 >",
                                      "< send 123 1 1 2 >",
                                      "< send 123 1 -1 >",
                                      "< send 20000000 0 >"};
    for (size_t i = 0U; i < (sizeof bad / sizeof bad[0]); i++) {
        say(&client, bad[i]);
        TEST_ASSERT_EQUAL_STRING("< error syntax of send >", take(&client));
    }
    TEST_ASSERT_EQUAL_UINT(0U, heard_count);
    osal_socket_close(&client);
}

static void a_client_that_does_not_read_loses_messages_and_delays_no_other(void)
{
    osal_socket_t client         = join_raw();
    const osal_can_frame_t frame = {.id = 0x100U, .length = 8U};
    for (unsigned i = 0U; (i < 400000U) && (socketcand_dropped(server) == 0U); i++) {
        (void)bus_submit(bus, node, &frame, 0U);
        bus_run_until(bus, bus_now_ns(bus) + (MS / 5U));
        socketcand_send(server);
    }
    TEST_ASSERT_GREATER_THAN_UINT64(0U, socketcand_dropped(server));
    (void)take(&client);
    TEST_ASSERT_NOT_NULL(strstr(answer, "< frame 100 "));
    osal_socket_close(&client);
}

static void a_fifth_client_is_refused_until_a_slot_is_free(void)
{
    osal_socket_t clients[5];
    for (unsigned i = 0U; i < 5U; i++) {
        clients[i] = join();
        serve();
        TEST_ASSERT_EQUAL_STRING((i < 4U) ? "< hi >" : "", take(&clients[i]));
    }
    osal_socket_close(&clients[0]);
    serve();
    TEST_ASSERT_EQUAL_STRING("< hi >", take(&clients[4])); // The fifth client has taken the slot.
    for (unsigned i = 1U; i < 5U; i++) {
        osal_socket_close(&clients[i]);
    }
}

static void clients_receive_the_frames_of_each_other(void)
{
    osal_socket_t one = join_raw();
    osal_socket_t two = join_raw();
    say(&one, "< send 12345678 1 2A >");
    TEST_ASSERT_NOT_NULL(strstr(take(&two), "< frame 12345678 "));
    osal_socket_close(&one);
    osal_socket_close(&two);
}

static void simulated_time_waits_for_a_client_in_lock_step(void)
{
    static const char* const done = "< send 123 1 5 >< step 1 >";
    size_t sent                   = 0U;
    osal_socket_t idler           = join_raw();
    osal_socket_t client          = join_raw();
    const osal_can_frame_t sync   = {.id = 0x080U};
    // There is no client to wait for.
    TEST_ASSERT_EQUAL_UINT(0U, socketcand_end_step(server, 500U * 1000U, 0U));
    say(&client, "< step 0 >");
    TEST_ASSERT_EQUAL_STRING("< error syntax of step >", take(&client));
    TEST_ASSERT_EQUAL_UINT(0U, socketcand_end_step(server, 500U * 1000U, 0U));
    say(&client, "< step 2 >");
    // The server waits for the client only in each second step.
    TEST_ASSERT_EQUAL_UINT(0U, socketcand_end_step(server, 1000U * 1000U, 0U));
    TEST_ASSERT_EQUAL_UINT(1U, socketcand_end_step(server, 1500U * 1000U, 0U));
    osal_socket_close(&client);
    client = join_raw();
    say(&client, "< step 1 >");
    TEST_ASSERT_EQUAL_STRING("", take(&client));
    TEST_ASSERT_EQUAL_INT(STATUS_OK, bus_submit(bus, node, &sync, bus_now_ns(bus)));
    bus_run_until(bus, bus_now_ns(bus) + MS);
    TEST_ASSERT_EQUAL_INT(STATUS_OK, osal_stream_send(&client, (const uint8_t*)done, strlen(done), &sent));
    TEST_ASSERT_EQUAL_UINT(0U, socketcand_end_step(server, 1234567000U, 20000U));
    (void)take(&client);
    TEST_ASSERT_EQUAL_PTR(answer, strstr(answer, "< frame 080 ")); // First the frames of the step.
    TEST_ASSERT_NOT_NULL(strstr(answer, " >< step 1.234567 >"));   // Then the end of the step.
    bus_run_until(bus, bus_now_ns(bus) + MS);
    TEST_ASSERT_EQUAL_UINT(1U, heard_count); // The frame of the client is on the bus before the next step.
    // The client no longer answers:
    TEST_ASSERT_EQUAL_UINT(1U, socketcand_end_step(server, 1235067000U, 20U));
    TEST_ASSERT_EQUAL_UINT(0U, socketcand_end_step(server, 1235567000U, 20000U));
    status_t status = STATUS_OK;
    uint8_t octet   = 0U;
    // The server drops the client: it closes the connection after the frames of the step.
    while (status == STATUS_OK) {
        status = osal_stream_receive(&client, &octet, 1U, &sent);
    }
    TEST_ASSERT_EQUAL_INT(STATUS_CLOSED, status);
    osal_socket_close(&client);
    osal_socket_close(&idler);
}

static void frames_have_the_text_of_socketcand(void)
{
    char text[SOCKETCAND_MESSAGE_MAX];
    const osal_can_frame_t sync = {.time_ns = 1000002999U, .id = 0x080U};
    TEST_ASSERT_EQUAL_UINT(strlen("< frame 080 1.000002  >"), socketcand_message(&sync, text));
    TEST_ASSERT_EQUAL_STRING("< frame 080 1.000002  >", text);
    const osal_can_frame_t error = {.time_ns = 5000U, .id = OSAL_CAN_ERROR | 0x24U, .length = 8U};
    (void)socketcand_message(&error, text);
    TEST_ASSERT_EQUAL_STRING("< error 20000024 0.000005 >", text);
    osal_can_frame_t longest = {.time_ns = UINT64_MAX,
                                .id      = 0x1FFFFFFFU | OSAL_CAN_EXTENDED,
                                .length  = 64U,
                                .flags   = OSAL_CAN_FLAG_FD};
    TEST_ASSERT_LESS_THAN_UINT(SOCKETCAND_MESSAGE_MAX, socketcand_message(&longest, text) + 1U);
}

static void a_port_in_use_is_reported(void)
{
    socketcand_t* second           = NULL;
    const socketcand_bus_t buses[] = {{"robot", bus}};
    TEST_ASSERT_EQUAL_INT(STATUS_EXISTS, socketcand_open(socketcand_port(server), buses, 1U, &second));
    TEST_ASSERT_NULL(second);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(frames_pass_in_both_directions);
    RUN_TEST(messages_may_arrive_in_pieces_and_several_at_once);
    RUN_TEST(wrong_words_are_answered_with_an_error);
    RUN_TEST(a_client_that_does_not_read_loses_messages_and_delays_no_other);
    RUN_TEST(a_fifth_client_is_refused_until_a_slot_is_free);
    RUN_TEST(clients_receive_the_frames_of_each_other);
    RUN_TEST(simulated_time_waits_for_a_client_in_lock_step);
    RUN_TEST(frames_have_the_text_of_socketcand);
    RUN_TEST(a_port_in_use_is_reported);
    return UNITY_END();
}
