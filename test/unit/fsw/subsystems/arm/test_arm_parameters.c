// SPDX-License-Identifier: Apache-2.0
// Descriptors of arms: what is accepted, and what is refused with file and line.
#include "test/unit/fsw/subsystems/arm/arm_rig.h"

#include "unity.h"

#include <string.h>

static subsystem_descriptor_t changed;
static subsystem_misfit_t misfit;

void setUp(void)
{
    rig_load();
    changed = rig_descriptor;
    descriptor_subsystem_use_storage(&changed);
    misfit = (subsystem_misfit_t){0U, "", 0U};
}

void tearDown(void)
{
}

static descriptor_field_t* field_of(const char* const parameter, const char* const field)
{
    const descriptor_parameter_t* const found = descriptor_find_parameter(&changed, parameter);
    TEST_ASSERT_NOT_NULL(found);
    for (uint16_t i = 0U; i < found->field_count; i++) {
        descriptor_field_t* const item = &changed.storage.fields[found->first_field + i];
        if (strcmp(item->name, field) == 0) {
            return item;
        }
    }
    TEST_FAIL_MESSAGE(field);
    return NULL;
}

static void expect_refusal(const uint32_t line, const char* const reason)
{
    TEST_ASSERT_FALSE(arm_callbacks()->fits(&changed, &misfit));
    TEST_ASSERT_EQUAL_UINT32(line, misfit.line);
    TEST_ASSERT_NOT_NULL_MESSAGE(strstr(misfit.reason, reason), misfit.reason);
}

static void the_descriptor_of_six_joints_fits(void)
{
    TEST_ASSERT_TRUE(arm_callbacks()->fits(&changed, &misfit));
    TEST_ASSERT_EQUAL_UINT(6U, arm_joint_count(&changed));
    changed.configuration_count = 1U;
    TEST_ASSERT_TRUE(arm_callbacks()->fits(&changed, &misfit));
    TEST_ASSERT_EQUAL_UINT(6U, arm_joint_count(&changed));
}

static void an_arm_has_one_to_twelve_joints(void)
{
    changed.storage.configurations[0].device_count = 0U;
    expect_refusal(1U, "1 to 12 <Device>");
    changed.storage.configurations[0].device_count = 13U;
    expect_refusal(1U, "1 to 12 <Device>");
    changed.configuration_count = 0U;
    TEST_ASSERT_EQUAL_UINT(0U, arm_joint_count(&changed));
    expect_refusal(1U, "1 to 12 <Device>");
}

static void the_lengths_of_lists_follow_from_the_joints(void)
{
    descriptor_field_t* const inertia = field_of("MASSES", "INERTIA");
    inertia->count                    = 35U;
    expect_refusal(inertia->line, "count of <ParamRef>");
}

static void names_and_types_are_those_of_an_arm(void)
{
    descriptor_field_t* const mass = field_of("MASSES", "MASS");
    mass->type                     = VALUE_FLOAT;
    expect_refusal(mass->line, "type of <ParamRef>");
    mass->type = VALUE_DOUBLE;
    mass->name = "MASSE";
    expect_refusal(mass->line, "name of <ParamRef>");
}

static void all_parameters_and_no_others_are_required(void)
{
    descriptor_parameter_t* const drives = &changed.storage.parameters[5];
    drives->field_count--;
    expect_refusal(drives->line, "with all their members");
    drives->field_count++;
    drives->is_struct = false;
    expect_refusal(drives->line, "with all their members");
    drives->is_struct = true;
    drives->name      = "OTHERS";
    expect_refusal(1U, "with all their members");
    drives->name                                             = "DRIVES";
    changed.storage.parameters[changed.parameter_count]      = changed.storage.parameters[0];
    changed.storage.parameters[changed.parameter_count].name = "OTHERS";
    changed.parameter_count++;
    expect_refusal(changed.parameters[0].line, "CUR_VALUES only");
}

static void functions_are_those_of_an_arm(void)
{
    changed.storage.functions[0].name = "JUMP";
    expect_refusal(changed.functions[0].line, "<Function>");
    changed.storage.functions[0].name           = "MOVE_TO";
    changed.storage.functions[0].argument_count = 1U;
    expect_refusal(changed.functions[0].line, "<Function>");
    changed.storage.functions[0].argument_count = 2U;
    descriptor_field_t* const position = &changed.storage.fields[changed.storage.functions[0].first_argument];
    position->count                    = 5U;
    expect_refusal(position->line, "<Argument>");
    position->count = 6U;
    position->type  = VALUE_FLOAT;
    expect_refusal(position->line, "<Argument>");
}

static void services_may_use_the_storage_of_the_program(void)
{
    const descriptor_service_t largest[] = {
        {.type = 2U, .capacity = ARM_DEVICE_REQUESTS, .line = 71U},
        {.type = 4U, .capacity = ARM_STATISTICS, .line = 72U},
        {.type = 6U, .capacity = ARM_MEMORY_OPERATIONS, .line = 73U},
        {.type = 12U, .capacity = ARM_MONITORS, .functional = ARM_FUNCTIONAL_MONITORS, .line = 74U}};
    changed.service_count = 4U;
    (void)memcpy(changed.storage.services, largest, sizeof largest);
    TEST_ASSERT_TRUE(arm_callbacks()->fits(&changed, &misfit));
    for (unsigned i = 0U; i < 4U; i++) {
        changed.storage.services[i].capacity++;
        expect_refusal(largest[i].line, "<Service>");
        changed.storage.services[i].capacity--;
    }
    changed.storage.services[3].functional++;
    expect_refusal(74U, "<Service>");
}

static descriptor_parameter_t* add_scalar(const char* const name, const value_type_t type)
{
    descriptor_parameter_t* const parameter = &changed.storage.parameters[changed.parameter_count];
    descriptor_field_t* const field         = &changed.storage.fields[changed.field_count];
    *field     = (descriptor_field_t){.name = name, .type = type, .count = 1U, .line = 88U};
    *parameter = (descriptor_parameter_t){.name        = name,
                                          .id          = 0x04090100U + changed.parameter_count,
                                          .first_field = changed.field_count,
                                          .field_count = 1U,
                                          .wire_size   = (uint32_t)value_size(type),
                                          .line        = 88U};
    changed.field_count++;
    changed.parameter_count++;
    return parameter;
}

static void single_values_of_cur_values_may_be_parameters(void)
{
    static arm_definitions_t definitions;
    static arm_parameters_t values;
    (void)add_scalar("TORQUE_2", VALUE_DOUBLE);
    (void)add_scalar("STATUSWORD_6", VALUE_UINT16);
    (void)add_scalar("TOOL_FORCE_3", VALUE_DOUBLE);
    TEST_ASSERT_TRUE_MESSAGE(arm_callbacks()->fits(&changed, &misfit), misfit.reason);
    arm_definitions_create(&definitions, &changed);
    TEST_ASSERT_EQUAL_UINT(ARM_PARAMETERS + 3U, definitions.count);
    const void* const expected[] = {&values.cur_values.torque_nm[1], &values.cur_values.statusword[5],
                                    &values.cur_values.tool_force_n[2]};
    const uint32_t sizes[]       = {8U, 2U, 8U};
    for (unsigned i = 0U; i < 3U; i++) {
        const parameter_definition_t* const made = &definitions.definitions[ARM_PARAMETERS + i];
        TEST_ASSERT_EQUAL_PTR(expected[i], (const uint8_t*)&values + definitions.offsets[ARM_PARAMETERS + i]);
        TEST_ASSERT_EQUAL_UINT32(changed.parameters[ARM_PARAMETERS + i].id, made->id);
        TEST_ASSERT_EQUAL_UINT32(sizes[i], made->memory_size);
        TEST_ASSERT_EQUAL_STRING(made->name, made->fields[0].name);
        TEST_ASSERT_EQUAL_UINT32(0U, made->fields[0].offset);
    }
}

static void names_other_than_values_of_cur_values_are_refused(void)
{
    static const char* const names[] = {"TORQUE_7", "TORQUE_0",  "TORQUE_02", "TORQUE_", "TORQUE_4294967298",
                                        "TORQUE-1", "TORQUE_1A", "MASS_1",    "TORQUE",  "TORQUE_1/"};
    descriptor_parameter_t* const parameter = add_scalar("TORQUE_1", VALUE_DOUBLE);
    for (unsigned i = 0U; i < (sizeof names / sizeof names[0]); i++) {
        parameter->name = names[i];
        expect_refusal(88U, "CUR_VALUES only");
    }
    parameter->name      = "TORQUE_1";
    parameter->is_struct = true;
    expect_refusal(88U, "CUR_VALUES only");
    parameter->is_struct   = false;
    parameter->is_settable = true;
    expect_refusal(88U, "not settable");
    parameter->is_settable                               = false;
    changed.storage.fields[parameter->first_field].count = 2U;
    expect_refusal(88U, "count 1");
    changed.storage.fields[parameter->first_field].count = 1U;
    changed.storage.fields[parameter->first_field].type  = VALUE_FLOAT;
    expect_refusal(88U, "type of this value");
}

static void the_geometry_decides_which_joints_are_linear_axes(void)
{
    static arm_definitions_t definitions;
    static arm_parameters_t values;
    arm_model_t model;
    descriptor_parameter_t* geometry = NULL;
    for (uint16_t i = 0U; i < changed.parameter_count; i++) {
        geometry = (strcmp(changed.storage.parameters[i].name, "GEOMETRY") == 0)
                       ? &changed.storage.parameters[i]
                       : geometry;
    }
    TEST_ASSERT_NOT_NULL(geometry);
    TEST_ASSERT_EQUAL_UINT16(5U, geometry->field_count); // The list PRISMATIC is missing.
    descriptor_field_t* const fields = &changed.storage.fields[changed.field_count];
    (void)memcpy(fields, &changed.fields[geometry->first_field], 5U * sizeof fields[0]);
    fields[5] = (descriptor_field_t){.name = "PRISMATIC", .type = VALUE_BOOL, .count = 6U, .line = 99U};
    geometry->first_field = changed.field_count;
    geometry->field_count = 6U;
    changed.field_count   = (uint16_t)(changed.field_count + 6U);
    TEST_ASSERT_TRUE_MESSAGE(arm_callbacks()->fits(&changed, &misfit), misfit.reason);
    arm_definitions_create(&definitions, &changed);
    TEST_ASSERT_EQUAL_UINT16(6U, definitions.definitions[3].field_count);
    values.geometry.is_prismatic[4] = true;
    for (unsigned i = 0U; i < 6U; i++) {
        values.geometry.axis[(3U * i) + 2U] = 1.0;
    }
    TEST_ASSERT_EQUAL(STATUS_OK, arm_model_of_parameters(&values, 6U, &model));
    TEST_ASSERT_TRUE(model.link[4].is_prismatic);
    TEST_ASSERT_FALSE(model.link[3].is_prismatic);
    fields[5].count = 5U;
    expect_refusal(99U, "count of <ParamRef>");
    geometry->field_count = 7U;
    expect_refusal(geometry->line, "with all their members");
}

static void at_most_48_single_values_are_parameters(void)
{
    for (unsigned i = 0U; i < ARM_SCALARS; i++) {
        (void)add_scalar("TORQUE_1", VALUE_DOUBLE); // The loader has checked that names differ.
    }
    TEST_ASSERT_TRUE(arm_callbacks()->fits(&changed, &misfit));
    (void)add_scalar("TORQUE_1", VALUE_DOUBLE);
    expect_refusal(88U, "at most 48");
}

static void ports_are_those_of_a_joystick(void)
{
    descriptor_port_t* const robot = &changed.storage.ports[0];
    descriptor_port_t* const hand  = &changed.storage.ports[1];
    TEST_ASSERT_TRUE(robot->is_provided && !hand->is_provided);
    hand->name = "FOOT_POSITION";
    expect_refusal(hand->line, "<RTLinkService>");
    hand->name        = "HAND_POSITION";
    hand->field_count = 2U;
    expect_refusal(hand->line, "<RTLinkService>");
    hand->field_count                = 1U;
    descriptor_field_t* const torque = &changed.storage.fields[robot->first_field + 1U];
    torque->count                    = 3U;
    expect_refusal(robot->line, "<RTLinkService>");
    torque->count = 2U;
    torque->type  = VALUE_FLOAT;
    expect_refusal(robot->line, "<RTLinkService>");
    torque->type                                 = VALUE_DOUBLE;
    changed.storage.configurations[3].port_count = 1U;
    expect_refusal(changed.configurations[3].line, "both ports of telepresence");
}

static void all_configurations_have_the_same_joints(void)
{
    changed.storage.configurations[1].device_count = 5U;
    expect_refusal(changed.configurations[1].line, "as many <Device>");
}

static void drives_are_in_torque_or_position_mode(void)
{
    for (uint16_t i = 0U; i < changed.setting_count; i++) {
        changed.storage.settings[i].bits =
            (changed.storage.settings[i].index == 0x6060U) ? 1U : changed.storage.settings[i].bits;
    }
    expect_refusal(changed.devices[0].line, "10 (torque) or 8 (position)");
}

static void an_axis_becomes_a_direction(void)
{
    arm_model_t model;
    arm_limits_t limits;
    rig_model(&model, &limits);
    rig_arm.parameters.geometry.axis[6] = 3.0;
    TEST_ASSERT_EQUAL(STATUS_OK, arm_model_of_parameters(&rig_arm.parameters, RIG_JOINTS, &model));
    TEST_ASSERT_TRUE(arm_length(model.link[2].axis) < 1.0000001);
}

static void a_model_without_a_direction_or_with_a_negative_value_is_refused(void)
{
    arm_model_t model;
    arm_limits_t limits;
    rig_model(&model, &limits);
    arm_parameters_t* const all = &rig_arm.parameters;
    double* const values[]      = {&all->masses.mass[RIG_JOINTS - 1U], &all->drives.rotor_inertia[0],
                                   &all->drives.stiffness[RIG_JOINTS - 1U]};
    for (size_t i = 0U; i < (sizeof values / sizeof values[0]); i++) {
        const double before = *values[i];
        *values[i]          = 0.0;
        TEST_ASSERT_EQUAL(STATUS_OK, arm_model_of_parameters(all, RIG_JOINTS, &model));
        *values[i] = -1.0e-9;
        TEST_ASSERT_EQUAL(STATUS_INVALID, arm_model_of_parameters(all, RIG_JOINTS, &model));
        *values[i] = before;
    }
    memset(&all->geometry.axis[3U * (RIG_JOINTS - 1U)], 0, 3U * sizeof(double));
    TEST_ASSERT_EQUAL(STATUS_INVALID, arm_model_of_parameters(all, RIG_JOINTS, &model));
    TEST_ASSERT_EQUAL(STATUS_OK, arm_model_of_parameters(all, RIG_JOINTS - 1U, &model));
}

/// The six numbers of a link, XX XY XZ YY YZ ZZ, form a symmetric matrix.
static void each_number_of_an_inertia_has_its_position(void)
{
    static const unsigned places[3][3] = {{0U, 1U, 2U}, {1U, 3U, 4U}, {2U, 4U, 5U}};
    arm_model_t model;
    arm_limits_t limits;
    rig_model(&model, &limits);
    for (unsigned i = 0U; i < (6U * RIG_JOINTS); i++) {
        rig_arm.parameters.masses.inertia[i] = 1.0 + (double)i;
    }
    TEST_ASSERT_EQUAL(STATUS_OK, arm_model_of_parameters(&rig_arm.parameters, RIG_JOINTS, &model));
    for (unsigned link = 0U; link < RIG_JOINTS; link++) {
        for (unsigned i = 0U; i < 9U; i++) {
            const double expected = 1.0 + (6.0 * (double)link) + (double)places[i / 3U][i % 3U];
            TEST_ASSERT_TRUE(model.link[link].inertia_kgm2.at[i / 3U][i % 3U] == expected);
        }
    }
}

/// Values after those of the last joint are ignored, whatever they are.
static void only_the_joints_of_the_arm_have_limits_and_links(void)
{
    arm_model_t model;
    arm_limits_t limits;
    rig_model(&model, &limits);
    arm_limits_of_parameters(&rig_arm.parameters, RIG_JOINTS - 1U, &limits);
    TEST_ASSERT_EQUAL(STATUS_OK, arm_model_of_parameters(&rig_arm.parameters, RIG_JOINTS - 1U, &model));
    TEST_ASSERT_TRUE(limits.upper_rad[RIG_JOINTS - 2U] == rig_arm.parameters.limits.upper[RIG_JOINTS - 2U]);
    TEST_ASSERT_TRUE(limits.upper_rad[RIG_JOINTS - 1U] == 0.0);
    TEST_ASSERT_TRUE(limits.acceleration_rad_s2[RIG_JOINTS - 1U] == 0.0);
    TEST_ASSERT_TRUE(model.link[RIG_JOINTS - 2U].mass_kg == rig_arm.parameters.masses.mass[RIG_JOINTS - 2U]);
    TEST_ASSERT_TRUE(model.link[RIG_JOINTS - 1U].mass_kg == 0.0);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(the_descriptor_of_six_joints_fits);
    RUN_TEST(an_arm_has_one_to_twelve_joints);
    RUN_TEST(the_lengths_of_lists_follow_from_the_joints);
    RUN_TEST(names_and_types_are_those_of_an_arm);
    RUN_TEST(all_parameters_and_no_others_are_required);
    RUN_TEST(functions_are_those_of_an_arm);
    RUN_TEST(services_may_use_the_storage_of_the_program);
    RUN_TEST(single_values_of_cur_values_may_be_parameters);
    RUN_TEST(names_other_than_values_of_cur_values_are_refused);
    RUN_TEST(the_geometry_decides_which_joints_are_linear_axes);
    RUN_TEST(at_most_48_single_values_are_parameters);
    RUN_TEST(ports_are_those_of_a_joystick);
    RUN_TEST(all_configurations_have_the_same_joints);
    RUN_TEST(drives_are_in_torque_or_position_mode);
    RUN_TEST(an_axis_becomes_a_direction);
    RUN_TEST(a_model_without_a_direction_or_with_a_negative_value_is_refused);
    RUN_TEST(only_the_joints_of_the_arm_have_limits_and_links);
    RUN_TEST(each_number_of_an_inertia_has_its_position);
    return UNITY_END();
}
