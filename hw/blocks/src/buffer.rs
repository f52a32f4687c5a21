//! The contract of what stands between a client and outside memory, and to each is the other: a cache, a write combiner.
//!
//! ```text
//!                +--------+
//!  request ----->|        |---> request (Stream)
//!  client <------| Buffer |<--- memory (ready, response)
//!  flush ------->|        |---> idle
//!                +--------+
//! ```
//! Both sides are the port of [`outside`], so that it can be put between any machine and any memory: requests are carried out
//! in their order, and reads are answered in it. The client takes its answers at once, and so does the buffer.
//!
//! What was written is in memory after a flush: asked for in any cycle, it ends in the first cycle behind it in which the buffer
//! is idle. Until then nothing is taken from the client.

use pellucid_machine::outside::{self, Request};
use pellucid_sim::{Block, Registers, Stream};

/// A block that keeps the contract. Whether it does is a matter of tests: see `pellucid-properties`.
pub trait Buffer: Block<State: Registers<Config = Self::Config>> {
    /// The port, on both sides.
    fn port(cfg: &Self::Config) -> outside::Config;
    /// The inputs for what the client asks for, what the memory drives, and whether a flush is asked for.
    fn inputs(request: Stream<Request>, memory: outside::In, flush: bool) -> Self::In;
    /// What the client sees of it, as of a memory.
    fn client(seen: &Self::Moore, memory: outside::In) -> outside::In;
    /// Nothing is on its way to memory.
    fn idle(seen: &Self::Moore) -> bool;
    /// What is asked of the memory.
    fn asks(out: &Self::Out) -> Stream<Request>;
}
