# SPDX-License-Identifier: Apache-2.0
"""A package, so that its flight ends with its last test and not with the last test of all."""
