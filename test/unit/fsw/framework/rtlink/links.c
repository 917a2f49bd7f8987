// SPDX-License-Identifier: Apache-2.0
#include "test/unit/fsw/framework/rtlink/links.h"

#include "unity.h"

#include <stdio.h>
#include <unistd.h>

#define ARRIVAL_MS 1000U

static osal_socket_t udp = OSAL_SOCKET_CLOSED;
static osal_address_t address;
static unsigned under_way;
status_t links_tipc_status;
static long owner; // The process that opened the links; a forked child uses the same names.

void links_name(uint16_t link, char out_name[64])
{
    (void)snprintf(out_name, 64U, "/hirosco-test.%ld.link%u", owner, (unsigned)link);
}

static bool shm_name(void* context, uint16_t link, char* out_name, size_t capacity)
{
    (void)context;
    char name[64];
    links_name(link, name);
    return (link != LINK_UNKNOWN) && (snprintf(out_name, capacity, "%s", name) < (int)capacity);
}

static bool udp_route(void* context, uint16_t link, osal_socket_t** out_socket, osal_address_t* out_consumer)
{
    (void)context;
    *out_socket   = &udp;
    *out_consumer = address;
    return link != LINK_UNKNOWN;
}

#define LINK_TYPE 0x4C000001U

static bool tipc_route(void* context, uint16_t link, osal_socket_t** out_socket,
                       osal_tipc_name_t* out_consumer)
{
    (void)context;
    *out_socket   = &udp;
    *out_consumer = (osal_tipc_name_t){LINK_TYPE, link};
    return link != LINK_UNKNOWN;
}

/// Replaces TIPC, which few kernels have: a frame sent to the name goes to the same UDP socket.
status_t osal_tipc_send(osal_socket_t* sock, osal_tipc_name_t to, const uint8_t* octets, size_t size)
{
    TEST_ASSERT_EQUAL_PTR(&udp, sock);
    TEST_ASSERT_EQUAL_HEX32(LINK_TYPE, to.type);
    TEST_ASSERT_EQUAL(((unsigned)octets[4] << 8U) | octets[5], to.instance);
    return (links_tipc_status == STATUS_OK) ? osal_udp_send(sock, address, octets, size) : links_tipc_status;
}

static void delivered(void* context, uint16_t link, uint32_t epoch)
{
    (void)context;
    (void)link;
    TEST_ASSERT_NOT_EQUAL(0U, epoch);
    under_way++;
}

const rtlink_resolver_t links = {
    .shm_name = shm_name, .udp_route = udp_route, .delivered = delivered, .tipc_route = tipc_route};

rtlink_terms_t links_terms(rtlink_method_t method, uint32_t octets)
{
    return (rtlink_terms_t){.layout_hash   = 1U,
                            .layout_octets = octets,
                            .order         = (uint8_t)rtlink_native_order(),
                            .period_us     = 500U,
                            .methods       = (uint8_t)(1U << (unsigned)method),
                            .decimation    = 1U,
                            .max_age_us    = 2000U};
}

unsigned links_under_way(void)
{
    return under_way;
}

size_t links_receive(uint8_t frame[LINK_FRAME_MAX])
{
    osal_address_t from = {0U, 0U};
    size_t size         = 0U;
    TEST_ASSERT_EQUAL(STATUS_OK, osal_socket_wait_readable(&udp, ARRIVAL_MS));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_udp_receive(&udp, &from, frame, LINK_FRAME_MAX, &size));
    under_way--;
    return size;
}

void links_send(const uint8_t* octets, size_t size)
{
    TEST_ASSERT_EQUAL(STATUS_OK, osal_udp_send(&udp, address, octets, size));
    under_way++;
}

void links_open(void)
{
    under_way         = 0U;
    links_tipc_status = STATUS_OK;
    owner             = (long)getpid();
    TEST_ASSERT_EQUAL(STATUS_OK, osal_udp_open(&udp, (osal_address_t){OSAL_IPV4_LOOPBACK, 0U}, 1048576U));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_socket_local_address(&udp, &address));
}

void links_close(void)
{
    osal_socket_close(&udp);
    for (uint16_t link = 1U; link < 8U; link++) {
        char name[64];
        links_name(link, name);
        (void)osal_shm_remove(name);
    }
}
