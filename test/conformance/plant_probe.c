// SPDX-License-Identifier: Apache-2.0
// The plant in a world whose joints have no drives. A spring and a damper pull each joint towards
// centre + amplitude (1 - cos(frequency t)); the torque of each wheel is a sine.
// probe WORLD SECONDS STEP_US, and on the standard input for each joint stiffness [Nm/rad], damping
// [Nms/rad], centre [rad], amplitude [rad] and frequency [rad/s] (linear axes: N/m, Ns/m, m), then for each
// wheel amplitude [Nm] and frequency [rad/s] of its torque. Prints every 10 ms the time [s], the pose of
// each free base (position [m], rotation by rows) and the positions of all joints [rad or m].
#include "sim/plant/plant.h"
#include "sim/plant/plant_internal.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

typedef struct {
    double stiffness;
    double damping;
    double centre;
    double amplitude;
    double frequency;
} law_t;

static world_t world;
static law_t law[PLANT_JOINTS_MAX];
static double step_s;

static void drive(void* context, unsigned substep, const plant_rotor_t* motor, double* out_torque_nm)
{
    const plant_t* plant = context;
    const double time_s =
        (double)plant_truth(plant)->time_ns * 1e-9 + (substep + 0.5) * step_s / (double)PLANT_SUBSTEPS;
    for (unsigned i = 0U; i < plant_truth(plant)->joint_count; i++) {
        const double wanted = law[i].centre + law[i].amplitude * (1.0 - cos(law[i].frequency * time_s));
        out_torque_nm[i] =
            law[i].stiffness * (wanted - motor[i].position_rad) - law[i].damping * motor[i].velocity_rad_s;
    }
}

static void print(const plant_t* plant)
{
    const double ends[4][3] = {{0.0, 0.0, 0.0}, {1.0, 0.0, 0.0}, {0.0, 1.0, 0.0}, {0.0, 0.0, 1.0}};
    printf("%.9f", (double)plant_truth(plant)->time_ns * 1e-9);
    for (unsigned r = 0U; r < world.robot_count; r++) {
        double at[4][3];
        for (unsigned k = 0U; k < 4U; k++) {
            robot_point(plant, r, 0U, ends[k], at[k]);
        }
        for (unsigned i = 0U; world.robot[r].is_free && (i < 3U); i++) {
            printf(" %.17g", at[0][i]);
        }
        for (unsigned i = 0U; world.robot[r].is_free && (i < 9U); i++) {
            printf(" %.17g", at[1U + (i % 3U)][i / 3U] - at[0][i / 3U]);
        }
    }
    for (unsigned i = 0U; i < plant_truth(plant)->joint_count; i++) {
        printf(" %.17g", plant_truth(plant)->link_position_rad[i]);
    }
    printf("\n");
}

int main(int argc, char** argv)
{
    char error[DOCUMENT_ERROR_MAX] = "usage: probe WORLD SECONDS STEP_US";
    plant_t* plant                 = NULL;
    if ((argc != 4) || (world_read(argv[1], &world, error) != STATUS_OK) ||
        (plant_create(&world, &plant, error) != STATUS_OK)) {
        (void)fprintf(stderr, "%s\n", error);
        return 1;
    }
    static plant_input_t input;
    const uint64_t step_ns = strtoull(argv[3], NULL, 10) * 1000U;
    const uint64_t end_ns  = (uint64_t)(atof(argv[2]) * 1e9);
    input.drive            = drive;
    input.drive_context    = plant;
    step_s                 = (double)step_ns * 1e-9;
    for (unsigned i = 0U; i < plant_truth(plant)->joint_count; i++) {
        if (scanf("%lf %lf %lf %lf %lf", &law[i].stiffness, &law[i].damping, &law[i].centre,
                  &law[i].amplitude, &law[i].frequency) != 5) {
            (void)fprintf(stderr, "standard input: expected five numbers for joint %u\n", i);
            return 1;
        }
    }
    double wheel[WORLD_WHEELS_MAX][2];
    for (unsigned i = 0U; i < world.wheel_count; i++) {
        if (scanf("%lf %lf", &wheel[i][0], &wheel[i][1]) != 2) {
            (void)fprintf(stderr, "standard input: expected two numbers for wheel %u\n", i);
            return 1;
        }
    }
    print(plant);
    while (plant_truth(plant)->time_ns < end_ns) {
        const double middle_s = (double)plant_truth(plant)->time_ns * 1e-9 + 0.5 * step_s;
        for (unsigned i = 0U; i < world.wheel_count; i++) {
            input.wheel_torque_nm[i] = wheel[i][0] * sin(wheel[i][1] * middle_s);
        }
        plant_step(plant, &input, step_ns);
        if ((plant_truth(plant)->time_ns % 10000000U) == 0U) {
            print(plant);
        }
    }
    plant_destroy(plant);
    return 0;
}
