# SPDX-License-Identifier: Apache-2.0
"""Reader of the recording of a run, without the code of the writer (hirosco_gse/recording.py describes the form)."""

import gzip
import json
import struct

import numpy as np


class Reader:
    def __init__(self, octets):
        whole = gzip.decompress(octets)
        (size,) = struct.unpack_from("<I", whole)
        self.head, self._rest = json.loads(whole[4 : 4 + size]), whole[4 + size :]
        self.tables = []
        for about in self.head["tables"]:
            times = self._column(about["rows"], about["per"])
            leaves = {name: np.array([self._column(about["rows"], per) for per in pers]).T for name, pers in about["leaves"]}
            self.tables.append({**about, "t": times, "leaves": leaves})
        assert not self._rest

    def _column(self, rows, per):
        width = 8 if per is None else 4
        planes, self._rest = self._rest[: width * rows], self._rest[width * rows :]
        octets = np.frombuffer(planes, np.uint8).reshape(width, rows).T.copy()
        if per is None:
            return octets.view("<f8").ravel()
        coded = octets.view("<u4").ravel().astype(np.int64)
        total = np.cumsum((coded >> 1) ^ -(coded & 1))
        whole = (total + 2**31) % 2**32 - 2**31
        return np.where(whole == -(2**31), np.nan, whole / per)
