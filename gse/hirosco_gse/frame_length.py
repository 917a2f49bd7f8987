# SPDX-License-Identifier: Apache-2.0
"""Time of a CAN frame on the bus [us], with an average number of stuff bits; length: octets of data, also as an array; rates in bit/s."""


def classic_us(length, rate=1e6):
    """Classic frame with an 11-bit identifier: 47 bits and 8 for each octet; stuff bits add 8 % on average."""
    return (47 + 8.0 * length) * 1.08e6 / rate


def fd_us(length, rate=1e6, data_rate=5e6):
    """CAN FD frame: 30 bits at the nominal rate; 31 bits and 8 for each octet at the data rate; 8 % of stuff bits."""
    return 30 * 1.08e6 / rate + (31 + 8.0 * length) * 1.08e6 / data_rate
