# SPDX-License-Identifier: Apache-2.0
"""Two emulated CAN controllers on one bus: each receives the frames of the other through Debian's driver."""

import pathlib
import subprocess

import buses
import cases


def case_controllers_come_up():
    for name in ("can0", "can1"):
        buses.command("ip", "link", "set", name, "up", "type", "can", "bitrate", "500000", "restart-ms", "100")
        shown = buses.command("ip", "-details", "link", "show", name)
        assert "state ERROR-ACTIVE" in shown and "bitrate 500000" in shown, shown
        assert pathlib.Path(f"/sys/class/net/{name}/device/driver").resolve().name == "kvaser_pci"


def case_frames_pass_both_ways():
    for listen, send in (("can0", "can1"), ("can1", "can0")):
        frames = ["123#DEADBEEF", "1ABCDEF0#11", "124#R"]
        assert buses.recorded(listen, send, *frames) == frames


def case_there_is_no_third_controller():
    shown = subprocess.run(["ip", "link", "show", "can2"], capture_output=True, text=True)
    assert shown.returncode != 0, shown.stdout


if __name__ == "__main__":
    cases.run(globals())
