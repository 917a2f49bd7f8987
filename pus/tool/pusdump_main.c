// SPDX-License-Identifier: Apache-2.0
/// pusdump prints space packets, like candump prints CAN frames.
#include "base/version.h"
#include "pus/tool/pusdump_input.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>

#define EXIT_GOOD 0
#define EXIT_MALFORMED 1
#define EXIT_USAGE 2

static const char usage[] =
    "usage: pusdump [--json] [--format auto|hex|log|binary] [--epoch SECONDS] [FILE|-]...\n"
    "\n"
    "Prints one line per space packet. FILE is a packet log (lines `<time> TC|TM <hex>`), lines of "
    "hexadecimal\n"
    "digits, or packets back to back; without FILE, or with -, standard input. Empty lines and lines that "
    "begin\n"
    "with # are skipped.\n"
    "\n"
    "  --json            one JSON object per packet: direction apid service subtype seq source|destination "
    "time_ns\n"
    "                    crc_ok error, and name ack|counter size log_time location data fields; null = "
    "absent\n"
    "  --format FORMAT   format of the input (default auto: recognize it)\n"
    "  --epoch SECONDS   print packet times relative to this moment, in seconds since 1958-01-01 TAI\n"
    "  --help            this text\n"
    "  --version         name and version\n"
    "\n"
    "A malformed packet gets one line that says what is wrong. Exit code: 0 all packets are well-formed, 1 "
    "some are\n"
    "not, 2 wrong usage or a file that cannot be read.\n";

typedef struct {
    dump_style_t style;
    dump_format_t format;
    int first_file; ///< Index of the first argument that is not an option.
} options_t;

static int report_error(const char* const words, const char* const what)
{
    (void)fprintf(stderr, "pusdump: %s%s; see pusdump --help\n", words, what);
    return EXIT_USAGE;
}

static bool read_format(const char* const word, dump_format_t* const out_format)
{
    static const char* const words[] = {"auto", "hex", "log", "binary"};
    for (size_t i = 0U; i < (sizeof words / sizeof words[0]); i++) {
        if (strcmp(word, words[i]) == 0) {
            *out_format = (dump_format_t)i;
            return true;
        }
    }
    return false;
}

static bool read_epoch(const char* const word, dump_style_t* const style)
{
    char* end                      = NULL;
    errno                          = 0;
    const unsigned long long value = strtoull(word, &end, 10);
    const bool is_good =
        (word[0] >= '0') && (word[0] <= '9') && (*end == '\0') && (value <= UINT32_MAX) && (errno == 0);
    style->has_epoch = true;
    style->epoch_ns  = is_good ? (value * 1000000000ULL) : 0U;
    return is_good;
}

/// Read the options. Returns EXIT_GOOD, or the exit code for wrong usage.
static int read_options(const int count, char** const arguments, options_t* const out_options)
{
    int index = 1;
    while ((index < count) && (arguments[index][0] == '-') && (arguments[index][1] != '\0')) {
        const char* const option = arguments[index];
        const char* const value  = ((index + 1) < count) ? arguments[index + 1] : "";
        index++;
        if (strcmp(option, "--") == 0) {
            break;
        }
        if (strcmp(option, "--json") == 0) {
            out_options->style.as_json = true;
        } else if (strcmp(option, "--format") == 0) {
            index++;
            if (!read_format(value, &out_options->format)) {
                return report_error("unknown format ", value);
            }
        } else if (strcmp(option, "--epoch") == 0) {
            index++;
            if (!read_epoch(value, &out_options->style)) {
                return report_error("not a number of seconds: ", value);
            }
        } else {
            return report_error("unknown option ", option);
        }
    }
    out_options->first_file = index;
    return EXIT_GOOD;
}

static int dump_file(const char* const name, const options_t* const options)
{
    const bool is_input = (strcmp(name, "-") == 0);
    FILE* const stream  = is_input ? stdin : fopen(name, "rb");
    if (stream == NULL) {
        (void)fprintf(stderr, "pusdump: %s: %s\n", name, strerror(errno));
        return EXIT_USAGE;
    }
    if (is_input) {
        (void)setvbuf(stdout, NULL, _IOLBF, BUFSIZ); // Print each packet as soon as it is read.
    }
    errno                         = 0;
    const unsigned long malformed = dump_stream(stream, options->format, &options->style);
    const bool is_unreadable      = ferror(stream) != 0;
    if (is_unreadable) {
        (void)fprintf(stderr, "pusdump: %s: %s\n", name, strerror(errno));
    }
    if (!is_input) {
        (void)fclose(stream);
    }
    return is_unreadable ? EXIT_USAGE : ((malformed > 0U) ? EXIT_MALFORMED : EXIT_GOOD);
}

int main(const int count, char** const arguments)
{
    static char standard_input[] = "-";
    options_t options            = {.format = DUMP_AUTO};
    for (int i = 1; i < count; i++) {
        if (strcmp(arguments[i], "--help") == 0) {
            (void)fputs(usage, stdout);
            return EXIT_GOOD;
        }
        if (strcmp(arguments[i], "--version") == 0) {
            (void)puts("pusdump " HIROSCO_VERSION);
            return EXIT_GOOD;
        }
    }
    int result = read_options(count, arguments, &options);
    if (result != EXIT_GOOD) {
        return result;
    }
    if (options.first_file >= count) {
        result = dump_file(standard_input, &options);
    }
    for (int i = options.first_file; i < count; i++) {
        const int code = dump_file(arguments[i], &options);
        result         = (code > result) ? code : result;
    }
    return (fflush(stdout) == 0) ? result : EXIT_USAGE;
}
