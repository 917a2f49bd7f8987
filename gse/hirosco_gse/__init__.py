# SPDX-License-Identifier: Apache-2.0
"""Ground segment: packets, dictionary, links, operator, figures and report."""

__version__ = "0.1.0"
