// SPDX-License-Identifier: Apache-2.0
// Contacts between shapes of links and fixtures: balance of forces, friction, yielding along the surface.
#include "sim/plant/plant.h"
#include "sim/plant/plant_internal.h"
#include "test/support/bounds.h"
#include "test/unit/sim/fixtures/temporary_file.h"
#include "test/unit/sim/plant/plant_state.h"
#include "unity.h"

#include <math.h>
#include <stdio.h>

#define STEP_NS 500000U
#define MASS 2.0
#define STIFFNESS 5000.0

#define BODY(shape)                                                                                          \
    "<robot name=\"b\"><link name=\"body\"><inertial><mass value=\"2\"/><inertia ixx=\"0.01\" ixy=\"0\" "    \
    "ixz=\"0\" iyy=\"0.01\" iyz=\"0\" izz=\"0.01\"/></inertial><collision><geometry>" shape                  \
    "</geometry></collision></link></robot>"
#define FREE(name, file, state)                                                                              \
    "<Robot name=\"" name "\" urdf=\"" file "\" base=\"free\"><State " state "/></Robot>\n"
#define FLOOR "<Fixture name=\"floor\" at=\"0 0 -0.5\"><Box size=\"4 4 1\" at=\"0 0 0\"/></Fixture>\n"
#define TOUCH(a, b, more)                                                                                    \
    "<Contact a=\"" a "\" b=\"" b "\" stiffness=\"5000\" damping=\"100\" friction=\"0.3\"" more "/>\n"
#define IN_WORLD(gravity, text)                                                                              \
    "<World name=\"w\" step=\"500us\" gravity=\"" gravity "\">\n" text "</World>\n"

static world_t world;
static plant_t* plant;
static plant_input_t idle;

void setUp(void)
{
    (void)temporary_file("ball.urdf", BODY("<sphere radius=\"0.1\"/>"));
    (void)temporary_file("box.urdf", BODY("<box size=\"0.2 0.3 0.2\"/>"));
    (void)temporary_file("plate.urdf", BODY("<box size=\"0.3 0.4 0.02\"/>"));
    (void)temporary_file("can.urdf", BODY("<cylinder radius=\"0.1\" length=\"0.2\"/>"));
}

void tearDown(void)
{
    plant_destroy(plant);
    plant = NULL;
    temporary_files_remove();
}

static void begin(const char* text)
{
    char error[DOCUMENT_ERROR_MAX];
    plant_destroy(plant);
    plant = NULL;
    TEST_ASSERT_EQUAL_INT_MESSAGE(STATUS_OK, world_read(temporary_file("w.xml", text), &world, error), error);
    TEST_ASSERT_EQUAL_INT_MESSAGE(STATUS_OK, plant_create(&world, &plant, error), error);
}

static void run(double seconds)
{
    for (unsigned i = 0U; i < (unsigned)lround(seconds * 2000.0); i++) {
        plant_step(plant, &idle, STEP_NS);
    }
}

/// Let a body of 0.1 m half height come to rest on a surface at the height 0.
static void expect_rest(const char* text)
{
    begin(text);
    run(3.0);
    const plant_contact_t* contact = &plant_truth(plant)->contact[0];
    TEST_ASSERT_TRUE(contact->is_touching);
    EXPECT_WITHIN(MASS * 9.81, 1e-3, contact->force_n[2]);
    EXPECT_WITHIN(0.0, 1e-3, contact->force_n[0]);
    EXPECT_WITHIN(MASS * 9.81 / STIFFNESS, 1e-5, 0.1 - contact->place_m[2]);
    EXPECT_WITHIN(contact->place_m[0], 1e-3, contact->point_m[0]);
}

static void every_shape_rests_on_the_floor_at_the_same_depth(void)
{
    expect_rest(IN_WORLD("0 0 -9.81",
                         FREE("b", "ball.urdf", "at=\"0.2 0.3 0.1\"") FLOOR TOUCH("b.body", "floor", "")));
    expect_rest(IN_WORLD("0 0 -9.81",
                         FREE("b", "box.urdf", "at=\"0.2 0.3 0.1\"") FLOOR TOUCH("b.body", "floor", "")));
    expect_rest(IN_WORLD("0 0 -9.81",
                         FREE("b", "can.urdf", "at=\"0.2 0.3 0.1\"") FLOOR TOUCH("b.body", "floor", "")));
    // The cylinder on its side, its axis along y.
    expect_rest(IN_WORLD("0 0 -9.81",
                         FREE("b", "can.urdf", "at=\"0.2 0.3 0.1\" rpy=\"1.5707963267948966 0 0\"")
                             FLOOR TOUCH("b.body", "floor", "")));
}

static void a_ball_rests_on_the_end_of_a_cylinder_and_on_a_ball(void)
{
    expect_rest(IN_WORLD(
        "0 0 -9.81", FREE("b", "ball.urdf",
                          "at=\"0.05 0.02 0.1\"") "<Fixture name=\"post\" at=\"0 0 -1\"><Cylinder "
                                                  "radius=\"0.2\" length=\"2\" "
                                                  "at=\"0 0 0\"/></Fixture>\n" TOUCH("b.body", "post", "")));
    expect_rest(IN_WORLD(
        "0 0 -9.81",
        FREE("b", "ball.urdf",
             "at=\"0 0 0.1\"") "<Fixture name=\"dome\" at=\"0 0 -1\"><Sphere radius=\"1\" at=\"0 0 0\"/>"
                               "</Fixture>\n" TOUCH("b.body", "dome", "")));
}

static void momentum_is_conserved_when_bodies_collide(void)
{
    begin(IN_WORLD("0 0 0", FREE("a", "ball.urdf", "at=\"-0.3 0.02 0\" velocity=\"0.5 0 0\"")
                                FREE("b", "box.urdf", "at=\"0 0 0\" rpy=\"0.1 0.2 0.3\" rate=\"0 0.1 0\"")
                                    TOUCH("a.body", "b.body", " shear=\"4000\" shearDamping=\"80\"")));
    double p0[3];
    double l0[3];
    double p[3];
    double l[3];
    double most_n = 0.0;
    plant_momentum(plant, p0, l0);
    for (unsigned i = 0U; i < 4000U; i++) {
        plant_step(plant, &idle, STEP_NS);
        most_n = fmax(most_n, -plant_truth(plant)->contact[0].force_n[0]);
    }
    plant_momentum(plant, p, l);
    EXPECT_ABOVE(10.0, most_n); // The ball hits the other body and gives it a part of its motion.
    EXPECT_ABOVE(0.1, dBodyGetLinearVel(plant->robot[1].body[0])[0]);
    for (unsigned i = 0U; i < 3U; i++) {
        EXPECT_WITHIN(p0[i], 1e-12, p[i]);
        EXPECT_WITHIN(l0[i], 1e-4, l[i]);
    }
}

static void the_reported_force_acts_on_side_a_whichever_side_moves(void)
{
    (void)temporary_file(
        "table.urdf",
        "<robot name=\"p\"><link name=\"plate\"><collision><geometry><box size=\"4 4 1\"/></geometry>"
        "</collision></link></robot>");
    begin(IN_WORLD(
        "0 0 -9.81",
        "<Robot name=\"p\" urdf=\"table.urdf\" base=\"fixed\"><State at=\"0 0 -0.5\"/></Robot>\n" FREE(
            "b", "ball.urdf", "at=\"0 0 0.1\"") TOUCH("p.plate", "b.body", "")));
    run(3.0);
    EXPECT_WITHIN(-MASS * 9.81, 1e-3, plant_truth(plant)->contact[0].force_n[2]);
    EXPECT_WITHIN(-MASS * 9.81 / STIFFNESS, 1e-6, plant_truth(plant)->contact[0].point_m[2]);
}

// ---- Along the surface ----

/// Returns how far a plate on the floor has moved along an axis after 1 s [m], under a gravity [m/s^2] with a
/// component along that axis.
static double slip_under(const char* gravity, const char* more, unsigned axis)
{
    char text[1500];
    (void)snprintf(
        text, sizeof text,
        "<World name=\"w\" step=\"500us\" gravity=\"%s\">\n" FREE("b", "plate.urdf", "at=\"0 0 0.006\"") FLOOR
        "<Contact a=\"b.body\" b=\"floor\" stiffness=\"5000\" damping=\"100\" "
        "friction=\"0.3\"%s/>\n</World>\n",
        gravity, more);
    begin(text);
    run(1.0);
    return plant_truth(plant)->contact[0].place_m[axis];
}

static void friction_holds_in_its_cone_and_slides_beyond(void)
{
    EXPECT_WITHIN(0.0, 1e-4, slip_under("2.8 0 -9.81", "", 0U));
    EXPECT_WITHIN(0.0, 1e-4, slip_under("0 2.8 -9.81", "", 1U));
    EXPECT_WITHIN(0.5 * (4.0 - 0.3 * 9.81), 0.01, slip_under("4 0 -9.81", "", 0U));
    EXPECT_WITHIN(0.5 * (4.0 - 0.3 * 9.81), 0.01, slip_under("0 4 -9.81", "", 1U));
}

static void a_contact_yields_along_the_surface_in_every_direction(void)
{
    const char* shear = " shear=\"1000\" shearDamping=\"50\"";
    EXPECT_WITHIN(MASS * 2.0 / 1000.0, 2e-4, slip_under("2 0 -9.81", shear, 0U));
    EXPECT_WITHIN(MASS * 2.0 / 1000.0, 2e-4, slip_under("0 2 -9.81", shear, 1U));
    EXPECT_ABOVE(0.5, slip_under("4 0 -9.81", shear, 0U));
    EXPECT_WITHIN(-0.3 * MASS * 9.81, 0.05, plant_truth(plant)->contact[0].force_n[0]);
    EXPECT_ABOVE(0.5, slip_under("0 4 -9.81", shear, 1U));
    EXPECT_WITHIN(-0.3 * MASS * 9.81, 0.05, plant_truth(plant)->contact[0].force_n[1]);
}

/// Put a ball on a cylinder along z, at an angle [rad] from x. The gravity [m/s^2] presses it on the
/// cylinder, pulls it along the axis by 0.5, and around the axis by `around`.
static void begin_on_post(double angle, double around)
{
    const double c = cos(angle);
    const double s = sin(angle);
    char text[1500];
    (void)snprintf(
        text, sizeof text,
        "<World name=\"w\" step=\"500us\" gravity=\"%.17g %.17g -0.5\">\n" FREE(
            "b", "ball.urdf", "at=\"%.17g %.17g 0\"") "<Fixture name=\"post\" at=\"0 0 0\"><Cylinder "
                                                      "radius=\"0.5\" length=\"4\" at=\"0 0 0\"/></Fixture>\n"
                                                      "<Contact a=\"b.body\" b=\"post\" stiffness=\"5000\" "
                                                      "damping=\"100\" friction=\"0.3\" shear=\"1000\" "
                                                      "shearDamping=\"50\"/>\n</World>\n",
        -9.81 * c - around * s, -9.81 * s + around * c, 0.597 * c, 0.597 * s);
    begin(text);
}

/// A ball on a cylinder along z yields along the surface. From 64 degrees on, where the normal is nearly y,
/// the simulator uses other directions along the surface (contacts.c); the ball must yield as far with both.
static void a_contact_yields_as_far_on_a_steep_surface(void)
{
    const double angles[] = {1.0, 1.15};
    double sink[2];
    for (unsigned i = 0U; i < 2U; i++) {
        begin_on_post(angles[i], 0.0);
        run(0.2);
        sink[i] = plant_truth(plant)->contact[0].place_m[2];
        TEST_ASSERT_EQUAL_UINT(i, plant->contacts.pair[0].is_steep ? 1U : 0U);
    }
    EXPECT_ABOVE(1e-5, -sink[0]);
    EXPECT_WITHIN(sink[0], 1e-6, sink[1]);
}

/// The second ball passes the angle at which the directions change. Its stretch is turned into the new
/// directions, so it moves as the first ball, which does not pass the angle.
static void a_ball_moves_as_far_if_the_directions_along_the_surface_change_under_way(void)
{
    const double angles[] = {0.9, 1.09};
    double sink[2];
    double way[2];
    for (unsigned i = 0U; i < 2U; i++) {
        begin_on_post(angles[i], 2.0);
        run(0.1);
        TEST_ASSERT_FALSE(plant->contacts.pair[0].is_steep);
        run(0.2);
        TEST_ASSERT_EQUAL_UINT(i, plant->contacts.pair[0].is_steep ? 1U : 0U);
        const double* place = plant_truth(plant)->contact[0].place_m;
        sink[i]             = place[2];
        way[i]              = atan2(place[1], place[0]) - angles[i];
    }
    EXPECT_ABOVE(1e-3, -sink[0]);
    EXPECT_ABOVE(1e-2, way[0]);
    EXPECT_WITHIN(sink[0], 1e-6, sink[1]);
    EXPECT_WITHIN(way[0], 1e-6, way[1]);
}

/// A cylinder that lies on another touches it along a line, but ODE finds only one point of the line.
static void two_cylinders_are_refused(void)
{
    char error[DOCUMENT_ERROR_MAX];
    const char* path = temporary_file("w.xml", IN_WORLD("0 0 -9.81", FREE("a", "can.urdf", "at=\"0 0 0\"")
                                                                         FREE("b", "can.urdf", "at=\"0 0 1\"")
                                                                             TOUCH("a.body", "b.body", "")));
    plant_destroy(plant);
    plant = NULL;
    TEST_ASSERT_EQUAL_INT_MESSAGE(STATUS_OK, world_read(path, &world, error), error);
    TEST_ASSERT_EQUAL_INT(STATUS_INVALID, plant_create(&world, &plant, error));
    TEST_ASSERT_NOT_NULL_MESSAGE(strstr(error, "w.xml:4: found 'two cylinders', expected a box or a sphere"),
                                 error);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(every_shape_rests_on_the_floor_at_the_same_depth);
    RUN_TEST(a_ball_rests_on_the_end_of_a_cylinder_and_on_a_ball);
    RUN_TEST(momentum_is_conserved_when_bodies_collide);
    RUN_TEST(the_reported_force_acts_on_side_a_whichever_side_moves);
    RUN_TEST(friction_holds_in_its_cone_and_slides_beyond);
    RUN_TEST(a_contact_yields_along_the_surface_in_every_direction);
    RUN_TEST(a_contact_yields_as_far_on_a_steep_surface);
    RUN_TEST(a_ball_moves_as_far_if_the_directions_along_the_surface_change_under_way);
    RUN_TEST(two_cylinders_are_refused);
    return UNITY_END();
}
