# SPDX-License-Identifier: Apache-2.0
"""The robot in its scene, drawn from truth: two links in a vertical plane, contour, spring, finger."""

import numpy as np

LINKS_M = (0.22, 0.25)
TIP_RADIUS_M = 0.012
CONTOUR_X_M, CONTOUR_Z_M = (0.20, 0.45), -0.042
BUMP_X_M, BUMP_HEIGHT_M, BUMP_RADIUS_M = 0.325, 0.007, 0.10
HOOK_M, ANCHOR_Z_M = (0.327, 0.155), 0.005

BASE, UPPER, FOREARM, JOINT = "#3b4252", "#5b7aa8", "#7fa3cf", "#2e3440"
GROUND, SPRING, FINGER, TRACE, FORCE = "#b9a88b", "#4c8c5a", "#d08770", "#c2553d", "#b3202a"


def elbow_and_tip(joints):
    """Positions (x, z) of joint 2 and of the tip."""
    first, both = joints[0], joints[0] + joints[1]
    elbow = np.array([LINKS_M[0] * np.cos(first), LINKS_M[0] * np.sin(first)])
    return elbow, elbow + np.array([LINKS_M[1] * np.cos(both), LINKS_M[1] * np.sin(both)])


def contour():
    """Profile of the contour as x and z."""
    x = np.linspace(*CONTOUR_X_M, 400)
    away = np.clip(np.abs(x - BUMP_X_M), 0, BUMP_RADIUS_M)
    z = CONTOUR_Z_M + BUMP_HEIGHT_M - BUMP_RADIUS_M + np.sqrt(BUMP_RADIUS_M**2 - away**2)
    return x, np.maximum(z, CONTOUR_Z_M)


def _spring(axes, top):
    """Zigzag from the anchor to the hook, taut or at rest."""
    anchor = np.array([HOOK_M[0], ANCHOR_Z_M])
    along = np.linspace(0, 1, 25)
    points = anchor + along[:, None] * (np.asarray(top) - anchor)
    points[2:-2, 0] += 0.006 * np.where(np.arange(21) % 2, 1, -1)
    axes.plot(points[:, 0], points[:, 1], color=SPRING, lw=1.2, zorder=2)
    axes.plot(*anchor, "s", color=SPRING, ms=4, zorder=2)
    axes.plot(top[0], top[1], marker=(3, 0, 0), color=SPRING, ms=6, zorder=2)


def _link(axes, start, end, colour, width):
    axes.plot([start[0], end[0]], [start[1], end[1]], color=colour, lw=width, solid_capstyle="round", zorder=4)


def draw(axes, joints, tip_trace=None, force=None, hooked=False, is_held=False):
    """Draw one pose; force is the (x, z) force on the finger [N]; is_held: brakes engaged."""
    x, z = contour()
    axes.fill_between(x, z, -0.09, color=GROUND, lw=0, zorder=1)
    axes.plot(x, z, color="#7d6e55", lw=1.0, zorder=2)
    elbow, tip = elbow_and_tip(joints)
    _spring(axes, tip if hooked else np.array(HOOK_M))
    if tip_trace is not None and len(tip_trace):
        axes.plot(tip_trace[:, 0], tip_trace[:, 1], color=TRACE, lw=0.9, alpha=0.7, zorder=3)
    axes.fill([-0.045, 0.045, 0.03, -0.03], [-0.09, -0.09, -0.005, -0.005], color=BASE, lw=0, zorder=3)
    _link(axes, (0, 0), elbow, UPPER, 11)
    _link(axes, elbow, tip, FOREARM, 8)
    for centre, size in (((0, 0), 13), (elbow, 11)):
        axes.plot(*centre, "o", ms=size, color="#bf616a" if is_held else JOINT, zorder=5)
        axes.plot(*centre, "o", ms=size * 0.4, color="white", zorder=6)
    finger = axes.transData.transform([(0, 0), (TIP_RADIUS_M, 0)])
    size = 2 * abs(finger[1][0] - finger[0][0]) * 72 / axes.figure.dpi
    axes.plot(*tip, "o", ms=max(size, 4), color=FINGER, mec="#8a4a3a", zorder=7)
    if force is not None and np.hypot(*force) > 0.5:
        axes.annotate(
            "", xy=tip + np.asarray(force) * 0.0022, xytext=tip, zorder=8,
            arrowprops={"arrowstyle": "-|>", "color": FORCE, "lw": 1.8},
        )


def frame(axes, title):
    """Limits and looks of one picture; before draw."""
    axes.set_xlim(-0.08, 0.50)
    axes.set_ylim(-0.09, 0.30)
    axes.set_aspect("equal")
    axes.set_xticks([])
    axes.set_yticks([])
    axes.set_facecolor("#f7f8fa")
    for spine in axes.spines.values():
        spine.set_color("#c9ced6")
    axes.set_title(title, fontsize=9, loc="left")
