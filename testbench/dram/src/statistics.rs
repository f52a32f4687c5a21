//! What a memory has done.

/// Of one client.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ClientStatistics {
    /// Reads asked for.
    pub reads: u64,
    /// Writes asked for.
    pub writes: u64,
    /// Clocks from each read's arrival to the end of its data, summed over those that have been served.
    pub read_latency_clocks: u64,
}

/// What a memory has done, of all channels together. Clocks are the device's.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Statistics {
    /// Device clocks that have gone by.
    pub clocks: u64,
    /// Reads asked for.
    pub reads: u64,
    /// Writes asked for.
    pub writes: u64,
    /// Bytes that went over the data buses in bursts of reads.
    pub bytes_read: u64,
    /// Bytes that went over the data buses in bursts of writes.
    pub bytes_written: u64,
    /// Bursts of requests that found their row open.
    pub row_hits: u64,
    /// Bursts of requests for which a row was opened in a closed bank.
    pub row_misses: u64,
    /// Bursts of requests for which another row was closed first.
    pub row_conflicts: u64,
    /// Rows that were opened.
    pub activates: u64,
    /// Precharge commands, to a bank or to a rank.
    pub precharges: u64,
    /// Refresh commands, to a bank or to a rank.
    pub refreshes: u64,
    /// Clocks in which a data bus was busy, summed over the buses: channels times pseudo-channels.
    pub busy_bus_clocks: u64,
    /// Clocks that reads waited in the queue for their command, summed over the bursts read. By `clocks` the mean occupancy,
    /// by the bursts the mean wait.
    pub read_queue_clocks: u64,
    /// The same of writes.
    pub write_queue_clocks: u64,
    /// Clocks from each read's arrival to the end of its data, summed over those that have been served.
    pub read_latency_clocks: u64,
    /// Reads that were served from a queued write and moved no burst.
    pub reads_forwarded: u64,
    /// Writes that joined a queued write to the same burst.
    pub writes_coalesced: u64,
    /// Times that a channel began to drain writes at the high mark.
    pub drains: u64,
    /// Of each client, by number; up to the highest that has asked.
    pub clients: Vec<ClientStatistics>,
}

impl Statistics {
    /// Counts a request.
    pub(crate) fn ask(&mut self, write: bool, client: u8) {
        let of_client = self.client(client);
        let count = if write { &mut of_client.writes } else { &mut of_client.reads };
        *count += 1;
        let count = if write { &mut self.writes } else { &mut self.reads };
        *count += 1;
    }

    pub(crate) fn client(&mut self, client: u8) -> &mut ClientStatistics {
        let index = usize::from(client);
        if self.clients.len() <= index {
            self.clients.resize(index + 1, ClientStatistics::default());
        }
        &mut self.clients[index]
    }
}
