# SPDX-License-Identifier: Apache-2.0
"""Time of a CAN frame on the bus [us], with an average number of stuff bits; rates in bit/s. Lengths may be arrays."""


def classic_us(length, rate=1e6):
    return (47 + 8.0 * length) * 1.08e6 / rate


def fd_us(length, rate=1e6, data_rate=5e6):
    return 30 * 1.08e6 / rate + (31 + 8.0 * length) * 1.08e6 / data_rate
