// SPDX-License-Identifier: Apache-2.0
// Each call sends one request over rtnetlink and receives its answer.
#define _GNU_SOURCE
#include "osal/include/osal/can_interface.h"

#include "base/assertion.h"

#include <errno.h>
#include <linux/can.h>
#include <linux/can/netlink.h>
#include <linux/if_link.h>
#include <linux/netlink.h>
#include <linux/rtnetlink.h>
#include <net/if.h>
#include <net/if_arp.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/time.h>
#include <sys/un.h>
#include <unistd.h>

#define REQUEST_OCTETS 512U
#define ANSWER_OCTETS 16384U
#define ANSWER_SECONDS 5 ///< The kernel answers at once, unless it has a fault.
#define CLAIM_PREFIX "hirosco.can."

typedef struct {
    union {
        struct nlmsghdr header;
        uint8_t octets[REQUEST_OCTETS];
    } message;
} request_t;

typedef struct {
    union {
        struct nlmsghdr header;
        uint8_t octets[ANSWER_OCTETS];
    } message;
    size_t size;
} answer_t;

// ---- Messages ----

static struct ifinfomsg* begin(request_t* const request, const uint16_t type, const uint16_t flags)
{
    (void)memset(request, 0, sizeof *request);
    struct nlmsghdr* const header  = &request->message.header;
    header->nlmsg_len              = NLMSG_LENGTH(sizeof(struct ifinfomsg));
    header->nlmsg_type             = type;
    header->nlmsg_flags            = (uint16_t)(NLM_F_REQUEST | flags);
    struct ifinfomsg* const device = NLMSG_DATA(header);
    device->ifi_family             = AF_UNSPEC;
    return device;
}

static struct rtattr* add(request_t* const request, const unsigned short type, const void* const octets,
                          const size_t size)
{
    struct nlmsghdr* const header = &request->message.header;
    const size_t at               = NLMSG_ALIGN(header->nlmsg_len);
    FSW_ASSERT((at + RTA_SPACE(size)) <= REQUEST_OCTETS);
    struct rtattr* const attribute = (struct rtattr*)(void*)&request->message.octets[at];
    attribute->rta_type            = type;
    attribute->rta_len             = (unsigned short)RTA_LENGTH(size);
    if (size > 0U) {
        (void)memcpy(RTA_DATA(attribute), octets, size);
    }
    header->nlmsg_len = (uint32_t)(at + RTA_SPACE(size));
    return attribute;
}

static void add_text(request_t* const request, const unsigned short type, const char* const text)
{
    (void)add(request, type, text, strlen(text) + 1U);
}

/// Returns the structure of `size` octets after the header of the answer; NULL when the answer is shorter.
static const void* payload_of(const answer_t* const answer, const size_t size)
{
    const struct nlmsghdr* const header = &answer->message.header;
    const bool is_whole = NLMSG_OK(header, answer->size) && (header->nlmsg_len >= NLMSG_LENGTH(size));
    return is_whole ? NLMSG_DATA(header) : NULL;
}

/// Returns the errno in the kernel's answer; 0 for success.
static int error_of(const answer_t* const answer)
{
    const struct nlmsgerr* error = NULL;
    if (payload_of(answer, 0U) == NULL) {
        return EIO;
    }
    if (answer->message.header.nlmsg_type != (uint16_t)NLMSG_ERROR) {
        return 0;
    }
    error = payload_of(answer, sizeof *error);
    return (error != NULL) ? -error->error : EIO;
}

/// Send a request and receive the answer. Returns an errno; 0 for success.
static int ask(const request_t* const request, answer_t* const answer)
{
    const struct timeval timeout = {.tv_sec = ANSWER_SECONDS};
    const int descriptor         = socket(AF_NETLINK, SOCK_RAW | SOCK_CLOEXEC, NETLINK_ROUTE);
    int error                    = 0;
    answer->size                 = 0U;
    if (descriptor < 0) {
        return errno;
    }
    (void)setsockopt(descriptor, SOL_SOCKET, SO_RCVTIMEO, &timeout, sizeof timeout);
    if (send(descriptor, &request->message, request->message.header.nlmsg_len, 0) < 0) {
        error = errno;
    } else {
        ssize_t size = 0;
        do {
            size = recv(descriptor, &answer->message, sizeof answer->message, 0);
        } while ((size < 0) && (errno == EINTR));
        answer->size = (size > 0) ? (size_t)size : 0U;
        error        = (size > 0) ? error_of(answer) : EIO;
    }
    (void)close(descriptor);
    return error;
}

static status_t status_of(const int error)
{
    switch (error) {
    case 0:
        return STATUS_OK;
    case EPERM:
    case EACCES:
        return STATUS_DENIED;
    case EEXIST:
        return STATUS_EXISTS;
    case ENODEV:
        return STATUS_NOT_FOUND;
    case EOPNOTSUPP:
    case EAFNOSUPPORT:
    case EPROTONOSUPPORT:
        return STATUS_UNSUPPORTED;
    default:
        return STATUS_IO;
    }
}

static bool is_name(const char* const name)
{
    const size_t length = strlen(name);
    return (length > 0U) && (length <= OSAL_CAN_INTERFACE_NAME_MAX) && (strpbrk(name, "/ \t\n:") == NULL) &&
           (strcmp(name, ".") != 0) && (strcmp(name, "..") != 0);
}

static bool has_socketcan(void)
{
    const int descriptor = socket(PF_CAN, SOCK_RAW | SOCK_CLOEXEC, CAN_RAW);
    if (descriptor >= 0) {
        (void)close(descriptor);
    }
    return descriptor >= 0;
}

// ---- Queries ----

typedef void (*attribute_taker_t)(const struct rtattr* attribute, osal_can_interface_t* interface);

/// Pass each attribute in `size` octets to `take`.
static void for_each_attribute(const void* const octets, const size_t size, const attribute_taker_t take,
                               osal_can_interface_t* const interface)
{
    const struct rtattr* attribute = octets;
    size_t left                    = size;
    while ((left >= sizeof *attribute) && (attribute->rta_len >= sizeof *attribute) &&
           (attribute->rta_len <= left)) {
        take(attribute, interface);
        const size_t whole = RTA_ALIGN((size_t)attribute->rta_len); // The last attribute may lack padding.
        left -= (whole < left) ? whole : left;
        attribute = (const struct rtattr*)(const void*)((const uint8_t*)(const void*)attribute + whole);
    }
}

static uint32_t word_of(const struct rtattr* const attribute)
{
    uint32_t word = 0U;
    if (RTA_PAYLOAD(attribute) >= sizeof word) {
        (void)memcpy(&word, RTA_DATA(attribute), sizeof word);
    }
    return word;
}

static void take_controller(const struct rtattr* const attribute, osal_can_interface_t* const interface)
{
    switch (attribute->rta_type) {
    case IFLA_CAN_BITTIMING: // Both structures begin with the bit rate.
        interface->bit_rate = word_of(attribute);
        break;
    case IFLA_CAN_DATA_BITTIMING:
        interface->data_bit_rate = word_of(attribute);
        break;
    case IFLA_CAN_STATE:
        interface->is_bus_off = (word_of(attribute) == (uint32_t)CAN_STATE_BUS_OFF);
        break;
    default:
        break;
    }
}

static bool is_kind(const struct rtattr* const attribute, const char* const kind)
{
    const size_t size = strlen(kind);
    return (RTA_PAYLOAD(attribute) >= size) && (strncmp(RTA_DATA(attribute), kind, size) == 0);
}

/// Take the kind of the interface and its data. The kernel sends the kind first.
static void take_information(const struct rtattr* const attribute, osal_can_interface_t* const interface)
{
    if (attribute->rta_type == (unsigned short)IFLA_INFO_KIND) {
        interface->is_virtual = is_kind(attribute, "vcan") || is_kind(attribute, "vxcan");
    } else if ((attribute->rta_type == (unsigned short)IFLA_INFO_DATA) && !interface->is_virtual) {
        for_each_attribute(RTA_DATA(attribute), RTA_PAYLOAD(attribute), take_controller, interface);
    } else {
        // Statistics are not needed.
    }
}

static void take_link(const struct rtattr* const attribute, osal_can_interface_t* const interface)
{
    size_t size = RTA_PAYLOAD(attribute);
    switch (attribute->rta_type) {
    case IFLA_MTU:
        interface->carries_fd = (word_of(attribute) >= (uint32_t)CANFD_MTU);
        break;
    case IFLA_IFALIAS:
        size = (size < OSAL_CAN_LABEL_MAX) ? size : OSAL_CAN_LABEL_MAX;
        (void)memcpy(interface->label, RTA_DATA(attribute), size);
        break;
    case IFLA_LINKINFO:
        for_each_attribute(RTA_DATA(attribute), size, take_information, interface);
        break;
    default:
        break;
    }
}

status_t osal_can_interface_look(const char* const name, osal_can_interface_t* const out_interface)
{
    FSW_ASSERT((name != NULL) && (out_interface != NULL));
    request_t request;
    answer_t answer;
    *out_interface = (osal_can_interface_t){.is_virtual = false};
    if (!is_name(name)) {
        return STATUS_INVALID;
    }
    if (!has_socketcan()) {
        return STATUS_UNSUPPORTED;
    }
    (void)begin(&request, RTM_GETLINK, 0U);
    add_text(&request, IFLA_IFNAME, name);
    const status_t status = status_of(ask(&request, &answer));
    if (status != STATUS_OK) {
        return ((status == STATUS_NOT_FOUND) || (status == STATUS_DENIED)) ? status : STATUS_IO;
    }
    const struct nlmsghdr* const header  = &answer.message.header;
    const struct ifinfomsg* const device = payload_of(&answer, sizeof *device);
    if ((device == NULL) || (header->nlmsg_type != (uint16_t)RTM_NEWLINK)) {
        return STATUS_IO;
    }
    if (device->ifi_type != (unsigned short)ARPHRD_CAN) {
        return STATUS_NOT_OURS;
    }
    out_interface->is_up = ((device->ifi_flags & (unsigned)IFF_UP) != 0U);
    for_each_attribute(IFLA_RTA(device), IFLA_PAYLOAD(header), take_link, out_interface);
    return STATUS_OK;
}

// ---- Creating and removing ----

static status_t set_label(const char* const name, const char* const label)
{
    request_t request;
    answer_t answer;
    (void)begin(&request, RTM_SETLINK, NLM_F_ACK);
    add_text(&request, IFLA_IFNAME, name);
    (void)add(&request, IFLA_IFALIAS, label, strlen(label));
    return status_of(ask(&request, &answer));
}

status_t osal_can_interface_create(const char* const name, const bool carries_fd, const char* const label)
{
    FSW_ASSERT((name != NULL) && (label != NULL));
    static const char kind[] = "vcan";
    const uint32_t mtu       = carries_fd ? (uint32_t)CANFD_MTU : (uint32_t)CAN_MTU;
    request_t request;
    answer_t answer;
    if (!is_name(name) || (strlen(label) > OSAL_CAN_LABEL_MAX)) {
        return STATUS_INVALID;
    }
    struct ifinfomsg* const device =
        begin(&request, RTM_NEWLINK, (uint16_t)(NLM_F_ACK | NLM_F_CREATE | NLM_F_EXCL));
    device->ifi_flags  = IFF_UP;
    device->ifi_change = IFF_UP;
    add_text(&request, IFLA_IFNAME, name);
    (void)add(&request, IFLA_MTU, &mtu, sizeof mtu);
    struct rtattr* const information = add(&request, IFLA_LINKINFO, NULL, 0U);
    (void)add(&request, IFLA_INFO_KIND, kind, sizeof kind - 1U);
    const uint8_t* const end = &request.message.octets[request.message.header.nlmsg_len];
    information->rta_len     = (unsigned short)(end - (const uint8_t*)(const void*)information);
    status_t status          = status_of(ask(&request, &answer));
    if (status == STATUS_NOT_FOUND) {
        status = STATUS_IO;
    }
    if (status == STATUS_OK) {
        status = set_label(name, label);
        if (status != STATUS_OK) {
            (void)osal_can_interface_remove(name);
            status = STATUS_IO;
        }
    }
    return status;
}

status_t osal_can_interface_remove(const char* const name)
{
    FSW_ASSERT(name != NULL);
    request_t request;
    answer_t answer;
    if (!is_name(name)) {
        return STATUS_INVALID;
    }
    (void)begin(&request, RTM_DELLINK, NLM_F_ACK);
    add_text(&request, IFLA_IFNAME, name);
    const status_t status = status_of(ask(&request, &answer));
    return (status == STATUS_EXISTS) ? STATUS_IO : status;
}

// ---- Claims ----

/// A claim is an abstract local socket of that name: only one process can have such a socket, and the kernel
/// removes it when that process ends.
status_t osal_can_interface_claim(const char* const name, osal_can_claim_t* const out_claim)
{
    FSW_ASSERT((name != NULL) && (out_claim != NULL));
    struct sockaddr_un address = {.sun_family = AF_UNIX};
    out_claim->descriptor      = -1;
    if (!is_name(name)) {
        return STATUS_INVALID;
    }
    const size_t prefix = sizeof CLAIM_PREFIX - 1U;
    const size_t length = strlen(name);
    (void)memcpy(&address.sun_path[1], CLAIM_PREFIX, prefix);
    (void)memcpy(&address.sun_path[1U + prefix], name, length);
    const socklen_t size = (socklen_t)(offsetof(struct sockaddr_un, sun_path) + 1U + prefix + length);
    const int descriptor = socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0);
    if (descriptor < 0) {
        return STATUS_IO;
    }
    if (bind(descriptor, (const struct sockaddr*)(const void*)&address, size) != 0) {
        const int error = errno;
        (void)close(descriptor);
        return (error == EADDRINUSE) ? STATUS_EXISTS : STATUS_IO;
    }
    out_claim->descriptor = descriptor;
    return STATUS_OK;
}

void osal_can_interface_release(osal_can_claim_t* const claim)
{
    FSW_ASSERT(claim != NULL);
    if (claim->descriptor >= 0) {
        (void)close(claim->descriptor);
    }
    claim->descriptor = -1;
}
