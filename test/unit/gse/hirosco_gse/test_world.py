# SPDX-License-Identifier: Apache-2.0
"""The reader of worlds, and the worlds as the page gets them."""

import base64
import json
import pathlib
import subprocess
import sys

import numpy as np
import pytest
from hirosco_gse import world
from hirosco_gse.station import geometry

ROOT = pathlib.Path(__file__).resolve().parents[4]
WORLDS = sorted((ROOT / "descriptors" / "worlds").glob("*.xml"))
URDF = """<robot name="r"><link name="a"/><link name="b"><collision><origin xyz="0 0 1"/><geometry><box size="2 4 6"/></geometry></collision></link>
<link name="c"/><link name="d"/>
<joint name="slide" type="prismatic"><parent link="b"/><child link="c"/><origin xyz="0 0 1"/><axis xyz="0 0 2"/></joint>
<joint name="turn" type="revolute"><parent link="a"/><child link="b"/><origin xyz="1 0 0" rpy="0 0 1.5707963267948966"/>
<axis xyz="0 1 0"/><limit lower="-1" upper="2" effort="3" velocity="4"/></joint>
<joint name="weld" type="fixed"><parent link="c"/><child link="d"/><origin xyz="0 1 0"/></joint></robot>"""


@pytest.mark.parametrize("path", WORLDS, ids=lambda path: path.stem)
def test_the_page_can_read_every_world(path):
    """The result is JSON without NaN and infinity, which JSON does not allow."""
    found = world.read(path)
    lists = json.loads(json.dumps(geometry.as_lists(found), allow_nan=False))
    assert [len(robot["joints"]) for robot in lists["robots"]] == [len(robot.joints) for robot in found.robots]


def test_the_tip_of_rokviss_is_where_its_two_links_put_it():
    robot = world.read(ROOT / "descriptors" / "worlds" / "rokviss.xml").robots[0]
    for first, second in ((0.0, 0.0), (1.0472, -1.5708), (0.3, -2.0)):
        tip = np.array(robot.poses([first, second])["finger"])[:3, 3]
        both = first + second
        assert tip == pytest.approx([0.22 * np.cos(first) + 0.25 * np.cos(both), 0, 0.22 * np.sin(first) + 0.25 * np.sin(both)])


def test_joints_in_any_order_of_the_file_move_in_the_frame_of_their_parent(tmp_path):
    path = tmp_path / "r.urdf"
    path.write_text(URDF, encoding="utf-8")
    robot = world.read_urdf(path)
    assert robot.root == "a"
    assert [joint.name for joint in robot.moving] == ["slide", "turn"]
    assert (robot.joints[1].lower, robot.joints[1].upper, robot.joints[1].effort, robot.joints[1].velocity) == (-1, 2, 3, 4)
    # b is at (1, 0, 0), turned by 90 degrees about z and then about its own y: its z has the direction of a's
    # y.
    poses = {name: np.array(pose) for name, pose in robot.poses([0.5, np.pi / 2]).items()}
    assert poses["b"][:3, 2] == pytest.approx([0, 1, 0], abs=1e-12)
    assert poses["c"][:3, 3] == pytest.approx([1, 1.5, 0], abs=1e-12)
    assert poses["d"][:3, 3] == pytest.approx([0, 1.5, 0], abs=1e-12)
    for pose in poses.values():
        assert pose[:3, :3] @ pose[:3, :3].T == pytest.approx(np.eye(3))
    assert robot.links["b"].shapes[0].size == (2.0, 4.0, 6.0)


def test_the_station_does_without_numpy():
    """It would take 13 MB of memory in a process that runs beside the flight."""
    script = f"""import sys; from hirosco_gse import world; from hirosco_gse.station import geometry, server
lists = [geometry.as_lists(world.read(path)) for path in {[str(path) for path in WORLDS]}]
print(len(lists), [name for name in sys.modules if name.startswith("numpy")])"""
    done = subprocess.run([sys.executable, "-c", script], cwd=ROOT / "gse", capture_output=True, text=True, check=False)
    assert done.stdout == f"{len(WORLDS)} []\n", done.stderr


def test_an_element_that_cannot_be_read_is_named(tmp_path):
    with pytest.raises(world.WorldError, match="none.xml"):
        world.read(tmp_path / "none.xml")
    path = tmp_path / "r.urdf"
    path.write_text(URDF.replace('parent link="a"', 'parent link="z"'), encoding="utf-8")
    with pytest.raises(world.WorldError, match="robot r: joint turn: parent z: expected a link that the root carries"):
        world.read_urdf(path).poses([0, 0])


def test_a_body_starts_with_its_initial_state(tmp_path):
    """The state refers to the axes of the world or of a link of an earlier robot."""
    urdf = ROOT / "descriptors" / "worlds" / "satellite.urdf"
    path = tmp_path / "w.xml"
    path.write_text(f'<World name="w"><Robot name="a" urdf="{urdf}" base="free"><State at="1 2 3" rpy="0 0 1.5707963267948966"/></Robot>'
                    f'<Robot name="b" urdf="{urdf}" base="free"><State at="1 0 0" rpy="0 0 0" relativeTo="a.body"/></Robot>'
                    f'<Robot name="c" urdf="{urdf}" base="free"/></World>')
    first, second, third = (np.array(robot.at) for robot in world.read(path).robots)
    assert first[:3, 3].tolist() == [1, 2, 3] and np.allclose(first[:3, 0], [0, 1, 0])
    assert np.allclose(second[:3, 3], [1, 3, 3]) and np.allclose(second[:3, :3], first[:3, :3])
    assert np.array_equal(third, np.eye(4))


def test_a_free_body_without_shapes_is_a_box_of_its_mass():
    """300 kg with 40, 50 and 60 kg m2: the box has these moments of inertia."""
    robots = geometry.as_lists(world.read(ROOT / "descriptors" / "worlds" / "actuators.xml"))["robots"]
    (box,) = robots[0]["links"]["body"]
    x, y, z = (size**2 for size in box["size"])
    assert [25 * (y + z), 25 * (x + z), 25 * (x + y)] == pytest.approx([40, 50, 60])
    assert robots[0]["free"] and robots[0]["at"] == np.eye(4).ravel().tolist()


TRIANGLE = b"\0" * 80 + (1).to_bytes(4, "little") + b"\0" * 12 + b"\0\0\x80?" + b"\0" * 32 + b"\0\0"
VISUALS = """<robot name="r"><material name="gold"><color rgba="1 0.8 0 1"/></material>
<link name="a"><visual><origin xyz="0 0 2"/><geometry><cylinder radius="0.5" length="3"/></geometry><material name="gold"/></visual>
<visual><geometry><sphere radius="1"/></geometry><material name="own"><color rgba="0 0 1 1"/></material></visual></link>
<link name="b"><visual><geometry><mesh filename="{mesh}" scale="0.001 0.001 0.001"/></geometry></visual></link>
<joint name="turn" type="revolute"><parent link="a"/><child link="b"/><axis xyz="0 1 0"/></joint></robot>"""


def visuals_of(directory, mesh):
    path = directory / "r.urdf"
    path.write_text(VISUALS.format(mesh=mesh), encoding="utf-8")
    return geometry._robot(world.read_urdf(path))["visuals"]


def test_visuals_keep_shape_colour_and_mesh(tmp_path):
    (tmp_path / "meshes").mkdir()
    (tmp_path / "meshes" / "b.STL").write_bytes(TRIANGLE)
    found = visuals_of(tmp_path, "meshes/b.STL")
    cylinder, sphere = found["a"]
    assert (cylinder["kind"], cylinder["radius"], cylinder["length"], cylinder["colour"]) == ("cylinder", 0.5, 3.0, [1.0, 0.8, 0.0])
    assert cylinder["pose"][11] == 2.0
    assert (sphere["kind"], sphere["colour"]) == ("sphere", [0.0, 0.0, 1.0])
    assert base64.b64decode(found["b"][0]["stl"]) == TRIANGLE
    assert found["b"][0]["scale"] == [0.001] * 3 and found["b"][0]["colour"] is None


@pytest.mark.parametrize("mesh", ["b.dae", "none.stl", "../outside.stl", "package://r/b.stl", "large.stl", "/etc/hostname"])
def test_a_mesh_that_cannot_be_drawn_is_left_out(tmp_path, mesh, monkeypatch):
    """Only STL files of a bounded size below the directory of the URDF reach the page."""
    directory = tmp_path / "robot"
    directory.mkdir()
    monkeypatch.setattr(world, "MESH_OCTETS", len(TRIANGLE))
    for place, octets in ((directory / "b.dae", b""), (tmp_path / "outside.stl", TRIANGLE), (directory / "large.stl", TRIANGLE + b"\0")):
        place.write_bytes(octets)
    found = visuals_of(directory, mesh)
    assert "b" not in found and len(found["a"]) == 2


def test_a_shape_that_cannot_be_drawn_is_left_out(tmp_path):
    """Here it is a capsule, which URDF does not define."""
    path = tmp_path / "r.urdf"
    path.write_text(VISUALS.replace('<mesh filename="{mesh}" scale="0.001 0.001 0.001"/>', '<capsule radius="1" length="2"/>'), encoding="utf-8")
    found = geometry._robot(world.read_urdf(path))["visuals"]
    assert "b" not in found and len(found["a"]) == 2


def test_the_page_gets_wheels_thrusters_and_the_joints_with_a_brake(tmp_path):
    """A servo drive, whose data sheet has no holding brake, is not among these joints."""
    (tmp_path / "r.urdf").write_text(URDF, encoding="utf-8")
    path = tmp_path / "w.xml"
    path.write_text("""<World name="w" step="500us" gravity="0 0 0"><Robot name="r" urdf="r.urdf" base="free"/>
        <Drive name="A" joint="r.slide" type="t" bus="b" node="1" eds="servo-drive.eds"/><Drive name="B" joint="r.turn" type="t" bus="b" node="2" eds="joint-drive.eds"/>
        <Wheel name="RW" on="r.a" axis="0 0 1" momentum="12" torque="0.2" bus="b" node="3" eds="wheel.eds"/>
        <ValveBox name="BOX" bus="b" node="4" eds="valve-box.eds"><Valve name="PUSH" on="r.a" at="1 2 3" direction="0 -1 0" force="5" output="1"/></ValveBox>
        </World>""", encoding="utf-8")
    lists = geometry.as_lists(world.read(path))
    assert lists["wheels"] == [{"name": "RW", "on": "r.a", "axis": [0, 0, 1], "momentum": 12}]
    assert lists["valves"] == [{"name": "PUSH", "device": "BOX", "on": "r.a", "at": [1, 2, 3], "direction": [0, -1, 0]}]
    assert lists["robots"][0]["braked"] == ["turn"] and lists["drives"] == {"A": "r.slide", "B": "r.turn"}
