// SPDX-License-Identifier: Apache-2.0
//! Packets encoded into a buffer and decoded from it by spacepackets: what bench_codec.c does by the code of this project. Each function
//! returns the number of octets of the packet, or 0 if decoding gives other values. The last two are for test/conformance, which reads the
//! reports of a flight by them and makes requests for it.
use arbitrary_int::{u11, u14};
use spacepackets::ecss::tc::{AckFlags, PusTcCreator, PusTcReader, PusTcSecondaryHeader};
use spacepackets::ecss::tm::{GenericPusTmSecondaryHeader, PusTmCreator, PusTmReader, PusTmSecondaryHeader};
use spacepackets::ecss::{CreatorConfig, MessageTypeId, PusError, PusPacket};
use spacepackets::time::cuc::{convert_fractional_part_to_ns, fractional_part_from_subsec_ns, CucTime, FractionalResolution};
use spacepackets::time::TimeReader;
use spacepackets::{CcsdsPacket, SpHeader};
use std::hint::black_box;

const APID: u11 = u11::new(16);
const USER: u16 = 1;
const TIME_OCTETS: usize = 8;
const NS_PER_S: u64 = 1_000_000_000;

fn time_of(time_ns: u64) -> CucTime {
    let fraction = fractional_part_from_subsec_ns(FractionalResolution::SixtyNs, time_ns % NS_PER_S);
    CucTime::new_with_fractions((time_ns / NS_PER_S) as u32, fraction).unwrap()
}

fn write_tc(service: u8, subtype: u8, data: &[u8], packet: &mut [u8]) -> usize {
    write_tc_to(APID, u14::new(7), USER, (service, subtype), data, packet)
}

fn write_tc_to(apid: u11, count: u14, user: u16, message: (u8, u8), data: &[u8], packet: &mut [u8]) -> usize {
    let header = PusTcSecondaryHeader::new(MessageTypeId::new(message.0, message.1), AckFlags::ALL, user);
    let sequence = SpHeader::new_for_unseg_tc(apid, count, 0);
    PusTcCreator::new(sequence, header, data, CreatorConfig::default()).write_to_slice(packet).unwrap()
}

fn read_tc(packet: &[u8]) -> Option<(usize, PusTcReader<'_>)> {
    let tc = PusTcReader::new(packet).ok()?;
    black_box((tc.apid(), tc.seq_count(), tc.service_type_id(), tc.message_subtype_id()));
    Some((tc.len_packed(), tc))
}

/// # Safety
/// `data` has `size` octets, `packet` room for `capacity`.
#[no_mangle]
pub unsafe extern "C" fn spacepackets_tm(data: *const u8, size: usize, time_ns: u64, packet: *mut u8, capacity: usize) -> usize {
    let data = std::slice::from_raw_parts(data, size);
    let packet = std::slice::from_raw_parts_mut(packet, capacity);
    let mut stamp = [0u8; TIME_OCTETS];
    time_of(time_ns).write_to_slice(&mut stamp).unwrap();
    let header = PusTmSecondaryHeader::new(MessageTypeId::new(3, 25), 9, USER, &stamp);
    let sequence = SpHeader::new_for_unseg_tm(APID, u14::new(7), 0);
    let written = PusTmCreator::new(sequence, header, data, CreatorConfig::default()).write_to_slice(packet).unwrap();
    let Ok(tm) = PusTmReader::new(&packet[..written], TIME_OCTETS) else { return 0 };
    let Ok(time) = CucTime::from_bytes(tm.timestamp()) else { return 0 };
    black_box((tm.apid(), tm.seq_count(), tm.service_type_id(), tm.message_subtype_id(), tm.msg_type_counter(), tm.dest_id()));
    black_box(time.counter().wrapping_add(convert_fractional_part_to_ns(time.fractions()) as u32));
    if tm.source_data().len() == size { written } else { 0 }
}

/// # Safety
/// As spacepackets_tm.
#[no_mangle]
pub unsafe extern "C" fn spacepackets_tc(data: *const u8, size: usize, packet: *mut u8, capacity: usize) -> usize {
    let data = std::slice::from_raw_parts(data, size);
    let packet = std::slice::from_raw_parts_mut(packet, capacity);
    let written = write_tc(8, 1, data, packet);
    match read_tc(&packet[..written]) {
        Some((length, tc)) if tc.user_data().len() == size => length,
        _ => 0,
    }
}

/// # Safety
/// As spacepackets_tm.
#[no_mangle]
pub unsafe extern "C" fn spacepackets_schedule(
    data: *const u8, size: usize, time_ns: u64, packet: *mut u8, capacity: usize,
) -> usize {
    let data = std::slice::from_raw_parts(data, size);
    let packet = std::slice::from_raw_parts_mut(packet, capacity);
    let mut activity = [0u8; 256];
    activity[0..2].copy_from_slice(&3u16.to_be_bytes()); // Sub-schedule, number of activities, group.
    activity[2] = 1;
    activity[3..5].copy_from_slice(&5u16.to_be_bytes());
    time_of(time_ns).write_to_slice(&mut activity[5..13]).unwrap();
    let request = write_tc(8, 1, data, &mut activity[13..]);
    let written = write_tc(11, 4, &activity[..13 + request], packet);
    let Some((length, tc)) = read_tc(&packet[..written]) else { return 0 };
    let list = tc.user_data();
    black_box((u16::from_be_bytes([list[0], list[1]]), list[2], u16::from_be_bytes([list[3], list[4]])));
    let Ok(time) = CucTime::from_bytes(&list[5..13]) else { return 0 };
    black_box(time.counter().wrapping_add(convert_fractional_part_to_ns(time.fractions()) as u32));
    match read_tc(&list[13..]) {
        Some((_, inner)) if inner.user_data().len() == size => length,
        _ => 0,
    }
}

/// Header fields of a report, and place of its data in the packet [octets].
#[repr(C)]
pub struct Report {
    apid: u16,
    sequence: u16,
    service: u8,
    subtype: u8,
    counter: u16,
    user: u16,
    time_status: u8,
    seconds: u32,
    fraction: u32,
    data_offset: u32,
    data_size: u32,
}

/// Returns 1; 0 for no packet of PUS-C, -1 for a wrong checksum, -2 for a time that is no CUC.
/// # Safety
/// `packet` has `size` octets; `report` may be written.
#[no_mangle]
pub unsafe extern "C" fn spacepackets_read(packet: *const u8, size: usize, report: *mut Report) -> i32 {
    let packet = std::slice::from_raw_parts(packet, size);
    let tm = match PusTmReader::new(packet, TIME_OCTETS) {
        Ok(tm) => tm,
        Err(PusError::ChecksumFailure(_)) => return -1,
        Err(_) => return 0,
    };
    let Ok(time) = CucTime::from_bytes(tm.timestamp()) else { return -2 };
    *report = Report {
        apid: tm.apid().value(),
        sequence: tm.seq_count().value(),
        service: tm.service_type_id(),
        subtype: tm.message_subtype_id(),
        counter: tm.msg_type_counter(),
        user: tm.dest_id(),
        time_status: tm.sc_time_ref_status().value(),
        seconds: time.counter(),
        fraction: time.fractions().counter(),
        data_offset: (tm.source_data().as_ptr() as usize - packet.as_ptr() as usize) as u32,
        data_size: tm.source_data().len() as u32,
    };
    1
}

/// Encode a request that asks for all verification reports. Returns its number of octets.
/// # Safety
/// `data` has `size` octets, `packet` room for `capacity`.
#[no_mangle]
pub unsafe extern "C" fn spacepackets_make(
    apid: u16, count: u16, user: u16, service: u8, subtype: u8, data: *const u8, size: usize, packet: *mut u8, capacity: usize,
) -> usize {
    let data = std::slice::from_raw_parts(data, size);
    let packet = std::slice::from_raw_parts_mut(packet, capacity);
    write_tc_to(u11::new(apid), u14::new(count), user, (service, subtype), data, packet)
}
