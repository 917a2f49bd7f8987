# SPDX-License-Identifier: Apache-2.0
"""A package, so that its flight ends with the last test of the package and not with the last test of the
session."""
