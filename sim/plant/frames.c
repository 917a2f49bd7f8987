// SPDX-License-Identifier: Apache-2.0
#include "sim/plant/plant_internal.h"

#include <string.h>

void plant_frame(const plant_t* const plant, const unsigned robot, const unsigned frame,
                 plant_base_t* const out_frame)
{
    const robot_frame_t* model = &plant->world->robot[robot].model.frame[frame];
    const robot_t* own         = &plant->robot[robot];
    const dBodyID body         = own->body[model->body];
    const matrix_t* turn       = &model->pose.rotation;
    dMatrix3 in_body           = {0.0};
    dMatrix3 in_world          = {0.0};
    dMatrix3 whole             = {0.0};
    dQuaternion quaternion;
    dVector3 speed;
    *out_frame = (plant_base_t){.rotation = {1.0}};
    robot_point(plant, robot, model->body, model->pose.position_m, out_frame->position_m);
    for (size_t i = 0U; i < 3U; i++) {
        memcpy(&in_body[4U * i], turn->at[i], 3U * sizeof(double));
        memcpy(&in_world[4U * i], own->base.rotation.at[i], 3U * sizeof(double));
    }
    if (body != NULL) {
        const double* at = out_frame->position_m;
        memcpy(in_world, dBodyGetRotation(body), sizeof in_world);
        memcpy(out_frame->rate_rad_s, dBodyGetAngularVel(body), sizeof out_frame->rate_rad_s);
        dBodyGetPointVel(body, at[0], at[1], at[2], speed);
        memcpy(out_frame->velocity_m_s, speed, sizeof out_frame->velocity_m_s);
    }
    dMultiply0_333(whole, in_world, in_body);
    dQfromR(quaternion, whole);
    memcpy(out_frame->rotation, quaternion, sizeof out_frame->rotation);
}
