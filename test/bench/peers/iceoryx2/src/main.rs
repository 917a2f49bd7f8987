// SPDX-License-Identifier: Apache-2.0
//! Round trips over iceoryx2 by the rules of test/bench/transport/round_trip.h; same arguments, same output.
//! The reader polls, or sleeps at a listener that its peer notifies. The other side is this program again,
//! started with a fourth argument, the common part of the services' names.

use iceoryx2::port::listener::Listener;
use iceoryx2::port::notifier::Notifier;
use iceoryx2::port::publisher::Publisher;
use iceoryx2::port::subscriber::Subscriber;
use iceoryx2::prelude::*;
use std::time::{Duration, Instant};

type Failure = Box<dyn std::error::Error>;

const WARM_UP: usize = 200;
const PRIORITY: i32 = 50;
const SCHED_FIFO: i32 = 1;
const LIMIT_S: u32 = 30;

extern "C" {
    fn sched_setaffinity(process: i32, size: usize, set: *const u64) -> i32;
    fn sched_setscheduler(process: i32, policy: i32, priority: *const i32) -> i32;
    fn alarm(seconds: u32) -> u32;
}

fn settle_on(processor: usize) {
    let mut set = [0u64; 16];
    set[0] = 1 << processor;
    // SAFETY: the set is as large as stated and both pointers live through the calls; refusals change nothing.
    unsafe {
        sched_setaffinity(0, std::mem::size_of_val(&set), set.as_ptr());
        sched_setscheduler(0, SCHED_FIFO, &PRIORITY);
        alarm(LIMIT_S);
    }
}

struct Side<const N: usize> {
    publisher: Publisher<ipc::Service, [u8; N], ()>,
    subscriber: Subscriber<ipc::Service, [u8; N], ()>,
    sleeping: Option<(Notifier<ipc::Service>, Listener<ipc::Service>)>,
}

impl<const N: usize> Side<N> {
    fn send(&self, payload: &[u8; N]) -> Result<(), Failure> {
        self.publisher.loan_uninit()?.write_payload(*payload).send()?;
        if let Some((notifier, _)) = &self.sleeping {
            notifier.notify()?;
        }
        Ok(())
    }

    fn receive(&mut self, payload: &mut [u8; N]) -> Result<(), Failure> {
        loop {
            if let Some(sample) = self.subscriber.receive()? {
                *payload = *sample;
                return Ok(());
            }
            if let Some((_, listener)) = &mut self.sleeping {
                listener.blocking_wait(|_| {})?;
            }
        }
    }
}

fn live<const N: usize>(side: usize, polled: bool, trips: usize, name: &str) -> Result<Vec<u64>, Failure> {
    set_log_level(LogLevel::Fatal);
    let node = NodeBuilder::new().create::<ipc::Service>()?;
    let service = |way: usize| -> Result<_, Failure> {
        let name: ServiceName = format!("{name}-{way}").as_str().try_into()?;
        Ok(node.service_builder(&name).publish_subscribe::<[u8; N]>().open_or_create()?)
    };
    let event = |way: usize| -> Result<_, Failure> {
        let name: ServiceName = format!("{name}-{way}").as_str().try_into()?;
        Ok(node.service_builder(&name).event().open_or_create()?)
    };
    let (there, back) = (service(side)?, service(1 - side)?);
    let (wake, woken) = (event(side)?, event(1 - side)?);
    let subscriber = back.subscriber_builder().create()?;
    let publisher = there.publisher_builder().create()?;
    let sleeping = if polled {
        None
    } else {
        let listener = woken.listener_builder().create()?;
        while wake.dynamic_config().number_of_listeners() == 0 {
            std::thread::sleep(Duration::from_millis(1));
        }
        Some((wake.notifier_builder().create()?, listener))
    };
    while there.dynamic_config().number_of_subscribers() == 0
        || back.dynamic_config().number_of_publishers() == 0
    {
        std::thread::sleep(Duration::from_millis(1));
    }
    settle_on(side);
    let mut end = Side { publisher, subscriber, sleeping };
    let taken = if side == 0 { ask(&mut end, trips)? } else { answer(&mut end, trips)? };
    if side == 1 {
        std::thread::sleep(Duration::from_millis(50)); // The peer reads the last sample before this program releases its memory.
    }
    Ok(taken)
}

fn ask<const N: usize>(end: &mut Side<N>, trips: usize) -> Result<Vec<u64>, Failure> {
    let (mut payload, mut back) = ([0x5Au8; N], [0u8; N]);
    let mut taken = Vec::with_capacity(trips);
    for i in 0..WARM_UP + trips {
        payload[..8].copy_from_slice(&i.to_ne_bytes());
        payload[N - 8..].copy_from_slice(&i.to_ne_bytes());
        let began = Instant::now();
        end.send(&payload)?;
        end.receive(&mut back)?;
        let ended = Instant::now();
        if payload != back {
            return Err("another payload came back".into());
        }
        if i >= WARM_UP {
            taken.push((ended - began).as_nanos() as u64);
        }
    }
    Ok(taken)
}

fn answer<const N: usize>(end: &mut Side<N>, trips: usize) -> Result<Vec<u64>, Failure> {
    let mut payload = [0u8; N];
    for _ in 0..WARM_UP + trips {
        end.receive(&mut payload)?;
        end.send(&payload)?;
    }
    Ok(Vec::new())
}

fn main() -> Result<(), Failure> {
    let words: Vec<String> = std::env::args().collect();
    if words.len() < 4 {
        return Err("usage: round-trip-iceoryx2 poll|block 64|1024 <round trips>".into());
    }
    let (polled, trips) = (words[1] == "poll", words[3].parse::<usize>()?);
    let side = if words.len() == 5 { 1 } else { 0 };
    let name = if side == 1 { words[4].clone() } else { format!("bench-{}", std::process::id()) };
    let other = match side {
        0 => Some(std::process::Command::new(std::env::current_exe()?).args(&words[1..]).arg(&name).spawn()?),
        _ => None,
    };
    let mut taken = match words[2].as_str() {
        "64" => live::<64>(side, polled, trips, &name)?,
        "1024" => live::<1024>(side, polled, trips, &name)?,
        _ => return Err("payloads are of 64 or 1024 octets".into()),
    };
    if let Some(mut other) = other {
        if !other.wait()?.success() {
            return Err("the other side failed".into());
        }
        taken.sort_unstable();
        println!("ROUND_TRIP {} {}", taken[trips / 2], taken[trips * 99 / 100]);
    }
    Ok(())
}
