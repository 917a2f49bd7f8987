// SPDX-License-Identifier: Apache-2.0
#include "sim/operator/hand.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define ARGUMENTS_MAX 5U
#define PI 3.14159265358979323846

#define PRESS_S 1.0       ///< Time from the first contact to the full force.
#define CLEARANCE_M 0.010 ///< Distance below the hook at which the finger stops after `release`.
#define SLEW_GRIP_S 0.3   ///< Time in which `grip` rises from 0 to 1.
#define SLEW_EXPECT_S 0.5 ///< Time in which `expectation` rises from 0 to 1, or falls to 0.
#define SLEW_SLIDE_S 0.5  ///< Time in which `slide` changes by 1.
#define SLIDING_M_S 0.001 ///< Below this speed `slide` keeps its value.

typedef struct {
    const char* name;
    double low;
    double high;
} argument_t;

typedef struct verb verb_t;

typedef struct {
    uint64_t time_ns;
    const verb_t* verb;
    double argument[ARGUMENTS_MAX];
} command_t;

/// A verb of the script. `begin` is called once when a command begins; `play` moves the wanted pose in each
/// step until the next command.
struct verb {
    const char* name;
    const char* usage;
    size_t count;
    argument_t argument[ARGUMENTS_MAX];
    void (*begin)(hand_t* hand, const command_t* command);                  ///< May be null.
    void (*play)(hand_t* hand, const command_t* command, double elapsed_s); ///< Null: no motion.
};

struct hand {
    hand_parameters_t parameters; // The verb `grip` changes stiffness and damping.
    bool knows_scene;
    scene_t scene; // All zero if the hand knows none.
    plane_t home;
    scenario_lines_t commands; // Entries: command_t.
    command_t current;         // Before the first command the verb is null.
    uint64_t time_ns;
    bool aiming;                 // The intent is stick_rad: from `aim` until the next motion.
    double stick_rad[HAND_AXES]; // Rest point of the stick in `aim`.
    double from_stick_rad[HAND_AXES];
    plane_t tip;                         // Wanted position of the tip.
    double joint_rad[SCENE_JOINTS];      // Wanted joint angles.
    plane_t from;                        // Value of `tip` when the current command began.
    double from_joint_rad[SCENE_JOINTS]; // Value of `joint_rad` when the current command began.
    double force_n;                      // Force of `press` and `follow`.
    bool gripping;                       // The hand holds the stick.
    bool expecting;                      // The hand compensates the torque that it expects.
    bool pulling;                        // The hand expects the force of the spring.
    double grip;                         // 0..1, follows `gripping` in SLEW_GRIP_S.
    double expectation;                  // 0..1, follows `expecting` in SLEW_EXPECT_S.
    double slide;                        // -1..1, follows the direction of sliding in SLEW_SLIDE_S.
    hand_intent_t intent;
};

// ---- Motions ----

/// Minimum-jerk profile from 0 to 1; `share` is the elapsed share of the duration, limited to 0..1.
static double minimum_jerk(const double share)
{
    const double s = fmax(0.0, fmin(1.0, share));
    return s * s * s * (10.0 - s * (15.0 - 6.0 * s));
}

static void want_tip(hand_t* const hand, const plane_t tip)
{
    hand->tip = tip;
    scene_joints(&hand->scene, tip, hand->joint_rad);
}

static void go_towards(hand_t* const hand, const plane_t target, const double share)
{
    const double s = minimum_jerk(share);
    want_tip(hand, (plane_t){hand->from.x + s * (target.x - hand->from.x),
                             hand->from.z + s * (target.z - hand->from.z)});
}

static void begin_rest(hand_t* const hand, const command_t* const command)
{
    (void)command;
    hand->expecting = false;
}

static void begin_let_go(hand_t* const hand, const command_t* const command)
{
    (void)command;
    hand->gripping = false;
}

static void play_circle(hand_t* const hand, const command_t* const command, const double elapsed_s)
{
    const double ramp_s = command->argument[2];
    const double down_s = elapsed_s - ramp_s - command->argument[3];
    const double up     = minimum_jerk(elapsed_s / ramp_s);
    const double down   = minimum_jerk(down_s / command->argument[4]);
    const double radius = command->argument[0] * (up - down);
    const double phase  = 2.0 * PI * command->argument[1] * elapsed_s;
    hand->joint_rad[0]  = hand->from_joint_rad[0] + radius * sin(phase);
    hand->joint_rad[1]  = hand->from_joint_rad[1] + radius * cos(phase);
    hand->tip           = scene_tip(&hand->scene, hand->joint_rad);
}

static void play_move(hand_t* const hand, const command_t* const command, const double elapsed_s)
{
    go_towards(hand, (plane_t){command->argument[0], command->argument[1]}, elapsed_s / command->argument[2]);
}

static void begin_press(hand_t* const hand, const command_t* const command)
{
    hand->force_n = command->argument[0];
}

static void play_press(hand_t* const hand, const command_t* const command, const double elapsed_s)
{
    const double x      = hand->from.x;
    const double touch  = scene_press_height(&hand->scene, x, 0.0);
    const double down_s = fmax(0.0, hand->from.z - touch) / command->argument[1];
    const double top    = fmin(hand->from.z, touch);
    if (elapsed_s < down_s) {
        want_tip(hand, (plane_t){x, hand->from.z - command->argument[1] * elapsed_s});
    } else {
        const double s = minimum_jerk((elapsed_s - down_s) / PRESS_S);
        want_tip(hand, (plane_t){x, top + s * (scene_press_height(&hand->scene, x, hand->force_n) - top)});
    }
}

static void play_follow(hand_t* const hand, const command_t* const command, const double elapsed_s)
{
    const double s = minimum_jerk(elapsed_s / command->argument[1]);
    const double x = hand->from.x + s * (command->argument[0] - hand->from.x);
    want_tip(hand, (plane_t){x, scene_press_height(&hand->scene, x, hand->force_n)});
}

static void begin_pull(hand_t* const hand, const command_t* const command)
{
    (void)command;
    hand->pulling = true;
}

static void play_pull(hand_t* const hand, const command_t* const command, const double elapsed_s)
{
    const plane_t target = {hand->from.x, hand->scene.hook_m[1] + command->argument[0]};
    go_towards(hand, target, elapsed_s / command->argument[1]);
}

static void play_release(hand_t* const hand, const command_t* const command, const double elapsed_s)
{
    go_towards(hand, (plane_t){hand->from.x, hand->scene.hook_m[1] - CLEARANCE_M},
               elapsed_s / command->argument[0]);
    hand->pulling = hand->pulling && (elapsed_s < command->argument[0]);
}

static void play_home(hand_t* const hand, const command_t* const command, const double elapsed_s)
{
    go_towards(hand, hand->home, elapsed_s / command->argument[0]);
}

/// Begin `aim`. The person at the stick reacts to the robot, so the hand expects no force. The expected
/// force of later motions rises slowly from zero, so that the intent does not jump.
static void begin_aim(hand_t* const hand, const command_t* const command)
{
    (void)command;
    hand->aiming      = true;
    hand->pulling     = false;
    hand->expecting   = false;
    hand->expectation = 0.0;
}

static void play_aim(hand_t* const hand, const command_t* const command, const double elapsed_s)
{
    const double share = fmin(1.0, elapsed_s / command->argument[HAND_AXES]);
    for (unsigned i = 0U; i < HAND_AXES; i++) {
        hand->stick_rad[i] =
            hand->from_stick_rad[i] + share * (command->argument[i] - hand->from_stick_rad[i]);
        hand->joint_rad[i] = hand->scene.home_rad[i] + hand->parameters.position_scale * hand->stick_rad[i];
    }
    hand->tip = scene_tip(&hand->scene, hand->joint_rad);
}

static void begin_grip(hand_t* const hand, const command_t* const command)
{
    hand->parameters.grip_stiffness_nm_rad = command->argument[0];
    hand->parameters.grip_damping_nms_rad  = command->argument[1];
}

#define DURATION                                                                                             \
    {                                                                                                        \
        "duration [s]", 0.05, 600.0                                                                          \
    }

static const verb_t verbs[] = {
    {"rest", "rest", 0U, {{0}}, begin_rest, NULL},
    {"grip",
     "grip <stiffness> <damping>",
     2U,
     {{"stiffness [Nm/rad]", 0.1, 50.0}, {"damping [Nms/rad]", 0.0, 5.0}},
     begin_grip,
     NULL},
    {"circle",
     "circle <amplitude> <frequency> <ramp> <hold> <down>",
     5U,
     {{"amplitude [rad]", 0.0, 0.6},
      {"frequency [Hz]", 0.01, 5.0},
      DURATION,
      {"hold [s]", 0.0, 600.0},
      DURATION},
     NULL,
     play_circle},
    {"move",
     "move <x> <z> <duration>",
     3U,
     {{"x [m]", -1.0, 1.0}, {"z [m]", -1.0, 1.0}, DURATION},
     NULL,
     play_move},
    {"press",
     "press <force> <speed>",
     2U,
     {{"force [N]", 0.0, 60.0}, {"speed [m/s]", 0.001, 0.2}},
     begin_press,
     play_press},
    {"follow", "follow <x> <duration>", 2U, {{"x [m]", -1.0, 1.0}, DURATION}, NULL, play_follow},
    {"hold", "hold", 0U, {{0}}, NULL, NULL},
    {"pull",
     "pull <distance> <duration>",
     2U,
     {{"distance [m]", 0.0, 0.15}, DURATION},
     begin_pull,
     play_pull},
    {"release", "release <duration>", 1U, {DURATION}, NULL, play_release},
    {"home", "home <duration>", 1U, {DURATION}, NULL, play_home},
    {"let_go", "let_go", 0U, {{0}}, begin_let_go, NULL},
    {"aim",
     "aim <stick 1> <stick 2> <duration>",
     3U,
     {{"stick angle [rad]", -0.6, 0.6}, {"stick angle [rad]", -0.6, 0.6}, {"duration [s]", 0.0005, 10.0}},
     begin_aim,
     play_aim},
};

#define VERB_COUNT (sizeof verbs / sizeof verbs[0])

// ---- Script ----

static const verb_t* find_verb(const char* const name)
{
    for (size_t i = 0U; i < VERB_COUNT; i++) {
        if (strcmp(verbs[i].name, name) == 0) {
            return &verbs[i];
        }
    }
    return NULL;
}

/// True for verbs whose arguments are positions or forces in the scene.
static bool needs_scene(const verb_t* const verb)
{
    return (verb->play != NULL) && (verb->play != play_circle) && (verb->play != play_aim);
}

/// Check that the target of a command is within reach, when the script is read and not during the flight.
static status_t check_reach(const hand_t* const hand, const scenario_line_t* const line,
                            const command_t* const command, char error[SCENARIO_ERROR_MAX])
{
    plane_t target = {command->argument[0], command->argument[1]};
    if (command->verb->play == play_follow) {
        target.z = scene_press_height(&hand->scene, target.x, 0.0);
    } else if (command->verb->play == play_pull) {
        target = (plane_t){hand->scene.hook_m[0], hand->scene.hook_m[1] + command->argument[0]};
    } else if (command->verb->play != play_move) {
        return STATUS_OK;
    }
    return scene_reachable(&hand->scene, target)
               ? STATUS_OK
               : scenario_error(line, line->word[1], "a target within reach of the arm", error);
}

status_t hand_add(hand_t* const hand, const scenario_line_t* const line, char error[SCENARIO_ERROR_MAX])
{
    const verb_t* const verb = find_verb(line->word[0]);
    if (verb == NULL) {
        return scenario_error(
            line, line->word[0],
            "rest, grip, circle, move, press, follow, hold, pull, release, home, let_go or aim", error);
    }
    if (needs_scene(verb) && !hand->knows_scene) {
        return scenario_error(
            line, line->word[0],
            "rest, grip, circle, hold, let_go or aim: the Hand of this world knows no scene", error);
    }
    command_t command = {.time_ns = line->time_ns, .verb = verb};
    status_t status   = scenario_arguments(line, verb->count, verb->usage, error);
    for (size_t i = 0U; (i < verb->count) && (status == STATUS_OK); i++) {
        const argument_t* argument = &verb->argument[i];
        status = scenario_number(line, i + 1U, argument->name, argument->low, argument->high,
                                 &command.argument[i], error);
    }
    status = (status == STATUS_OK) ? check_reach(hand, line, &command, error) : status;
    status = (status == STATUS_OK) ? scenario_insert(&hand->commands, &command, sizeof command) : status;
    if (status == STATUS_EXHAUSTED) {
        (void)scenario_error(line, line->word[0], "memory for one more line of the hand", error);
    }
    return status;
}

static status_t take_line(void* const context, const scenario_line_t* const line,
                          char error[SCENARIO_ERROR_MAX])
{
    return hand_add(context, line, error);
}

hand_parameters_t hand_parameters_of(const world_hand_t* const hand)
{
    if (!hand->knows_scene) { // The joints are then the axes of the stick.
        return (hand_parameters_t){.grip_stiffness_nm_rad = hand->stiffness,
                                   .grip_damping_nms_rad  = hand->damping,
                                   .position_scale        = 1.0,
                                   .arm_stiffness_nm_rad  = 1.0};
    }
    return (hand_parameters_t){.grip_stiffness_nm_rad = hand->stiffness,
                               .grip_damping_nms_rad  = hand->damping,
                               .position_scale        = hand->position_scale,
                               .force_scale           = hand->force_scale,
                               .arm_stiffness_nm_rad  = hand->joint_stiffness};
}

static void update_intent(hand_t* hand);

status_t hand_load(const hand_parameters_t* const parameters, const scene_t* const scene,
                   const char* const path, hand_t** const out_hand, char error[SCENARIO_ERROR_MAX])
{
    *out_hand    = NULL;
    error[0]     = '\0';
    hand_t* hand = calloc(1U, sizeof *hand);
    if (hand == NULL) {
        (void)snprintf(error, SCENARIO_ERROR_MAX, "no memory for the hand");
        return STATUS_EXHAUSTED;
    }
    hand->parameters  = *parameters;
    hand->gripping    = true;
    hand->grip        = 1.0;
    hand->intent.verb = verbs[0].name;
    if (scene != NULL) {
        hand->knows_scene = true;
        hand->scene       = *scene;
        hand->home        = scene_tip(scene, scene->home_rad);
        want_tip(hand, hand->home);
    }
    update_intent(hand);

    const status_t status = (path != NULL) ? scenario_read(path, "hand", take_line, hand, error) : STATUS_OK;
    if (status != STATUS_OK) {
        hand_destroy(hand);
        return status;
    }
    *out_hand = hand;
    return STATUS_OK;
}

static status_t refuse_line(void* const context, const scenario_line_t* const line,
                            char error[SCENARIO_ERROR_MAX])
{
    (void)context;
    return scenario_error(line, "hand", "fault, operator or ground: this world has no Hand", error);
}

status_t hand_check_no_lines(const char* const path, char error[SCENARIO_ERROR_MAX])
{
    return (path != NULL) ? scenario_read(path, "hand", refuse_line, NULL, error) : STATUS_OK;
}

void hand_destroy(hand_t* const hand)
{
    if (hand != NULL) {
        free(hand->commands.record);
        free(hand);
    }
}

// ---- Playing ----

/// Move `value` towards `target` at a rate of 1 per `unit_s`.
static double slew(const double value, const double target, const double unit_s, const double dt_s)
{
    const double most = dt_s / unit_s;
    return value + fmax(-most, fmin(most, target - value));
}

static void begin_command(hand_t* const hand, const command_t* const command)
{
    if (command->verb->begin == begin_grip) {
        begin_grip(hand, command); // The current command continues.
        return;
    }
    // After a rest the hand no longer expects the spring.
    hand->pulling = hand->pulling && hand->expecting;
    hand->current = *command;
    memcpy(hand->from_stick_rad, hand->intent.intent_rad, sizeof hand->from_stick_rad);
    hand->aiming            = hand->aiming && (command->verb->play == NULL);
    hand->from              = hand->tip;
    hand->from_joint_rad[0] = hand->joint_rad[0];
    hand->from_joint_rad[1] = hand->joint_rad[1];
    hand->gripping          = true;
    hand->expecting         = true;
    hand->intent.verb       = command->verb->name;
    if (command->verb->begin != NULL) {
        command->verb->begin(hand, command);
    }
}

/// Joint torques that the hand expects from contour and spring at the wanted pose.
static void update_expected(hand_t* const hand, double out_torque_nm[SCENE_JOINTS])
{
    double contact[SCENE_JOINTS] = {0.0, 0.0};
    double spring[SCENE_JOINTS]  = {0.0, 0.0};
    if (hand->knows_scene) {
        scene_contact_torque(&hand->scene, hand->tip, hand->slide, contact);
    }
    if (hand->pulling) {
        scene_spring_torque(&hand->scene, hand->tip, spring);
    }
    for (unsigned i = 0U; i < SCENE_JOINTS; i++) {
        out_torque_nm[i] = hand->expectation * (contact[i] + spring[i]);
    }
}

static void update_intent(hand_t* const hand)
{
    const hand_parameters_t* parameters = &hand->parameters;
    hand_intent_t* intent               = &hand->intent;

    update_expected(hand, intent->expected_torque_nm);
    for (unsigned i = 0U; i < HAND_AXES; i++) {
        // The load deflects the arm; force_scale times the load acts on the stick.
        const double load       = intent->expected_torque_nm[i];
        const double joint      = hand->joint_rad[i] - load / parameters->arm_stiffness_nm_rad;
        const double stick      = (joint - hand->scene.home_rad[i]) / parameters->position_scale;
        const double deflection = parameters->force_scale * load / parameters->grip_stiffness_nm_rad;

        intent->wanted_joint_rad[i] = hand->joint_rad[i];
        intent->intent_rad[i]       = hand->aiming ? hand->stick_rad[i] : (stick - deflection);
    }
    intent->wanted_tip_m[0] = hand->tip.x;
    intent->wanted_tip_m[1] = hand->tip.z;
    intent->grip            = hand->grip;
}

/// Target of `slide`: the sign of the finger's speed while it slides on the contour, the present value of
/// `slide` below SLIDING_M_S, 0 without contact.
static double slide_target(const hand_t* const hand, const double speed_m_s)
{
    if (!hand->knows_scene || !scene_touching(&hand->scene, hand->tip)) {
        return 0.0;
    }
    return (fabs(speed_m_s) < SLIDING_M_S) ? hand->slide : ((speed_m_s > 0.0) ? 1.0 : -1.0);
}

void hand_step(hand_t* const hand, const uint64_t time_ns)
{
    const double dt_s    = (double)(time_ns - hand->time_ns) * 1.0e-9;
    const plane_t before = hand->tip;
    hand->time_ns        = time_ns;

    const command_t* const commands = hand->commands.record;
    while ((hand->commands.next < hand->commands.count) &&
           (commands[hand->commands.next].time_ns <= time_ns)) {
        begin_command(hand, &commands[hand->commands.next]);
        hand->commands.next++;
    }
    if ((hand->current.verb != NULL) && (hand->current.verb->play != NULL)) {
        const double elapsed_s = (double)(time_ns - hand->current.time_ns) * 1.0e-9;
        hand->current.verb->play(hand, &hand->current, elapsed_s);
    }
    if (dt_s > 0.0) {
        hand->slide =
            slew(hand->slide, slide_target(hand, (hand->tip.x - before.x) / dt_s), SLEW_SLIDE_S, dt_s);
        hand->grip        = slew(hand->grip, hand->gripping ? 1.0 : 0.0, SLEW_GRIP_S, dt_s);
        hand->expectation = slew(hand->expectation, hand->expecting ? 1.0 : 0.0, SLEW_EXPECT_S, dt_s);
    }
    if (!hand->gripping) {
        hand->grip = 0.0; // The hand lets go at once.
    }
    update_intent(hand);
}

void hand_torque(const hand_t* const hand, const double stick_position_rad[HAND_AXES],
                 const double stick_velocity_rad_s[HAND_AXES], double out_torque_nm[HAND_AXES])
{
    const hand_parameters_t* parameters = &hand->parameters;
    for (unsigned i = 0U; i < HAND_AXES; i++) {
        const double pull =
            parameters->grip_stiffness_nm_rad * (hand->intent.intent_rad[i] - stick_position_rad[i]);
        out_torque_nm[i] = hand->grip * (pull - parameters->grip_damping_nms_rad * stick_velocity_rad_s[i]);
    }
}

void hand_act(void* const context, const unsigned substep, const double* const stick_position_rad,
              const double* const stick_velocity_rad_s, double* const out_torque_nm)
{
    (void)substep;
    hand_torque(context, stick_position_rad, stick_velocity_rad_s, out_torque_nm);
}

const hand_intent_t* hand_intent(const hand_t* const hand)
{
    return &hand->intent;
}
