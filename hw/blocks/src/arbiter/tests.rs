use super::*;
use crate::test_util::{Behind, Pattern, Source, at_first, pattern, read, refusal, write};
use pellucid_machine::outside::Word;
use pellucid_sim::stream::valid_ignores_ready;
use pellucid_sim::{Sim, StreamMonitor};
use proptest::prelude::*;
use std::collections::VecDeque;

/// An arbiter of clients with so many words of 70 bits each.
pub(super) fn config(words: &[u32], policy: Policy, reads_in_flight: u32) -> Config {
    let words = std::array::from_fn(|k| words.get(k).copied().unwrap_or(0));
    Config { words, bits: 70, policy, reads_in_flight }
}

type Offers = [Stream<Request>; MAX_CLIENTS];

/// An arbiter between clients that take every answer and a memory.
struct Bench {
    sim: Sim<Arbiter>,
    memory: Behind,
    from_client: Vec<StreamMonitor<Request>>,
    to_memory: StreamMonitor<Request>,
    /// The request of each client that is next, where it was taken and did not go.
    kept: Vec<Option<Request>>,
    /// Whom reads that went are for.
    readers: VecDeque<usize>,
    /// Which client's request went, and when.
    gone: Vec<(u64, u32)>,
    /// What each client was answered, and when.
    answers: Vec<Vec<(u64, Word)>>,
}

impl Bench {
    fn new(cfg: Config, memory: Behind) -> Bench {
        let clients = cfg.clients() as usize;
        let from_client = |_| StreamMonitor::new("request", "client", "arbiter");
        Bench {
            sim: Sim::new(cfg),
            memory,
            from_client: (0..clients).map(from_client).collect(),
            to_memory: StreamMonitor::new("request", "arbiter", "memory"),
            kept: vec![None; clients],
            readers: VecDeque::new(),
            gone: vec![],
            answers: vec![vec![]; clients],
        }
    }
    /// In front of a memory that is always ready and answers after `latency` cycles.
    fn ready(cfg: Config, latency: u64) -> Bench {
        let words = cfg.memory().words;
        Bench::new(cfg, Behind::new(words, Pattern::always(), vec![latency]))
    }
    /// The client that offers the request that may go and, by the rules, does: of those that may the one with the lowest number
    /// where that is the policy. And whether any may.
    fn may_go(&self, offers: &Offers) -> (Option<usize>, bool) {
        let full = self.readers.len() == self.sim.config().reads_in_flight as usize;
        let may = |(k, kept): (usize, &Option<Request>)| {
            let offer = offers[k].valid.then_some(offers[k].payload);
            kept.or(offer).is_some_and(|request| request.write || !full).then_some(k)
        };
        let lowest = self.kept.iter().enumerate().find_map(may);
        (lowest.filter(|_| self.sim.config().policy == Policy::Priority), lowest.is_some())
    }
    /// A cycle; which requests were taken.
    fn cycle(&mut self, offers: Offers) -> Vec<bool> {
        let cycle = self.sim.cycle();
        let (seen, memory) = (self.sim.moore(), self.memory.shows(cycle));
        assert_eq!(seen.idle, self.readers.is_empty() && self.kept.iter().all(Option::is_none));
        for (k, offer) in offers.iter().enumerate().take(self.kept.len()) {
            let shown = client(&(k as u32), seen, memory);
            assert_eq!(shown.ready, self.kept[k].is_none());
            if shown.response.valid {
                assert_eq!(self.readers.front(), Some(&k), "an answer for another client");
                self.answers[k].push((cycle, shown.response.payload));
            }
            self.from_client[k].observe(offer.with(shown.ready)).unwrap();
        }
        let with_ready = |ready| In { request: offers, memory: outside::In { ready, ..memory } };
        assert!(valid_ignores_ready::<Arbiter, Request>(
            self.sim.config(),
            self.sim.state(),
            || Arbiter::memories(self.sim.config()),
            with_ready,
            |out| out.request,
        ));
        let on_offer = self.to_memory.last() == (true, false);
        let (lowest, any) = self.may_go(&offers);
        let out = self.sim.clock(with_ready(memory.ready)).unwrap().out;
        assert_eq!(out.request.valid, any, "in cycle {cycle}");
        if let Some(lowest) = lowest
            && !on_offer
        {
            assert_eq!(out.client as usize, lowest, "in cycle {cycle}");
        }
        self.to_memory.observe(out.request.with(memory.ready)).unwrap();
        self.memory.edge(cycle, out.request);

        if memory.response.valid {
            self.readers.pop_front();
        }
        let took: Vec<bool> = self
            .kept
            .iter()
            .zip(&offers)
            .map(|(kept, offer)| offer.valid && kept.is_none())
            .collect();
        for (k, took) in took.iter().enumerate() {
            self.kept[k] = if *took { Some(offers[k].payload) } else { self.kept[k] };
        }
        if out.request.valid && memory.ready {
            let who = out.client as usize;
            let asked = self.kept[who].take().expect("it asked for nothing");
            let address = asked.address + self.sim.config().words[..who].iter().sum::<u32>();
            assert_eq!(out.request.payload, Request { address, ..asked });
            if !asked.write {
                self.readers.push_back(who);
            }
            self.gone.push((cycle, out.client));
        }
        took
    }
    /// So many cycles in which each client offers a request, over and over; who went in each.
    fn always(&mut self, requests: &[Request], cycles: u64) -> Vec<u32> {
        let mut offers = Offers::default();
        for (offer, request) in offers.iter_mut().zip(requests) {
            *offer = Stream::offer(*request);
        }
        let first = self.sim.cycle();
        for _ in 0..cycles {
            self.cycle(offers);
        }
        let expected: Vec<u64> = (first..first + cycles).collect();
        let (when, who): (Vec<u64>, Vec<u32>) = self.gone.iter().copied().unzip();
        assert_eq!(when, expected, "a request goes in each cycle");
        who
    }
}

/// So many offers of `request`, the others idle.
fn offers<const N: usize>(requests: [Option<Request>; N]) -> Offers {
    let mut offers = Offers::default();
    for (offer, request) in offers.iter_mut().zip(requests) {
        *offer = request.map_or(Stream::idle(), Stream::offer);
    }
    offers
}

#[test]
fn requests_and_answers_pass_in_their_cycle() {
    let mut bench = Bench::ready(config(&[4, 8], Policy::RoundRobin, 4), 3);
    bench.cycle(offers([None, Some(read(5))]));
    bench.cycle(offers([Some(read(2)), None]));
    for _ in 0..4 {
        bench.cycle(offers([]));
    }
    assert_eq!(bench.gone, [(0, 1), (1, 0)]);
    assert_eq!(bench.answers, [[(4, at_first(2))], [(3, at_first(4 + 5))]]);
    assert!(bench.sim.moore().idle);
}

#[test]
fn in_turn_each_of_k_clients_goes_each_kth_cycle() {
    for clients in 1..=MAX_CLIENTS {
        let mut bench = Bench::ready(config(&vec![2; clients], Policy::RoundRobin, 9), 7);
        let requests: Vec<Request> =
            (0..clients).map(|k| if k % 2 == 0 { read(1) } else { write(1, 0) }).collect();
        let expected: Vec<u32> = (0..clients as u32).cycle().take(100).collect();
        assert_eq!(bench.always(&requests, 100), expected);
    }
}

#[test]
fn by_priority_the_first_client_has_it_all() {
    let mut bench = Bench::ready(config(&[2, 2, 2], Policy::Priority, 9), 7);
    let requests = [read(1), write(1, 0), read(0)];
    assert_eq!(bench.always(&requests, 50), [0; 50]);
    // It pauses for a cycle, and the next one goes.
    bench.cycle(offers([None, Some(requests[1]), Some(requests[2])]));
    bench.cycle(offers(requests.map(Some)));
    assert_eq!(bench.gone[50..], [(50, 1), (51, 0)]);
}

#[test]
fn what_the_memory_does_not_take_stays_whoever_comes() {
    for policy in [Policy::RoundRobin, Policy::Priority] {
        let ready = Pattern::of(vec![false, false, true]);
        let memory = Behind::new(6, ready, vec![3]);
        let mut bench = Bench::new(config(&[2, 2, 2], policy, 4), memory);
        bench.cycle(offers([None, None, Some(write(0, 1))]));
        bench.cycle(offers([Some(write(0, 2)), Some(write(0, 3)), None]));
        for _ in 0..10 {
            bench.cycle(offers([]));
        }
        assert_eq!(bench.gone, [(2, 2), (5, 0), (8, 1)]);
    }
}

/// The queue of readers is free again in the cycle after an answer.
#[test]
fn a_read_a_cycle_needs_room_for_one_more_than_the_latency() {
    for latency in 1..8 {
        for reads_in_flight in 1..=latency + 1 {
            let cfg = config(&[4, 4], Policy::RoundRobin, reads_in_flight);
            let mut bench = Bench::ready(cfg, latency.into());
            for _ in 0..20 * (latency + 1) {
                bench.cycle(offers([Some(read(1)), Some(read(2))]));
            }
            assert_eq!(bench.gone.len() as u32, 20 * reads_in_flight);
        }
    }
}

/// Room for one read, which comes back in every third cycle: the writer fills the others, and the readers share.
#[test]
fn writes_go_before_reads_that_find_no_room_and_no_reader_starves() {
    let mut bench = Bench::ready(config(&[4, 4, 4], Policy::RoundRobin, 1), 2);
    let expected: Vec<u32> = [0, 1, 1, 1, 2, 1, 1].into_iter().cycle().take(70).collect();
    assert_eq!(bench.always(&[read(0), write(0, 1), read(0)], 70), expected);
    // Several writers share, too.
    let mut bench = Bench::ready(config(&[4, 4, 4], Policy::RoundRobin, 1), 4);
    let expected: Vec<u32> = [0, 1, 2, 1, 2, 1, 2].into_iter().cycle().take(70).collect();
    assert_eq!(bench.always(&[read(0), write(0, 1), write(0, 2)], 70), expected);
}

fn refused(change: impl FnOnce(&mut Config)) -> String {
    let mut cfg = config(&[4, 4], Policy::Priority, 2);
    change(&mut cfg);
    refusal::<Arbiter>(&cfg)
}

#[test]
fn numbers_out_of_range_are_refused() {
    let cases: [(String, &str); 5] = [
        (refused(|c| c.words[0] = 0), "words of an arbiter's client is 0: expected at least 1"),
        (
            refused(|c| c.words[3] = 1),
            "words behind the last client of an arbiter is 1: expected at most 0",
        ),
        (
            refused(|c| c.words = [1 << 31, 1 << 31, 0, 0]),
            "words behind an arbiter is 4294967296: expected at most 4294967295",
        ),
        (refused(|c| c.bits = 129), "bits of an arbiter's word is 129: expected 1 to 128"),
        (
            refused(|c| c.reads_in_flight = 0),
            "an arbiter's reads in flight is 0: expected at least 1",
        ),
    ];
    for (said, expected) in cases {
        assert_eq!(said, format!("the number of {expected}"));
    }
}

/// A client's requests: which are writes, and of which word.
type Asks = Vec<(bool, u32)>;

prop_compose! {
    /// Clients' words, their requests, and when they offer.
    fn any_clients()(
        clients in proptest::collection::vec(
            (1u32..9).prop_flat_map(|words| {
                let asks = proptest::collection::vec((any::<bool>(), 0..words), 0..40);
                (Just(words), asks, pattern())
            }),
            1..=MAX_CLIENTS,
        ),
    ) -> Vec<(u32, Asks, Pattern)> {
        clients
    }
}

proptest! {
    /// Whatever is asked, and whenever the memory takes and answers: each client has a memory of its own, which gives what was
    /// written last, in order and once; no cycle is lost; and nobody is behind another more than once, as long as reads find
    /// room, and no read behind another client's reads.
    #[test]
    fn each_client_has_a_plain_array(
        clients in any_clients(),
        in_turn: bool,
        reads_in_flight in prop_oneof![1u32..6, Just(400u32)],
        ready in pattern(),
        latencies in proptest::collection::vec(1u64..9, 1..6),
    ) {
        let words: Vec<u32> = clients.iter().map(|(words, ..)| *words).collect();
        let policy = if in_turn { Policy::RoundRobin } else { Policy::Priority };
        let cfg = config(&words, policy, reads_in_flight);
        let mut bench = Bench::new(cfg, Behind::new(cfg.memory().words, ready, latencies));
        let mut arrays: Vec<Vec<Word>> = vec![];
        let mut sources = vec![];
        let mut numbers = 1..;
        for (k, (words, asks, starts)) in clients.iter().enumerate() {
            arrays.push((0..*words).map(|at| at_first(cfg.base(k as u32) + at)).collect());
            let asks = asks.iter().zip(&mut numbers);
            let requests: Vec<Request> =
                asks.map(|((writes, at), n)| if *writes { write(*at, n) } else { read(*at) }).collect();
            sources.push(Source::new(requests, starts.clone()));
        }
        let mut left: usize = clients.iter().map(|(_, asks, _)| asks.len()).sum();
        let mut expected = vec![vec![]; clients.len()];
        // Requests of others that went while one of the client waited.
        let mut behind = vec![0; clients.len()];
        for cycle in 0.. {
            prop_assert!(cycle < 30_000, "not all is done");
            if left == 0 && bench.sim.moore().idle {
                break;
            }
            let ready = bench.sim.moore().ready;
            let mut offers = Offers::default();
            for (k, source) in sources.iter_mut().enumerate() {
                offers[k] = source.offer(cycle);
                source.edge(ready[k]);
            }
            let waits = |bench: &Bench, k: usize| {
                bench.kept[k].or(offers[k].valid.then_some(offers[k].payload))
            };
            let waiting: Vec<Option<Request>> =
                (0..clients.len()).map(|k| waits(&bench, k)).collect();
            let gone = bench.gone.len();
            let took = bench.cycle(offers);
            for (k, _) in took.iter().enumerate().filter(|(_, took)| **took) {
                left -= 1;
                let Request { write, address, word } = offers[k].payload;
                if write {
                    arrays[k][address as usize] = word;
                } else {
                    expected[k].push(arrays[k][address as usize]);
                }
            }
            let Some((_, who)) = bench.gone.get(gone) else { continue };
            let reads = |k: usize| waiting[k].is_some_and(|request| !request.write);
            for k in 0..clients.len() {
                let all = reads_in_flight == 400 && waiting[k].is_some();
                if *who as usize == k {
                    behind[k] = 0;
                } else if all || (reads(k) && reads(*who as usize)) {
                    behind[k] += 1;
                }
                prop_assert!(!in_turn || behind[k] < clients.len(), "client {} starves", k);
            }
        }
        for (answers, expected) in bench.answers.iter().zip(expected) {
            let answers: Vec<Word> = answers.iter().map(|(_, word)| *word).collect();
            prop_assert_eq!(answers, expected);
        }
        prop_assert_eq!(&bench.memory.words, &arrays.concat());
    }
}
