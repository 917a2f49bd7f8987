// SPDX-License-Identifier: Apache-2.0
/// Joint drive (joint-drive.eds): CiA 402 with CSP, CSV, CST and homing, an 8 kHz regulator, a holding brake,
/// a torque sensor after the gear and an encoder on the motor.
///
/// Callbacks of the node process messages of the bus. The caller calls drive_regulate in every rotor substep
/// and drive_end_step after each plant step. Sensor errors and quantisation are those of sim/plant/sensor.h.
///
/// Ownership  drive_create allocates, drive_destroy frees.
/// Time       About 20 ns per substep.
#ifndef SIM_DEVICES_DRIVE_H
#define SIM_DEVICES_DRIVE_H

#include "base/status.h"
#include "sim/devices/axis.h"
#include "sim/devices/node.h"
#include "sim/plant/sensor.h"

#include <stdbool.h>
#include <stdint.h>

/// True values of the quantities that the drive's sensors measure.
typedef struct {
    double motor_position_rad; ///< Referred to the joint.
    double motor_velocity_rad_s;
    double joint_torque_nm;
} drive_truth_t;

typedef struct {
    uint64_t seed;
    uint32_t sensor_device; ///< Number of the sensor, unique in the run, for its noise.
    uint64_t step_ns;       ///< Step of the plant, which is the sampling period of the sensor.
    uint64_t substep_ns;    ///< Period of the regulator.
    /// Largest torque of the motor, in addition to the limits of the objects; 0: no such limit.
    double torque_limit_nm;
    /// Without a sensor (range 0), 0x6077 is the torque of the motor, and the EDS need not have this object.
    torque_sensor_parameters_t torque_sensor;
    encoder_parameters_t encoder;
    void (*read_truth)(void* context, drive_truth_t* out_truth);
    void* truth_context;
    axis_observer_t observer; ///< May be null.
    void* observer_context;
} drive_config_t;

typedef struct drive drive_t;

/// Create a drive. Statuses of node_create.
MUST_USE status_t drive_create(bus_t* bus, const char* eds_path, uint8_t node_id,
                               const drive_config_t* config, drive_t** out_drive, char error[EDS_ERROR_MAX]);
void drive_destroy(drive_t* drive);
node_t* drive_node(drive_t* drive);

/// Returns the torque of the motor on the joint side for one substep, from the motor's position and velocity.
double drive_regulate(drive_t* drive, double position_rad, double velocity_rad_s);
/// Called after a plant step that ended at `now_ns`: checks homing, limits, following error and end of ramps.
void drive_end_step(drive_t* drive, uint64_t now_ns);
bool drive_brake_is_engaged(const drive_t* drive);
uint16_t drive_statusword(const drive_t* drive);

/// Set by a scenario: an extra offset of the torque sensor [Nm].
void drive_set_torque_offset(drive_t* drive, double offset_nm);
/// Set by a scenario: an error of the table in sim/devices/README.md appears or disappears. Faults stop the
/// drive; other errors only set the warning flag.
void drive_set_error(drive_t* drive, uint16_t code, bool is_present, uint64_t now_ns);
/// Set by a scenario: temperature in 0x2210 [degC]. At 80 or more EMCY 0x4310 is present; below 75 the error
/// has ended.
void drive_set_temperature(drive_t* drive, double celsius, uint64_t now_ns);

#endif // SIM_DEVICES_DRIVE_H
