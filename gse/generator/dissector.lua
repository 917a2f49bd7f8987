
-- Fields show the numbers of the packets; times are seconds of mission time, as in the logs of a run.

local PRIMARY, TC_HEADER, TM_HEADER, CRC = 6, 11, 21, 2
local SIZES = { UINT8 = 1, UINT16 = 2, UINT32 = 4, UINT64 = 8, INT8 = 1, INT16 = 2, INT32 = 4, INT64 = 8, FLOAT = 4, DOUBLE = 8, BOOL = 1 }
local NUMBERS = { u8 = 1, u16 = 2, u32 = 4, u64 = 8, i16 = 2, i32 = 4, i64 = 8, f64 = 8, id = 4, layout = 1 }
local FRACTION, ANGLE = 2 ^ 24, 2 ^ 16
local KINDS = { UINT8 = "uint8", UINT16 = "uint16", UINT32 = "uint32", UINT64 = "uint64", INT8 = "int8", INT16 = "int16",
    INT32 = "int32", INT64 = "int64", FLOAT = "float", DOUBLE = "double", BOOL = "bool", STRING = "string", OCTETS = "bytes" }

local pus = Proto("pus", "PUS of mission " .. MISSION.name)
local fields, by_name = {}, {}
for name, row in pairs(FIELDS) do -- name -> type, label, words, mask, bits of the word of a flag
    local make, words = ProtoField[KINDS[row[1]]], row[3] and WORDS[row[3]]
    if row[5] then
        fields[name] = make("pus." .. name, row[2], row[5], nil, row[4])
    elseif words then
        fields[name] = make("pus." .. name, row[2], base.DEC, words, row[4])
    else
        fields[name] = make("pus." .. name, row[2])
    end
    by_name[#by_name + 1] = fields[name]
end
pus.fields = by_name
local wrong_crc = ProtoExpert.new("pus.crc.wrong", "Checksum is wrong", expert.group.CHECKSUM, expert.severity.ERROR)
local malformed = ProtoExpert.new("pus.malformed", "Differs from the dictionary", expert.group.MALFORMED, expert.severity.ERROR)
local unknown = ProtoExpert.new("pus.unknown", "Not in the dictionary", expert.group.UNDECODED, expert.severity.NOTE)
local differs = ProtoExpert.new("pus.interface.differs", "The spacecraft has another interface", expert.group.PROTOCOL, expert.severity.WARN)
pus.experts = { wrong_crc, malformed, unknown, differs }

local crc_table = {}
for octet = 0, 255 do
    local crc = bit.lshift(octet, 8)
    for _ = 1, 8 do
        crc = bit.band(bit.band(crc, 0x8000) ~= 0 and bit.bxor(bit.lshift(crc, 1), 0x1021) or bit.lshift(crc, 1), 0xFFFF)
    end
    crc_table[octet] = crc
end

local function checksum(range)
    local crc, octets = 0xFFFF, range:bytes()
    for at = 0, octets:len() - 1 do
        crc = bit.bxor(bit.band(bit.lshift(crc, 8), 0xFFFF), crc_table[bit.bxor(bit.rshift(crc, 8), octets:get_index(at))])
    end
    return crc
end

-- Add a field, and the parts of a word of bits below it.
local function add(tree, name, range, ...)
    local item = tree:add(fields[name], range, ...)
    for _, part in ipairs(BITS[name] or {}) do
        item:add(fields[part], range)
    end
    return item
end

-- Kinds of numbers whose names are those of the subsystem that a packet or a group of its values is about.
local OF_SUBSYSTEM = { event_id = "event", configuration_id = "configuration", failure_code = "failure" }

-- A reader of the data field [at, stop) of one packet; it raises an error text if octets are missing.
local Reader = {}
Reader.__index = Reader

function Reader:range(size)
    if self.at + size > self.stop then
        error(string.format("%d octets left, %d needed", self.stop - self.at, size), 0)
    end
    local found = self.tvb(self.at, size)
    self.at = self.at + size
    return found
end

function Reader:rest()
    return self:range(self.stop - self.at)
end

-- Name of a number of a kind in a subsystem, or nil. The present configuration of the subsystem decides between devices with one number.
function Reader:name_of(kind, number, apid)
    if kind == "event" then
        local event = EVENTS[apid] and EVENTS[apid][number]
        return event and event.name
    elseif kind == "device" or kind == "CANopen node" then
        local present = NAMES.device[apid][self.configuration]
        return present and present[kind] and present[kind][number]
    end
    return kind and NAMES[kind][apid] and NAMES[kind][apid][number]
end

function Reader:items(tree, items)
    for _, item in ipairs(items) do -- {field, type, count, names of its numbers: {kind, value with the APID}}, or {repetitions, items}
        if type(item[1]) == "number" then
            for _ = 1, item[1] do
                self:items(tree, item[2])
            end
        else
            for _ = 1, item[3] do
                local range = self:range(SIZES[item[2]])
                local shown = add(tree, item[1], range)
                local name = item[4] and self:name_of(item[4][1], range:uint(), item[4][2] and self.subjects[item[4][2]] or self.apid)
                shown:append_text(name and " (" .. name .. ")" or "")
            end
        end
    end
end

local function size_of(items)
    local size = 0
    for _, item in ipairs(items) do
        size = size + (type(item[1]) == "number" and item[1] * size_of(item[2]) or SIZES[item[2]] * item[3])
    end
    return size
end

-- The numbers of an event, by field. They are read before the values are shown, because the name of a number
-- may depend on an APID that follows it.
function Reader:subjects_of(items)
    local found, at = {}, self.at
    for _, item in ipairs(items) do
        local size = size_of({ item })
        if SIZES[item[2]] == size and size <= 4 and at + size <= self.stop then
            found[item[1]] = self.tvb(at, size):uint()
        end
        at = at + size
    end
    return found
end

local function signed(range, octets) -- An exact number; `range` has at most seven octets.
    local value = 0
    for at = 0, octets - 1 do
        value = value * 256 + range(at, 1):uint()
    end
    return range(0, 1):uint() >= 0x80 and value - 256 ^ octets or value
end

local function cuc(range)
    return range(1, 4):uint() - MISSION.epoch + range(5, 3):uint() / FRACTION
end

local DERIVED = { -- coding -> octets, value
    time = { 8, cuc },
    reltime = { 7, function(range) return signed(range, 7) / FRACTION end },
    position = { 6, function(range) return signed(range, 6) / ANGLE end },
    cds = { 8, function(range) return range(0, 2):uint() * 86400 - MISSION.epoch + range(2, 4):uint() / 1e3 + range(6, 2):uint() / 1e6 end },
}

local dissect

function Reader:bits(count)
    local shift = self.shift or 0
    local octet, value = math.floor(shift / 8), 0
    for number = shift, shift + count - 1 do
        local place = self.at + math.floor(number / 8)
        if place >= self.stop then
            error("octets are missing", 0)
        end
        value = value * 2 + bit.band(bit.rshift(self.tvb(place, 1):uint(), 7 - number % 8), 1)
    end
    shift = shift + count
    local range = self.tvb(self.at + octet, math.ceil(shift / 8) - octet)
    if shift % 8 == 0 then
        self.at, shift = self.at + shift / 8, 0
    end
    self.shift = shift
    return range, value
end

function Reader:kind(tree, field, place)
    local kind = CATALOGUE.kinds[field.kind]
    local coding, own = kind.coding, fields[place]
    if coding == "bits" then
        local range, value = self:bits(kind.size)
        tree:add(own, range, value)
    elseif NUMBERS[coding] then
        local range = self:range(NUMBERS[coding])
        local item = tree:add(own, range)
        if coding == "id" then
            self.of[field.name] = range:uint()
            local parameter = PARAMETERS[range:uint()]
            item:append_text(parameter and " (" .. parameter.name .. ")" or "")
        elseif coding == "layout" then
            self.of[field.name] = bit.lshift(range:uint(), 16)
        elseif NUMBERS[coding] <= 4 then
            self.seen[field.name] = range:uint()
            local name = self:name_of(OF_SUBSYSTEM[field.kind], range:uint(), self.seen.apid or self.apid)
            item:append_text(name and " (" .. name .. ")" or "")
        end
    elseif DERIVED[coding] then
        local range = self:range(DERIVED[coding][1])
        if coding == "time" and range:bytes():tohex() == "0000000000000000" then
            tree:add(range, field.name .. ": no time")
        else
            tree:add(own, range, DERIVED[coding][2](range))
        end
    elseif coding == "name" then
        local range = self:range(8)
        local name = range:string():match("^%Z*") -- stringz() would read beyond a name of eight characters.
        self.seen[field.name] = name
        tree:add(own, range, name)
    elseif coding == "text" or coding == "octets" and not kind.size then
        local size = self:range(2):uint()
        if size > 0 then
            tree:add(own, self:range(size))
        end
    elseif coding == "octets" then
        tree:add(own, self:range(kind.size))
    elseif coding == "packet" then
        if self.at + PRIMARY > self.stop then
            error("octets are missing in the request within", 0)
        end
        local range = self:range(self.tvb(self.at + 4, 2):uint() + 7)
        dissect(range:tvb(), nil, tree:add(own, range))
    elseif self.at < self.stop then -- rest
        tree:add(own, self:rest())
    end
end

function Reader:value(tree, field, place)
    local argument = self.functions and self.functions[self.seen.function_id]
    argument = argument and argument[self.seen[field.of]]
    local of = self.of[field.of]
    if argument then
        self:items(tree, { argument })
    elseif of == nil then
        self:kind(tree, { name = field.name, kind = "part" }, place)
    else
        local parameter = PARAMETERS[of]
        if parameter and (self.service == 20 or #parameter.items > 1 or parameter.items[1][3] > 1) then
            self:items(tree, parameter.items)
            return
        end
        local kind = LAYOUTS[bit.band(bit.rshift(of, 16), 0x1F)]
        if kind == nil then
            error(string.format("parameter 0x%08X is not in the dictionary", of), 0)
        end
        tree:add(fields[place .. "." .. kind:lower()], self:range(SIZES[kind]))
    end
end

function Reader:structure(tree)
    local identifier, known = self.seen.hk_structure_id or self.seen.diag_structure_id, STRUCTURES[self.apid]
    local fits
    for _, structure in ipairs(known and known[identifier] or {}) do
        if size_of(structure.items) == self.stop - self.at and (fits == nil or structure.configuration == self.configuration) then
            fits = structure
        end
    end
    if fits then
        self:items(tree, fits.items)
    else
        tree:add(fields.octets, self:rest()):add_proto_expert_info(unknown, "a report structure that was defined in flight")
    end
end

function Reader:event(tree)
    local known = EVENTS[self.apid]
    local event = known and known[self.seen.event_definition_id]
    if event == nil then
        error(string.format("event %d is not in the dictionary", self.seen.event_definition_id), 0)
    end
    tree:add(fields.event, self.tvb(self.at - 2, 2), event.name)
    self.title = event.name
    self.subjects = self:subjects_of(event.items)
    self:items(tree, event.items)
end

function Reader:group(tree, listed)
    for _, field in ipairs(listed) do
        local place = string.format("st%d.%s", self.service, field.name or field["repeat"] or "")
        if field["repeat"] then
            local range = self:range(self.count_size)
            local item = tree:add(fields[place], range)
            for _ = 1, range:uint() do
                self:group(item, field.fields)
            end
        elseif field.choice then
            local case = field.cases[tostring(self.seen[field.choice])]
            if case == nil then
                error(string.format("%s is %s", field.choice, tostring(self.seen[field.choice])), 0)
            end
            self:group(tree, case)
        elseif field.values then
            self:structure(tree)
        elseif field.kind == "auxiliary" then
            self:event(tree)
        elseif field.kind == "value" then
            self:value(tree, field, place)
        else
            self:kind(tree, field, place)
        end
    end
end

-- Configurations of the subsystems at each report, collected in the first pass, which visits the packets in order.
local present, at_frame = {}, {}

local function configuration_of(pinfo, apid, tvb, service, subtype)
    if not pinfo then
        return nil
    end
    local at = service == 129 and (subtype == 2 and TM_HEADER + 3 or subtype == 5 and TM_HEADER + 3) or nil
    if not pinfo.visited then
        if at and tvb:len() >= at + 2 + CRC then
            present[apid] = tvb(at, 2):uint()
        end
        at_frame[pinfo.number] = at_frame[pinfo.number] or {}
        at_frame[pinfo.number][apid] = present[apid]
    end
    return (at_frame[pinfo.number] or present)[apid]
end

local function check_interface(tree, apid, tvb)
    local wanted = INTERFACES[apid]
    local at = TM_HEADER + 5
    if wanted and tvb:len() >= at + 8 + CRC and tvb(at, 8):bytes():tohex() ~= wanted then
        tree:add_proto_expert_info(differs, "this dissector has 0x" .. wanted .. " of " .. (MISSION.apids[apid] or apid))
    end
end

local function headers(tree, tvb, is_tc)
    tree:add(fields.type, tvb(0, 1), is_tc and 1 or 0)
    local word, sequence = tvb(0, 2):uint(), tvb(2, 2):uint()
    local apid = bit.band(word, 0x7FF)
    tree:add(fields.apid, tvb(0, 2), apid)
    tree:add(fields.sequence, tvb(2, 2), bit.band(sequence, 0x3FFF))
    tree:add(fields.length, tvb(4, 2))
    return apid, word, sequence
end

-- Text of an error in the headers of a packet, or nil.
local function problem_of(tvb, word, sequence, is_tc)
    local size = tvb:len()
    if bit.rshift(word, 13) ~= 0 then
        return "packet version number is not 0"
    elseif tvb(4, 2):uint() + 7 ~= size then
        return "length field does not give the size of the packet"
    elseif bit.rshift(sequence, 14) ~= 3 then
        return "packet is segmented"
    elseif word == 0 then
        return size ~= 18 and "spacecraft time packet: expected 18 octets" or nil
    elseif bit.band(word, 0x0800) == 0 then
        return "no secondary header"
    elseif size < (is_tc and TC_HEADER or TM_HEADER) + CRC then
        return "too short for its headers"
    elseif bit.rshift(tvb(6, 1):uint(), 4) ~= 2 then
        return "PUS version is not 2"
    end
    return nil
end

local function secondary(tree, tvb, is_tc)
    tree:add(fields.service, tvb(7, 1))
    tree:add(fields.subtype, tvb(8, 1))
    if is_tc then
        add(tree, "ack", tvb(6, 1), bit.band(tvb(6, 1):uint(), 0xF))
        tree:add(fields.source, tvb(9, 2))
    else
        tree:add(fields.counter, tvb(9, 2))
        tree:add(fields.destination, tvb(11, 2))
        tree:add(fields.time, tvb(13, 8), cuc(tvb(13, 8)))
    end
    return tvb(7, 1):uint(), tvb(8, 1):uint()
end

function dissect(tvb, pinfo, parent)
    local tree = parent:add(pus, tvb())
    local size = tvb:len()
    if size < PRIMARY then
        tree:add(fields.octets, tvb()):add_proto_expert_info(malformed, "too short for a primary header")
        return
    end
    local is_tc = bit.band(tvb(0, 1):uint(), 0x10) ~= 0
    local apid, word, sequence = headers(tree, tvb, is_tc)
    local direction, owner = is_tc and "TC" or "TM", MISSION.apids[apid] or "APID " .. apid
    local problem = problem_of(tvb, word, sequence, is_tc)
    if problem then
        tree:add(fields.octets, tvb(PRIMARY)):add_proto_expert_info(malformed, problem)
        tree:append_text(string.format(", %s %s, %s", direction, owner, problem))
        return direction .. " " .. owner .. " (" .. problem .. ")"
    end
    local sum = tree:add(fields.crc, tvb(size - CRC, CRC))
    if checksum(tvb(0, size - CRC)) ~= tvb(size - CRC, CRC):uint() then
        sum:add_proto_expert_info(wrong_crc)
    end
    local service, subtype, first
    if word == 0 then
        service, subtype, first = 9, tvb(7, 1):uint() == 0x1F and 2 or 3, PRIMARY
    else
        service, subtype = secondary(tree, tvb, is_tc)
        first = is_tc and TC_HEADER or TM_HEADER
    end
    local message = CATALOGUE.messages[string.format("%s[%d,%d]", direction, service, subtype)]
    local reader = setmetatable({ tvb = tvb, at = first, stop = size - CRC, service = service, apid = apid, of = {}, seen = {},
        count_size = is_tc and 1 or 2, functions = FUNCTIONS[apid],
        configuration = not is_tc and configuration_of(pinfo, apid, tvb, service, subtype) or nil }, Reader)
    if message then
        tree:add(fields.message, tvb(7, 2), message.name)
        local is_whole, says = pcall(function()
            reader:group(tree, message.fields)
            if reader.at ~= reader.stop then
                error(string.format("%d octets too many", reader.stop - reader.at), 0)
            end
        end)
        if not is_whole then
            tree:add_proto_expert_info(malformed, tostring(says))
        end
    else
        tree:add_proto_expert_info(unknown, "message that is not in the catalogue")
    end
    if not is_tc and service == 129 and subtype == 5 then
        check_interface(tree, apid, tvb)
    end
    if reader.at < reader.stop then
        tree:add(fields.octets, reader:rest())
    end
    local title = string.format("%s[%d,%d] %s %s", direction, service, subtype, owner, reader.title or message and message.name or "")
    tree:append_text(", " .. title)
    return title
end

local function show(tvb, pinfo, tree)
    pinfo.cols.protocol = "PUS"
    pinfo.cols.info = dissect(tvb, pinfo, tree) or "malformed"
    return tvb:len()
end

function pus.dissector(tvb, pinfo, tree)
    if pinfo.port_type == 2 then -- TCP: the packets follow each other without framing.
        dissect_tcp_pdus(tvb, tree, PRIMARY, function(buffer, _, offset) return buffer(offset + 4, 2):uint() + 7 end, show)
        return tvb:len()
    end
    return show(tvb, pinfo, tree)
end

DissectorTable.get("tcp.port"):add(MISSION.port, pus)
DissectorTable.get("wtap_encap"):add(wtap.USER0, pus)
