# SPDX-License-Identifier: Apache-2.0
"""The light ground station: a web page beside a flight (`make gse`)."""
