// SPDX-License-Identifier: Apache-2.0
#include "test/unit/fsw/framework/descriptor/documents.h"

#include "unity.h"

#include <string.h>

// The comments // 5, // 10 .. number the lines of a document; the tests of errors expect these numbers.
const char arm_document[] =
    "<Subsystem name='ARM' id='16' samplingTime='5ms'>\n"
    "<Resources poolWarning='80' poolClear='70'/>\n"
    "<States><State name='HARDWARE_INIT' timeout='2s'/></States>\n"
    "<Parameters>\n"
    "<StructRef name='CUR_VALUES' id='0' type='STRUCT'>\n" // 5
    "<ParamRef name='STATE' id='0' type='INT32'/>\n"
    "<ParamRef name='POSITION' id='0' type='DOUBLE' count='2' unit='rad' init='0.5 -1'/>\n"
    "<ParamRef name='FLAG' type='BOOL' init='true'/>\n"
    "</StructRef>\n"
    "<ParamRef name='TARGET' id='1' type='DOUBLE' count='2' unit='rad' min='-1.5' max='1.5' "
    "settable='true'/>\n" // 10
    "<ParamRef name='COUNT' id='1' type='UINT32'/>\n"
    "</Parameters>\n"
    "<Events>\n"
    "<Event name='LOST' id='1' severity='HIGH'/>\n"
    "<Event name='LIMIT' id='3' severity='MEDIUM'><ParamRef name='JOINT' type='UINT8'/>\n" // 15
    "<ParamRef name='TORQUE' type='DOUBLE' unit='Nm'/></Event>\n"
    "<Event name='NOTE' id='2' severity='LOW'><ParamRef name='CUR_VALUES'/>\n"
    "<ParamRef name='COUNT'/></Event>\n"
    "</Events>\n"
    "<Functions>\n" // 20
    "<Function name='MOVE_TO' id='1' states='OPERATIONAL' configurations='ALONE'>\n"
    "<Argument name='FAST' id='7' type='BOOL'/>\n"
    "<Argument name='POSITION' id='1' type='DOUBLE' count='2' min='-1.5' max='1.5'/></Function>\n"
    "<Function name='STOP' id='2' states='*'/>\n"
    "</Functions>\n" // 25
    "<Configuration name='ALONE' id='1' priority='80' samplingTime='1ms'>\n"
    "<Initial parameter='CUR_VALUES' field='POSITION' value='1 2'/>\n"
    "<Initial parameter='TARGET' value='0.25 0.5'/>\n"
    "<HKService id='4711' interval='500'>\n"
    "<SampledOnce><ParamRef name='CUR_VALUES'/></SampledOnce>\n" // 30
    "<SampledNREPTimes nrep='5'><ParamRef name='TARGET'/></SampledNREPTimes>\n"
    "</HKService>\n"
    "<HKService id='4712' interval='7' enabled='false'><SampledOnce><ParamRef "
    "name='COUNT'/></SampledOnce></HKService>\n"
    "</Configuration>\n"
    "<Configuration name='COUPLED' id='2' priority='90' samplingTime='500us'>\n" // 35
    "<RTLinkService>\n"
    "<Provides name='ARM_STATE' id='1' methods='SHARED_MEMORY UDP'>\n"
    "<ParamRef name='POSITION' type='DOUBLE' count='2' unit='rad'/></Provides>\n"
    "<Requires name='HAND' id='2' methods='UDP' required='true' staleAfter='3ms'>\n"
    "<ParamRef name='KIND' type='UINT8'/>\n" // 40
    "<ParamRef name='POSITION' type='DOUBLE' count='2'/></Requires>\n"
    "</RTLinkService>\n"
    "<Devices>\n"
    "<Device name='JOINT1' type='joint-drive'>\n"
    "<Setting object='0x6060:00' type='INT8' value='-8'/>\n" // 45
    "<Setting object='0x1600:0A' type='UINT32' value='0x60400010'/>\n"
    "<Endnode type='CAN' bus='robot' node='0x11'/></Device>\n"
    "<Device name='GROUND' type='ground-port'><Endnode type='TCP' address='127.0.0.1' "
    "port='10015' framing='LENGTH' order='LITTLE'/><Endnode type='SERIAL' name='/dev/ttyS0' framing='SLIP' "
    "baud='19200'/><Endnode type='FILE' name='/dev/adc0' direction='READ' silence='3ms'/>"
    "<Field name='RATE' direction='IN' type='INT16' scale='-1e-3' offset='2' unit='1/s'/><Field name='ON' "
    "direction='OUT' type='UINT8' safe='1'/></Device>\n"
    "</Devices>\n"
    "</Configuration>\n" // 50
    "</Subsystem>\n";

const char hand_document[] =
    "<Subsystem name='HAND' id='17'>\n"
    "<Parameters><ParamRef name='TORQUE' id='1' type='DOUBLE'/></Parameters>\n"
    "<Events><Event name='LOST' id='9' severity='HIGH'/></Events>\n"
    "<Functions><Function name='STOP' id='1' states='*'/></Functions>\n"
    "<Configuration name='COUPLED' id='5' priority='90' samplingTime='500us'>\n"
    "<RTLinkService>\n"
    "<Provides name='HAND' id='4' methods='SHARED_MEMORY UDP'>\n"
    "<ParamRef name='KIND' type='UINT8'/><ParamRef name='POSITION' type='DOUBLE' count='2'/></Provides>\n"
    "<Requires name='ARM' id='3' methods='SHARED_MEMORY' required='false'>\n"
    "<ParamRef name='POSITION' type='DOUBLE' count='2'/></Requires>\n"
    "</RTLinkService>\n"
    "</Configuration>\n"
    "</Subsystem>\n";

const char flight_document[] =
    "<Mission name='flight' epoch='2026-06-01T12:00:00' power='200'>\n"
    "<Subsystems>\n"
    "<Subsystem name='ARM' id='16' executable='arm' descriptor='arm.xml' autostart='true' memoryKiB='4096' "
    "restarts='3'>\n"
    "<Power state='OPERATIONAL' watts='120'/></Subsystem>\n"
    "<Subsystem name='HAND' id='17' executable='hand' descriptor='hand.xml'/>\n" // 5
    "</Subsystems>\n"
    "<Modes><Mode name='SAFE' id='0'/>\n"
    "<Mode name='NOMINAL' id='3' initial='true'/></Modes>\n"
    "<Users><User name='CLI' id='1'/></Users>\n"
    "<Permissions>\n" // 10
    "<Allow tc='8,1' select='MOVE_TO' to='ARM' modes='NOMINAL' states='OPERATIONAL'/>\n"
    "<Allow tc='8,1' select='STOP' to='*' modes='*' states='*'/>\n"
    "<Allow tc='129,1' select='PRE_OPERATIONAL' to='*' modes='SAFE NOMINAL' states='OFFLINE'/>\n"
    "<Allow tc='129,3' select='COUPLED' to='HAND' modes='NOMINAL' states='PRE_OPERATIONAL'/>\n"
    "<Allow tc='130,3' select='BACK' to='ARM' modes='NOMINAL' states='*'/>\n" // 15
    "<Allow tc='20,3' to='ARM' modes='NOMINAL' states='SAFE_OPERATIONAL OPERATIONAL'/>\n"
    "</Permissions>\n"
    "<Links><Link name='FORTH' from='ARM.ARM_STATE' to='HAND.ARM'/>\n"
    "<Link name='BACK' from='HAND.HAND' to='ARM.HAND'/></Links>\n"
    "<RecoveryPlans>\n" // 20
    "<Plan name='HAND_LOST' severity='HIGH' subsystem='HAND' event='LOST'><Action do='LOG'/></Plan>\n"
    "<Plan name='DOWN' severity='HIGH'><Action do='STATE' target='NETWORK' state='OFFLINE' after='500ms'/>\n"
    "<Action do='MODE' mode='SAFE'/></Plan>\n"
    "</RecoveryPlans>\n"
    "<PacketLog strategy='SQLITE' ringRecords='100'/>\n" // 25
    "<Buses><Bus name='robot' bitRate='1000000' dataBitRate='5000000'/></Buses>\n"
    "<Transports messages='TIPC' links='UDP'/>\n"
    "<Ground address='127.0.0.1' port='10015'/>\n"
    "</Mission>\n";

const char* damaged(const char* const document, const char* const find, const char* const replacement)
{
    static char copy[16384];
    const char* const at = strstr(document, find);
    TEST_ASSERT_NOT_NULL_MESSAGE(at, find);
    const size_t before = (size_t)(at - document);
    TEST_ASSERT_LESS_THAN_UINT64(sizeof copy, strlen(document) + strlen(replacement));
    memcpy(copy, document, before);
    strcpy(&copy[before], replacement);
    strcat(copy, &at[strlen(find)]);
    return copy;
}
