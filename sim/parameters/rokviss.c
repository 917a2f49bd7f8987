// SPDX-License-Identifier: Apache-2.0
// Tags: [S] from a public source, named; [A] assumed engineering value, to be replaced when a source appears.
//   S1  DLR, robotic systems, ROKVISS: arm of 0.5 m and 7 kg, two torque-controlled joints, metal finger,
//       contour.
//   S2  HIROSCO paper, section 5: one vertical and one horizontal spring, pulled by the finger; 2 kHz.
//   S3  DLR, Kontur-2: space-qualified joystick of two degrees of freedom with force feedback.
#include "sim/parameters/rokviss.h"

#define PI 3.14159265358979323846
#define DEGREE (PI / 180.0)

const plant_parameters_t rokviss_plant = {
    // Lengths and masses are [A], chosen to give the arm of S1: 0.47 m, 7 kg with the base.
    .link_length_m     = {0.22, 0.25},                    // [A]
    .link_mass_kg      = {3.0, 2.0},                      // [A]
    .link_com_m        = {0.11, 0.125},                   // [A] uniform rods
    .link_inertia_kgm2 = {0.0121, 0.010416666667},        // [A] m l^2 / 12
    .link_twist_kgm2   = {0.0024, 0.0016},                // [A] tube of 40 mm radius
    .base_mass_kg      = 2.0,                             // [A]
    .base_inertia_kgm2 = 0.01,                            // [A]
    .home_rad          = {60.0 * DEGREE, -90.0 * DEGREE}, // [A] tip at (0.327, 0.066)
    .range_rad         = 90.0 * DEGREE,                   // [A] both joints

    // Joint of the DLR light-weight class: harmonic drive with torque sensor (S1: torque-controlled).
    .gear_ratio            = 160.0,  // [A]
    .rotor_inertia_kgm2    = 0.256,  // [A] 1e-5 kgm2 x 160^2
    .gear_stiffness_nm_rad = 8000.0, // [A]
    .gear_damping_nms_rad  = 8.0,    // [A]
    .coulomb_nm            = 2.0,    // [A]
    .stiction_nm           = 2.4,    // [A]
    .stribeck_rad_s        = 0.02,   // [A]
    .viscous_nms_rad       = 1.0,    // [A]
    .brake_torque_nm       = 100.0,  // [A] 0.6 Nm at the motor; twice the drive's limit
    .joint_stop_nm_rad     = 2.0e4,  // [A]
    .joint_stop_nms_rad    = 200.0,  // [A]
    .gravity_m_s2          = 9.81,   // laboratory model of the paper

    // Contour on the platform (S1); its shape is [A].
    .tip_radius_m          = 0.012,  // [A]
    .contour_top_m         = -0.042, // [A]
    .contour_start_m       = 0.20,   // [A]
    .contour_end_m         = 0.45,   // [A]
    .bump_x_m              = 0.325,  // [A]
    .bump_height_m         = 0.007,  // [A]
    .bump_radius_m         = 0.10,   // [A]
    .contour_stiffness_n_m = 5000.0, // [A] includes the finger's bending
    .contour_damping_ns_m  = 100.0,  // [A]
    .contour_friction      = 0.3,    // [A]

    // Vertical spring (S2).
    .hook_m               = {0.327, 0.155}, // [A]
    .hook_catch_m         = 0.02,           // [A]
    .cable_m              = 0.15,           // [A]
    .spring_stiffness_n_m = 500.0,          // [A]
    .spring_preload_n     = 5.0,            // [A]
    .spring_preload_m     = 0.002,          // [A]
    .spring_limit_n       = 60.0,           // [A]

    // Joystick (S3: two axes with force feedback).
    .stick_inertia_kgm2     = 2.0e-3,        // [A]
    .stick_friction_nms_rad = 0.01,          // [A]
    .stick_range_rad        = 20.0 * DEGREE, // [A]
    .stick_stop_nm_rad      = 200.0,         // [A]
    .stick_stop_nms_rad     = 0.5,           // [A]
};

const hand_parameters_t rokviss_hand = {
    .grip_stiffness_nm_rad = 3.0,    // [A] arm at rest on the stick, firm grip
    .grip_damping_nms_rad  = 0.1,    // [A]
    .position_scale        = 2.0,    // [A] mission setting
    .force_scale           = 0.03,   // [A] mission setting
    .arm_stiffness_nm_rad  = 2667.0, // [A] 4000 Nm/rad control in series with the gear
};

const torque_sensor_parameters_t rokviss_torque_sensor = {
    .noise_rms_nm   = 0.02,   // [A]
    .offset_max_nm  = 0.2,    // [A]
    .drift_max_nm_s = 2.0e-4, // [A]
    .range_nm       = 60.0,   // [A]
};

const encoder_parameters_t rokviss_joint_encoder = {.counts_per_turn = 65536U, .gear_ratio = 160.0}; // [A]
const encoder_parameters_t rokviss_stick_encoder = {.counts_per_turn = 65536U, .gear_ratio = 1.0};   // [A]
