// SPDX-License-Identifier: Apache-2.0
#define _GNU_SOURCE
#include "sim/devices/stream_port.h"

#include "osal/include/osal/device.h"
#include "osal/include/osal/hand_over.h"
#include "osal/include/osal/mqueue.h"
#include "osal/include/osal/serial.h"
#include "osal/include/osal/shm.h"
#include "osal/include/osal/socket.h"

#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <termios.h>
#include <unistd.h>

#define NAME_OCTETS 64U
#define PATH_OCTETS 96U
#define DEPTH 8U ///< Messages of a queue; the flight software expects this number.
#define RECEIVED_OCTETS 512U
#define QUEUE_MAGIC 0x464C4F57U // As in flow_shm.c.
#define QUEUE_ENDED 0x454E4445U // Replaces QUEUE_MAGIC when the owner removes the queue.
#define QUEUE_KIND 1U           // FLOW_SHM_QUEUE in flow_shm.h.
#define NAME_ROOM 58U           // Precision of the formats that append a suffix to `name`.

typedef struct { // Layout of a queue in shared memory.
    uint32_t magic;
    uint32_t kind;
    uint32_t value_octets;
    uint32_t depth;
    uint64_t written;
    uint64_t read;
    uint64_t words[];
} queue_t;

struct stream_port {
    stream_port_config_t config;
    bool is_plugged;
    char name[NAME_OCTETS]; // "/RUN.flow.CHANNEL"
    char in[NAME_OCTETS];   // Queue to flight: `in` and `out` are named as in the flight software.
    char out[NAME_OCTETS];  // Queue to the device.
    char path[PATH_OCTETS]; // SERIAL, FILE: the symbolic link to the terminal.
    char counts_name[NAME_OCTETS];
    osal_hand_over_t counts;
    uint32_t connection; // Last connection that was accepted.
    osal_address_t address;
    osal_address_t peer; // UDP: flight's end, which has the same port.
    osal_socket_t listener;
    osal_socket_t socket; // UDP, and the connection of TCP.
    osal_device_t terminal;
    osal_shm_t to_flight;
    osal_shm_t to_device;
    osal_mqueue_t mqueue_to_flight;
    osal_mqueue_t mqueue_to_device;
    uint8_t received[RECEIVED_OCTETS]; // Octets of a stream that do not form a complete message yet.
    size_t held;                       // Number of these octets.
};

static bool is_terminal(const stream_port_t* const port)
{
    return (port->config.kind == STREAM_PORT_SERIAL) || (port->config.kind == STREAM_PORT_FILE);
}

static bool is_stream(const stream_port_t* const port)
{
    return is_terminal(port) || (port->config.kind == STREAM_PORT_TCP);
}

// ---- Names ----

static unsigned long number_after(const char* const text, const char mark)
{
    const char* last = strrchr(text, mark);
    return (last != NULL) ? strtoul(&last[1], NULL, 10) : 0U;
}

static bool name_all(stream_port_t* const port)
{
    const stream_port_config_t* config = &port->config;
    const bool is_udp                  = config->kind == STREAM_PORT_UDP;
    const bool has_port                = is_udp || (config->kind == STREAM_PORT_TCP);
    const unsigned long number         = number_after(config->channel, ':');
    char channel[NAME_OCTETS];
    int size = has_port ? snprintf(channel, sizeof channel, "%s.%lu", is_udp ? "udp" : "tcp", number)
                        : snprintf(channel, sizeof channel, "%s",
                                   &config->channel[(config->channel[0] == '/') ? 1U : 0U]);
    for (char* next = channel; *next != '\0'; next++) {
        *next = (*next == '/') ? '.' : *next;
    }
    port->address =
        (osal_address_t){OSAL_IPV4_OF_DEVICES((uint32_t)number_after(config->run, '-')), (uint16_t)number};
    port->peer =
        (osal_address_t){OSAL_IPV4_OF_FLIGHT((uint32_t)number_after(config->run, '-')), (uint16_t)number};
    const int most = snprintf(port->name, sizeof port->name, "/%s.flow.%s", config->run, channel);
    (void)snprintf(port->in, sizeof port->in, "%.58s.in", port->name);
    (void)snprintf(port->out, sizeof port->out, "%.58s.out", port->name);
    (void)snprintf(port->counts_name, sizeof port->counts_name, "%.58s.n", port->name);
    (void)snprintf(port->path, sizeof port->path, "/dev/shm%s", port->name);
    return (size > 0) && ((size_t)size < sizeof channel) && (most > 0) && ((unsigned)most < NAME_ROOM) &&
           (!has_port || ((number > 0U) && (number <= UINT16_MAX)));
}

// ---- Queues in shared memory ----

static size_t queue_stride(const size_t octets)
{
    return ((octets + 7U) / 8U) * 8U;
}

static status_t create_queue(stream_port_t* const port)
{
    const size_t octets = port->config.octets_out;
    (void)osal_shm_remove(port->in);
    const status_t status =
        osal_shm_create(&port->to_flight, port->in, sizeof(queue_t) + (queue_stride(octets) * DEPTH));
    if (status == STATUS_OK) {
        queue_t* queue      = osal_shm_address(&port->to_flight);
        queue->kind         = QUEUE_KIND;
        queue->value_octets = (uint32_t)octets;
        queue->depth        = DEPTH;
        // Last: flight uses the queue when it finds the magic number, and then the header must be complete.
        __atomic_store_n(&queue->magic, QUEUE_MAGIC, __ATOMIC_RELEASE);
    }
    return status;
}

static void end_queue(stream_port_t* const port)
{
    queue_t* queue = osal_shm_address(&port->to_flight);
    if (queue != NULL) {
        __atomic_store_n(&queue->magic, QUEUE_ENDED, __ATOMIC_RELEASE);
        osal_shm_close(&port->to_flight);
        (void)osal_shm_remove(port->in);
    }
    osal_shm_close(&port->to_device);
}

static void write_queue(stream_port_t* const port, const uint8_t* const message)
{
    queue_t* queue         = osal_shm_address(&port->to_flight);
    const uint64_t written = __atomic_load_n(&queue->written, __ATOMIC_RELAXED);
    if ((written - __atomic_load_n(&queue->read, __ATOMIC_ACQUIRE)) < DEPTH) {
        const size_t stride = queue_stride(port->config.octets_out);
        memcpy((uint8_t*)queue->words + ((size_t)(written % DEPTH) * stride), message,
               port->config.octets_out);
        __atomic_store_n(&queue->written, written + 1U, __ATOMIC_RELEASE);
    }
}

/// Find the queue that the flight software has made; when flight restarts, it makes a new one.
static queue_t* find_queue(stream_port_t* const port)
{
    queue_t* queue = osal_shm_address(&port->to_device);
    if ((queue != NULL) && (__atomic_load_n(&queue->magic, __ATOMIC_ACQUIRE) != QUEUE_MAGIC)) {
        osal_shm_close(&port->to_device);
        queue = NULL;
    }
    if ((queue == NULL) && (osal_shm_open(&port->to_device, port->out) == STATUS_OK)) {
        queue             = osal_shm_address(&port->to_device);
        const size_t size = sizeof(queue_t) + (queue_stride(port->config.octets_in) * DEPTH);
        if ((osal_shm_size(&port->to_device) < size) || (queue->magic != QUEUE_MAGIC) ||
            (queue->value_octets != port->config.octets_in) || (queue->depth != DEPTH)) {
            osal_shm_close(&port->to_device);
            queue = NULL;
        }
    }
    return queue;
}

static bool read_queue(stream_port_t* const port, uint8_t* const message, size_t* const out_size)
{
    queue_t* queue = find_queue(port);
    if (queue == NULL) {
        return false;
    }
    const uint64_t read = __atomic_load_n(&queue->read, __ATOMIC_RELAXED);
    if (__atomic_load_n(&queue->written, __ATOMIC_ACQUIRE) == read) {
        return false;
    }
    const size_t stride = queue_stride(port->config.octets_in);
    memcpy(message, (const uint8_t*)queue->words + ((size_t)(read % DEPTH) * stride), port->config.octets_in);
    __atomic_store_n(&queue->read, read + 1U, __ATOMIC_RELEASE);
    *out_size = port->config.octets_in;
    return true;
}

// ---- Message queues ----

static status_t create_mqueue(stream_port_t* const port)
{
    (void)osal_mqueue_remove(port->out);
    return osal_mqueue_create(&port->mqueue_to_device, port->out, DEPTH, (uint32_t)port->config.octets_in);
}

static void end_mqueue(stream_port_t* const port)
{
    osal_mqueue_close(&port->mqueue_to_device);
    osal_mqueue_close(&port->mqueue_to_flight);
    (void)osal_mqueue_remove(port->out);
}

static void write_mqueue(stream_port_t* const port, const uint8_t* const message, const size_t size)
{
    status_t status =
        port->mqueue_to_flight.is_open ? STATUS_OK : osal_mqueue_open(&port->mqueue_to_flight, port->in);
    if (status == STATUS_OK) {
        status = osal_mqueue_send(&port->mqueue_to_flight, message, size);
    }
    if ((status != STATUS_OK) && (status != STATUS_FULL)) {
        osal_mqueue_close(&port->mqueue_to_flight); // Flight has restarted.
    }
}

// ---- Terminals ----

static status_t make_raw(const int descriptor)
{
    struct termios mode;
    if (tcgetattr(descriptor, &mode) != 0) {
        return STATUS_IO;
    }
    cfmakeraw(&mode);
    return (tcsetattr(descriptor, TCSANOW, &mode) == 0) ? STATUS_OK : STATUS_IO;
}

static status_t create_terminal(stream_port_t* const port)
{
    char partner[PATH_OCTETS];
    const int descriptor = posix_openpt(O_RDWR | O_NOCTTY | O_CLOEXEC | O_NONBLOCK);
    if (descriptor < 0) {
        return STATUS_EXHAUSTED;
    }
    port->terminal = (osal_device_t){.descriptor = descriptor};
    (void)unlink(port->path);
    if ((grantpt(descriptor) != 0) || (unlockpt(descriptor) != 0) ||
        (ptsname_r(descriptor, partner, sizeof partner) != 0) || (make_raw(descriptor) != STATUS_OK) ||
        (symlink(partner, port->path) != 0)) {
        osal_device_close(&port->terminal);
        return STATUS_IO;
    }
    return STATUS_OK;
}

static void end_terminal(stream_port_t* const port)
{
    osal_device_close(&port->terminal);
    (void)unlink(port->path);
}

// ---- Plugging ----

static status_t begin(stream_port_t* const port)
{
    port->held = 0U;
    switch (port->config.kind) {
    case STREAM_PORT_SHM:
        return create_queue(port);
    case STREAM_PORT_MQUEUE:
        return create_mqueue(port);
    case STREAM_PORT_UDP:
        return osal_udp_open(&port->socket, port->address, 0U);
    case STREAM_PORT_TCP:
        return osal_tcp_listen(&port->listener, port->address);
    default:
        return create_terminal(port);
    }
}

static void end(stream_port_t* const port)
{
    if (port->config.kind == STREAM_PORT_SHM) {
        end_queue(port);
    } else if (port->config.kind == STREAM_PORT_MQUEUE) {
        end_mqueue(port);
    } else if (is_terminal(port)) {
        end_terminal(port);
    } else {
        osal_socket_close(&port->socket);
        osal_socket_close(&port->listener);
    }
}

static status_t open_port(stream_port_t* const port)
{
    if (!name_all(port)) {
        return STATUS_INVALID;
    }
    const bool has_counts = is_stream(port) || (port->config.kind == STREAM_PORT_UDP);
    status_t status       = STATUS_OK;
    if (port->config.is_counted && has_counts) {
        status = osal_hand_over_create(&port->counts, port->counts_name);
    }
    if (status == STATUS_OK) {
        status           = begin(port);
        port->is_plugged = (status == STATUS_OK);
    }
    return status;
}

status_t stream_port_open(const stream_port_config_t* const config, stream_port_t** const out_port,
                          char error[STREAM_PORT_ERROR_MAX])
{
    *out_port           = NULL;
    stream_port_t* port = calloc(1U, sizeof *port);
    if (port == NULL) {
        (void)snprintf(error, STREAM_PORT_ERROR_MAX, "out of memory");
        return STATUS_EXHAUSTED;
    }
    *port                 = (stream_port_t){.config   = *config,
                                            .counts   = OSAL_HAND_OVER_CLOSED,
                                            .listener = OSAL_SOCKET_CLOSED,
                                            .socket   = OSAL_SOCKET_CLOSED,
                                            .terminal = OSAL_DEVICE_CLOSED};
    const status_t status = open_port(port);
    if (status != STATUS_OK) {
        (void)snprintf(error, STREAM_PORT_ERROR_MAX,
                       "channel '%s': %s; expected a name, path or HOST:PORT that no other device uses",
                       config->channel, status_text(status));
        stream_port_close(port);
        return status;
    }
    *out_port = port;
    return STATUS_OK;
}

void stream_port_close(stream_port_t* const port)
{
    if (port == NULL) {
        return;
    }
    end(port);
    if (osal_hand_over_is_open(&port->counts)) {
        osal_hand_over_close(&port->counts);
        (void)osal_shm_remove(port->counts_name);
    }
    free(port);
}

bool stream_port_is_plugged(const stream_port_t* const port)
{
    return port->is_plugged;
}

void stream_port_plug(stream_port_t* const port, const bool is_plugged)
{
    if (is_plugged == port->is_plugged) {
        return;
    }
    // A socket for datagrams stays open: its peer cannot detect that a cable is unplugged.
    if (port->config.kind == STREAM_PORT_UDP) {
        port->is_plugged = is_plugged;
    } else if (is_plugged) {
        port->is_plugged = (begin(port) == STATUS_OK);
        osal_hand_over_set_present(&port->counts, port->is_plugged);
    } else {
        osal_hand_over_set_present(&port->counts, false);
        end(port);
        port->is_plugged = false;
    }
}

uint32_t stream_port_lost(const stream_port_t* const port)
{
    return osal_hand_over_lost(&port->counts);
}

// ---- Octets ----

/// Accept a new connection. In stepped time flight counts its connections, and this function waits until the
/// kernel has delivered the new one, so that the step does not depend on the speed of the machine.
static void accept_connection(stream_port_t* const port)
{
    osal_socket_t arrived = OSAL_SOCKET_CLOSED;
    osal_address_t from;
    if (osal_hand_over_is_open(&port->counts)) {
        const uint32_t connection = osal_hand_over_connection(&port->counts);
        if ((connection == port->connection) ||
            (osal_socket_wait_readable(&port->listener, OSAL_HAND_OVER_TIMEOUT_MS) != STATUS_OK)) {
            return;
        }
        port->connection = connection;
    }
    while (osal_tcp_accept(&port->listener, &arrived, &from) == STATUS_OK) { // Keep only the last connection.
        osal_socket_close(&port->socket);
        port->socket = arrived;
        port->held   = 0U;
    }
}

void stream_port_step(stream_port_t* const port)
{
    if (!port->is_plugged) {
        return;
    }
    if (port->config.kind == STREAM_PORT_TCP) {
        accept_connection(port);
    } else if (port->connection != osal_hand_over_connection(&port->counts)) {
        port->connection = osal_hand_over_connection(&port->counts);
        port->held       = 0U;
    } else {
        // The connection is the same.
    }
}

/// True if flight has opened its end, as far as the counts show; without counts always true. While the end is
/// closed nothing is sent, because a terminal would keep the octets until flight opens it.
static bool is_open_at_flight(const stream_port_t* const port)
{
    return !osal_hand_over_is_open(&port->counts) || osal_hand_over_is_connected(&port->counts);
}

void stream_port_send_raw(stream_port_t* const port, const uint8_t* const octets, const size_t size)
{
    size_t sent     = 0U;
    status_t status = STATUS_CLOSED;
    if (!port->is_plugged || !is_open_at_flight(port)) {
        return;
    }
    if (port->config.kind == STREAM_PORT_SHM) {
        write_queue(port, octets);
    } else if (port->config.kind == STREAM_PORT_MQUEUE) {
        write_mqueue(port, octets, size);
    } else if (port->config.kind == STREAM_PORT_UDP) {
        status = osal_udp_send(&port->socket, port->peer, octets, size);
        osal_hand_over_announce(&port->counts, (status == STATUS_OK) ? 1U : 0U);
    } else if (is_terminal(port)) {
        status = osal_device_write(&port->terminal, octets, size, &sent);
        osal_hand_over_announce(&port->counts, (uint32_t)sent);
    } else if (osal_socket_is_open(&port->socket)) {
        status = osal_stream_send(&port->socket, octets, size, &sent);
        osal_hand_over_announce(&port->counts, (uint32_t)sent);
    } else {
        // Flight is not connected.
    }
    (void)status; // Octets that the flight software does not take are lost, as on a real line.
}

void stream_port_send(stream_port_t* const port, const uint8_t* const message, const size_t size)
{
    uint8_t frame[STREAM_FRAME_OCTETS(STREAM_PORT_MESSAGE_MAX)];
    if (is_stream(port)) {
        const size_t length = stream_frame_put(&port->config.framing, message, size, frame);
        stream_port_send_raw(port, frame, length);
    } else {
        stream_port_send_raw(port, message, size);
    }
}

static status_t read_at_once(stream_port_t* const port, size_t* const out_size)
{
    uint8_t* octets   = &port->received[port->held];
    const size_t room = sizeof port->received - port->held;
    *out_size         = 0U;
    if (room == 0U) {
        return STATUS_FULL;
    }
    return is_terminal(port) ? osal_device_read(&port->terminal, octets, room, out_size)
                             : osal_stream_receive(&port->socket, octets, room, out_size);
}

/// Read octets of a stream; in stepped time, wait for those that flight has announced.
static void read_octets(stream_port_t* const port)
{
    size_t size     = 0U;
    status_t status = read_at_once(port, &size);
    while ((status == STATUS_OK) || ((status == STATUS_EMPTY) && (osal_hand_over_due(&port->counts) > 0U))) {
        osal_hand_over_take(&port->counts, (uint32_t)size);
        port->held += size;
        const bool is_due = osal_hand_over_due(&port->counts) > 0U;
        if (is_due) {
            status = is_terminal(port) ? osal_device_wait_readable(&port->terminal, OSAL_HAND_OVER_TIMEOUT_MS)
                                       : osal_socket_wait_readable(&port->socket, OSAL_HAND_OVER_TIMEOUT_MS);
            if (status != STATUS_OK) {
                osal_hand_over_give_up(&port->counts);
            }
        }
        status = read_at_once(port, &size);
    }
    if ((status == STATUS_CLOSED) && (port->config.kind == STREAM_PORT_TCP)) {
        osal_socket_close(&port->socket);
    }
}

static bool take_datagram(stream_port_t* const port, uint8_t* const message, size_t* const out_size)
{
    osal_address_t from;
    status_t status = osal_udp_receive(&port->socket, &from, message, STREAM_PORT_MESSAGE_MAX, out_size);
    if ((status == STATUS_EMPTY) && (osal_hand_over_due(&port->counts) > 0U)) {
        if (osal_socket_wait_readable(&port->socket, OSAL_HAND_OVER_TIMEOUT_MS) == STATUS_OK) {
            status = osal_udp_receive(&port->socket, &from, message, STREAM_PORT_MESSAGE_MAX, out_size);
        } else {
            osal_hand_over_give_up(&port->counts);
        }
    }
    if ((status == STATUS_OK) || (status == STATUS_TOO_LARGE)) {
        osal_hand_over_take(&port->counts, 1U);
    }
    return status == STATUS_OK;
}

static bool receive_message(stream_port_t* const port, uint8_t* const message, size_t* const out_size)
{
    switch (port->config.kind) {
    case STREAM_PORT_SHM:
        return read_queue(port, message, out_size);
    case STREAM_PORT_MQUEUE:
        return osal_mqueue_receive(&port->mqueue_to_device, message, STREAM_PORT_MESSAGE_MAX, out_size) ==
               STATUS_OK;
    case STREAM_PORT_UDP:
        return take_datagram(port, message, out_size);
    default:
        if (is_terminal(port) || osal_socket_is_open(&port->socket)) {
            read_octets(port);
        }
        return stream_frame_take(&port->config.framing, port->received, &port->held, message, out_size);
    }
}

bool stream_port_receive(stream_port_t* const port, uint8_t* const message, size_t* const out_size)
{
    *out_size = 0U;
    if (port->is_plugged) {
        return receive_message(port, message, out_size);
    }
    while ((port->config.kind == STREAM_PORT_UDP) && take_datagram(port, message, out_size)) {
        *out_size = 0U; // The cable is unplugged: the device does not receive the datagram.
    }
    return false;
}
