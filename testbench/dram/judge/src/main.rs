//! Plays requests through DRAMsim3: `pellucid-dram-judge CONFIG FOLDER < REQUESTS`.
//!
//! A request is a line `CLOCK r|w ADDRESS`: it is added in that clock or the first one after it that takes it. The output has a
//! line for each read, in order: how many clocks after that its data came; then `clocks N`, after which all had come, and
//! `seconds S` that this and the rest took: DRAMsim3 leaves its statistics in the folder at the end of each of its epochs, so
//! that the last one is completed, and `ticks N` says with which clock.

use dramsim3::MemorySystem;
use std::collections::{HashMap, VecDeque};
use std::io::Read;
use std::time::Instant;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut arguments = std::env::args().skip(1);
    let (Some(config), Some(folder)) = (arguments.next(), arguments.next()) else {
        return Err("expected a configuration file and a folder".into());
    };
    let mut text = String::new();
    std::io::stdin().read_to_string(&mut text)?;
    let mut requests = vec![];
    for line in text.lines() {
        let fields: Vec<&str> = line.split(' ').collect();
        let [clock, kind, address] = fields[..] else {
            return Err(format!("expected `CLOCK r|w ADDRESS` instead of `{line}`").into());
        };
        requests.push((clock.parse::<u64>()?, kind == "w", address.parse::<u64>()?));
    }
    let epoch = epoch(&config)?;
    let mut memory = MemorySystem::new(&config, &folder).map_err(|error| format!("{error:?}"))?;
    // Of each address the reads that wait for it, oldest first.
    let mut waiting: HashMap<u64, VecDeque<usize>> = HashMap::new();
    let (mut latencies, mut left) = (vec![], 0);
    let (mut clock, mut next, mut end) = (0, 0, 0);
    let begin = Instant::now();
    while next < requests.len() || left > 0 || clock % epoch != 0 {
        if let Some(&(at, write, address)) = requests.get(next)
            && at <= clock
            && memory.can_add(address, write)
        {
            memory.add(address, write);
            next += 1;
            if !write {
                waiting.entry(address).or_default().push_back(latencies.len());
                latencies.push(at);
                left += 1;
            }
        }
        memory.tick(|address, write| {
            if !write && let Some(read) = waiting.get_mut(&address).and_then(VecDeque::pop_front) {
                latencies[read] = clock - latencies[read];
                left -= 1;
                end = clock + 1;
            }
        });
        clock += 1;
    }
    let seconds = begin.elapsed().as_secs_f64();
    for latency in latencies {
        println!("{latency}");
    }
    println!("clocks {end}\nseconds {seconds}\nticks {clock}");
    Ok(())
}

/// The length of an epoch in the configuration file.
fn epoch(config: &str) -> Result<u64, Box<dyn std::error::Error>> {
    let text = std::fs::read_to_string(config)?;
    let value = text.lines().find_map(|line| line.strip_prefix("epoch_period = "));
    Ok(value.ok_or("expected a line `epoch_period = N`")?.parse()?)
}
