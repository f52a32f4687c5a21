//! What a report lists beside single figures: memories and streams.

use super::costs;
use pellucid_machine::{MemoryTally, StreamTally};
use serde_json::{Value as Json, json};

/// What the fields of a memory mean.
pub(super) const MEMORY_FIELDS: [(&str, &str, &str); 6] = [
    ("reads", "words", "Words read."),
    ("writes", "words", "Words written."),
    ("words", "words", "Words that the memory has."),
    ("bits_per_word", "bits", "Bits of a word."),
    ("peak_words", "words", "The most words that held something of use at once."),
    ("bits", "bits", "Size of the memory."),
];

/// What the fields of a stream mean.
pub(super) const STREAM_FIELDS: [(&str, &str, &str); 2] = [
    ("transfers", "transfers", "Items handed over."),
    ("stalls", "cycles", "Cycles with an offer that was not taken."),
];

/// The values of these.
pub(super) fn stream_values(stream: &StreamTally) -> [u64; 2] {
    [stream.transfers, stream.stalls]
}

/// The values of a memory's fields.
pub(super) fn memory_values(memory: &MemoryTally) -> [u64; 6] {
    let info = &memory.info;
    [info.reads, info.writes, info.words, info.bits_per_word.into(), memory.peak_words, info.bits()]
}

/// A memory with what it costs, as far as that is known.
pub(super) fn memory_json((memory, costs): (&MemoryTally, Option<[Json; 5]>)) -> Json {
    let mut object = json!({ "name": memory.name });
    for ((name, ..), value) in MEMORY_FIELDS.iter().zip(memory_values(memory)) {
        object[*name] = json!(value);
    }
    for ((name, ..), value) in costs::MEMORY_FIELDS.iter().zip(costs.into_iter().flatten()) {
        object[*name] = value;
    }
    object
}

/// A stream.
pub(super) fn stream_json(stream: &StreamTally) -> Json {
    let mut object = json!({ "name": stream.name, "from": stream.from, "to": stream.to });
    for ((name, ..), value) in STREAM_FIELDS.iter().zip(stream_values(stream)) {
        object[*name] = json!(value);
    }
    object
}
