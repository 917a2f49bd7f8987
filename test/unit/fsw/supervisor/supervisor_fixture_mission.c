// SPDX-License-Identifier: Apache-2.0
#include "test/unit/fsw/supervisor/supervisor_fixture_mission.h"

#include "osal/include/osal/file.h"
#include "unity.h"

#include <stdio.h>
#include <string.h>
#include <unistd.h>

static const char communication_document[] =
    "<Subsystem name='COMMUNICATION' id='2' samplingTime='10ms'><Parameters/><Events/><Functions/>\n"
    "<Configuration name='FLIGHT' id='1' priority='5' samplingTime='10ms'/></Subsystem>\n";

static const char arm_document[] =
    "<Subsystem name='ARM' id='16' samplingTime='1ms'><Parameters/>\n"
    "<Events><Event name='BROKEN' id='1' severity='HIGH'/><Event name='STRAIN' id='2' severity='MEDIUM'/>\n"
    "<Event name='TIRED' id='3' severity='MEDIUM'/><Event name='NOTE' id='4' severity='LOW'/>\n"
    "<Event name='GRIPLESS' id='5' severity='HIGH'/><Event name='TORQUE' id='6' severity='MEDIUM'/>\n"
    "<Event name='JAMMED' id='7' severity='HIGH'/><Event name='WORN' id='8' severity='LOW'/></Events>\n"
    "<Functions><Function name='MOVE' id='1' states='OPERATIONAL'/>\n"
    "<Function name='REST' id='2' states='SAFE_OPERATIONAL'/></Functions>\n"
    "<Configuration name='ALONE' id='1' priority='10' samplingTime='1ms'/>\n"
    "<Configuration name='LINKED' id='2' priority='10' samplingTime='1ms'><RTLinkService>\n"
    "<Provides name='STATE' id='1' methods='SHARED_MEMORY'><ParamRef name='A' type='DOUBLE'/></Provides>\n"
    "<Requires name='POS' id='2' methods='SHARED_MEMORY' required='true'><ParamRef name='B' type='DOUBLE'/>\n"
    "</Requires></RTLinkService></Configuration></Subsystem>\n";

static const char hand_document[] =
    "<Subsystem name='HAND' id='17' samplingTime='1ms'><Parameters/>\n"
    "<Events><Event name='BROKEN' id='1' severity='HIGH'/><Event name='STRAIN' id='2' severity='MEDIUM'/>\n"
    "</Events><Functions/>\n"
    "<Configuration name='LINKED' id='2' priority='10' samplingTime='1ms'><RTLinkService>\n"
    "<Provides name='POS' id='1' methods='SHARED_MEMORY'><ParamRef name='B' type='DOUBLE'/></Provides>\n"
    "<Requires name='STATE' id='2' methods='SHARED_MEMORY' required='true'><ParamRef name='A' "
    "type='DOUBLE'/>\n"
    "</Requires></RTLinkService></Configuration></Subsystem>\n";

static const char lone_document[] =
    "<Subsystem name='LONE' id='18' samplingTime='1ms'><Parameters/>\n"
    "<Events><Event name='BROKEN' id='1' severity='HIGH'/><Event name='STRAIN' id='2' severity='MEDIUM'/>\n"
    "</Events><Functions/>\n"
    "<Configuration name='ALONE' id='1' priority='10' samplingTime='1ms'/>\n"
    "<Configuration name='LINKED' id='2' priority='10' samplingTime='1ms'><RTLinkService>\n"
    "<Requires name='STATE' id='3' methods='SHARED_MEMORY' required='false'><ParamRef name='A' "
    "type='DOUBLE'/>\n"
    "</Requires></RTLinkService></Configuration></Subsystem>\n";

// These events have plans: HIGH ones of HAND, BROKEN (the number of the supervisor's PROCESS_LOST) and JAMMED
// of ARM, SUBSYSTEM_SILENT and LOG_FAILED of the supervisor; MEDIUM: STRAIN of ARM and LONE, TORQUE of ARM;
// LOW: WORN of ARM. For all others only the built-in reaction applies. The plans of TORQUE and JAMMED
// take 20 s and 30 s.
static const char mission_document[] =
    "<Mission name='fixture' epoch='2026-06-01T12:00:00' power='100'><Subsystems>\n"
    "<Subsystem name='ARM' id='16' executable='arm' descriptor='arm.xml' restarts='2'>\n"
    "<Power state='PRE_OPERATIONAL' watts='10'/><Power state='SAFE_OPERATIONAL' watts='20'/>\n"
    "<Power state='OPERATIONAL' watts='60'/><Power state='ERROR_OPERATIONAL' watts='10'/></Subsystem>\n"
    "<Subsystem name='HAND' id='17' executable='hand' descriptor='hand.xml' restarts='2'>\n"
    "<Power state='OPERATIONAL' watts='15'/></Subsystem>\n"
    "<Subsystem name='LONE' id='18' executable='lone' descriptor='lone.xml' restarts='1'>\n"
    "<Power state='PRE_OPERATIONAL' watts='41'/></Subsystem>\n"
    "<Subsystem name='SUPERVISOR' id='1' executable='supervisor' descriptor='supervisor.xml' "
    "autostart='true'\n"
    " restarts='1'/>\n"
    "<Subsystem name='COMMUNICATION' id='2' executable='communication' descriptor='communication.xml'\n"
    " autostart='true' restarts='2'/></Subsystems>\n"
    "<Modes><Mode name='SAFE' id='0'/><Mode name='NOMINAL' id='1' initial='true'/></Modes>\n"
    "<Users><User name='CLI' id='1'/><User name='WEB' id='3'/></Users>\n"
    "<Permissions>\n"
    "<Allow tc='129,1' select='PRE_OPERATIONAL' to='*' modes='SAFE NOMINAL' states='OFFLINE'/>\n"
    "<Allow tc='129,1' select='SAFE_OPERATIONAL' to='*' modes='NOMINAL' states='PRE_OPERATIONAL'/>\n"
    "<Allow tc='129,1' select='OPERATIONAL' to='*' modes='NOMINAL' states='SAFE_OPERATIONAL'/>\n"
    "<Allow tc='129,3' select='LINKED' to='ARM' modes='NOMINAL' states='PRE_OPERATIONAL'/>\n"
    "<Allow tc='129,3' select='LINKED' to='HAND' modes='NOMINAL' states='PRE_OPERATIONAL'/>\n"
    "<Allow tc='129,8' to='LONE' modes='NOMINAL' states='*'/>\n"
    "<Allow tc='130,3' select='ARM_STATE' to='SUPERVISOR' modes='NOMINAL' states='*'/>\n"
    "<Allow tc='130,3' select='LONE_STATE' to='SUPERVISOR' modes='NOMINAL' states='*'/>\n"
    "<Allow tc='130,3' select='HAND_POS' to='SUPERVISOR' modes='NOMINAL' states='*'/>\n"
    "<Allow tc='130,6' to='SUPERVISOR' modes='NOMINAL' states='*'/>\n"
    "<Allow tc='8,1' select='MOVE' to='ARM' modes='NOMINAL' states='OPERATIONAL'/>\n"
    "<Allow tc='20,3' to='ARM' modes='NOMINAL' states='PRE_OPERATIONAL'/>\n"
    "<Allow tc='9,*' to='SUPERVISOR' modes='NOMINAL' states='*'/>\n"
    "<Allow tc='11,*' to='SUPERVISOR' modes='NOMINAL' states='*'/>\n"
    "<Allow tc='13,*' to='SUPERVISOR' modes='NOMINAL' states='*'/>\n"
    "<Allow tc='14,*' to='SUPERVISOR' modes='NOMINAL' states='*'/>\n"
    "<Allow tc='15,*' to='SUPERVISOR' modes='NOMINAL' states='*'/>\n"
    "<Allow tc='18,*' to='SUPERVISOR' modes='NOMINAL' states='*'/>\n"
    "<Allow tc='19,*' to='SUPERVISOR' modes='NOMINAL' states='*'/>\n"
    "<Allow tc='21,*' to='SUPERVISOR' modes='NOMINAL' states='*'/>\n"
    "<Allow tc='22,*' to='SUPERVISOR' modes='NOMINAL' states='*'/>\n"
    "<Allow tc='23,*' to='SUPERVISOR' modes='NOMINAL' states='*'/>\n"
    "<Allow tc='6,*' to='SUPERVISOR' modes='NOMINAL' states='*'/>\n"
    "<Allow tc='5,*' to='SUPERVISOR' modes='NOMINAL' states='*'/>\n"
    "<Allow tc='131,1' to='SUPERVISOR' modes='SAFE NOMINAL' states='*'/>\n"
    "<Allow tc='131,3' to='SUPERVISOR' modes='SAFE NOMINAL' states='*'/>\n"
    "<Allow tc='131,6' to='SUPERVISOR' modes='SAFE NOMINAL' states='*'/>\n"
    "<Allow tc='131,7' to='SUPERVISOR' modes='SAFE NOMINAL' states='*'/></Permissions>\n"
    "<Links><Link name='ARM_STATE' from='ARM.STATE' to='HAND.STATE'/>\n"
    "<Link name='HAND_POS' from='HAND.POS' to='ARM.POS'/>\n"
    "<Link name='LONE_STATE' from='ARM.STATE' to='LONE.STATE'/></Links>\n";

static const char plans_document[] =
    "<RecoveryPlans>\n"
    "<Plan name='HAND_DOWN' severity='HIGH' subsystem='HAND'>\n"
    "<Action do='MODE' mode='SAFE'/><Action do='STATE' target='NETWORK' state='OFFLINE' "
    "after='200ms'/></Plan>\n"
    "<Plan name='NOTED' severity='HIGH' subsystem='ARM' event='BROKEN'><Action do='LOG'/></Plan>\n"
    "<Plan name='MUTE' severity='HIGH' subsystem='SUPERVISOR' event='SUBSYSTEM_SILENT'>\n"
    "<Action do='MODE' mode='SAFE'/></Plan>\n"
    "<Plan name='UNLOGGED' severity='HIGH' subsystem='SUPERVISOR' event='LOG_FAILED'>\n"
    "<Action do='MODE' mode='SAFE'/><Action do='STATE' target='SELF' state='OFFLINE'/>\n"
    "<Action do='STATE' target='LONE' state='OFFLINE' after='100ms'/></Plan>\n"
    "<Plan name='SLOW' severity='MEDIUM' subsystem='ARM' event='TORQUE'>\n"
    "<Action do='STATE' target='SELF' state='SAFE_OPERATIONAL'/>\n"
    "<Action do='STATE' target='NETWORK' state='PRE_OPERATIONAL' after='20s'/></Plan>\n"
    "<Plan name='SLOWER' severity='HIGH' subsystem='ARM' event='JAMMED'>\n"
    "<Action do='STATE' target='NETWORK' state='OFFLINE' after='2s'/><Action do='LOG' after='30s'/></Plan>\n"
    "<Plan name='CARE' severity='LOW' subsystem='ARM' event='WORN'>\n"
    "<Action do='STATE' target='NETWORK' state='SAFE_OPERATIONAL' after='100ms'/></Plan>\n"
    "<Plan name='HALT' severity='MEDIUM' subsystem='LONE' event='STRAIN'>\n"
    "<Action do='STATE' target='SELF' state='ERROR_OPERATIONAL'/></Plan>\n"
    "<Plan name='EASE' severity='MEDIUM' subsystem='ARM' event='STRAIN'>\n"
    "<Action do='STATE' target='SELF' state='SAFE_OPERATIONAL'/></Plan></RecoveryPlans>\n"
    "<PacketLog strategy='ASCII' ringRecords='64'/>\n"
    "<Transports messages='UDP' links='SHARED_MEMORY'/><Ground address='127.0.0.1' "
    "port='10015'/></Mission>\n";

static descriptor_loader_t loader;
static subsystem_descriptor_t scratch;

static const char* path_of(const char* directory, const char* name)
{
    static char path[160];
    (void)snprintf(path, sizeof path, "%s/%s", directory, name);
    return path;
}

static void write_file(const char* directory, const char* name, const char* text, size_t size)
{
    osal_file_t file;
    TEST_ASSERT_EQUAL(STATUS_OK, osal_file_create(&file, path_of(directory, name)));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_file_write(&file, text, size));
    osal_file_close(&file);
}

void fixture_mission_load(const char* directory, mission_descriptor_t* out_mission,
                          subsystem_descriptor_t* out_supervisor)
{
    static const char* const names[] = {"mission.xml", "supervisor.xml", "communication.xml",
                                        "arm.xml",     "hand.xml",       "lone.xml"};
    static char own[16384];
    size_t size = 0U;
    TEST_ASSERT_EQUAL(STATUS_OK,
                      osal_file_load("descriptors/subsystems/supervisor.xml", own, sizeof own, &size));
    write_file(directory, "supervisor.xml", own, size);
    write_file(directory, "communication.xml", communication_document, strlen(communication_document));
    write_file(directory, "arm.xml", arm_document, strlen(arm_document));
    write_file(directory, "hand.xml", hand_document, strlen(hand_document));
    write_file(directory, "lone.xml", lone_document, strlen(lone_document));
    (void)snprintf(own, sizeof own, "%s%s", mission_document, plans_document);
    write_file(directory, "mission.xml", own, strlen(own));
    descriptor_loader_init(&loader);
    const status_t status =
        descriptor_load_mission(&loader, path_of(directory, "mission.xml"), MISSION_ANY_TARGET,
                                &descriptor_mission_whole, out_mission, &scratch);
    TEST_ASSERT_EQUAL_STRING("", descriptor_error(&loader));
    TEST_ASSERT_EQUAL(STATUS_OK, status);
    TEST_ASSERT_EQUAL(
        STATUS_OK, descriptor_load_subsystem(&loader, path_of(directory, "supervisor.xml"), out_supervisor));
    for (unsigned i = 0U; i < (sizeof names / sizeof names[0]); i++) {
        (void)unlink(path_of(directory, names[i]));
    }
}
