// SPDX-License-Identifier: Apache-2.0
// The simulated hand of the operator: the torques that it expects from the scene, the motion of each verb,
// errors of scripts, and lines that are added during a flight.
#include "sim/operator/hand.h"
#include "sim/operator/scene.h"
#include "test/support/bounds.h"
#include "test/unit/sim/operator/script_file.h"
#include "test/unit/sim/fixtures/rokviss.h"
#include "unity.h"

#include <math.h>
#include <string.h>

static hand_t* hand;
static uint64_t now_ns;
static char error[SCENARIO_ERROR_MAX];

void setUp(void)
{
    now_ns = 0U;
}

void tearDown(void)
{
    hand_destroy(hand);
    hand = NULL;
    script_file_remove();
}

static void play(const char* text)
{
    hand_destroy(hand);
    now_ns = 0U;
    TEST_ASSERT_EQUAL(STATUS_OK,
                      hand_load(&rokviss()->hand, &rokviss()->scene, script_file_write(text), &hand, error));
}

static const hand_intent_t* at(double time_s)
{
    for (; (double)now_ns * 1e-9 < time_s - 1e-9; now_ns += 500000U) {
        hand_step(hand, now_ns);
    }
    hand_step(hand, now_ns);
    return hand_intent(hand);
}

/// Expect that the intent follows from the wanted pose and the expected torque, as hand.h defines it. The
/// numbers are those of <Hand> in the world rokviss: jointStiffness 2667, positionScale 2, forceScale 0.03.
static void expect_intent(const hand_intent_t* intent, double grip_nm_rad)
{
    for (unsigned i = 0U; i < HAND_AXES; i++) {
        const double load  = intent->expected_torque_nm[i];
        const double joint = intent->wanted_joint_rad[i] - load / 2667.0;
        EXPECT_WITHIN((joint - rokviss()->scene.home_rad[i]) / 2.0 - 0.03 * load / grip_nm_rad, 1e-12,
                      intent->intent_rad[i]);
    }
}

// ---- Knowledge of the scene ----

static void inverse_kinematics_is_the_inverse_of_forward_kinematics(void)
{
    unsigned count = 0U;
    for (double x = -0.45; x < 0.46; x += 0.05) {
        for (double z = -0.45; z < 0.46; z += 0.05) {
            const plane_t tip = {x, z};
            if (scene_reachable(&rokviss()->scene, tip)) {
                double joint[SCENE_JOINTS];
                scene_joints(&rokviss()->scene, tip, joint);
                const plane_t back = scene_tip(&rokviss()->scene, joint);
                EXPECT_WITHIN(x, 1e-12, back.x);
                EXPECT_WITHIN(z, 1e-12, back.z);
                TEST_ASSERT_TRUE(joint[1] < 0.0);
                count++;
            }
        }
    }
    TEST_ASSERT_GREATER_THAN_UINT(200U, count);
    TEST_ASSERT_FALSE(scene_reachable(&rokviss()->scene, (plane_t){0.47, 0.0}));
    TEST_ASSERT_FALSE(scene_reachable(&rokviss()->scene, (plane_t){0.0, 0.03}));
}

/// Returns the elastic energy of the spring, or of the finger in the contour: 500 N/m from 0.15 m on with a
/// preload of 5 N, or 5000 N/m.
static double energy(plane_t tip, bool spring)
{
    if (spring) {
        const double dx      = tip.x - 0.327;
        const double dz      = tip.z - 0.005;
        const double stretch = sqrt(dx * dx + dz * dz) - 0.15;
        return 5.0 * stretch + 250.0 * stretch * stretch;
    }
    const double bx   = tip.x - 0.325;
    const double bz   = tip.z + 0.135;
    const double flat = fmax(0.0, -0.030 - tip.z);
    const double bump = fmax(0.0, 0.112 - sqrt(bx * bx + bz * bz));
    return 2500.0 * (flat * flat + bump * bump);
}

static void expect_gradient(plane_t tip, bool spring, const double torque[SCENE_JOINTS])
{
    double joint[SCENE_JOINTS];
    scene_joints(&rokviss()->scene, tip, joint);
    for (unsigned i = 0U; i < SCENE_JOINTS; i++) {
        double up[]        = {joint[0], joint[1]};
        double down[]      = {joint[0], joint[1]};
        const double delta = 1e-6;
        up[i] += delta;
        down[i] -= delta;
        const double slope = energy(scene_tip(&rokviss()->scene, up), spring) -
                             energy(scene_tip(&rokviss()->scene, down), spring);
        EXPECT_WITHIN(-slope / (2.0 * delta), 1e-6, torque[i]);
    }
}

static void expected_torque_is_the_gradient_of_energy(void)
{
    const plane_t touching[] = {
        {0.25, -0.033}, {0.325, -0.025}, {0.35, -0.027}, {0.3635, -0.032}, {0.27, -0.029}};
    const plane_t pulling[] = {{0.327, 0.215}, {0.30, 0.20}, {0.35, 0.18}};
    double torque[SCENE_JOINTS];
    for (unsigned i = 0U; i < 5U; i++) {
        scene_contact_torque(&rokviss()->scene, touching[i], 0.0, torque);
        expect_gradient(touching[i], false, torque);
    }
    for (unsigned i = 0U; i < 3U; i++) {
        scene_spring_torque(&rokviss()->scene, pulling[i], torque);
        expect_gradient(pulling[i], true, torque);
    }
    scene_spring_torque(&rokviss()->scene, (plane_t){0.327, 0.150}, torque);
    EXPECT_WITHIN(0.0, 0.0, torque[0]);
}

static void expected_friction_acts_against_the_slide(void)
{
    const plane_t tip = {0.25, -0.033};
    double none[SCENE_JOINTS];
    double right[SCENE_JOINTS];
    double left[SCENE_JOINTS];
    scene_contact_torque(&rokviss()->scene, tip, 0.0, none);
    scene_contact_torque(&rokviss()->scene, tip, 1.0, right);
    scene_contact_torque(&rokviss()->scene, tip, -1.0, left);
    // 4.5 N to -x at the sphere's lowest point.
    EXPECT_WITHIN(-4.5 * 0.045, 1e-9, right[0] - none[0]);
    EXPECT_WITHIN(none[1], 1e-12, 0.5 * (left[1] + right[1]));
}

static void press_height_gives_the_force(void)
{
    EXPECT_WITHIN(-0.030, 1e-9, scene_press_height(&rokviss()->scene, 0.25, 0.0));
    EXPECT_WITHIN(-0.033, 1e-9, scene_press_height(&rokviss()->scene, 0.25, 15.0));
    EXPECT_WITHIN(-0.023, 1e-9, scene_press_height(&rokviss()->scene, 0.325, 0.0));
    EXPECT_WITHIN(-0.026, 1e-9, scene_press_height(&rokviss()->scene, 0.325, 15.0));
    double before = scene_press_height(&rokviss()->scene, 0.27, 15.0);
    // The height has no steps, not even at the corners of the bump.
    for (double x = 0.27; x < 0.38; x += 1e-4) {
        const double height = scene_press_height(&rokviss()->scene, x, 15.0);
        EXPECT_WITHIN(before, 5e-5, height);
        before = height;
    }
}

// ---- Verbs ----

static void without_a_script_the_hand_rests_in_the_centre(void)
{
    TEST_ASSERT_EQUAL(STATUS_OK, hand_load(&rokviss()->hand, &rokviss()->scene, NULL, &hand, error));
    const hand_intent_t* intent = at(1.0);
    EXPECT_WITHIN(0.0, 1e-12, intent->intent_rad[0]);
    EXPECT_WITHIN(0.0, 1e-12, intent->intent_rad[1]);
    EXPECT_WITHIN(0.3265, 1e-4, intent->wanted_tip_m[0]);
    EXPECT_WITHIN(0.0655, 1e-4, intent->wanted_tip_m[1]);
    TEST_ASSERT_EQUAL_STRING("rest", intent->verb);
}

static void the_torque_is_that_of_a_spring_and_a_damper(void)
{
    play("0 hand grip 4 0.2\n");
    (void)at(0.1);
    const double position[] = {0.05, -0.02};
    const double velocity[] = {0.1, 0.3};
    double torque[HAND_AXES];
    hand_act(hand, 0U, position, velocity, torque);
    EXPECT_WITHIN((-4.0 * 0.05) - (0.2 * 0.1), 1e-12, torque[0]);
    EXPECT_WITHIN((4.0 * 0.02) - (0.2 * 0.3), 1e-12, torque[1]);
}

static void circle_ramps_holds_and_ends_where_it_began(void)
{
    play("1 hand circle 0.19 0.5 2 9 1\n");
    EXPECT_WITHIN(0.0, 1e-12, at(1.0)->intent_rad[0]);
    for (double t = 3.0; t < 12.0; t += 0.25) {
        const hand_intent_t* intent = at(t);
        const double phase          = acos(-1.0) * (t - 1.0);
        EXPECT_WITHIN(0.095 * sin(phase), 1e-9, intent->intent_rad[0]);
        EXPECT_WITHIN(0.095 * cos(phase), 1e-9, intent->intent_rad[1]);
        EXPECT_BELOW(0.150, intent->wanted_tip_m[1]); // The tip is below the hook and above the contour.
        EXPECT_ABOVE(-0.020, intent->wanted_tip_m[1]);
    }
    EXPECT_WITHIN(0.0, 1e-12, at(13.0)->intent_rad[0]);
    EXPECT_WITHIN(0.0, 1e-12, at(14.0)->intent_rad[1]);
    expect_intent(at(14.0), 3.0);
}

static void move_is_smooth_and_arrives(void)
{
    play("1 hand move 0.28 -0.02 2\n");
    double before = at(1.0)->wanted_tip_m[0];
    double speed  = 0.0;
    while (now_ns < 3000000000U) {
        const double x    = at((double)now_ns * 1e-9 + 0.0005)->wanted_tip_m[0];
        const double next = (x - before) / 0.0005;
        EXPECT_WITHIN(speed, 0.001, next); // The speed has no jump.
        speed  = next;
        before = x;
    }
    const hand_intent_t* intent = at(3.0);
    EXPECT_WITHIN(0.28, 1e-12, intent->wanted_tip_m[0]);
    EXPECT_WITHIN(-0.02, 1e-12, intent->wanted_tip_m[1]);
    EXPECT_WITHIN(0.0, 1e-12, intent->expected_torque_nm[0]);
    expect_intent(intent, 3.0);
    TEST_ASSERT_EQUAL_STRING("move", intent->verb);
}

static void press_touches_at_its_speed_then_applies_its_force(void)
{
    play("0 hand move 0.25 -0.02 1\n2 hand press 15 0.02\n");
    EXPECT_WITHIN(-0.025, 1e-9, at(2.25)->wanted_tip_m[1]);
    EXPECT_WITHIN(-0.030, 1e-6, at(2.5)->wanted_tip_m[1]);
    EXPECT_WITHIN(0.0, 1e-3, at(2.5)->expected_torque_nm[0]);
    const hand_intent_t* intent = at(4.0);
    EXPECT_WITHIN(-0.033, 1e-9, intent->wanted_tip_m[1]);
    EXPECT_WITHIN(15.0 * 0.25, 1e-6, intent->expected_torque_nm[0]);
    expect_intent(intent, 3.0);
}

static void follow_keeps_the_force_over_the_bump(void)
{
    play("0 hand move 0.28 -0.02 1\n2 hand press 15 0.02\n4 hand follow 0.39 6\n10 hand hold\n");
    for (double t = 4.0; t < 10.0; t += 0.05) {
        const hand_intent_t* intent = at(t);
        const plane_t tip           = {intent->wanted_tip_m[0], intent->wanted_tip_m[1]};
        EXPECT_WITHIN(scene_press_height(&rokviss()->scene, tip.x, 15.0), 1e-9, tip.z);
        expect_intent(intent, 3.0);
    }
    const hand_intent_t* intent = at(12.0);
    EXPECT_WITHIN(0.39, 1e-9, intent->wanted_tip_m[0]);
    // Normal force, and the friction of a finger that came from the left.
    EXPECT_WITHIN(15.0 * 0.39 - 4.5 * 0.045, 1e-6, intent->expected_torque_nm[0]);
    const double kept = intent->intent_rad[1];
    EXPECT_WITHIN(kept, 0.0, at(20.0)->intent_rad[1]);
    TEST_ASSERT_EQUAL_STRING("hold", at(20.0)->verb);
}

static void lifting_the_finger_ends_the_expected_force(void)
{
    play("0 hand move 0.28 -0.02 1\n2 hand press 15 0.02\n4 hand follow 0.30 2\n7 hand move 0.30 0.02 1\n");
    EXPECT_ABOVE(3.0, at(7.0)->expected_torque_nm[0]);
    EXPECT_WITHIN(0.0, 0.0, at(9.0)->expected_torque_nm[0]);
    EXPECT_WITHIN(0.0, 0.0, at(9.0)->expected_torque_nm[1]);
}

static void pull_stretches_the_spring_and_release_ends_the_force(void)
{
    play("0 hand move 0.327 0.145 2\n3 hand pull 0.06 3\n6 hand hold\n8 hand release 1.5\n10 hand home 1\n");
    EXPECT_WITHIN(0.0, 0.0, at(3.0)->expected_torque_nm[0]);
    const hand_intent_t* intent = at(7.0);
    EXPECT_WITHIN(0.215, 1e-9, intent->wanted_tip_m[1]);
    EXPECT_WITHIN(-35.0 * 0.327, 1e-6, intent->expected_torque_nm[0]);
    expect_intent(intent, 3.0);
    EXPECT_WITHIN(0.145, 1e-12, at(9.6)->wanted_tip_m[1]);
    EXPECT_WITHIN(0.0, 0.0, at(9.6)->expected_torque_nm[0]);
    EXPECT_WITHIN(0.0, 1e-12, at(11.0)->intent_rad[0]);
    EXPECT_WITHIN(0.0, 1e-12, at(11.0)->intent_rad[1]);
}

static void rest_ends_the_force_without_moving(void)
{
    play("0 hand move 0.327 0.145 1\n1 hand pull 0.06 2\n4 hand rest\n6 hand home 1\n");
    const double tip = at(4.0)->wanted_tip_m[1];
    double before    = at(4.0)->intent_rad[0];
    for (double t = 4.0; t < 5.0; t += 0.0005) {
        EXPECT_WITHIN(before, 5e-4, at(t)->intent_rad[0]); // The offset for the expected torque fades.
        before = at(t)->intent_rad[0];
    }
    EXPECT_WITHIN(0.0, 0.0, at(5.0)->expected_torque_nm[0]);
    EXPECT_WITHIN(tip, 0.0, at(5.0)->wanted_tip_m[1]);
    // The hand no longer expects the force of the spring on its way home.
    EXPECT_WITHIN(0.0, 0.0, at(6.2)->expected_torque_nm[0]);
    EXPECT_WITHIN(0.0, 1e-12, at(7.0)->intent_rad[0]);
}

static void let_go_leaves_the_stick_and_the_next_verb_takes_it(void)
{
    play("1 hand let_go\n2 hand rest\n");
    const double position[] = {0.1, -0.1};
    const double velocity[] = {0.0, 0.0};
    double torque[HAND_AXES];
    (void)at(0.9);
    hand_torque(hand, position, velocity, torque);
    EXPECT_WITHIN(-0.3, 1e-12, torque[0]);
    EXPECT_WITHIN(0.0, 0.0, at(1.0)->grip);
    hand_torque(hand, position, velocity, torque);
    EXPECT_WITHIN(0.0, 0.0, torque[0]);
    EXPECT_WITHIN(0.0, 0.0, at(1.9)->grip);
    EXPECT_WITHIN(0.5, 0.01, at(2.15)->grip);
    EXPECT_WITHIN(1.0, 1e-9, at(2.4)->grip);
}

static void grip_changes_the_stiffness_and_not_the_motion(void)
{
    play("0 hand move 0.28 -0.02 1\n2 hand press 15 0.02\n4 hand grip 5 0.3\n4 hand follow 0.30 2\n5 hand "
         "grip 6 0.3\n");
    expect_intent(at(4.5), 5.0);
    expect_intent(at(5.5), 6.0);
    EXPECT_WITHIN(0.30, 1e-12, at(6.0)->wanted_tip_m[0]);
    TEST_ASSERT_EQUAL_STRING("follow", at(6.0)->verb);
}

static void a_new_verb_begins_at_the_pose_of_the_old_one(void)
{
    play("0 hand move 0.28 -0.02 2\n1 hand home 1\n");
    const double x = at(0.9995)->wanted_tip_m[0];
    EXPECT_WITHIN(x, 1e-4, at(1.0)->wanted_tip_m[0]);
    EXPECT_WITHIN(x, 1e-4, at(1.001)->wanted_tip_m[0]);
    EXPECT_WITHIN(0.3265, 1e-4, at(2.0)->wanted_tip_m[0]);
}

static void equal_scripts_give_equal_motions(void)
{
    static const char* const text =
        "0 hand circle 0.1 1 1 1 1\n4 hand move 0.28 -0.02 1\n5 hand press 10 0.05\n";
    double first[HAND_AXES];
    play(text);
    memcpy(first, at(6.1235)->intent_rad, sizeof first);
    play(text);
    TEST_ASSERT_EQUAL_MEMORY(first, at(6.1235)->intent_rad, sizeof first);
}

static void mission_script_is_accepted_and_stays_within_the_stops_of_the_stick(void)
{
    TEST_ASSERT_EQUAL(STATUS_OK, hand_load(&rokviss()->hand, &rokviss()->scene,
                                           "sim/scenarios/telepresence.scn", &hand, error));
    for (double t = 0.0; t < 95.0; t += 0.01) {
        const hand_intent_t* intent = at(t);
        for (unsigned i = 0U; i < HAND_AXES; i++) {
            const double stick = intent->intent_rad[i] + 0.03 * intent->expected_torque_nm[i] / 3.0;
            // Less than the stop at 0.35: on the stick, the wanted pose is corrected by the expected load.
            EXPECT_BELOW(0.30, fabs(stick));
        }
    }
}

// ---- Errors ----

typedef struct {
    const char* text;
    const char* message; // After the path.
} bad_t;

static void play_without_a_scene(const char* text)
{
    static const world_hand_t plain = {.stiffness = 3.0, .damping = 0.1};
    const hand_parameters_t grip    = hand_parameters_of(&plain);
    hand_destroy(hand);
    now_ns = 0U;
    TEST_ASSERT_EQUAL(STATUS_OK, hand_load(&grip, NULL, script_file_write(text), &hand, error));
}

static void a_hand_without_a_scene_leads_the_stick_and_expects_nothing(void)
{
    play_without_a_scene(
        "0 hand aim 0.1 -0.2 1\n2 hand hold\n3 hand circle 0.05 0.5 1 4 1\n10 hand let_go\n");
    EXPECT_WITHIN(0.05, 1e-12, at(0.5)->intent_rad[0]);
    EXPECT_WITHIN(-0.2, 1e-12, at(2.5)->intent_rad[1]);
    const hand_intent_t* const intent = at(5.0);
    EXPECT_WITHIN(0.05, 1e-9, hypot(intent->intent_rad[0] - 0.1, intent->intent_rad[1] + 0.2));
    for (unsigned i = 0U; i < HAND_AXES; i++) {
        EXPECT_WITHIN(0.0, 0.0, intent->expected_torque_nm[i]);
        EXPECT_WITHIN(0.0, 0.0, intent->wanted_tip_m[i]);
    }
    EXPECT_WITHIN(0.0, 0.0, at(10.5)->grip);
}

static void a_hand_without_a_scene_refuses_positions_and_forces(void)
{
    static const char* const texts[] = {"0 hand move 0.3 0.1 1\n", "0 hand press 5 0.02\n",
                                        "0 hand follow 0.3 1\n",   "0 hand pull 0.1 1\n",
                                        "0 hand release 1\n",      "0 hand home 1\n"};
    for (size_t i = 0U; i < (sizeof texts / sizeof texts[0]); i++) {
        hand_t* loaded = NULL;
        TEST_ASSERT_EQUAL(STATUS_INVALID,
                          hand_load(&rokviss()->hand, NULL, script_file_write(texts[i]), &loaded, error));
        TEST_ASSERT_NOT_NULL_MESSAGE(strstr(error, "the Hand of this world knows no scene"), error);
    }
}

static void a_world_without_a_hand_refuses_its_lines(void)
{
    TEST_ASSERT_EQUAL(STATUS_OK, hand_check_no_lines(NULL, error));
    TEST_ASSERT_EQUAL(STATUS_OK, hand_check_no_lines(script_file_write("0 fault unplug robot\n"), error));
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND, hand_check_no_lines("nowhere.scn", error));
    TEST_ASSERT_EQUAL(STATUS_INVALID, hand_check_no_lines(script_file_write("\n0 hand rest\n"), error));
    TEST_ASSERT_NOT_NULL_MESSAGE(strstr(error, ":2: found 'hand', expected "), error);
    TEST_ASSERT_NOT_NULL_MESSAGE(strstr(error, "this world has no Hand"), error);
}

static void bad_lines_are_reported_with_their_number(void)
{
    static const bad_t bad[] = {
        {"0 hand wave\n",
         ":1: found 'wave', expected rest, grip, circle, move, press, follow, hold, pull, release, "
         "home, let_go or aim"},
        {"0 hand rest\n1 hand move 0.3\n", ":2: found 'end of line', expected move <x> <z> <duration>"},
        {"0 hand hold 3\n", ":1: found '3', expected hold"},
        {"0 hand move 0.3 low 1\n", ":1: found 'low', expected z [m] from -1 to 1"},
        {"0 hand move 0.3 0.1 0\n", ":1: found '0', expected duration [s] from 0.05 to 600"},
        {"0 hand move 0.6 0.1 1\n", ":1: found '0.6', expected a target within reach of the arm"},
        {"0 hand follow 0.5 1\n", ":1: found '0.5', expected a target within reach of the arm"},
        {"0 hand press 100 0.02\n", ":1: found '100', expected force [N] from 0 to 60"},
        {"0 hand press 10 0\n", ":1: found '0', expected speed [m/s] from 0.001 to 0.2"},
        {"0 hand pull 0.2 1\n", ":1: found '0.2', expected distance [m] from 0 to 0.15"},
        {"0 hand pull 0.149 1\n", NULL},
        {"0 hand grip 0 0.1\n", ":1: found '0', expected stiffness [Nm/rad] from 0.1 to 50"},
        {"0 hand circle 0.1 0.5 1 1\n",
         ":1: found 'end of line', expected circle <amplitude> <frequency> <ramp> <hold> <down>"},
        {"0 hand release nan\n", ":1: found 'nan', expected duration [s] from 0.05 to 600"},
        {"0 hand home inf\n", ":1: found 'inf', expected duration [s] from 0.05 to 600"},
        {"0 foot rest\n", ":1: found 'foot', expected an actor: hand, fault, operator or ground"},
    };
    for (size_t i = 0U; i < (sizeof bad / sizeof bad[0]); i++) {
        const char* const path = script_file_write(bad[i].text);
        hand_t* loaded         = NULL;
        const status_t status  = hand_load(&rokviss()->hand, &rokviss()->scene, path, &loaded, error);
        if (bad[i].message != NULL) {
            TEST_ASSERT_EQUAL(STATUS_INVALID, status);
            TEST_ASSERT_NULL(loaded);
            TEST_ASSERT_EQUAL_STRING_LEN(path, error, strlen(path));
            TEST_ASSERT_EQUAL_STRING(bad[i].message, error + strlen(path));
        } else {
            TEST_ASSERT_EQUAL(STATUS_OK, status);
        }
        hand_destroy(loaded);
    }
}

static void a_missing_script_is_reported(void)
{
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND,
                      hand_load(&rokviss()->hand, &rokviss()->scene, "/nowhere.scn", &hand, error));
    TEST_ASSERT_NOT_NULL(strstr(error, "/nowhere.scn"));
}

/// Add a line such as "1.5 hand rest" to the hand.
static status_t add(const char* const text)
{
    bool is_mine         = false;
    scenario_line_t line = {.path = "live", .line = 1U};
    (void)snprintf(line.text, sizeof line.text, "%s", text);
    TEST_ASSERT_EQUAL(STATUS_OK, scenario_interpret(&line, "hand", &is_mine, error));
    TEST_ASSERT_TRUE(is_mine);
    return hand_add(hand, &line, error);
}

static void many_lines_play_in_the_order_of_their_times(void)
{
    static char text[1000U * 32U];
    size_t used = 0U;
    for (unsigned i = 0U; i < 1000U; i++) {
        used += (size_t)snprintf(&text[used], sizeof text - used, "%u hand %s\n", i,
                                 (i < 999U) ? "hold" : "rest");
    }
    play(text);
    TEST_ASSERT_EQUAL_STRING("rest", at(999.0)->verb);
}

/// An hour of mouse motion: 50 lines a second. Lines that have been played leave room for later ones.
static void an_hour_of_aims_is_taken_and_played(void)
{
    char text[64];
    play("");
    for (unsigned i = 0U; i < 180000U; i++) {
        (void)snprintf(text, sizeof text, "%u.%02u hand aim %s 0 0.03", i / 50U, (i % 50U) * 2U,
                       ((i % 2U) == 0U) ? "0.1" : "-0.1");
        TEST_ASSERT_EQUAL(STATUS_OK, add(text));
        now_ns = (i + 1U) * 20000000ULL;
        hand_step(hand, now_ns - 500000U);
        TEST_ASSERT_EQUAL_STRING("aim", hand_intent(hand)->verb);
    }
}

static void a_line_added_late_plays_between_those_of_the_scenario(void)
{
    play("");
    TEST_ASSERT_EQUAL(STATUS_OK, add("1 hand hold"));
    TEST_ASSERT_EQUAL(STATUS_OK, add("3 hand rest"));
    hand_step(hand, 1500000000U);
    TEST_ASSERT_EQUAL_STRING("hold", hand_intent(hand)->verb);
    TEST_ASSERT_EQUAL(STATUS_OK, add("2 hand let_go"));
    hand_step(hand, 2000000000U);
    TEST_ASSERT_EQUAL_STRING("let_go", hand_intent(hand)->verb);
    hand_step(hand, 3000000000U);
    TEST_ASSERT_EQUAL_STRING("rest", hand_intent(hand)->verb);
}

static void a_refused_line_has_no_effect(void)
{
    play("");
    TEST_ASSERT_EQUAL(STATUS_OK, add("2 hand hold"));
    TEST_ASSERT_EQUAL(STATUS_INVALID, add("1 hand aim 0.1 9 0.02"));
    TEST_ASSERT_NOT_NULL_MESSAGE(
        strstr(error, "live:1: found '9', expected stick angle [rad] from -0.6 to 0.6"), error);
    TEST_ASSERT_EQUAL(STATUS_INVALID, add("1 hand grasp"));
    hand_step(hand, 1999999999U);
    TEST_ASSERT_EQUAL_STRING("rest", hand_intent(hand)->verb);
    hand_step(hand, 2000000000U);
    TEST_ASSERT_EQUAL_STRING("hold", hand_intent(hand)->verb);
}

/// Returns the largest change of the intent in a step of 0.5 ms from `from_ns` to `to_ns`.
static double largest_jump(const uint64_t from_ns, const uint64_t to_ns)
{
    double largest = 0.0;
    for (now_ns = from_ns; now_ns <= to_ns; now_ns += 500000U) {
        const hand_intent_t before = *hand_intent(hand);
        hand_step(hand, now_ns);
        for (unsigned i = 0U; i < HAND_AXES; i++) {
            largest = fmax(largest, fabs(hand_intent(hand)->intent_rad[i] - before.intent_rad[i]));
        }
    }
    return largest;
}

static void aim_moves_the_intent_without_a_jump(void)
{
    play("");
    TEST_ASSERT_EQUAL(STATUS_OK, add("1 hand move 0.30 0.05 2"));
    TEST_ASSERT_EQUAL(STATUS_OK, add("4 hand press 15 0.02"));
    TEST_ASSERT_EQUAL(STATUS_OK, add("10 hand aim 0.10 -0.05 0.5"));
    TEST_ASSERT_EQUAL(STATUS_OK, add("12 hand hold"));
    TEST_ASSERT_EQUAL(STATUS_OK, add("14 hand home 3"));
    const double scripted = largest_jump(500000U, 9999500000U);
    EXPECT_WITHIN(0.0, 5e-4, scripted);
    EXPECT_WITHIN(0.0, 1e-3, largest_jump(10000000000U, 11999500000U));
    EXPECT_WITHIN(0.10, 1e-12, hand_intent(hand)->intent_rad[0]);
    EXPECT_WITHIN(-0.05, 1e-12, hand_intent(hand)->intent_rad[1]);
    EXPECT_WITHIN(0.0, 0.0, largest_jump(12000000000U, 13999500000U));
    EXPECT_WITHIN(0.0, 1e-3, largest_jump(14000000000U, 18000000000U));
    EXPECT_WITHIN(0.0, 1e-9, hand_intent(hand)->intent_rad[0]);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(inverse_kinematics_is_the_inverse_of_forward_kinematics);
    RUN_TEST(expected_torque_is_the_gradient_of_energy);
    RUN_TEST(expected_friction_acts_against_the_slide);
    RUN_TEST(press_height_gives_the_force);
    RUN_TEST(without_a_script_the_hand_rests_in_the_centre);
    RUN_TEST(the_torque_is_that_of_a_spring_and_a_damper);
    RUN_TEST(circle_ramps_holds_and_ends_where_it_began);
    RUN_TEST(move_is_smooth_and_arrives);
    RUN_TEST(press_touches_at_its_speed_then_applies_its_force);
    RUN_TEST(follow_keeps_the_force_over_the_bump);
    RUN_TEST(lifting_the_finger_ends_the_expected_force);
    RUN_TEST(pull_stretches_the_spring_and_release_ends_the_force);
    RUN_TEST(rest_ends_the_force_without_moving);
    RUN_TEST(let_go_leaves_the_stick_and_the_next_verb_takes_it);
    RUN_TEST(grip_changes_the_stiffness_and_not_the_motion);
    RUN_TEST(a_new_verb_begins_at_the_pose_of_the_old_one);
    RUN_TEST(equal_scripts_give_equal_motions);
    RUN_TEST(mission_script_is_accepted_and_stays_within_the_stops_of_the_stick);
    RUN_TEST(a_hand_without_a_scene_leads_the_stick_and_expects_nothing);
    RUN_TEST(a_hand_without_a_scene_refuses_positions_and_forces);
    RUN_TEST(a_world_without_a_hand_refuses_its_lines);
    RUN_TEST(bad_lines_are_reported_with_their_number);
    RUN_TEST(a_missing_script_is_reported);
    RUN_TEST(many_lines_play_in_the_order_of_their_times);
    RUN_TEST(an_hour_of_aims_is_taken_and_played);
    RUN_TEST(a_line_added_late_plays_between_those_of_the_scenario);
    RUN_TEST(a_refused_line_has_no_effect);
    RUN_TEST(aim_moves_the_intent_without_a_jump);
    return UNITY_END();
}
